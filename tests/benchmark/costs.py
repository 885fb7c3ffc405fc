#!/usr/bin/env python3
"""What a run costs as its input grows: processor time of lake-gait over frames, of lake-calibrate over views, of lake-optimize over
starts, and of each program's start. Where the cost is linear the time per unit stays, and the exponent is 1. With --against another
build's folder of programs, whole runs of both in turn, and how much less time this one takes.

costs.py [--quick] [--only gait calibrate optimize begin]     LAKE_BIN names the folder of the programs, build/test/bin by default
costs.py --against FOLDER [--rounds N]
"""
import argparse
import csv
import math
import os
import pathlib
import random
import statistics
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "faults"))
import programs  # noqa: E402

SIZES = {
    False: {"gait": (12_500, 25_000, 50_000, 100_000), "calibrate": (60, 125, 250, 500), "optimize": (1250, 2500, 5000, 10_000)},
    True: {"gait": (12_500, 100_000), "calibrate": (30, 120), "optimize": (10, 40)},
}
UNITS = {"gait": "frames", "calibrate": "views", "optimize": "starts"}


def processor_s(words, folder, bin_folder=programs.BIN):
    """Of a run that must end well, all its processes together, and its largest memory in MB."""
    command = [str(bin_folder / words[0])] + [str(word) for word in words[1:]]
    previous = os.getcwd()
    os.chdir(folder)
    try:
        silent = [(os.POSIX_SPAWN_OPEN, stream, "/dev/null", os.O_RDWR, 0) for stream in (0, 1, 2)]
        child = os.posix_spawn(command[0], command, os.environ, file_actions=silent)
    finally:
        os.chdir(previous)
    _, status, usage = os.wait4(child, 0)
    if status:
        sys.exit(f"{' '.join(command)} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def make_tracks(folder, frames):
    """A leg that rises and sits down every four seconds, seen at 60 Hz with noise of 0.3 mm."""
    rng = random.Random(1)
    with open(folder / "trial.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["frame", "time_s"] + [f"{name}_{cell}" for name in ("ankle", "knee", "hip", "waist")
                                               for cell in ("x_mm", "y_mm", "sigma_mm", "status")])
        for frame in range(frames):
            time_s = frame / 60
            bend = math.radians(45 * (1 + math.cos(2 * math.pi * time_s / 4)))  # of the knee, 0 when it stands
            lean = 0.35 * math.sin(bend)
            knee = (400 * math.sin(0.2 * bend), 400 * math.cos(0.2 * bend))
            hip = (knee[0] - 420 * math.sin(0.8 * bend), knee[1] + 420 * math.cos(0.8 * bend))
            waist = (hip[0] + 200 * math.sin(lean), hip[1] + 200 * math.cos(lean))
            cells = [[f"{x + rng.gauss(0, 0.3):.4f}", f"{y + rng.gauss(0, 0.3):.4f}", 0.3, "detected"]
                     for x, y in ((0, 0), knee, hip, waist)]
            table.writerow([frame, f"{time_s:.9f}"] + sum(cells, []))
    return ["lake-gait", "trial.csv"]


def make_views(folder, views):
    rng = random.Random(1)
    if not (folder / "views").is_dir():
        (folder / "views").mkdir()
        for number in range(30):
            tilt, turn = rng.uniform(-30, 30), rng.uniform(-30, 30)
            programs.view_of_board(folder / "views" / f"{number}.pgm", tilt, turn, (rng.uniform(-20, 20), rng.uniform(-10, 10)))
    for number in range(30, views):
        picture = folder / "views" / f"{number}.pgm"
        if not picture.exists():
            os.link(folder / "views" / f"{number % 30}.pgm", picture)
    return ["lake-calibrate"] + [f"views/{number}.pgm" for number in range(views)] + ["--board", "chessboard:6x4:25"]


def make_starts(_, starts):
    problem = programs.ROOT / "calibration/problems/buildable.yaml"
    return ["lake-optimize", "--problem", problem, "--starts", starts]


MAKE = {"gait": make_tracks, "calibrate": make_views, "optimize": make_starts}


def show_growth(name, sizes, folder):
    times = []
    for size in sizes:
        time_s, memory_mb = processor_s(MAKE[name](folder, size) + ["--quiet", "-o", f"out-{name}"], folder)
        times.append(time_s)
        print(f"lake-{name:10} {size:7} {UNITS[name]:6} {time_s:8.2f} s {1000 * time_s / size:8.3f} ms each {memory_mb:6.0f} MB", flush=True)
    grown = math.log(times[-1] / times[0]) / math.log(sizes[-1] / sizes[0])
    print(f"lake-{name:10} exponent {grown:.2f}", flush=True)


def show_beginnings(folder):
    for program in sorted(programs.BIN.glob("lake*")):
        if program.name.startswith("lake_"):
            continue  # tests and benchmarks
        best_s = min(processor_s([program.name, "--version"], folder)[0] for _ in range(10))
        print(f"{program.name:16} begins in {1000 * best_s:4.0f} ms", flush=True)


WHOLE = {
    "lake-optimize --version": ["lake-optimize", "--version"],
    "lake-optimize, one start": ["lake-optimize", "--starts", 1, "--quiet", "-o", "out"],
    "lake-optimize, 100 starts": ["lake-optimize", "--starts", 100, "--quiet", "-o", "out"],
    "lake-track --version": ["lake-track", "--version"],
}


def compare_with(other, rounds, folder):
    """Medians of runs of both in turn: what else the machine does meets both."""
    for name, words in WHOLE.items():
        pairs = [(processor_s(words, folder, other)[0], processor_s(words, folder)[0]) for _ in range(rounds)]
        before_s, now_s = (statistics.median(times) for times in zip(*pairs))
        ratio = statistics.median(now / before for before, now in pairs)
        print(f"{name:26} {1000 * before_s:6.0f} ms before {1000 * now_s:6.0f} ms now, ratio {ratio:.2f}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="*", default=["begin", "gait", "calibrate", "optimize"])
    parser.add_argument("--against", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        if asked.against:
            compare_with(asked.against.resolve(), asked.rounds, folder)
            return
        for name in asked.only:
            if name == "begin":
                show_beginnings(folder)
            else:
                show_growth(name, SIZES[asked.quick][name], folder)


if __name__ == "__main__":
    main()
