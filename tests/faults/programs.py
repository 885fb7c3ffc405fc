"""Every program once, on small inputs of its own making: what the trials of faults and of determinism start from.

programs.py FOLDER makes the inputs there; about 5 s of processor time.
"""
import csv
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("LAKE_BIN", ROOT / "build/test/bin"))

MARKERS = "ankle,knee,hip,waist"
POINTS = "360,330=0,0; 360,120=0,420; 240,120=-240,420; 240,40=-240,580"

CAMERA = """%YAML:1.0
---
image_width: 640
image_height: 360
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 965.5, 0., 319.5, 0., 965.5, 179.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
plane_rvec: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 3.1415926535897931, 0., 0. ]
plane_tvec: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 114.5, 524.5, 3500. ]
"""

DUTY_TABLE = "duty,extend_mm_s,retract_mm_s,tolerance_percent\n0.2,0,0,\n0.3,8,8.2,3\n1,30,31,3\n"

EVENTS = "repetition,event,frame\n1,onset,14\n1,standing,50\n"

SEGMENTS = """source: made up
foot: {mass: 0.0145, centre: 0.5, gyration: 0.475}
shank: {mass: 0.0465, centre: 0.433, gyration: 0.302}
thigh: {mass: 0.1, centre: 0.433, gyration: 0.323}
trunk: {mass: 0.678, centre: 0.626, gyration: 0.496}
"""

COHORT = """name: Small
task: sitstand
steps: [comparison]
study:
  camera: $cohort/camera.yaml
  human: {video: human.mp4, markers: [ankle, knee, hip, waist]}
  exo: {video: exo.mp4, markers: [ankle, knee, hip, waist, exo_knee]}
  loads: {mass_kg: $mass_kg}
people:
  sub-02: {exo: {seeds: ["exo_knee=740,415"]}}
"""

PARTICIPANTS = "participant_id\tage\tmass_kg\theight_mm\nsub-01\t31\t70.5\t1750\nsub-02\t28\tn/a\t1690\n"

STUDY = """name: Small
camera: camera.yaml
human: {video: video.mp4, seeds: [KNEE]}
exo: {trial: te}
loads: {mass_kg: 70}
stroke: {duty_table: duty.csv, speed_mm_s: 5, accept_drift: true}
design: {problem: problem.yaml, starts: 2}
"""


def view_of_board(path, tilt_deg, turn_deg, shift_mm):
    """A chessboard of 6x4 inner corners and 25 mm as a pinhole camera sees it, each pixel the mean of four rays."""
    width, height, focal, distance = 240, 180, 220, 300
    tilt, turn = math.radians(tilt_deg), math.radians(turn_deg)
    x_axis = (math.cos(turn), math.sin(turn) * math.sin(tilt), -math.sin(turn) * math.cos(tilt))
    y_axis = (0, math.cos(tilt), math.sin(tilt))
    normal = (x_axis[1] * y_axis[2] - x_axis[2] * y_axis[1], x_axis[2] * y_axis[0] - x_axis[0] * y_axis[2],
              x_axis[0] * y_axis[1] - x_axis[1] * y_axis[0])
    centre = (shift_mm[0], shift_mm[1], distance)
    offset = sum(n * c for n, c in zip(normal, centre))

    def level(u, v):
        ray = ((u - width / 2) / focal, (v - height / 2) / focal, 1)
        reach = offset / sum(n * r for n, r in zip(normal, ray))
        on_board = [reach * r - c for r, c in zip(ray, centre)]
        x = sum(p * a for p, a in zip(on_board, x_axis)) / 25 + 3.5
        y = sum(p * a for p, a in zip(on_board, y_axis)) / 25 + 2.5
        return 30 if 0 <= x < 7 and 0 <= y < 5 and (int(x) + int(y)) % 2 == 0 else 220

    rays = (-0.25, 0.25)
    pixels = bytes(sum(level(u + du, v + dv) for du in rays for dv in rays) // 4
                   for v in range(height) for u in range(width))
    path.write_bytes(b"P5 %d %d 255\n" % (width, height) + pixels)


