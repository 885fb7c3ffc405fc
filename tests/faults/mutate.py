"""Damaged inputs through every program that reads them: each run ends by itself, in at most ten times the usual processor time,
with results or with one line that says what is wrong.

mutate.py INPUTS [--count 1000] [--seed 1] [--light] [--only NAME…]     INPUTS as programs.py makes them. What fails is kept in ./mutated.

Best with programs built with the sanitizers: LAKE_BIN=build/asan/bin. The same seed gives the same damage.
"""
import argparse
import os
import pathlib
import random
import re
import resource
import shutil
import sys
import tempfile
import time

import programs

SPICE = ["nan", "inf", "-1", "0", "1e308", "-1e308", "1e-320", "", "99999999999999999999", "0x10", "-", "1,5", "\x00", "\xff", "*a",
         "[", "]", "{", "}", "\"", "'", ":", "%", "%s", "\n", "\r\n", "\t", "&", "<", ">", "é", "A" * 5000]
HEAVY = {"video track", "video check", "corrections", "picture", "trial gait", "trial loads", "trial compare", "list of results",
         "comparison", "loads", "actuators", "problem", "forces", "segments"}
ENDS_WITH_1 = {"lake-check", "lake-cohort"}  # of what is not fit; of studies whose videos are not there
NUMBER = re.compile(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?")


def damage_bytes(data, rng):
    data = bytearray(data)
    at = rng.randrange(len(data))
    length = min(len(data) - at, rng.choice((1, 2, 4, 16, 200, 4000)))
    kind = rng.randrange(6)
    if kind == 0:
        data[at] ^= 1 << rng.randrange(8)
    elif kind == 1:
        data[at:at + length] = rng.randbytes(length)
    elif kind == 2:
        del data[at:]
    elif kind == 3:
        del data[at:at + length]
    elif kind == 4:
        data[at:at] = data[at:at + length]
    else:
        data[at:at + length] = bytes([rng.choice((0, 255))]) * length
    return bytes(data)


def damage_text(data, rng):
    kind = rng.randrange(7)
    lines = data.split(b"\n")
    line = rng.randrange(len(lines))
    if kind in (0, 1, 5, 6) and (numbers := list(NUMBER.finditer(data))):
        number = rng.choice(numbers)
        # Another of the file's numbers is mostly read without complaint: what it spoils comes later.
        instead = rng.choice(numbers).group() if kind >= 5 else rng.choice(SPICE).encode("latin-1")
        return data[:number.start()] + instead + data[number.end():]
    if kind == 2:
        del lines[line]
    elif kind == 3:
        lines.insert(line, rng.choice(lines))
    else:
        at = rng.randrange(len(data))
        return data[:at] + rng.choice(SPICE).encode("latin-1") + data[at:]
    return b"\n".join(lines)


def damaged(data, is_text, rng):
    """One to four wounds; text is also treated as bytes now and then."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        if data:
            data = damage_text(data, rng) if is_text and rng.random() < 0.8 else damage_bytes(data, rng)
    return data


def kinds(folder):
    """Name, the file that is damaged, the words that read it, and how many parts of the count are its own."""
    seeds = programs.seeds(folder)
    track = ["lake-track", "video.mp4", "--camera", "camera.yaml", "--no-overlay", "--end", "1.2"] + seeds[:2]
    plane = ["lake-calibrate", "plane", "video.mp4", "--camera", "camera.yaml", "--points", programs.POINTS]
    stroke = ["lake-stroke", "worn.yaml", "--speed", "5", "--duty-table", "duty.csv", "--accept-drift"]
    simulate = ["lake-simulate", "worn.yaml", "--no-animation", "--rows", "21", "--angles", "70"]
    loads = ["lake-loads", "th", "--mass", "70", "--draws", "20"]
    cohort = ["lake-cohort", "cohort", "out", "participant"]  # it names no folder by an option
    tables = [(f"{path.name} {word}", f"te/{path.name}", words, 4)
              for path in sorted((folder / "te").glob("video*")) + [folder / "te/tracks.csv", folder / "te/trajectory.csv"]
              for word, words in (("info", ["lake-info", f"te/{path.name}"]),
                                  ("convert", ["lake-convert", f"te/{path.name}", "converted.csv"]))
              if not (word == "convert" and path.suffix == ".mot")]
    return tables + [
        ("video track", "video.mp4", track, 10),
        ("video check", "video.mp4", ["lake-check", "video.mp4"], 10),
        ("corrections", "corrections.csv", track + ["--corrections", "corrections.csv"], 5),
        ("camera", "camera.yaml", plane, 8),
        ("picture", "board1.pgm", ["lake-calibrate"] + [f"board{i}.pgm" for i in range(6)] + ["--board", "chessboard:6x4:25"], 3),
        ("trial gait", "th/trajectory.csv", ["lake-gait", "th"], 4),
        ("trial loads", "th/trajectory.csv", loads, 3),
        ("trial compare", "te/trajectory.csv", ["lake-compare", "th", "te"], 3),
        ("events", "events.csv", ["lake-gait", "th", "--events", "events.csv"], 5),
        ("forces", "forces.mot", loads[:1] + ["te/video.trc", "--forces", "forces.mot"] + loads[2:], 4),
        ("segments", "segments.yaml", loads + ["--anthropometry", "segments.yaml"], 4),
        ("cohort", "cohort/cohort.yaml", cohort, 8),
        ("participants", "cohort/participants.tsv", cohort, 8),
        ("list of results", "th/.lake-track.lake-files.json", ["lake-gait", "th"], 3),
        ("comparison", "comparison/comparison.json",
         ["lake-optimize", "--problem", "problem.yaml", "--comparison", "comparison", "--human-only", "--starts", "1"], 3),
        ("loads", "loads/loads.json", simulate + ["--profile", "loads"], 5),
        ("actuators", "actuators.csv", simulate + ["--profile", "loads", "--actuator", "actuators.csv:LA31-1000"], 3),
        ("design", "worn.yaml", ["lake-export", "worn.yaml", "dxf"], 8),
        ("problem", "problem.yaml", ["lake-optimize", "--problem", "problem.yaml", "--starts", "1"], 3),
        ("study", "study.yaml", ["lake-run", "study.yaml", "--plan"], 8),
        ("duty table", "duty.csv", stroke, 8),
        ("actuator log", "log.csv", ["lake-stroke", "calibrate", "log.csv"], 8),
        ("configuration", "options.toml", ["lake-export", "worn.yaml", "dxf", "--config", "options.toml"], 3),
    ]


def run_counted(words, folder, most_cpu_s):
    """The ended program and its processor time, s; it is ended by the system beyond `most_cpu_s`."""
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (most_cpu_s, most_cpu_s))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (2**28, 2**28))

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    shutil.rmtree(folder / "out", ignore_errors=True)
    out = {"lake-info": [], "lake-convert": [], "lake-cohort": ["--quiet"]}.get(words[0], ["--quiet", "-o", "out"])
    ended = programs.run(words + out, folder, preexec_fn=limit)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return ended, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def fault_of(ended, program, cpu_s, most_cpu_s):
    errors = [line for line in ended.stderr.splitlines()
              if line.startswith(program + ": ") and not line.startswith(program + ": warning: ")]
    if "Sanitizer" in ended.stderr or "runtime error" in ended.stderr:
        return "sanitizer"
    if ended.returncode not in (0, 1, 2, 3):
        return f"ended with {ended.returncode}"
    if cpu_s >= most_cpu_s:
        return f"took {cpu_s:.1f} s of processor time"
    if ended.returncode and len(errors) != 1 and program != "lake-check":  # lake-check's 1 also says: not fit
        return f"{len(errors)} error lines"
    return None


def try_kind(kind, count, seed, folder):
    """How many of `count` damaged files failed."""
    name, path, words, _ = kind
    whole = (folder / path).read_bytes()
    is_text = b"\x00" not in whole and pathlib.Path(path).suffix not in (".mp4", ".c3d", ".pgm")
    usual, usual_cpu_s = run_counted(words, folder, 600)
    if usual.returncode and words[0] not in ENDS_WITH_1:
        print(f"FAULT {name}: not damaged, it ends with {usual.returncode}: {usual.stderr[-500:]}", flush=True)
        return 1
    most_cpu_s = int(10 * usual_cpu_s) + 2  # the system counts whole seconds
    faults, codes, slowest = 0, {}, 0
    for number in range(count):
        data = damaged(whole, is_text, random.Random(f"{seed} {name} {number}"))
        (folder / path).write_bytes(data)
        ended, cpu_s = run_counted(words, folder, most_cpu_s)
        slowest = max(slowest, cpu_s / usual_cpu_s)
        codes[ended.returncode] = codes.get(ended.returncode, 0) + 1
        if fault := fault_of(ended, words[0], cpu_s, most_cpu_s):
            faults += 1
            kept = pathlib.Path("mutated") / f"{name.replace(' ', '-')}-{number}{pathlib.Path(path).suffix}"
            kept.parent.mkdir(exist_ok=True)
            kept.write_bytes(data)
            print(f"FAULT {name} {number}: {fault}; {kept}; {' '.join(words)}: {ended.stderr[-1500:]}", flush=True)
    (folder / path).write_bytes(whole)
    print(f"{name}: {count} files, exit codes {dict(sorted(codes.items()))}, usually {usual_cpu_s:.2f} s, at most "
          f"{slowest:.1f} times that", flush=True)
    return faults


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--light", action="store_true", help="without videos, figures and searches: tenths of a second each")
    asked = parser.parse_args()
    os.environ.setdefault("ASAN_OPTIONS", "allocator_may_return_null=1")
    os.environ.setdefault("LSAN_OPTIONS", f'suppressions="{programs.ROOT}/tests/leaks_of_others.txt":print_suppressions=0')
    began, faults, done = time.monotonic(), 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "in"
        shutil.copytree(asked.inputs, folder)
        (folder / "options.toml").write_text('plate = "5mm,6061-T6"\nbar-width = 26\n')
        chosen = [kind for kind in kinds(folder) if kind[0] in (asked.only or [kind[0]])
                  and not (asked.light and kind[0] in HEAVY)]
        parts = sum(kind[3] for kind in chosen)
        for kind in chosen:
            count = max(1, round(asked.count * kind[3] / parts))
            faults += try_kind(kind, count, asked.seed, folder)
            done += count
    print(f"{done} damaged files, {faults} faults, {time.monotonic() - began:.0f} s")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
