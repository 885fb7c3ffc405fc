"""The numbers of the sample study that README, manual and rooms state: where each stands, and which result it is.

SENTENCES is the only list of them: `write` puts the results into the pages, `differences` says where a page differs.
A sentence is as in the page, however its lines are broken, with a format for each number."""
import csv
import functools
import json
import pathlib
import re
import types

ROOT = pathlib.Path(__file__).resolve().parents[3]
SAMPLE = ROOT / "data/sts-study"
PAGES = "libs/present/manual/pages/"
TRIALS = ["human", "exo"]


class Study:
    """The results of `lake run data/sts-study/study.yaml`; study.STEP.KEY is KEY of STEP's summary.json."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def __getattr__(self, step):
        text = (self.folder / step / "summary.json").read_text(encoding="utf-8")
        setattr(self, step, json.loads(text, object_hook=lambda keys: types.SimpleNamespace(**keys)))
        return self.__dict__[step]

    def column(self, trial, table, name):
        return numbers(self.folder / trial / f"{table}.csv", name)

    def errors(self, trial, table, name):
        """A column of a trial's table less the truth's column of that name."""
        return [a - b for a, b in zip(self.column(trial, table, name), numbers(SAMPLE / f"{trial}-truth.csv", name), strict=True)]

    def rms_px(self, trial):
        return rms([error for name in axes(trial) for error in self.errors(trial, "tracks", f"{name}_px")])

    def rms_mm(self, trial):
        return rms([error for name in axes(trial) for error in self.errors(trial, "trajectory", f"{name}_mm")])

    def rms_deg(self, trial):
        return rms(self.errors(trial, "kinematics", "knee_deg"))

    def knee_rms_px(self, trial):
        return rms(self.errors(trial, "tracks", "knee_x_px") + self.errors(trial, "tracks", "knee_y_px"))

    def knee_bias_px(self, trial):
        """How far in front of its true place the knee's marker is found; the subject faces right."""
        errors = self.errors(trial, "tracks", "knee_x_px")
        return sum(errors) / len(errors)

    def knee_sigma_px(self, trial):
        return rms(self.column(trial, "tracks", "knee_sigma_px"))

    def error_over_sigma(self, trial):
        return rms([error / sigma for name in axes(trial)
                    for error, sigma in zip(self.errors(trial, "tracks", f"{name}_px"), self.column(trial, "tracks", f"{name[:-2]}_sigma_px"), strict=True)])

    def loads_at_peak(self):
        """The row of the mean in loads.csv with the largest moment at the knee."""
        rows = [row for row in table_of(self.folder / "loads/loads.csv") if row["repetition"] == "mean" and row["knee_nm"]]
        return max(rows, key=lambda row: float(row["knee_nm"]))


@functools.lru_cache(maxsize=None)
def table_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def numbers(path, name):
    return [float(row[name]) for row in table_of(path)]


def axes(trial):
    markers = ["ankle", "knee", "hip", "waist"] + ["exo_knee"] * (trial == "exo")
    return [f"{marker}_{axis}" for marker in markers for axis in "xy"]


def rms(values):
    return (sum(value * value for value in values) / len(values)) ** 0.5


def true_joint_mm():
    return json.loads((SAMPLE / "exo-scene.json").read_text(encoding="utf-8"))["motion"]["exo_knee_mm"]


def percent(interval):
    return [100 * end for end in interval]


def tens(numbers):
    """Rounded as the report does what is known to some tens."""
    return [round(number, -1) for number in numbers]


