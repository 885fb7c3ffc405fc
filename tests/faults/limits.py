"""Every program on a disk that is full, with little memory, and where it may not write: the results are those of a run without
limits, or there is one line that says what went wrong, exit code 1, and no half-written file.

limits.py INPUTS disk|memory|folder [--quick] [--only NAME]     INPUTS as programs.py makes them
"""
import argparse
import ctypes
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import sys
import tempfile

import programs

MIB = 2**20
DISK = {"quick": (0, 30_000), "long": (0, 100, 1000, 4096, 10_000, 30_000, 60_000, 100_000, 200_000, 400_000)}
MEMORY = {"quick": (300_000 * 1024,), "long": tuple(kib * 1024 for kib in (60_000, 120_000, 200_000, 300_000, 400_000, 500_000,
                                                                          600_000, 700_000, 800_000, 1_000_000))}
FOLDER = {"quick": ("out",), "long": ("out", ".")}  # which may be read only
CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, PR_CAPBSET_DROP = 1, 2, 24  # linux/capability.h, linux/prctl.h
TEMPORARY = re.compile(r"^\..*\.lake-[A-Za-z0-9]{6}(\.[A-Za-z0-9]+)?$")  # AtomicFile's names


def give_up_write_everywhere():
    """What root starts from now on keeps to the folders' modes. It stays root: another user may not reach the programs."""
    libc = ctypes.CDLL(None, use_errno=True)
    for capability in CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH:
        if libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0):
            raise OSError(ctypes.get_errno(), "prctl(PR_CAPBSET_DROP)")


def limited(what, value):
    def apply():
        if what == "disk":
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a write fails, as on a full disk
            resource.setrlimit(resource.RLIMIT_FSIZE, (value, value))
        if what == "memory":
            resource.setrlimit(resource.RLIMIT_AS, (value, value))
        if what == "folder" and os.getuid() == 0:
            give_up_write_everywhere()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    return apply


def files_in(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def is_hidden(name):
    return any(part.startswith(".") for part in pathlib.PurePath(name).parts)


def results_in(folder):
    """The files under final names, as bytes; of the study's summary what does not say which steps this run did, and how fast."""
    files = {name: content for name, content in files_in(folder).items() if not is_hidden(name)}
    if "summary.json" in files:
        summary = json.loads(files["summary.json"])
        for step in summary.get("steps", []):
            for key in ("done", "why", "seconds"):
                step.pop(key, None)
        files["summary.json"] = json.dumps(summary).encode()
    return files


def is_error_line(line, program):
    return line.startswith(program + ": ") and not line.startswith(program + ": warning: ")


def faults_of(ended, program, out, usual_code, whole):
    """What is wrong with how a limited run ended, one text each."""
    errors = [line for line in ended.stderr.splitlines() if is_error_line(line, program)]
    results = results_in(out) if out.is_dir() else {}
    done = ended.returncode == usual_code and not errors
    if ended.returncode == 127 and "error while loading shared libraries" in ended.stderr:
        return  # the system's words: nothing of the program has begun
    if not done and ended.returncode != 1:
        yield f"ended with {ended.returncode}: {ended.stderr[-300:]!r}"
    elif not done and len(errors) != 1:
        yield f"{len(errors)} error lines: {ended.stderr[-400:]!r}"
    elif done and results != whole:
        yield "says that all went well, and differs in " + ", ".join(
            sorted(name for name in set(results) | set(whole) if results.get(name) != whole.get(name)))
    for name in files_in(out) if out.is_dir() else ():
        if TEMPORARY.match(pathlib.PurePath(name).name):
            yield f"left {name}"
    for name, content in results.items():
        if not done and content != whole.get(name):
            yield f"{name} is not that of a whole run"


def try_program(name, words, folder, what, values):
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    usual_code = programs.run(programs.into(words, "out", folder), folder).returncode  # 1 if lake-check says that the recording is not fit
    whole, faults = results_in(out), 0
    for value in values:
        shutil.rmtree(out, ignore_errors=True)
        limited_words = programs.into(words, "out", folder)
        if what == "folder":
            (folder / value).mkdir(exist_ok=True)
            (folder / value).chmod(0o555)
        ended = programs.run(limited_words, folder, preexec_fn=limited(what, value), timeout=300)
        if what == "folder":
            (folder / value).chmod(0o755)
        last = (ended.stderr.strip().splitlines() or [""])[-1]
        print(f"{name} {what} {value}: {ended.returncode} {last[:200]}", flush=True)
        for fault in faults_of(ended, words[0], out, usual_code, whole):
            print(f"FAULT {name} {what} {value}: {fault}", flush=True)
            faults += 1
    return faults


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("what", choices=("disk", "memory", "folder"))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="*")
    asked = parser.parse_args()
    values = {"disk": DISK, "memory": MEMORY, "folder": FOLDER}[asked.what]["quick" if asked.quick else "long"]
    faults = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "in"
        shutil.copytree(asked.inputs, folder)
        for name, words in programs.commands(folder).items():
            if name in (asked.only or [name]) and name != "check":  # lake-check sees less when the machine is busy
                faults += try_program(name, words, folder, asked.what, values)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
