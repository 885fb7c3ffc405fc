#!/usr/bin/env python3
"""Prints what the benchmarks measured as tables: processor time of ours, each peer, and their ratio; how exact each is."""
import json
import pathlib
import re
import sys

MILLISECONDS = {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}


def measurements(*files):
    """By case (radius, margin, noise): what was measured of each competitor, in the order of the files."""
    cases = {}
    for row in (row for file in files for row in json.loads(file.read_text())["benchmarks"]):
        name, case = re.sub(r"/(real_time|iterations:\d+)", "", row["name"]).rsplit("/", 1)
        row["ms"] = row["cpu_time"] * MILLISECONDS[row["time_unit"]]
        cases.setdefault(case, {})[name.split("/")[-1]] = row
    return cases


def print_table(title, cases, case_name, ours, columns):
    print(f"\n{title}\n{case_name:<24}{'':<22}{'ms':>12}{'ours = 1':>12}" + "".join(f"{c:>14}" for c in columns))
    for case, rows in cases.items():
        for name, row in rows.items():
            if any(column not in row for column in columns):
                continue
            ratio = row["ms"] / rows[ours]["ms"]
            values = "".join(f"{row[column]:>14.5g}" for column in columns)
            print(f"{case:<24}{name:<22}{row['ms']:>12.3f}{ratio:>12.2f}{values}")


def main():
    folder = pathlib.Path(sys.argv[1])
    print_table("Markers in a picture of 1920x1080", measurements(folder / "detection.json"), "radius, px", "lake",
                ["found", "rms_px", "false"])
    print_table("The paper's synthesis problem, 20 starts", measurements(folder / "synthesis.json"), "margin, mm", "Ipopt",
                ["best_deg", "reached", "evaluations"])
    print_table("A camera from a board's corners, 1280x720; spoilt: one corner in eighteen up to 8 px off",
                measurements(folder / "calibration.json"), "views, noise in px", "lake", ["focal_px", "centre_px", "lens_px"])
    scipy = folder / "smoothing_scipy.json"
    print_table("A knee's angle of 10 s at 60 Hz, and its speed", measurements(folder / "smoothing.json", scipy), "noise, deg", "lake",
                ["angle_deg", "speed_deg_s"])
    if missing := json.loads(scipy.read_text()).get("missing"):
        print(missing)


if __name__ == "__main__":
    main()
