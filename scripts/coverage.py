#!/usr/bin/env python3
"""Which lines of the rooms a build with counts has run: coverage.py BUILD [--least PERCENT]

Prints each room's lines and the share of them that was run, least first; BUILD/missed.txt names the lines that were not. Ends
with 1 where less than PERCENT of all were run. What gcov counts in a header that several sources include is taken together.
"""
import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def counts_of(notes):
    """File, line and count of all that gcov knows of one compiled source."""
    ended = subprocess.run(["gcov", "-t", "-j", str(notes)], cwd=notes.parent, capture_output=True, text=True, check=False)
    for report in map(json.loads, filter(None, ended.stdout.splitlines())):
        for file in report["files"]:
            path = os.path.normpath(os.path.join(report["current_working_directory"], file["file"]))
            for line in file["lines"]:
                yield path, line["line_number"], line["count"]


def lines_run(build):
    """Of each file of libs, by its path from there: whether each line that can be run was."""
    files = collections.defaultdict(dict)
    for notes in sorted((build.resolve() / "libs").rglob("*.gcno")):
        for path, line, count in counts_of(notes):
            if path.startswith(f"{ROOT}/libs/"):
                lines = files[os.path.relpath(path, ROOT / "libs")]
                lines[line] = lines.get(line, False) or count > 0
    return files


def room_of(path):
    folders = pathlib.PurePath(path).parts
    return "/".join(folders[:2]) if folders[1] not in ("src", "include") else folders[0]


def ranges(numbers):
    """12-14,20 of 12, 13, 14 and 20."""
    runs = []
    for number in sorted(numbers):
        if runs and runs[-1][1] == number - 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ",".join(f"{first}-{last}" if first < last else str(first) for first, last in runs)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--least", type=float, default=0)
    asked = parser.parse_args()
    rooms = collections.defaultdict(list)
    missed = []
    for path, lines in sorted(lines_run(asked.build).items()):
        rooms[room_of(path)] += lines.values()
        if not all(lines.values()):
            missed.append(f"libs/{path}:{ranges(line for line, was_run in lines.items() if not was_run)}\n")
    if not rooms:
        sys.exit(f"{asked.build}: nothing was compiled with counts here; scripts/coverage.sh does that")
    (asked.build / "missed.txt").write_text("".join(missed))

    def share(lines):
        return 100 * sum(lines) / len(lines)

    print("| room | lines | run |\n| --- | --- | --- |")
    for room, lines in sorted(rooms.items(), key=lambda item: share(item[1])):
        print(f"| {room} | {len(lines)} | {share(lines):.1f} % |")
    everything = [was_run for lines in rooms.values() for was_run in lines]
    print(f"| all | {len(everything)} | {share(everything):.1f} % |")
    sys.exit(1 if share(everything) < asked.least else 0)


if __name__ == "__main__":
    main()