def actuator_log():
    """Two plateaus of each of four duties."""
    rows, time_s, stroke_mm = ["time_s,stroke_mm,duty"], 0.0, 300.0
    for duty in (0.3, -0.3, 0.5, -0.5, 0.8, -0.8, 1.0, -1.0) * 2:
        for part, samples in ((0.0, 25), (duty, 100)):
            for _ in range(samples):
                stroke_mm += 0.02 * math.copysign(max(0.0, abs(part) * 12 - 1.5), part)
                time_s += 0.02
                rows.append(f"{time_s:.2f},{stroke_mm:.4f},{part}")
    return "\n".join(rows) + "\n"


def ground_forces():
    """A plate that bears half a person for 4 s, as OpenSim has it."""
    axes = [f"ground_force_1_{what}{axis}" for what in "vpm" for axis in "xyz"]
    rows = [f"{i / 100:.2f}\t" + "\t".join(map(str, (5, 340 + 40 * math.sin(i / 20), -3, 0.05, 0, 0.1, 0, 0.4, 0)))
            for i in range(401)]
    head = ["forces", "version=1", f"nRows={len(rows)}", f"nColumns={len(axes) + 1}", "inDegrees=yes", "endheader"]
    return "\n".join(head + ["\t".join(["time"] + axes)] + rows) + "\n"


def make_cohort(folder):
    """Two people whose videos are not there, so that cohort and studies are read and none is done."""
    for person in ("sub-01", "sub-02/ses-1"):
        (folder / "sourcedata" / person).mkdir(parents=True, exist_ok=True)
        (folder / "sourcedata" / person / "notes.txt").write_text("Videos to come.\n")
    (folder / "cohort.yaml").write_text(COHORT)
    (folder / "participants.tsv").write_text(PARTICIPANTS)


def seeds(folder):
    """Where the markers are that are no part of the leg, or beside one that is not, in the first frame."""
    with open(folder / "rendering/truth.csv", encoding="utf-8") as table:
        first = next(csv.DictReader(table))
    return [word for name in ("knee", "exo_knee")
            for word in ("--seed", f"{name}={float(first[name + '_x_px']):.1f},{float(first[name + '_y_px']):.1f}")]


def run(arguments, folder, **options):
    """The ended program; `arguments` begin with a program's name. Its output is kept, as text."""
    command = [str(BIN / arguments[0])] + [str(argument) for argument in arguments[1:]]
    return subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                          check=False, **options)


def must_run(arguments, folder):
    ended = run(arguments, folder)
    if ended.returncode:
        sys.exit(f"{' '.join(map(str, arguments))} ended with {ended.returncode}: {ended.stderr}")
    return ended


