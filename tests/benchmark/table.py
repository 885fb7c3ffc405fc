#!/usr/bin/env python3
"""Prints what the detection and synthesis benchmarks measured as one table: processor time of ours, each peer, and their ratio."""
import json
import pathlib
import sys

MILLISECONDS = {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}


def measurements(file):
    """By case (radius, margin): what was measured of each competitor, in the order of the file."""
    cases = {}
    for row in json.loads(file.read_text())["benchmarks"]:
        name, case = row["name"].split("/real_time")[0].replace("/iterations:1", "").rsplit("/", 1)
        row["ms"] = row["cpu_time"] * MILLISECONDS[row["time_unit"]]
        cases.setdefault(case, {})[name.split("/")[-1]] = row
    return cases


def print_table(title, cases, case_name, ours, columns):
    print(f"\n{title}\n{case_name:<14}{'':<22}{'ms':>12}{'ours = 1':>12}" + "".join(f"{c:>14}" for c in columns))
    for case, rows in cases.items():
        for name, row in rows.items():
            if any(column not in row for column in columns):
                continue
            ratio = row["ms"] / rows[ours]["ms"]
            values = "".join(f"{row[column]:>14.5g}" for column in columns)
            print(f"{case:<14}{name:<22}{row['ms']:>12.3f}{ratio:>12.2f}{values}")


def main():
    folder = pathlib.Path(sys.argv[1])
    print_table("Markers in a picture of 1920x1080", measurements(folder / "detection.json"), "radius, px", "lake",
                ["found", "rms_px", "false"])
    print_table("The paper's synthesis problem, 20 starts", measurements(folder / "synthesis.json"), "margin, mm", "Ipopt",
                ["best_deg", "reached", "evaluations"])


if __name__ == "__main__":
    main()
