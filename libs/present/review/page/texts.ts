// Every text of the page, in one place.
import UNITS from "../../report/page/units.json";
import { CheckMessage, CourseMessage, LivePlace, LiveStateMessage, MeasureMessage, Pair, PinName, ProblemKind, StudyPart } from "./messages";

const EVENTS: { [event: string]: string } = {
  onset: "onset",
  seat_off: "seat-off",
  standing: "standing",
  descent: "descent",
  seated: "seated",
  bottom: "bottom",
  heel_strike: "heel strike",
  toe_off: "toe-off",
  heel_strike_other: "other heel strike",
  toe_off_other: "other toe-off",
};
export const EVENTS_OF_WALKING = Object.entries(EVENTS).slice(-4);

// No finer than a workshop works.
const short = (value: number) => String(Number(value.toFixed(Math.abs(value) < 10 ? 2 : 1))).replace("-", "−");
const fixed = (value: number | null, digits: number) => (value === null ? "–" : value.toFixed(digits));

const capitalised = (name: string) => (/^l\d/.test(name) ? name : name[0].toUpperCase() + name.slice(1));
const withUnit = (value: number, unit: string) => short(value) + (unit === "deg" ? "°" : unit === "1" ? "" : ` ${unit}`);
const percentage = (part: number) => `${Math.round(100 * part)} %`;

const NO_BREAK = "\u00a0";
const BEFORE_UNIT = new RegExp(`(\\d) (?=(?:${UNITS.join("|")})(?![A-Za-z\\d]))`, "g");

/** The text with no line's end between a number and its unit, at "±", nor at the dash between two numbers. */
export const unbroken = (text: string) =>
  text
    .replace(BEFORE_UNIT, `$1${NO_BREAK}`)
    .replace(/(\d\u00a0N) m\b/g, `$1${NO_BREAK}m`)
    .replace(/ ?± /g, (at) => at.replace(/ /g, NO_BREAK))
    .replace(/(\d–)(?=\d)/g, "$1\u2060");

/** The same of all texts in it, and of those that its functions make. */
function allUnbroken<T>(texts: T): T {
  const made = (): unknown => {
    if (typeof texts === "string") return unbroken(texts);
    if (typeof texts === "function") return (...args: unknown[]) => allUnbroken(texts(...args) as unknown);
    if (Array.isArray(texts)) return texts.map(allUnbroken);
    if (typeof texts !== "object" || texts === null) return texts;
    return Object.fromEntries(Object.entries(texts).map(([key, text]) => [key, allUnbroken(text as unknown)]));
  };
  return made() as T;
}

