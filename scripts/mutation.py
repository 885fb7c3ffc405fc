#!/usr/bin/env python3
"""How much of the numerical code the tests hold: plants small mutations and reports, room by room, how many the tests notice.

    scripts/mutation.py [--rooms gait,axis] [--per-room 25] [--seed 1] [--tests fast|default|nightly] [--minutes 60]

A mutation exchanges two operators (+ -, * /, < >, && ||, min max, sin cos), negates the condition of an `if`, or changes a number
by a tenth. All are compiled in at once, in a copy of the sources in build/mutation; the environment variable LAKE_MUTANT chooses
one. What does not compile, such as an exchange in a constant expression, is left out. Each mutation that is drawn runs the test
program of its room alone, its fast tests first, then the slow ones, then all with as many draws as at night, up to those of
--tests; it is noticed if a test fails, crashes, or takes four times the processor time that it takes without it. The result is a
table of the shares that each of these sets of tests notices, with 95 % intervals (Wilson), and build/mutation/mutants.csv, one row
a mutation: room, file, line, before, after, noticed by (fast, default, nightly, or none)."""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build/mutation"
# Room -> the test program that looks at it, where that has another name.
TESTS = {"problem": "synthesis", "certificate": "synthesis", "redesign": "synthesis"}
LAYERS = ("base", "measure", "design")
# Sets of tests by ctest's labels; "nightly" runs all anew, with as many draws as at night.
LEVELS = {"fast": ["-L", "fast", "-LE", "nightly"], "default": ["-LE", "nightly|fast"], "nightly": []}
LONGEST = 900  # seconds of processor; a room whose tests take longer without a mutation is left out
HEADER = """#pragma once
#include <cstdlib>
inline const int kLakeMutant = std::getenv("LAKE_MUTANT") ? std::atoi(std::getenv("LAKE_MUTANT")) : -1;
inline bool LakeMutant(int number) { return kLakeMutant == number; }
"""
EXCHANGED = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">", ">": "<", "<=": ">", ">=": "<", "&&": "||", "||": "&&"}
OPERAND = r"(?:[A-Za-z_][\w.]*(?:\[[\w ]+\]|\([\w.,: ]*\))?|\d+(?:\.\d*)?(?:e-?\d+)?)"


class Mutant:
    def __init__(self, room, path, line, begin, end, after):
        self.room, self.path, self.line, self.begin, self.end, self.after = room, path, line, begin, end, after
        self.number = None

    def code(self):
        return self.after.replace("LakeMutant({})", f"LakeMutant({self.number})")


def closing(text, begin):
    """Where the parenthesis that opens at `begin` closes; -1 beyond this line."""
    depth = 0
    for i in range(begin, len(text)):
        depth += {"(": 1, ")": -1}.get(text[i], 0)
        if depth == 0:
            return i
    return -1


def mutants_of_line(text):
    """(begin, end, after) of what may be exchanged in a line of code; `after` has {} for the number."""
    for m in re.finditer(rf"(?<![\w.\])*/%+-])(?<![*/%+\-&|<>=!] )({OPERAND}) (\+|-|\*|/) ({OPERAND})(?![\w.(\[]| [*/%]|->|\))", text):
        yield m.start(), m.end(), f"(LakeMutant({{}}) ? {m[1]} {EXCHANGED[m[2]]} {m[3]} : {m[0]})"
    for m in re.finditer(rf"(?<![\w.\])*/%+-])(?<![*/%+\-<>=!] )({OPERAND}) (<=|>=|<|>) ({OPERAND})(?![\w.(\[]| [*/%+-]|->|:|>)", text):
        yield m.start(), m.end(), f"(LakeMutant({{}}) ? {m[1]} {EXCHANGED[m[2]]} {m[3]} : {m[0]})"
    for m in re.finditer(r"\b(std::)?(min|max|sin|cos)\(", text):
        other = {"min": "max", "max": "min", "sin": "cos", "cos": "sin"}[m[2]]
        end = closing(text, m.end() - 1)
        if end > 0:
            rest = text[m.end() - 1:end + 1]
            yield m.start(), end + 1, f"(LakeMutant({{}}) ? {m[1] or ''}{other}{rest} : {m[0][:-1]}{rest})"
    for m in re.finditer(r"\bif \(", text):
        end = closing(text, m.end() - 1)
        condition = text[m.end():end]
        if end > 0 and ";" not in condition and "=" not in re.sub(r"[=!<>]=", "", condition):
            yield m.end(), end, f"LakeMutant({{}}) != static_cast<bool>({condition})"
    for m in re.finditer(r"(?<![\w.])(\d+\.\d+|\d+e-?\d+)(?![\w.])", text):
        if float(m[0]) != 0:
            yield m.start(), m.end(), f"(LakeMutant({{}}) ? {float(m[0]) * 1.1:.12g} : {m[0]})"


