"""How near `lake run --plan` and `lake cohort --plan` come to what is taken: time and memory, expected and measured.

    tests/benchmark/plan_cost.py build/release/bin [NAME...]

On an idle machine. The sample study, one like it of ten rises, one of larger pictures, and a cohort of three; or those
that are named: sample, ten_rises_720p, two_rises_2160p, cohort. A ratio is what was expected over what it took; beyond a
factor of 1.5 it has a star."""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

BIN = pathlib.Path(sys.argv[1]).resolve()
NAMES = sys.argv[2:]
SAMPLE = pathlib.Path(__file__).resolve().parents[2] / "data/sts-study/study.yaml"
# A person's trial alone, tracked and designed for.
STUDY = """name: {name}
camera: recording/camera.yaml
human: {{video: recording/video.mp4, markers: [ankle, knee, hip, waist]}}
loads: {{mass_kg: 70, height_mm: 1750}}
design: {{starts: {starts}}}
"""
OTHERS = (
    ("ten_rises_720p", ("--repetitions", 10, "--width", 1280, "--height", 720), 20),
    ("two_rises_2160p", ("--repetitions", 2, "--width", 3840, "--height", 2160), 60),
)
PEOPLE = ("--population", 3, "--seed-number", 11)
FACTOR = 1.5  # that an estimate is to keep within


def lake(program, *words, cwd=None):
    return subprocess.run([str(BIN / program), *map(str, words)], cwd=cwd, check=True, capture_output=True, text=True)


def memory_mb(root):
    """Of a process and all that it started, at this moment; what they share is counted once."""
    children = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
        except OSError:  # it has ended
            continue
        children.setdefault(parent, []).append(int(stat.parent.name))
    kilobytes, waiting = 0, [root]
    while waiting:
        process = waiting.pop()
        waiting += children.get(process, [])
        try:
            shares = re.search(r"^Pss: +(\d+) kB$", pathlib.Path(f"/proc/{process}/smaps_rollup").read_text(), re.M)
        except OSError:
            continue
        kilobytes += int(shares[1]) if shares else 0
    return kilobytes / 1024


def measured(program, *words):
    """Time and the most memory at a time of a run."""
    start, most_mb = time.monotonic(), 0
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen([str(BIN / program), *map(str, words)], stdout=said, stderr=said) as run:
            while run.poll() is None:
                most_mb = max(most_mb, memory_mb(run.pid))
                time.sleep(0.1)
        if run.returncode != 0:
            said.seek(0)
            sys.exit(f"{program}: exit code {run.returncode}: {said.read().decode(errors='replace')}")
    return {"seconds": time.monotonic() - start, "memory_mb": most_mb}


def row(name, expected, took):
    text = f"{name:<14}"
    for key, digits in (("seconds", 1), ("memory_mb", 0)):
        ratio = expected[key] / took[key]
        star = " " if 1 / FACTOR <= ratio <= FACTOR else "*"
        text += f"{took[key]:8.{digits}f}{expected[key]:10.{digits}f}{ratio:7.2f}{star}"
    print(text, flush=True)


def head(name):
    print(f"\n{name}\n{'':<14}{'s':>8}{'expected':>10}{'ratio':>7} {'MB':>8}{'expected':>10}{'ratio':>7}")


def stamps(out):
    for stamp in out.rglob(".*.lake-step.json"):
        said = json.loads(stamp.read_text())
        if "seconds" in said:
            yield said["step"], said


def compare_study(study, out):
    plan = json.loads(lake("lake-run", study, "--plan", "-o", out).stdout)
    all_took = measured("lake-run", study, "--quiet", "-o", out)
    took = dict(stamps(out))
    head(plan["name"])
    for step in plan["steps"]:
        if step["name"] in took:
            row(step["name"], step["expected"], took[step["name"]])
    row("all", plan["expected"], all_took)


# What Snakemake itself takes is in it.
def compare_cohort(folder, out):
    words = (folder, out, "participant")
    plan = json.loads(lake("lake-cohort", *words, "--plan").stdout)
    took = measured("lake-cohort", *words, "--quiet")
    head(plan["name"])
    for recording in plan["recordings"]:
        steps = dict(stamps(out / recording["name"]))
        print(f"{recording['name']:<14}{sum(step['seconds'] for step in steps.values()):8.1f} s of steps")
    row("all", plan["expected"], took)


def main():
    known = ["sample", *(name for name, *_ in OTHERS), "cohort"]
    if unknown := [name for name in NAMES if name not in known]:
        raise SystemExit(f"{', '.join(unknown)}: no such case; there are {', '.join(known)}")
    with tempfile.TemporaryDirectory(prefix="lake-plan-") as temporary:
        folder = pathlib.Path(temporary)
        asked = NAMES or known
        if "sample" in asked:
            compare_study(SAMPLE, folder / "out/sample")
        for name, film, starts in OTHERS:
            if name in asked:
                (folder / name).mkdir()
                lake("lake-synth", *film, "--quiet", "-o", "recording", cwd=folder / name)
                (folder / name / "study.yaml").write_text(STUDY.format(name=name, starts=starts))
                compare_study(folder / name / "study.yaml", folder / "out" / name)
        if "cohort" in asked:
            lake("lake-synth", *PEOPLE, "--quiet", "-o", folder / "people")
            compare_cohort(folder / "people", folder / "out/cohort")


main()