export const TEXTS = allUnbroken({
  // What the program is doing
  loading: "Loading",
  fitting: "Fitting the leg",
  saved: (corrections: number, swaps: number) => {
    if (corrections === 0) return "No corrections";
    const swapped = swaps === 0 ? "" : swaps === 1 ? "1 swap: " : `${swaps} swaps: `;
    return `${swapped}${corrections === 1 ? "1 correction" : `${corrections} corrections`}, saved`;
  },
  unapplied: "The results in the folder were made without these corrections: apply them",
  applying: "Tracking again with the corrections",
  applied: "The results in the folder are made with the corrections",
  notApplied: (why: string) => `The results are as they were: ${why}`,
  ended: "lake review has ended; all corrections are saved. Start it again to go on.",
  noFit: (why: string) => `No leg can be fitted: ${why}`,

  // Frames
  frame: (frame: number, last: number, time_s: number, knee: number | null, sigma: number | null) =>
    `Frame ${frame} of ${last}, ${time_s.toFixed(3)} s` +
    (knee === null ? "" : `, knee ${knee.toFixed(1)}°${sigma === null ? "" : ` ± ${(2 * sigma).toFixed(2)}°`}`),
  done: { undo: "Undone", redo: "Done again" },
  play: "Play",
  noFrame: (text: string, first: number, last: number) => `${text}: frames ${first} to ${last} are there`,
  speed: (factor: number) => (factor === 1 ? "Real time" : `${factor} × real time`),
  pause: "Pause",
  event: (event: string, repetition: number) => `${EVENTS[event] ?? event} ${repetition}`,

  // Events
  events: (count: number) => (count === 0 ? "No rise and no stride found" : count === 1 ? "1 event" : `${count} events`),
  eventAt: (name: string, frame: number, isMoved: boolean) => `${name}, frame ${frame}${isMoved ? ", moved" : ""}`,
  eventMoved: (name: string, frame: number) => `${name} moved to frame ${frame}`,
  eventRestored: (name: string) => `${name} is where it was found`,
  chooseEvent: "Choose an event first (E)",
  eventIsThere: (name: string) => `${name} is there already: choose and move it`,

  // Markers
  status: { d: "detected", f: "filled", m: "missing" } as { [status: string]: string },
  // A place that a person pointed at is no measurement.
  corrected: (isSeen: boolean, sigma: number) => (!isSeen ? "hidden by you" : sigma >= 0.5 ? "placed by eye" : "corrected, measured"),
  position: (x: number, y: number, sigma: number) => `(${x.toFixed(2)}, ${y.toFixed(2)}) ± ${sigma.toFixed(2)} px`,
  placing: (marker: string) => `Click where ${marker} is; Esc ends it`,
  placedFree: (marker: string) => `${marker} placed where you pointed, ± 0.5 px: no marker was measured there`,
  snapped: (marker: string, x: number, y: number) => `${marker} snapped to (${x.toFixed(2)}, ${y.toFixed(2)})`,
  swapped: (one: string, other: string, frame: number) => `${one} and ${other} swapped from frame ${frame} on`,

  // Angles, distances and speeds
  measured: ({ measure, unit, value, sd }: CourseMessage, row: number) => {
    const digits = unit.startsWith("px") ? 2 : 1, known = value.filter((one) => one !== null) as number[];
    const said = unit === "deg" ? "°" : ` ${unit.replace("_s", "/s")}`;
    const least = known.reduce((a, b) => Math.min(a, b), Infinity), most = known.reduce((a, b) => Math.max(a, b), -Infinity);
    const here = value[row] ?? null, band = sd[row] ?? null;
    const text = here === null ? "not seen here" : fixed(here, digits) + said + (band === null ? "" : ` ± ${fixed(2 * band, digits + 1)}${said}`);
    return `${measure.name}: ${text}` + (known.length ? `; ${fixed(least, digits)} to ${fixed(most, digits)}${said}` : "");
  },
  sameMarkers: "Choose different markers",
  remove: "Remove",
  removeMeasure: (name: string) => `Remove ${name}`,
  measureWords: (measures: MeasureMessage[], isCommand: boolean) =>
    measures
      .map(({ kind, name, markers }) => `${isCommand ? ` --${kind} ` : `, ${kind}: `}${name}=${markers.join()}`)
      .join(""),

  // Problems
  problem: (kind: ProblemKind, marker: string, first: number, last: number, value: number) => {
    const frames = first === last ? `frame ${first}` : `frames ${first} to ${last}`;
    switch (kind) {
      case "gap":
        return `${marker} not seen, ${frames}`;
      case "outlier":
        return `${marker} ${value.toFixed(1)} px off the fit, ${frames}`;
      case "uncertain":
        return `${marker} uncertain, ± ${value.toFixed(2)} px, ${frames}`;
      case "length":
        return `Segment below ${marker} ${value.toFixed(2)} times its usual length, ${frames}; names exchanged?`;
    }
  },
  problems: (count: number) => (count === 0 ? "No problems found" : count === 1 ? "1 problem" : `${count} problems`),
  noProblem: "There is no further problem in this direction",

  // Charts
  knee: "Knee angle (°)",
  lengths: "Segment lengths in the picture (% from their median)",
  residuals: "Residuals (px)",
  places: (marker: string) => `Place of ${marker} (px from its median)`,
  copyCurves: "Copy",
  saveCurves: "Save as CSV",
  shank: "shank",
  thigh: "thigh",
  trunk: "trunk",

  // Naming
  finding: "Looking for markers",
  spots: (count: number) => (count === 1 ? "1 detection" : `${count} detections`),
  spot: (id: number, x: number, y: number, frame: number, moves: boolean) =>
    `#${id} at (${x.toFixed(0)}, ${y.toFixed(0)}) in frame ${frame}${moves ? "" : ", does not move"}`,
  choose: (name: string) => `Click ${name}`,
  pointAt: {
    scale: ["Click one end of the scale bar", "Click its other end"],
"plane-points": ["Click a point of the plane whose place is known", "Click the next one; Esc ends it"],
    vertical: ["Click one end of the plumb line", "Click its other end"],
    crop: ["Click one corner of the part to search", "Click the corner across"],
    color: ["Click a marker of the colour"],
  },
  barLength: "Length of the scale bar (mm)",
  planePlace: "Place of this point in the plane, mm: X,Y (right, up)",
  planePoints: (count: number) => (count < 4 ? `${count} of at least 4 points; click the next one` : `${count} points; click a further one, or Esc`),
  seedAt: (name: string, [x, y, frame]: [number, number, number]) => `${name}: (${x.toFixed(0)}, ${y.toFixed(0)}) in frame ${frame}`,
  unfound: (name: string, count: number) => `${name} was not found by itself: click it (1–${count})`,
  track: "Track",
  replaceTrial: "Replace the trial",
  trialThere: (folder: string) => `${folder} holds a trial already; it is replaced if you go on`,
  chooseDone: "All markers are named; choose a name to change one",
  taken: (spot: number, name: string) => `#${spot} is ${name}: choose ${name} to change it`,
  addMarker: (name: string) => `Add ${name}`,
  useCamera: (file: string) => `Use ${file}`,
  tracking: "Tracking",
  trackingFailed: (why: string) => `Tracking ended without a result: ${why}`,
  copied: "Copied",

  // Comparison
  role: { human: "Without exoskeleton", exo: "With exoskeleton" },
  compared: (role: string, video: string, marker: string) => `${role}: ${video}, ${marker}`,
  rise: (repetition: number) => `rise ${repetition}`,
  noRise: "There is no rise in this trial",
  ofRise: (percent: number, distance: number | null, human: number | null, exo: number | null) =>
    `${percent} % of the rise: ${fixed(distance, 1)} mm apart, knee ${fixed(human, 1)}° and ${fixed(exo, 1)}°`,
  misalignment: "Path difference of the knees (mm) over the rise, 0 to 100 %",
  ofRises: (rms: number, human: number, exo: number) =>
    `${rms.toFixed(1)} mm RMS between ${human ? `rise ${human}` : "the mean"} without and ${exo ? `rise ${exo}` : "the mean"} with exoskeleton`,
  meanRise: "mean of all rises",
  riseLeftOut: "This rise does not count in the comparison: the warnings of lake compare say why",
  knees: "Knee angles (°)",
  human: "without",
  exo: "with",
  comparisonState: (rms: number, parts: Record<string, number>) =>
    `${rms.toFixed(1)} mm RMS: ${Object.entries(parts).map(([name, share]) => `${name} ${percentage(share)}`).join(", ")}`,

  // Study
  studyPart: {
    human: "Trial without exoskeleton",
    exo: "Trial with exoskeleton",
    comparison: "Both side by side",
    redesign: "New design",
    optimum: "Benchmark optimum",
  } as { [step in StudyPart["step"]]: string },
  reportFile: (path: string) => `Links to files work in the report itself: ${path}`,
  noReport: "There is no report yet",

  // Start
  foundCount: (count: number) => (count === 1 ? "1 file or result" : `${count} files and results`),
  openFound: "Open",
  choose_one: (kind: string) => `choose a ${kind}`,
  without: (what: string) => `no ${what}`,
  done_step: (path: string) => `✓ ${path}`,
  making: "Under way",
  made: "Done",
  notMade: (why: string) => `It failed: ${why}`,

  // Design
  links: ["coupler RS", "slewing bar PR", "thigh link KP", "shank link KS", "mount behind thigh", "mount above P"],
  bounds: (lower: number, upper: number) => `${lower}–${upper} mm`,
  pins: { thigh_pin: "P", tip: "R", shank_pin: "S", mount: "M" } as { [pin in PinName]: string },
  knee_pin: "K",
  range: (degrees: number | null) => (degrees === null ? "Cannot be assembled" : `Range ${degrees.toFixed(2)}°`),
  failing: (failed: number, all: number) =>
    failed === 0 ? `meets all ${all} requirements asked` : failed === 1 ? "fails 1 requirement" : `fails ${failed} requirements`,
  unknown: "Not known of these links",
  notAsked: (names: string[]) => (names.length === 0 ? "" : `; not asked, and not met: ${names.join(", ")}`),
  gap: (why: string) => `These links cannot be assembled: ${why}.`,
  asDrawn: (tolerance: number) => ` as drawn; builds within ± ${tolerance} mm follow`,
  ofBuilds: (tolerance: number) => `, also with every length off by up to ${tolerance} mm`,
  check: ({ name, is_lower_limit, limit, unit, value, asked }: CheckMessage) => {
    const shown = value === null ? "cannot be evaluated" : withUnit(value, unit);
    if (!asked) return `${capitalised(name)}: ${shown}`;
    // The order of two links says its limit by its name.
    if (name.includes("≤")) return `${name}${value === null ? `: ${shown}` : ""}`;
    return `${capitalised(name)} ${is_lower_limit ? "≥" : "≤"} ${withUnit(limit!, unit)}: ${shown}`;
  },
  slack: ({ slack, holds, unit, asked, limit, is_lower_limit }: CheckMessage) =>
    !asked && limit === null ? (holds ? "" : "cannot be evaluated")
    : slack === null ? ""
    : !asked && !is_lower_limit ? `${holds ? "within" : "above"} the ${withUnit(limit!, unit)} of the design`
    : !asked ? `not asked${holds ? "" : `; at least ${withUnit(limit!, unit)} is needed`}`
    : !holds ? `fails by ${withUnit(-slack, unit)}`
    : slack < 0.005 ? "at its limit" : `${withUnit(slack, unit)} to spare`,
  worst: ({ worst }: CheckMessage) =>
    worst?.knee_deg !== undefined ? `at ${worst.knee_deg.toFixed(1)}°`
    : worst?.percent !== undefined ? `at ${worst.percent.toFixed(0)} % of the rise` : "",
  pose: (stroke: number, knee: number | null, arm: number | null, force: number | null) =>
    `d ${stroke.toFixed(1)} mm, θ ${fixed(knee, 1)}°, moment arm ${fixed(arm, 1)} mm, force ${fixed(force, 0)} N`,
  kneeOverStroke: (first: number, last: number) => `Knee angle θ (°) over the stroke d, ${first.toFixed(1)} to ${last.toFixed(1)} mm`,
  noCurves: "No curves: these links cannot be assembled",
  arm: "Moment arm (mm)",
  force: (torque: number) => `Actuator force (N) for a knee torque of ${torque} N m`,
  now: "now",
  saved_design: "saved",
  savedAs: (path: string) => `Saved as ${path}`,
  optimising: "Optimising",
  optimiseFailed: (why: string) => `No optimum: ${why}`,
  optimised: "The optimum from these links; Undo goes back to them",

  // Live
  liveEnded: "lake live has ended; what was recorded is in its folder",
  phase: ({ phase, is_held, recorded_s, end, has_trial }: LiveStateMessage) =>
    is_held ? "The film waits for Begin trial"
    : phase === "watching" ? `Recording, ${recorded_s.toFixed(0)} s; begin the trial when the person sits`
    : phase === "trial" ? `Trial, ${recorded_s.toFixed(0)} s recorded`
    : phase === "finishing" ? `${end ? `The recording has ended: ${end}. ` : ""}Making the trial`
    : has_trial ? `The trial is ready: ${end}` : "There is no trial",
  beginTrial: "Begin trial",
  endTrial: "End trial",
  late: (late_s: number) => `The picture is ${late_s.toFixed(0)} s late: this computer is too busy. What is recorded is whole`,
  measuring: "Stand up and sit down: the joint's place is shown after each rise",
  notNamed: (missing: string[]) => `Not named yet: ${missing.join(", ")}. Stand up and sit down once, or click a name and then its marker`,
  toleranceText: ({ verdict, do_rises_narrow }: LivePlace, tolerance: number) =>
    verdict === "within" ? `✓ Within ${tolerance} mm`
    : verdict === "beyond" ? `✗ Not within ${tolerance} mm`
    : do_rises_narrow ? `? Not known yet whether within ${tolerance} mm: one more rise`
    : `? Cannot be distinguished from ${tolerance} mm`,
  placeDetail: (rises: number, where: string, beneath: number, [x, y]: Pair) =>
    `${rises === 1 ? "1 rise" : `mean of ${rises} rises`} since the joint was put there: it sits ${where}; of the joint beneath the skin ± ${beneath.toFixed(0)} mm${x !== 0 || y !== 0 ? `; assumes that the joint's marker is ${x}, ${y} mm from the axis (--joint-at)` : ""}`,
  riseRow: (rise: number, x: number, y: number, moves: number) =>
    `Rise ${rise}: ${Math.abs(x).toFixed(0)} mm ${x >= 0 ? "in front of" : "behind"}, ${Math.abs(y).toFixed(0)} mm ${y >= 0 ? "above" : "below"} the knee${moves ? ` (after move ${moves})` : ""}`,
  riseCount: (count: number) => (count === 0 ? "No rise yet" : count === 1 ? "1 rise" : `${count} rises`),
  movedSaid: (moves: number) => `Move ${moves} noted; the next rises show the new place`,
  clickSpot: (name: string) => `Click the marker ${name}; Esc ends it`,
  named: (name: string) => `${name} named`,
  liveKnee: "Knee angle (°), the last 20 s",
  liveJoint: "Joint against the knee (mm), the last 20 s",
  anterior: "in front",
  above: "above",
  difference: (px: number) => `Live positions differ from the trial's by ${px.toFixed(3)} px (root mean square)`,
  checkCount: (bad: number) => (bad === 0 ? "Pictures: all good" : bad === 1 ? "Pictures: 1 change needed" : `Pictures: ${bad} changes needed`),
});