def find_mutants(room, folder):
    found = []
    for path in sorted(folder.glob("src/*.cc")):
        constant = 0  # brackets that are open since a line with a constant expression
        for number, text in enumerate(path.read_text().splitlines()):
            code = text.split("//")[0]
            if constant > 0 or re.search(r"\b(constexpr|static_assert)\b", code):
                constant += len(re.findall(r"[({]", code)) - len(re.findall(r"[)}]", code))
                continue
            if re.match(r"\s*(#|using|template|case)", code) or '"' in text:
                continue
            found += [Mutant(room, path.relative_to(ROOT), number, *m) for m in mutants_of_line(code)]
    return found


def rooms_of(names):
    rooms = {}
    for layer in LAYERS:
        for folder in sorted((ROOT / "libs" / layer).iterdir()):
            if (folder / "src").is_dir() and (not names or folder.name in names):
                rooms[folder.name] = folder
    for name in set(names) - set(rooms):
        sys.exit(f"mutation.py: no room {name} in {', '.join(LAYERS)}")
    return rooms


def program_of(room):
    return f"lake_{TESTS.get(room, room)}_test"


def write(mutants):
    """The sources with all mutants; one per line, as they would overlap."""
    by_file = {}
    for mutant in mutants:
        by_file.setdefault(mutant.path, {})[mutant.line] = mutant
    for path, lines in by_file.items():
        text = (ROOT / path).read_text().splitlines()
        for number, mutant in lines.items():
            line = text[number]
            text[number] = line[:mutant.begin] + mutant.code() + line[mutant.end:]
        # Only files that change are written, so that a second build compiles these alone.
        after = "\n".join(text) + "\n"
        if (WORK / "source" / path).read_text() != after:
            (WORK / "source" / path).write_text(after)


