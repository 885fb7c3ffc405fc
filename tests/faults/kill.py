"""`lake run` killed at random moments: no half-written file under a final name, no process left behind, and the next run completes
with the bytes of a run that nobody disturbed.

kill.py INPUTS [--count 200] [--seed 1]     INPUTS as programs.py makes them

A moment is an amount of processor time, so that a busy machine does not move all of them to the study's beginning or past its end.
"""
import argparse
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import programs
from limits import files_in, is_hidden, results_in

WORDS = ["lake-run", "study.yaml", "--quiet", "-o", "out"]


def is_leftover(name):
    """Hidden, and none of the lists and stamps that belong there."""
    return is_hidden(name) and not name.endswith(
        (".lake-files.json", ".lake-step.json", ".lake-lock"))


def of_processes(folder, name):
    """This file in /proc of each process that works in this folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if os.readlink(process / "cwd") == str(folder):
                found.append((process / name).read_bytes())
        except OSError:
            pass
    return found


def still_there(folder):
    return [words.replace(b"\0", b" ").decode(errors="replace") for words in of_processes(folder, "cmdline")]


def spent_s(folder):
    """Processor time of the processes that work in this folder, and of those they have waited for."""
    ticks = [sum(map(int, stat.rpartition(b")")[2].split()[11:15])) for stat in of_processes(folder, "stat")]
    return sum(ticks) / os.sysconf("SC_CLK_TCK")


def children_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def kill_after(seconds, folder, rng):
    """Whether the study was still at work after so much processor time; afterwards none of its processes is to be left."""
    with subprocess.Popen([str(programs.BIN / WORDS[0])] + WORDS[1:], cwd=folder, stdin=subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as study:
        while (was_at_work := study.poll() is None) and spent_s(folder) < seconds:
            time.sleep(rng.uniform(0.01, 0.03))
        study.send_signal(signal.SIGKILL)
    for _ in range(600):  # gnuplot ends with its figure, all else a moment later
        if not (left := still_there(folder)):
            return was_at_work, []
        time.sleep(0.05)
    return was_at_work, left


def differences(results, whole):
    return sorted(name for name, content in results.items() if content != whole.get(name))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    rng, faults, killed, completed = random.Random(asked.seed), 0, 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary).resolve() / "in"
        shutil.copytree(asked.inputs, folder)
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        with open(folder / "study.yaml", "a", encoding="utf-8") as study:
            study.write("simulate: {animation: false}\n")  # half of the time, in one file
        began_s = children_s()
        programs.must_run(WORDS, folder)
        usual_s, whole = children_s() - began_s, results_in(out)
        shutil.rmtree(out)

        def say(fault):
            nonlocal faults
            faults += 1
            print(f"FAULT {fault}", flush=True)

        number = -1
        while killed < asked.count:
            number += 1
            was_at_work, left = kill_after(rng.uniform(0, usual_s), folder, rng)
            killed += was_at_work
            if was_at_work and killed % 20 == 0:
                print(f"{killed} killed", flush=True)
            if left:
                say(f"{number}: still at work: {left}")
            if out.is_dir() and (wrong := differences(results_in(out), whole)):
                say(f"{number}: not those of a whole run: {', '.join(wrong)}")
            if rng.random() < 0.25 or killed == asked.count:
                ended, completed = programs.run(WORDS, folder), completed + 1
                results = results_in(out)
                if ended.returncode:
                    say(f"{number}: run again, it ended with {ended.returncode}: {ended.stderr[-500:]}")
                elif results != whole:
                    missing = sorted(set(whole) - set(results))
                    say(f"{number}: run again, it differs in {', '.join(differences(results, whole) + missing)}")
                if hidden := [name for name in files_in(out) if is_leftover(name)]:
                    say(f"{number}: run again, it left {', '.join(hidden)}")
                shutil.rmtree(out)
    print(f"{killed} of {number + 1} runs killed at work, {completed} completed by the next run, {faults} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
