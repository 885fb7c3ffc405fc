#!/usr/bin/env python3
"""Writes data/paper/README.md: the paper's numbers, what lake finds for the paper's design, and lake's own optima, side by side.

Needs the programs built (preset release). Runs lake-optimize and lake-simulate; takes a few seconds."""
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAPER = ROOT / "data" / "paper"
BIN = ROOT / "build" / "release" / "bin"


def run(out, program, *options):
    """Runs a program into `out` and returns its summary."""
    command = [BIN / program, "--quiet", "-o", out, *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program} ended with {done.returncode}: {done.stderr.strip()}")
    return json.loads((out / "summary.json").read_text())


def table(name):
    with open(PAPER / name, newline="") as file:
        return list(csv.DictReader(file))


def requirement(evaluation, name):
    return next(r for r in evaluation["requirements"] if r["name"] == name)


def pose_near(rows, stroke_mm):
    return min(rows, key=lambda row: abs(float(row["stroke_mm"]) - stroke_mm))


def percent(fraction):
    return f"{100 * fraction['value']:.1f} %"


def link_rows(table1, columns):
    rows = []
    for row in table1:
        cells = [row["variable"], row["initial_mm"], row["optimum_mm"]]
        cells += [f"{column['links'][row['variable']]:.3f}" for column in columns]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def page(published, simulated, rows, zero, margin, buildable, table1, claims):
    claimed = {row["quantity"]: row for row in claims}
    start, optimum = published["start"], zero["optimum"]
    grashof, singularity = (requirement(start, name)["slack"] for name in ("grashof", "singularity"))
    standing, at_range = pose_near(rows, 373.962), pose_near(rows, 242)
    rounded = buildable["rounded"]
    return f"""# The paper, computed again

*Written by `scripts/reproduce_paper.py`; do not edit. The CSV files beside this page hold the paper's tables.*

Gautam, Singla & Singla, "Optimal Kinematic Synthesis and Prototype Development of Knee Exoskeleton". Problem: largest knee angle at the actuator's
shortest stroke, {claimed['d_min']['value']} mm.

## Links, mm

| | paper, initial | paper, optimum | ours, the same problem | ours, both margins 2 mm |
| --- | --- | --- | --- | --- |
{link_rows(table1, [zero, margin])}

## Numbers

| | paper says | the paper's design, evaluated | ours, the same problem | ours, both margins 2 mm |
| --- | --- | --- | --- | --- |
| range of rotation | {claimed['range_of_rotation']['value']}° | {start['range_deg']:.4f}° | {zero['range_deg']:.4f}° | {margin['range_deg']:.4f}° |
| no design can have more than | | | {zero['certified_upper_bound_deg']:.4f}° | {margin['certified_upper_bound_deg']:.4f}° |
| largest violation | | {start['violation']:.1e} | {zero['constraint_violation']:.1e} | {margin['constraint_violation']:.1e} |
| KKT error | | | {zero['kkt_error']:.1e} | {margin['kkt_error']:.1e} |
| slack of Grashof's law | | {grashof:.3f} mm | {requirement(optimum, 'grashof')['slack']:.1e} mm | {requirement(margin['optimum'], 'grashof')['value']:.3f} mm |
| distance to the actuator singularity | | {singularity:.5f} mm | {requirement(optimum, 'singularity')['slack']:.1e} mm | {requirement(margin['optimum'], 'singularity')['value']:.3f} mm |
| builds with links at ±0.1 mm (all else exact) that can be assembled at {claimed['d_min']['value']} mm | | {percent(start['yield']['assembled'])} | {percent(zero['yield']['assembled'])} | {percent(margin['yield']['assembled'])} |
| … and keep every limit of the problem | | {percent(start['yield']['all_limits'])} | {percent(zero['yield']['all_limits'])} | {percent(margin['yield']['all_limits'])} |

The paper's design in motion (knee torque {simulated['knee_torque_nm']:.0f} N m): it stands at 2° with {float(standing['stroke_mm']):.3f} mm and straight with
{start['stroke_when_standing_mm']:.4f} mm, a travel of {simulated['travel_mm']:.2f} mm. At its full range the moment arm is {float(at_range['moment_arm_mm']):.2f} mm per rad and the actuator would need
{float(at_range['force_n']) / 1000:.0f} kN; at 2° it needs {float(standing['force_n']) / 1000:.2f} kN.

## What differs

- **The published point is feasible but not optimal.** Under the printed constraints {zero['range_deg']:.2f}° is reached, and interval branch and bound proves that no design exceeds
  {zero['certified_upper_bound_deg']:.4f}°. The published point is not even a local optimum: shortening l4 alone by 1 mm is allowed and gives more range.
- **It lies on two singularities.** Grashof's law has {grashof:.3f} mm left, the actuator triangle {singularity:.5f} mm. The supremum lies on both exactly: a change-point parallelogram
  with the actuator in line with the bar. It is the answer to the printed problem and useless as a machine: no moment arm, no defined motion.
- **Half of all builds cannot be assembled.** With every link within ±0.1 mm, {percent(start['yield']['assembled'])} of the builds of the published design close at {claimed['d_min']['value']} mm; {percent(start['yield']['all_limits'])} keep every limit as well.
- **The initial point of Table 1 is not feasible.** It violates l1, l2, l3 <= l4 by {zero['start']['violation']:.0f} mm; its angle is {zero['start']['range_deg']:.3f}°.
- **The gain of {claimed['gain_over_inspired_design']['value']} % cannot be checked**: the links of the design that it refers to are not published.
- **Margins cost range and buy a machine.** 2 mm from both singularities leave {margin['range_deg']:.2f}° (proved: at most {margin['certified_upper_bound_deg']:.2f}°), and every build at ±0.1 mm can be assembled.
- **A design to build** (`calibration/problems/buildable.yaml`: margins of 2 mm, at most 2000 N for {simulated['knee_torque_nm']:.0f} N m down to 5° before standing, transmission angle at least 10°): {buildable['range_deg']:.2f}°; with links
  in multiples of 0.5 mm, {', '.join(f'{k} = {v:g}' for k, v in rounded['links'].items())}: {rounded['evaluation']['range_deg']:.2f}°, all of it evaluated again.

## Range against margin

![range against margin](margin.png)

## Sensitivity of the optimum with margins of 2 mm

The paper's figure of its "local minimum", for every link and on both sides:

![sensitivity](sensitivity.png)
"""


def main():
    table1 = table("table1.csv")
    published_links = ",".join(row["optimum_mm"] for row in table1)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        common = ["--certify", "--yield", "0.1"]
        zero = run(out / "zero", "lake-optimize", *common)
        published = run(out / "published", "lake-optimize", "--start", published_links, *common)
        margin = run(out / "margin", "lake-optimize", "--grashof-margin", "2", "--singularity-margin", "2", *common)
        buildable = run(out / "buildable", "lake-optimize", "--problem", ROOT / "calibration/problems/buildable.yaml", "--round", "0.5")
        simulated = run(out / "simulated", "lake-simulate", "--links", published_links, "--stroke", "242,373.962", "--no-animation")
        with open(out / "simulated" / "angle_vs_stroke.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        text = page(published, simulated, rows, zero, margin, buildable, table1, table("published.csv"))
        for picture in ("margin.png", "sensitivity.png"):
            shutil.copyfile(out / "margin" / picture, PAPER / picture)
    (PAPER / "README.md").write_text(text)
    print(PAPER / "README.md")


if __name__ == "__main__":
    main()