# (page, sentence, results): the results in the order of the numbers.
SENTENCES = [
    # README
    ("README.md", "In all {:.0f} frames of the first trial the knee angle is within {:.3f}° of the truth (RMS), in the {:.0f} of the second within {:.3f}°.",
     lambda s: [s.human.video.frames, s.rms_deg("human"), s.exo.video.frames, s.rms_deg("exo")]),
    ("README.md", "is {:.1f} mm from the knee of the leg that wears it, {:.1f} mm in front of it and {:.1f} mm above it (rendered: {:.0f} and {:.0f})",
     lambda s: [s.comparison.joint.rms_mm, *s.comparison.joint.offset_mm, *true_joint_mm()]),
    ("README.md", "95 % interval with everything that skin and marker placement do: {:.0f} to {:.0f} mm",
     lambda s: s.comparison.uncertainty.joint_rms_mm.anatomical_interval),
    ("README.md", "differ by {:.1f} % of the shank's length; with the joint moved onto the knee, by {:.1f} % (95 % interval {:.0f} to {:.1f} %)",
     lambda s: [100 * s.comparison.metrics.relative_rms, 100 * s.comparison.best_placement.path_relative_rms,
                *percent(s.comparison.best_placement.path_relative_rms_interval)]),
    ("README.md", "New links follow the person within {:.1f} % at {:.1f}° of range",
     lambda s: [s.redesign.after.misalignment_percent, s.redesign.after.range_deg]),
    ("README.md", "{:.0f} % of the knee's moment is at most {:.0f} N of the actuator's {:.0f} N; but a rise takes {:.1f} s, where the person takes {:.1f} s",
     lambda s: [100 * s.assistance.assistance.assist, s.assistance.assistance.force_n.value, s.assistance.assistance.actuator.lifting_force_n,
                s.assistance.assistance.shortest_duration_s, s.assistance.assistance.own_duration_s]),
    # The manual
    (PAGES + "first-recording.md", "All markers are found in all {:.0f} frames", lambda s: [s.human.video.frames]),
    (PAGES + "first-recording.md",
     "{:.3f} px per axis as measured in each frame (`tracks.csv`), {:.3f} mm after the leg fit (`trajectory.csv`), {:.3f}° of knee angle",
     lambda s: [s.rms_px("human"), s.rms_mm("human"), s.rms_deg("human")]),
    (PAGES + "design.md", "RMS errors of this trial: {:.3f} px, {:.3f} mm, {:.3f}°", lambda s: [s.rms_px("exo"), s.rms_mm("exo"), s.rms_deg("exo")]),
    (PAGES + "design.md", "is found {:.2f} px too far to the front, as parts of the exoskeleton are beside it; its standard deviation, {:.2f} px, holds this",
     lambda s: [s.knee_bias_px("exo"), s.knee_sigma_px("exo")]),
    (PAGES + "design.md", "the joint is {:.1f} mm from the knee of the leg that wears it, {:.1f} mm in front of it and {:.1f} mm above it (rendered: {:.0f} and {:.0f} mm)",
     lambda s: [s.comparison.joint.rms_mm, *s.comparison.joint.offset_mm, *true_joint_mm()]),
    (PAGES + "design.md", "differ by {:.1f} % of the shank's length. How much", lambda s: [100 * s.comparison.metrics.relative_rms]),
    (PAGES + "design.md", "With the joint moved they would differ by {:.1f} % (95 % interval from {:.0f} to {:.1f} %, from three rises each)",
     lambda s: [100 * s.comparison.best_placement.path_relative_rms, *percent(s.comparison.best_placement.path_relative_rms_interval)]),
    (PAGES + "design.md", "these links reach {:.0f} mm into a seat that supports half the thigh, {:.0f} mm further than as worn",
     lambda s: [-s.comparison.best_placement.on_body.moved.seat_clearance_mm,
                s.comparison.best_placement.on_body.as_worn.seat_clearance_mm - s.comparison.best_placement.on_body.moved.seat_clearance_mm]),
    (PAGES + "design.md", "The published problem's best is {:.2f}°", lambda s: [s.optimum.range_deg]),
    (PAGES + "design.md", "has {:.1f} % of path difference at {:.1f}° of range, with the joint on the knee, {:.0f} mm lower than as worn.",
     lambda s: [s.redesign.after.misalignment_percent, s.redesign.after.range_deg,
                s.redesign.before.placement_y_mm - s.redesign.after.placement_y_mm]),
    (PAGES + "design.md", "with their joint moved onto the knee leave {:.1f} %, in the {:.1f} s of their program",
     lambda s: [s.redesign.joint_moved.misalignment_percent, s.redesign.joint_moved.program_duration_s]),
    (PAGES + "loads.md", "The peak extension moment of one knee is {:.0f} N m, with a 95 % interval from {:.0f} to {:.0f} N m",
     lambda s: tens([s.loads.peak_knee_nm, *s.loads.peak_knee_nm_interval])),
    (PAGES + "loads.md", "at {:.0f} % of the rise, where the mean is largest ({:.0f} N m), it goes from {:.0f} to {:.0f} N m",
     lambda s: [float(s.loads_at_peak()["percent"]),
                *tens(float(s.loads_at_peak()[key]) for key in ("knee_nm", "knee_low_nm", "knee_high_nm"))]),
    (PAGES + "loads.md", "{:.0f} % of the knee moment requires at most {:.0f} N of its {:.0f} N. But a rise takes {:.1f} s with the links that make it "
     "fastest, while the person took {:.1f} s: at {:.0f} % of the rise its {:.0f} mm/s are not enough",
     lambda s: [100 * s.assistance.assistance.assist, s.assistance.assistance.force_n.value, s.assistance.assistance.actuator.lifting_force_n,
                s.assistance.assistance.shortest_duration_s, s.assistance.assistance.own_duration_s, s.assistance.assistance.limiting_percent,
                s.assistance.assistance.actuator.no_load_speed_mm_s]),
    (PAGES + "prototype.md", "takes {:.1f} s: the design's {:.0f} and {:.1f} s of rest at its reversals",
     lambda s: [s.stroke.duration_s, s.redesign.after.program_duration_s, s.stroke.duration_s - s.redesign.after.program_duration_s]),
    (PAGES + "prototype.md", "may drift by {:.1f} mm, and standing is only {:.2f} mm past the end of the program",
     lambda s: [s.stroke.firmware.drift.last_drift_mm, s.stroke.firmware.drift.end_mm - s.stroke.end.stroke_mm]),
    (PAGES + "validation.md", "{:.3f} and {:.3f} px RMS; {:.2f} and {:.2f} of the stated standard deviation",
     lambda s: [*map(s.rms_px, TRIALS), *map(s.error_over_sigma, TRIALS)]),
    (PAGES + "validation.md", "its mean is {:.1f} and {:.1f} mm, the rendered place {:.0f} and {:.0f} mm",
     lambda s: [*s.comparison.joint.offset_mm, *true_joint_mm()]),
    # What is measured with it in the rooms, and its own page
    ("libs/measure/tracking/README.md", "position as measured (`tracks.csv`), RMS per axis | {:.3f} px | {:.3f} px (knee {:.3f} px)",
     lambda s: [*map(s.rms_px, TRIALS), s.knee_rms_px("exo")]),
    ("libs/measure/tracking/README.md", "RMS of error / sigma | {:.2f} | {:.2f} |", lambda s: map(s.error_over_sigma, TRIALS)),
    ("libs/measure/tracking/README.md", "the knee's mean error is {:.3f} px in x: the exoskeleton's parts next to the marker are no sloping background. "
     "Its sigma, {:.3f} px RMS, holds that.", lambda s: [s.knee_bias_px("exo"), s.knee_sigma_px("exo")]),
    ("data/sts-study/README.md", "is more than the {:.2f} mm that are left between the program's end", lambda s: [s.stroke.firmware.drift.end_mm - s.stroke.end.stroke_mm]),
    ("data/sts-study/README.md", "the centre of pressure keeps {:.0f} mm inside the foot (least at {:.0f} % of the rise, where the seat lets go) at {:.1f}° of range; "
     "without it, it would be {:.0f} mm outside",
     lambda s: [s.redesign.balance.margin_mm, s.redesign.balance.at_percent, s.redesign.after.range_deg, -s.redesign.balance.without.balance_margin_mm]),
]