def build(targets):
    command = ["cmake", "--build", str(WORK / "build"), "-j2", "--target", *targets, "--", "-k", "0"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.returncode == 0, done.stdout


def compile_all(mutants, targets):
    """Leaves out what does not compile; what is left is built."""
    for attempt in range(12):
        write(mutants)
        good, said = build(targets)
        if good:
            return mutants
        wrong = {(m[1], int(m[2]) - 1) for m in re.finditer(r"source/(libs/[\w/.]+):(\d+)", said)}
        bad = [m for m in mutants if (str(m.path), m.line) in wrong]
        if not bad:
            (WORK / "build.txt").write_text(said)
            sys.exit(f"mutation.py: the mutated sources do not compile: {WORK / 'build.txt'}")
        print(f"build {attempt + 1}: {len(bad)} mutations do not compile and are left out", flush=True)
        for mutant in bad:
            mutants.remove(mutant)
            line = (ROOT / mutant.path).read_text().splitlines()
            copied = (WORK / "source" / mutant.path).read_text().splitlines()
            copied[mutant.line] = line[mutant.line]
            (WORK / "source" / mutant.path).write_text("\n".join(copied) + "\n")
    sys.exit("mutation.py: the mutated sources do not compile after twelve attempts")


def tests_of(program, labels):
    """The filters of a room's tests that have these labels for ctest: one of the cases that are named, and one of all but some."""
    listed = json.loads(subprocess.run(["ctest", "--test-dir", str(WORK / "build"), "--show-only=json-v1", *labels],
                                       capture_output=True, text=True, check=True).stdout)
    names = []
    for test in listed["tests"]:
        command = test.get("command", [])
        if command and pathlib.Path(command[0]).name == program:
            names += [a.split("=", 1)[1] for a in command[1:] if a.startswith("--gtest_filter=")]
    but_some = [name for name in names if name.startswith("-")]
    named = ":".join(name for name in names if not name.startswith("-"))
    return but_some + ([named] if named else [])


def run_tests(program, filters, level, number, limit):
    """Whether all tests pass, each run within `limit` seconds of processor time, and ten times that by the clock, if it only waits;
    and the processor time of all."""
    took = 0
    for which in filters:
        environment = {**os.environ, "LAKE_MUTANT": str(number), "GTEST_FILTER": which}
        if level == "nightly":
            environment["LAKE_LONG_TESTS"] = "1"
        process = subprocess.Popen(["timeout", f"{10 * limit}", "prlimit", f"--cpu={limit}", WORK / "build/bin" / program, "--gtest_fail_fast",
                                    "--gtest_brief=1"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, cwd=WORK)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        took += usage.ru_utime + usage.ru_stime
        if process.returncode != 0:
            return False, took
    return True, took


def wilson(noticed, of):
    z, p = 1.96, noticed / of
    middle, half = p + z * z / (2 * of), z * math.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    return (middle - half) / (1 + z * z / of), (middle + half) / (1 + z * z / of)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", default="", help="comma-separated; default: all of base, measure and design")
    parser.add_argument("--per-room", type=int, default=25, help="mutations drawn from each room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", choices=tuple(LEVELS), default="default", help="the last set of tests that is run")
    parser.add_argument("--minutes", type=float, default=60, help="when this time has passed, what has run is reported")
    options = parser.parse_args()
    end = time.monotonic() + 60 * options.minutes
    draw = random.Random(options.seed)

    mutants = []
    for room, folder in rooms_of([r for r in options.rooms.split(",") if r]).items():
        found = find_mutants(room, folder)
        draw.shuffle(found)
        one_a_line = list({(m.path, m.line): m for m in found}.values())
        mutants += one_a_line[:3 * options.per_room]  # more than are run, as some do not compile
    for number, mutant in enumerate(mutants):
        mutant.number = number

    shutil.rmtree(WORK / "source", ignore_errors=True)
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in files:
        (WORK / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, WORK / "source" / name)
    (WORK / "mutant.h").write_text(HEADER)
    subprocess.run(["cmake", "-S", str(WORK / "source"), "-B", str(WORK / "build"), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8", "-DLAKE_BUILD_BENCHMARKS=OFF",
                    f"-DLAKE_SHARED_DATA={ROOT.parent / 'shared/data'}", f"-DCMAKE_CXX_FLAGS=-w -include {WORK / 'mutant.h'}"],
                   check=True, stdout=subprocess.DEVNULL)
    programs = sorted({program_of(m.room) for m in mutants})
    mutants = compile_all(mutants, programs)
    build(["programs"])  # which some test programs start

    levels = list(LEVELS)[:list(LEVELS).index(options.tests) + 1]
    chosen = []
    for room in dict.fromkeys(m.room for m in mutants):
        chosen += [m for m in mutants if m.room == room][:options.per_room]
    draw.shuffle(chosen)  # so that a run that is cut short has some of every room
    pool = concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count())
    last_took = {}  # by program, seconds of processor
    noticed_by = {}  # by mutant
    known = {}       # by level, the mutants of which it is known whether this one or an earlier one notices them
    for level in levels:
        left = [m for m in chosen if m not in noticed_by]
        # Slow rooms first, as their tests end last.
        names = sorted({program_of(m.room) for m in left}, key=lambda name: -sum(last_took.get(name, [0])))
        filters = {name: tests_of(name, LEVELS[level]) for name in names}
        without = dict(zip(names, pool.map(lambda name: run_tests(name, filters[name], level, -1, LONGEST), names)))
        for name in names:
            good, took = without[name]
            last_took.setdefault(name, []).append(took)
            print(f"{name}, {level}: {took:.0f} s of processor without a mutation" +
                  ("" if good else "; FAILS without one or takes too long, and is left out"), flush=True)

        def judge(mutant):
            program = program_of(mutant.room)
            good, took = without[program]
            if not good or time.monotonic() > end:
                return None
            return not run_tests(program, filters[program], level, mutant.number, math.ceil(4 * took) + 10)[0]

        verdicts = dict(zip(left, pool.map(judge, left)))
        noticed_by |= {m: level for m, verdict in verdicts.items() if verdict}
        # Where the time is up, or a room is left out, those that an earlier set notices do not count either.
        out = {m.room for m in left if not without[program_of(m.room)][0]}
        late = [i for i, m in enumerate(chosen) if m.room not in out and m in verdicts and verdicts[m] is None]
        known[level] = [m for m in chosen[:late[0] if late else None] if m.room not in out]
    with open(WORK / "mutants.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["room", "file", "line", "before", "after", "noticed_by"])
        for mutant in known[levels[0]]:
            before = (ROOT / mutant.path).read_text().splitlines()[mutant.line][mutant.begin:mutant.end]
            rows.writerow([mutant.room, mutant.path, mutant.line + 1, before, mutant.code(), noticed_by.get(mutant, "none")])
    print("room         mutants" + "".join(f"  {'with ' + level + ' tests':>24}" for level in levels))
    for room in [*dict.fromkeys(m.room for m in mutants), "all"]:
        shares = ""
        for i, level in enumerate(levels):
            tried = [m for m in known[level] if room in (m.room, "all")]
            if not tried:
                continue
            noticed = sum(noticed_by.get(m) in levels[:i + 1] for m in tried)
            low, high = wilson(noticed, len(tried))
            shares += f"  {noticed / len(tried):4.0%} ({low:4.0%} to {high:4.0%} of {len(tried):3})"
        print(f"{room:12} {sum(room in (m.room, 'all') for m in chosen):7}{shares}")


if __name__ == "__main__":
    main()