def make_inputs(folder):
    """Fills `folder` with all that COMMANDS read."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "camera.yaml").write_text(CAMERA)
    (folder / "duty.csv").write_text(DUTY_TABLE)
    (folder / "log.csv").write_text(actuator_log())
    (folder / "events.csv").write_text(EVENTS)
    (folder / "forces.mot").write_text(ground_forces())
    (folder / "segments.yaml").write_text(SEGMENTS)
    make_cohort(folder / "cohort")
    (folder / "corrections.csv").write_text("frame,marker,x_px,y_px\n5,knee,,\n")
    shutil.copy(ROOT / "data/sts-study/worn.yaml", folder / "worn.yaml")
    shutil.copy(ROOT / "calibration/problems/buildable.yaml", folder / "problem.yaml")
    shutil.copy(ROOT / "calibration/actuators.csv", folder / "actuators.csv")
    for number, (tilt, turn, x, y) in enumerate(
            ((0, 0, 0, 0), (25, 10, -15, 5), (-20, 20, 10, -5), (15, -25, 20, 10), (-25, -15, -20, -10), (5, 30, 0, 10))):
        view_of_board(folder / f"board{number}.pgm", tilt, turn, (x, y))
    must_run(["lake-synth", "--seed-number", 3, "--repetitions", 1, "--rate", 30, "--pace", 0.7, "--rest", 0.4, "--crf", 23,
              "--width", 640, "--height", 360, "--camera", "camera.yaml", "--radius-px", 7, "--exo", "60,60", "--quiet",
              "-o", "rendering"], folder)
    shutil.copy(folder / "rendering/video.mp4", folder / "video.mp4")
    (folder / "study.yaml").write_text(STUDY.replace("KNEE", f'"{seeds(folder)[1]}"'))
    track = ["lake-track", "video.mp4", "--camera", "camera.yaml", "--quiet"]
    must_run(track + seeds(folder)[:2] + ["--no-overlay", "-o", "th"], folder)
    must_run(track + seeds(folder) + ["--markers", MARKERS + ",exo_knee", "--no-overlay", "-o", "te",
                                      "--export", "trc,c3d,tracker,trk,kinovea,kva,mot"], folder)
    must_run(["lake-compare", "th", "te", "--quiet", "-o", "comparison"], folder)
    shutil.copytree(folder / "comparison", folder / "comparison2", dirs_exist_ok=True)
    must_run(["lake-loads", "th", "--mass", 70, "--quiet", "-o", "loads"], folder)


def commands(folder):
    """Name, then the words of a run that ends well in `folder`, without where to (`into`); inputs are named relative to it."""
    track = ["lake-track", "video.mp4", "--camera", "camera.yaml"]
    reoptimize = ["lake-optimize", "--problem", "problem.yaml", "--human-only", "--penalty", "1", "--starts", "1"]
    return {
        "calibrate": ["lake-calibrate"] + [f"board{i}.pgm" for i in range(6)] + ["--board", "chessboard:6x4:25"],
        "calibrate-plane": ["lake-calibrate", "plane", "video.mp4", "--camera", "camera.yaml", "--points", POINTS],
        "calibrate-board": ["lake-calibrate", "board", "--board", "chessboard:9x6:25", "--paper", "a4"],
        "check": ["lake-check", "video.mp4", "--markers", "ankle,knee,hip,waist"],
        "track": track + seeds(folder)[:2] + ["--corrections", "corrections.csv"],
        "track-exo": track + seeds(folder) + ["--markers", MARKERS + ",exo_knee", "--no-overlay", "--export", "trc,c3d,kva"],
        "track-list": ["lake-track", "video.mp4", "--list"],
        "anonymise": ["lake-anonymise", "video.mp4", "--trial", "th"],
        "gait": ["lake-gait", "th"],
        "loads": ["lake-loads", "th", "--mass", "70"],
        "compare": ["lake-compare", "th", "te"],
        "optimize": ["lake-optimize", "--problem", "problem.yaml", "--starts", "2"],
        "reoptimize": reoptimize + ["--comparison", "comparison"],
        "reoptimize-group": reoptimize + ["--comparison", "comparison", "--comparison", "comparison2"],
        "simulate": ["lake-simulate", "worn.yaml", "--no-animation"],
        "export-mjcf": ["lake-export", "worn.yaml", "mjcf"],
        "export-urdf": ["lake-export", "worn.yaml", "urdf"],
        "export-step": ["lake-export", "worn.yaml", "step"],
        "export-dxf": ["lake-export", "worn.yaml", "dxf"],
        "stroke": ["lake-stroke", "worn.yaml", "--speed", "5", "--duty-table", "duty.csv", "--accept-drift"],
        "stroke-calibrate": ["lake-stroke", "calibrate", "log.csv"],
        "synth": ["lake-synth", "--duration", "0.2", "--width", "320", "--height", "180"],
        "run": ["lake-run", "study.yaml"],
        "convert": ["lake-convert", "th"],
    }


def into(words, out, folder):
    """The words of a run that writes into the folder `out` of `folder`."""
    if words[0] != "lake-convert":
        return words + ["--quiet", "-o", out]
    (folder / out).mkdir(exist_ok=True)  # it makes none
    return words + [f"{out}/converted.trc"]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make_inputs(pathlib.Path(sys.argv[1]))