FORMAT = re.compile(r"\{:(\.\d+f)\}")
NUMBER = r"(-?\d+(?:\.\d+)?)"


def found(text, sentence):
    """The sentence in a page's text, a group for each number."""
    parts = [r"\s+".join(re.escape(word) for word in re.split(r"\s+", part)) for part in FORMAT.split(sentence)[::2]]
    return re.search(NUMBER.join(parts), text)


def written(sentence, results):
    """The numbers as a page has them; one that is rounded to nothing has no sign."""
    return [f"{round(result, int(how[1:-1])) + 0.0:{how}}" for how, result in zip(FORMAT.findall(sentence), results, strict=True)]


def differences(folder):
    """What the pages say otherwise than the study's results do. A solver on another machine may change the digit behind
    the last one."""
    study, said = Study(folder), []
    for page, sentence, results in SENTENCES:
        place = found((ROOT / page).read_text(encoding="utf-8"), sentence)
        if place is None:
            said.append(f"{page} does not say: {sentence}")
            continue
        values = list(results(study))
        for number, value, right in zip(place.groups(), values, written(sentence, values), strict=True):
            decimals = len(right.partition(".")[2])
            if len(number.partition(".")[2]) != decimals or abs(float(number) - value) > 0.51 * 10**-decimals:
                said.append(f"{page}: {number}, and the study has {right}: {sentence}")
    return said


def write(folder):
    """Puts the study's results into the pages; returns those that changed."""
    study, changed = Study(folder), []
    for page, sentence, results in SENTENCES:
        text = (ROOT / page).read_text(encoding="utf-8")
        place = found(text, sentence)
        if place is None:
            raise LookupError(f"{page} does not say: {sentence}")
        new = text
        for group, number in reversed(list(enumerate(written(sentence, results(study)), start=1))):
            new = new[:place.start(group)] + number + new[place.end(group):]
        if new != text:
            (ROOT / page).write_text(new, encoding="utf-8")
            changed.append(page)
    return list(dict.fromkeys(changed))
