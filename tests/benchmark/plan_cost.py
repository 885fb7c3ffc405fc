"""How near `lake run --plan` comes to what a study takes: each step of some studies, expected and measured.

    tests/benchmark/plan_cost.py build/release/bin

On an idle machine; the sample study, and two like it with a longer and with a larger recording."""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

BIN = pathlib.Path(sys.argv[1]).resolve()
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


def lake(program, *words, cwd=None):
    return subprocess.run([str(BIN / program), *map(str, words)], cwd=cwd, check=True, capture_output=True, text=True)


def stamps(out):
    for stamp in out.rglob(".*.lake-step.json"):
        said = json.loads(stamp.read_text())
        if "seconds" in said:
            yield said["step"], said


def compare(study, out):
    plan = json.loads(lake("lake-run", study, "--plan", "-o", out).stdout)
    lake("lake-run", study, "--quiet", "-o", out)
    took = dict(stamps(out))
    print(f"{plan['name']}\n{'step':<14}{'s':>8}{'expected':>10}{'ratio':>7}{'MB':>8}{'expected':>10}{'ratio':>7}")
    for step in plan["steps"]:
        said, was = step["expected"], took.get(step["name"])
        if was:
            print(f"{step['name']:<14}{was['seconds']:8.1f}{said['seconds']:10.1f}{said['seconds'] / was['seconds']:7.2f}"
                  f"{was['memory_mb']:8.0f}{said['memory_mb']:10.0f}{said['memory_mb'] / was['memory_mb']:7.2f}")
    return plan["expected"]["seconds"]


def main():
    with tempfile.TemporaryDirectory(prefix="lake-plan-") as temporary:
        folder = pathlib.Path(temporary)
        studies = [("sample", SAMPLE)]
        for name, film, starts in OTHERS:
            (folder / name).mkdir()
            lake("lake-synth", *film, "--quiet", "-o", "recording", cwd=folder / name)
            (folder / name / "study.yaml").write_text(STUDY.format(name=name, starts=starts))
            studies.append((name, folder / name / "study.yaml"))
        for name, study in studies:
            start = time.monotonic()
            expected_s = compare(study, folder / "out" / name)
            took_s = time.monotonic() - start
            print(f"{'all':<14}{took_s:8.1f}{expected_s:10.1f}{expected_s / took_s:7.2f}\n", flush=True)


main()
