#!/usr/bin/python3
"""Random recordings with known truth, each tracked by `lake track` with the camera and nothing else, and judged.

worlds.py --seeds 1-92 [--jobs 2] --bin build/test/bin --out DIR [--rejudge] [--csv FILE] [--keep]

A seed draws all of a recording: the motion, the leg, the camera, light, blur, clutter, hidden markers, what encoder and
converter did to it. README.md says what is drawn and how it is judged. The recordings stay in DIR/SEED with --keep, and
--rejudge tracks those again without rendering. FILE (DIR/worlds.csv) gets a row for each recording, FILE with the ending
.txt the table that is printed at the end, and the folder of that name what `lake track` wrote.
"""
import argparse
import concurrent.futures
import csv
import functools
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

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
SHARED = pathlib.Path(os.environ.get("LAKE_SHARED_DATA", ROOT / "../shared/data")).resolve()
NTSC = 30000 / 1001  # frames per second of American television
LEG = ("ankle", "knee", "hip", "waist")


# --- what is drawn ----------------------------------------------------------------------------------------------------

def opencap_leg(side):
    r, s = ("r", "R") if side == "right" else ("L", "L")
    asis = "r" if side == "right" else "L"
    return {"ankle": f"{r}_ankle", "knee": f"{r}_knee", "hip": f"{s}_HJC",
            "waist": [f"{asis}.ASIS+{asis}.PSIS", f"{s}_Shoulder"],
            "extra": [f"{r}_thigh1", f"{r}_sh2", f"{r}_toe", f"{r}_calc", f"{r}_thigh3"]}


def plug_in_leg(side):
    s = side[0].upper()
    return {"ankle": f"{s}ANK", "knee": f"{s}KNE", "hip": f"{s}ASI+{s}PSI", "waist": [f"{s}SHO"],
            "extra": [f"{s}THI", f"{s}TIB", f"{s}TOE"]}


# name: (file, markers of a leg, weight)
REAL_MOTIONS = {
    "sit-to-stand": ("opencap_sts/sts_default_markers.trc", opencap_leg, 6),
    "sit-to-stand 2": ("sts_force_plates/STS1.trc", opencap_leg, 7),
    "squats": ("real_motions/subject4_squats1.trc", opencap_leg, 5),
    "squat 2": ("real_motions/tabs_squat2.trc", plug_in_leg, 2),
}
DRAWN_WEIGHT = 5


def lot(seed, what):
    """Each thing has its own: what is drawn for one does not change when another is drawn differently."""
    return random.Random(f"{seed} {what}")


@functools.cache
def read_trc(path):
    """Times in s, and each marker's places in mm."""
    lines = path.read_text(encoding="utf-8", errors="replace").replace("\r", "").split("\n")
    names = [name for name in lines[3].split("\t")[2:] if name.strip()]
    scale = {"m": 1000, "mm": 1}[lines[2].split("\t")[4].strip()]
    rows = [line.split("\t")[1:2 + 3 * len(names)] for line in lines[5:] if line.split("\t")[0].strip().isdigit()]
    cells = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return cells[:, 0], {name: scale * cells[:, 1 + 3 * i:4 + 3 * i] for i, name in enumerate(names)}


def slowed_trc(source, target, pace):
    """The same motion, `pace` times as long."""
    lines = source.read_text(encoding="utf-8", errors="replace").replace("\r", "").split("\n")
    for i, line in enumerate(lines[5:], 5):
        cells = line.split("\t")
        if cells[0].strip().isdigit():
            lines[i] = "\t".join([cells[0], f"{float(cells[1]) * pace:.6f}", *cells[2:]])
    head = lines[2].split("\t")
    head[0] = f"{float(head[0]) / pace:.6f}"
    lines[2] = "\t".join(head)
    target.write_text("\n".join(lines), encoding="utf-8")


def draw_motion(seed, world, kinds, brief):
    """Fills in what moves; the box of all markers' paths in mm comes back."""
    it = lot(seed, "motion")
    names = list(REAL_MOTIONS) if "real" in kinds and SHARED.is_dir() else []
    weights = [REAL_MOTIONS[name][2] for name in names]
    if "drawn" in kinds:
        names, weights = names + ["drawn"], weights + [DRAWN_WEIGHT]
    name = it.choices(names, weights)[0]
    side = it.choice(("right", "left"))
    length = it.uniform(4, 5) if brief else it.uniform(6, 9)
    extra = lot(seed, "extra markers")
    world |= {"motion": name, "leg": side, "extra": extra.random() < 0.16}
    if name == "drawn":
        skin = it.choice((0, 0, 5, 12))
        world["synth"] += [f"--facing={side}", f"--motion-seed={it.randrange(10**6)}", f"--duration={length:.2f}",
                           f"--pace={it.uniform(0.8, 1.5):.3f}", f"--rest={it.choice((0.6, 0.8, 1.5, 4)):g}", f"--skin={skin}"]
        if it.random() < 0.25:
            world["synth"].append("--standing")
        if it.random() < 0.3:
            world["synth"].append("--still")
        width, height = 700, 1000
        if it.random() < 0.12:
            world["synth"].append(f"--walk-in={it.uniform(2, 3):.2f}")
            world["motion"] = "drawn, walks in"
        if world["extra"]:
            world["synth"] += [f"--exo={extra.uniform(10, 30):.1f},{extra.uniform(15, 45):.1f}", "--exoskeleton"]
        return width, height
    file, leg_of, _ = REAL_MOTIONS[name]
    times, markers = read_trc(SHARED / file)
    leg = leg_of(side)
    chosen = {marker: leg[marker] for marker in LEG[:3]} | {"waist": it.choice(leg["waist"])}
    pace = it.choice((1, 1, 1, 1, it.uniform(0.8, 1.25), it.uniform(1.2, 1.7)))
    total = (times[-1] - times[0]) * pace
    length = min(length, total - 0.05)
    begin = max(it.uniform(0, total - length - 0.02), 0.1)  # the first exposure begins before its time
    far = it.random() < 0.08
    facing = side if not far else {"left": "right", "right": "left"}[side]
    world |= {"file": file, "pace": round(pace, 3), "far": far}
    world["synth"] += ["--map=" + ",".join(f"{own}={theirs}" for own, theirs in chosen.items()), f"--facing={facing}",
                       f"--begin={begin:.2f}", f"--duration={length:.2f}"]
    shown = list(chosen.values())
    if world["extra"]:
        more = extra.sample(leg["extra"], 3)
        world["synth"].append("--extra-markers=" + ",".join(more))
        shown += more
    rows = (times - times[0] >= begin / pace) & (times - times[0] <= (begin + length) / pace)
    places = np.concatenate([np.mean([markers[part] for part in name.split("+")], axis=0)[rows] for name in shown])
    size = places.max(0) - places.min(0)
    return max(size[0], size[2]), size[1]


RATES = {25: 4, 30: 5, 50: 3, 60: 5, 24: 1, 120: 1}
PICTURES = {(1280, 720): 6, (960, 540): 4, (854, 480): 2, (640, 480): 2, (720, 960): 2, (540, 960): 1, (1920, 1080): 1}


def draw_camera(seed, world, box_mm, brief):
    it = lot(seed, "camera")
    rates = {rate: weight for rate, weight in RATES.items() if rate <= 60 or not brief}
    pictures = {size: weight for size, weight in PICTURES.items() if size[0] * size[1] <= 960 * 540 or not brief}
    rate = it.choices(list(rates), rates.values())[0]
    width, height = it.choices(list(pictures), pictures.values())[0]
    px_per_mm = min(width / (box_mm[0] + 420), height / (box_mm[1] + 330)) * it.uniform(0.75, 1)
    least_mm = 2 / px_per_mm  # nobody uses markers that are smaller than this in the picture
    radius_mm = min(13, max(it.uniform(6, 13), least_mm))
    oblique = it.random() < 0.6
    world |= {"rate": rate, "size": [width, height], "radius_px": round(radius_mm * px_per_mm, 2)}
    world["synth"] += [f"--rate={rate}", f"--width={width}", f"--height={height}", f"--radius={radius_mm:.2f}",
                       f"--radius-px={radius_mm * px_per_mm:.3f}", f"--distance={it.uniform(2400, 4500):.0f}",
                       f"--yaw={it.uniform(-9, 9) * oblique:.2f}", f"--pitch={it.uniform(-4, 4) * oblique:.2f}",
                       f"--roll={it.uniform(-1.5, 1.5) * oblique:.2f}"]
    if it.random() < 0.5:
        world["synth"].append(f"--distortion={it.uniform(-0.16, 0.03):.4f},{it.uniform(0, 0.05):.4f},0,0,0")
    if it.random() < 0.1:
        world["synth"].append(f"--jitter={it.uniform(0.05, 0.3):.3f}")
        world["variable"] = True
    world["synth"].append(f"--shutter={it.choice((0.1, 0.2, 0.3, 0.5, 0.7)) * min(1, rate / 25 if rate < 25 else 1):.2f}")


def draw_room(seed, world, brief):
    it = lot(seed, "room")
    level = it.choice((190, 220, 235, 260, 300))
    world["synth"] += [f"--level={level}", f"--brightness={it.uniform(0.5, 1.5):.2f}", f"--exposure={it.uniform(0.7, 1.05):.2f}",
                       f"--psf={it.uniform(0.5, 1.1):.2f}", f"--read-noise={it.uniform(0.7, 3.2):.2f}",
                       f"--shot-gain={it.uniform(0.005, 0.04):.3f}"]
    if it.random() < 0.4:
        world["synth"].append(f"--flicker={it.uniform(0.005, 0.03):.3f}")
    if it.random() < 0.35:
        world["synth"].append(f"--reflections={it.randint(1, 4)}")
        world["clutter"] = True
    if it.random() < 0.12:
        world["synth"].append("--glint")
        world["clutter"] = True
    if it.random() < 0.3:
        world["synth"].append("--color")
    hidden = lot(seed, "hidden")
    if hidden.random() < 0.4:
        world["hidden"] = hidden.randint(1, 3)
        for _ in range(world["hidden"]):
            world["synth"].append(f"--hide={hidden.choice(LEG)}={hidden.uniform(0.5, 3.5 if brief else 8):.2f},{hidden.uniform(0.12, 0.6):.2f}")


def draw_codec(it):
    kind = it.choices(("x264", "x265", "mpeg4", "mjpeg"), (11, 3, 3, 2))[0]
    if kind == "x264":
        preset, crf = it.choice(("ultrafast", "ultrafast", "superfast", "veryfast", "faster", "medium")), it.randint(18, 34)
        return {"name": f"x264 {preset} crf {crf}", "kind": kind, "ending": ".mp4",
                "words": ["-c:v", "libx264", "-preset", preset, "-crf", str(crf), "-pix_fmt", "yuv420p"]}
    if kind == "x265":
        preset, crf = it.choice(("ultrafast", "veryfast", "fast")), it.randint(20, 32)
        return {"name": f"x265 {preset} crf {crf}", "kind": kind, "ending": ".mp4",
                "words": ["-c:v", "libx265", "-preset", preset, "-crf", str(crf), "-x265-params", "log-level=error",
                          "-tag:v", "hvc1", "-pix_fmt", "yuv420p"]}
    quality = it.randint(2, 9)
    if kind == "mpeg4":
        return {"name": f"MPEG-4 q {quality}", "kind": "MPEG-4", "ending": it.choice((".mp4", ".mkv")),
                "words": ["-c:v", "mpeg4", "-q:v", str(quality), "-bf", str(it.choice((0, 2))), "-pix_fmt", "yuv420p"]}
    return {"name": f"MJPEG q {quality}", "kind": "MJPEG", "ending": it.choice((".mov", ".mkv")),
            "words": ["-c:v", "mjpeg", "-q:v", str(quality), "-pix_fmt", "yuvj420p"]}


def draw_film(seed, world, brief):
    """What is done to the recording: first by the camera, then, for some, by whoever converts or sends it."""
    it = lot(seed, "film")
    world["codec"] = draw_codec(it)
    rate, change = world["rate"], it.random()
    if world.get("variable"):
        change = 1
    if change < 0.18:
        to = it.choice({24: (25, 30), 25: (NTSC, 30, 50), 30: (25, 60), 50: (25, NTSC, 30), 60: (25, 30, 50), 120: (30, 60, 25)}[rate])
        world["to_rate"] = to
    elif change < 0.26:
        world["dropped"] = round(it.uniform(0.02, 0.15), 3)  # a phone in the dark: frames that never came
    elif change < 0.31:
        world["gap_s"] = [round(it.uniform(1, 3 if brief else 5), 2), round(it.uniform(0.12, 0.4), 2)]  # begins, lasts; the stamps say so
    elif change < 0.35:
        world["freeze_s"] = [round(it.uniform(1, 3 if brief else 5), 2), round(it.choice((0.1, 0.25, 0.6, 1.5)), 2)]
    light = lot(seed, "light")
    if light.random() < 0.1:  # the camera's exposure hunts
        world["light"] = f"eq=contrast='1+{light.uniform(0.05, 0.15):.3f}*sin({light.uniform(0.5, 3):.2f}*t)':eval=frame"
    if it.random() < 0.18:
        size = world["size"]
        by = it.choice((1, 1, 0.75, 0.667)) if min(size) > 500 else 1
        world["processing"] = {"denoise": it.choice(("hqdn3d=2:1.5:3:3", "hqdn3d=4:3:6:4.5", "atadenoise")),
                               "sharpen": f"unsharp=5:5:{it.uniform(0.4, 1.2):.2f}:5:5:0.3",
                               "size": [2 * round(by * side / 2) for side in size]}


def draw(seed, kinds=("real", "drawn"), brief=False):
    """A recording's recipe; of these kinds of motion. A brief one lasts 4 to 5 s and has small pictures."""
    world = {"seed": seed, "synth": [f"--seed-number={seed}", "--lossless"]}
    box = draw_motion(seed, world, kinds, brief)
    draw_camera(seed, world, box, brief)
    draw_room(seed, world, brief)
    draw_film(seed, world, brief)
    return world


def describe(world):
    words = [world["motion"]]
    if world["motion"].startswith("drawn") is False:
        words.append(f"{world['leg']} leg{' from the far side' if world['far'] else ''}")
        if world["pace"] != 1:
            words.append(f"pace {world['pace']:g}")
    words += [f"{world['rate']} Hz", "{}x{}".format(*world["size"]), f"radius {world['radius_px']:g} px"]
    words += ["extra markers"] * world["extra"] + ["clutter"] * world.get("clutter", False)
    if "hidden" in world:
        words.append(f"{world['hidden']} hidden")
    if world.get("variable"):
        words.append("variable rate")
    if "to_rate" in world:
        words.append(f"converted to {world['to_rate']:.6g} Hz")
    if "dropped" in world:
        words.append(f"{100 * world['dropped']:.0f} % of the frames dropped")
    if "gap_s" in world:
        words.append("a gap of {1:g} s at {0:g} s".format(*world["gap_s"]))
    if "freeze_s" in world:
        words.append("frozen for {1:g} s at {0:g} s".format(*world["freeze_s"]))
    words += ["changing light"] * ("light" in world) + ["processed"] * ("processing" in world)
    return ", ".join(words + [world["codec"]["name"]])


# --- making the recording ---------------------------------------------------------------------------------------------

class Failure(Exception):
    """Of the benchmark, not of what it measures."""


def call(words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, check=False, **options)
    if done.returncode:
        raise Failure(f"{words[0]}: {done.stderr.decode(errors='replace').strip()[-400:]}")
    return done.stdout


FFMPEG = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]


def converted(frames, rate, to_rate):
    """Which picture each frame of a converter like ffmpeg's shows: the last of those whose time rounds to the frame's or before."""
    stamps = [math.floor(i * to_rate / rate + 0.5) for i in range(frames)]
    sources, i = [], 0
    for n in range(stamps[-1] + 1):
        while i + 1 < frames and stamps[i + 1] <= n:
            i += 1
        sources.append(i)
    return sources


def sources_of(world, frames):
    """The rendered frame that each frame of the film shows."""
    if "to_rate" in world:
        return converted(frames, world["rate"], world["to_rate"])
    if "dropped" in world:
        it = lot(world["seed"], "dropped")
        return [i for i in range(frames) if i == 0 or it.random() >= world["dropped"]]
    begin, last = (round(part * world["rate"]) for part in world.get("gap_s", world.get("freeze_s", (0, 0))))
    if "gap_s" in world:
        return [i for i in range(frames) if not begin <= i < begin + last]
    return [begin if begin <= i < begin + last else i for i in range(frames)]


def without(frames, rate):
    """Filters that leave these out; an expression of ffmpeg's has at most a hundred terms, and each filter counts frames anew."""
    return ["select='not(" + "+".join(f"between(t,{(i - 0.5) / rate:.5f},{(i + 0.5) / rate:.5f})" for i in frames[at:at + 40]) + ")'"
            for at in range(0, len(frames), 40)]


def encode(world, source, target, sources, frames):
    filters = [world["light"]] if "light" in world else []
    if "processing" in world:
        processing = world["processing"]
        filters += [processing["denoise"], processing["sharpen"], "scale={}:{}:flags=bicubic".format(*processing["size"])]
    if "to_rate" not in world and "freeze_s" not in world:  # pictures keep their stamps
        filters = without(sorted(set(range(frames)) - set(sources)), world["rate"]) + filters
        call([*FFMPEG, "-i", source, "-vf", ",".join(filters) or "null", "-an", "-fps_mode", "passthrough",
              "-enc_time_base", "1:60000" if world.get("variable") else f"1:{world['rate']}", *world["codec"]["words"], "-threads", "1", target])
        return
    # Even stamps: pictures go through a pipe, each as often as it is shown.
    width, height = world["size"]
    size = width * height * 3 // 2
    with subprocess.Popen([*FFMPEG, "-i", str(source), "-f", "rawvideo", "-pix_fmt", "yuv420p", "-"], stdout=subprocess.PIPE) as read, \
         subprocess.Popen([word for word in FFMPEG if word != "-nostdin"] + ["-f", "rawvideo", "-pix_fmt", "yuv420p", "-s", f"{width}x{height}",
                          "-r", str(world.get("to_rate", world["rate"])), "-i", "-", "-vf", ",".join(filters) or "null",
                          *world["codec"]["words"], "-threads", "1", str(target)], stdin=subprocess.PIPE, stderr=subprocess.PIPE) as write:
        at, picture = -1, b""
        for wanted in sources:
            while at < wanted:
                picture, at = read.stdout.read(size), at + 1
            write.stdin.write(picture)
        read.stdout.read()
        write.stdin.close()
        told = write.stderr.read().decode(errors="replace")
        if write.wait() or read.wait():
            raise Failure(f"ffmpeg: {told.strip()[-400:]}")


def write_truth(world, rendered, target, sources):
    """The truth of each frame's picture: its own time, not the frame's stamp."""
    with open(rendered, newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    scale = [new / old for new, old in zip(world["processing"]["size"], world["size"])] if "processing" in world else [1, 1]
    with open(target, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*header, "repeated"])
        for frame, source in enumerate(sources):
            row = list(rows[source])
            row[0] = str(frame)
            for column, name in enumerate(header):
                for axis, ending in enumerate(("_x_px", "_y_px")):
                    if name.endswith(ending):
                        row[column] = repr((float(row[column]) + 0.5) * scale[axis] - 0.5)
            table.writerow([*row, int(frame > 0 and source == sources[frame - 1])])


def render(world, folder, programs):
    """film.*, camera.yaml, truth.csv of the film's frames and motion.csv of all that were rendered."""
    rendering = folder / "rendering"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    words = list(world["synth"])
    if "file" in world:
        motion = SHARED / world["file"]
        if world["pace"] != 1:
            slowed_trc(motion, folder / "motion.trc", world["pace"])
            motion = folder / "motion.trc"
        words.append(f"--motion={motion}")
    call([programs / "lake-synth", *words, "--quiet", "-o", rendering])
    with open(rendering / "truth.csv", newline="", encoding="utf-8") as file:
        frames = sum(1 for _ in file) - 1
    sources = sources_of(world, frames)
    film = folder / ("film" + world["codec"]["ending"])
    encode(world, rendering / "video.mp4", film, sources, frames)
    count = int(call(["ffprobe", "-v", "error", "-select_streams", "v", "-count_packets", "-show_entries", "stream=nb_read_packets",
                      "-of", "csv=p=0", film]).split()[0].strip(b",\n"))
    if count != len(sources):
        raise Failure(f"the film has {count} frames, {len(sources)} were written")
    write_truth(world, rendering / "truth.csv", folder / "truth.csv", sources)
    (rendering / "truth.csv").rename(folder / "motion.csv")
    camera = (rendering / "camera.yaml").read_text(encoding="utf-8")
    (folder / "camera.yaml").write_text(scaled_camera(camera, world), encoding="utf-8")
    shutil.rmtree(rendering)
    (folder / "motion.trc").unlink(missing_ok=True)
    (folder / "world.json").write_text(json.dumps(world, indent=1), encoding="utf-8")


def scaled_camera(text, world):
    """camera.yaml for the film's size; pixel centres are at whole numbers."""
    if "processing" not in world:
        return text
    sx, sy = (new / old for new, old in zip(world["processing"]["size"], world["size"]))
    text = re.sub(r"(image_width: *)\d+", lambda m: m[1] + str(world["processing"]["size"][0]), text)
    text = re.sub(r"(image_height: *)\d+", lambda m: m[1] + str(world["processing"]["size"][1]), text)

    def matrix(found):
        fx, _, cx, _, fy, cy = (float(cell) for cell in found[2].split(",")[:6])
        cells = [fx * sx, 0, (cx + 0.5) * sx - 0.5, 0, fy * sy, (cy + 0.5) * sy - 0.5, 0, 0, 1]
        return found[1] + ", ".join(repr(float(cell)) for cell in cells) + found[3]

    return re.sub(r"(camera_matrix:.*?data: *\[)([^\]]*)(\])", matrix, text, count=1, flags=re.S)


# --- tracking and judging ---------------------------------------------------------------------------------------------

def track(folder, film, programs):
    """Exit code, what it said, wall and processor seconds."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    words = [programs / "lake-track", film, "--camera", film.parent / "camera.yaml", "--no-overlay", "--quiet", "--threads", "1", "-o", folder]
    begin = time.monotonic()
    with open(folder.parent / f"{folder.name}.log", "w+b") as log:
        with subprocess.Popen([str(word) for word in words], stdout=log, stderr=log) as child:
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        told = log.read().decode(errors="replace").strip()
    return child.returncode, told, time.monotonic() - begin, usage.ru_utime + usage.ru_stime


def read_table(path):
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    return {name: [row[i] for row in rows] for i, name in enumerate(header)}


def numbers(cells):
    return np.array([float(cell) if cell else np.nan for cell in cells])


def rms(values):
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan


def judge_positions(truth, tracks, rows, not_repeated, radius_px, row, why):
    """Marks against the pictures that show something new."""
    seen = found = 0
    all_z = []
    others = [name[:-5] for name in truth if name.endswith("_x_px")]
    places = {name: np.stack([numbers(truth[name + "_x_px"]), numbers(truth[name + "_y_px"])], 1)[rows] for name in others}
    limit = max(1.0, radius_px)  # beyond its own disc a mark is not on the marker
    for name in LEG:
        mark = np.stack([numbers(tracks[name + "_x_px"]), numbers(tracks[name + "_y_px"])], 1)
        detected = np.array([status == "detected" for status in tracks[name + "_status"]]) & not_repeated
        visible = (numbers(truth[name + "_visible"])[rows] > 0.5) & not_repeated
        off = np.linalg.norm(mark - places[name], axis=1)
        good = detected & visible
        seen, found = seen + visible.sum(), found + good.sum()
        z = ((mark - places[name]) / numbers(tracks[name + "_sigma_px"])[:, None])[good]
        all_z.append(z)
        row[f"z_{name}"] = rms(z)
        false = detected & (off > limit)
        if false.any():
            worst = int(np.argmax(np.where(detected, off, 0)))
            near = [other for other in others if other != name and np.linalg.norm(mark[worst] - places[other][worst]) < limit]
            what = f"{name} is on {near[0]}" if near else f"{name} is {off[worst]:.0f} px off"
            why.append(f"{what} (frame {tracks['frame'][worst]}; {false.sum()} frames)")
    row["recall"] = found / max(seen, 1)
    row["z"] = rms(np.concatenate(all_z))


def cubic(x, known_x, known_y):
    """Hermite's cubic through the known values, with their central differences."""
    slopes = np.gradient(known_y, known_x)
    i = np.clip(np.searchsorted(known_x, x) - 1, 0, len(known_x) - 2)
    h = known_x[i + 1] - known_x[i]
    t = np.clip((x - known_x[i]) / h, 0, 1)
    return ((1 + 2 * t) * (1 - t) ** 2 * known_y[i] + t * (1 - t) ** 2 * h * slopes[i]
            + t * t * (3 - 2 * t) * known_y[i + 1] + t * t * (t - 1) * h * slopes[i + 1])


def judge_angles(truth, motion, kinematics, row, why):
    """A new picture's angle against that picture's, an angle at a repeated one against the motion's at the time that is told."""
    frames, told = numbers(kinematics["frame"]).astype(int), numbers(kinematics["time_s"])
    pictures = numbers(truth["time_s"])[frames]
    moving = cubic(told - told[0] + pictures[0], numbers(motion["time_s"]), numbers(motion["knee_deg"]))
    not_repeated = numbers(truth["repeated"])[frames] == 0
    true = np.where(not_repeated, numbers(truth["knee_deg"])[frames], moving)
    error, raw = (numbers(kinematics[name]) - true for name in ("knee_deg", "knee_raw_deg"))
    sigma = numbers(kinematics["knee_sigma_deg"])
    row["knee_deg"] = rms(error)
    both = np.isfinite(raw) & np.isfinite(error) & not_repeated  # on the same frames
    row["knee_fit_deg"], row["knee_raw_deg"] = rms(error[both]), rms(raw[both])
    row["ratio"] = row["knee_fit_deg"] / row["knee_raw_deg"] if row["knee_raw_deg"] else math.nan
    z = error / sigma
    row["knee_z"] = rms(z)
    off = (np.abs(z) > 3) & (np.abs(error) > 0.3)
    row["knee_off"] = int(off.sum())
    # Of many frames a few lie beyond 3 SD by chance; 2 % do where error/SD is 1.3. Beyond 5 SD none does.
    if off.mean() > 0.02 or (off & (np.abs(z) > 5)).any():
        worst = int(np.argmax(np.where(off, np.abs(z), 0)))
        why.append(f"knee {abs(error[worst]):.1f} deg off, {abs(z[worst]):.1f} SD (frame {frames[worst]}; {off.sum()} frames)")


def judge_times(truth, tracks, rows, not_repeated, row, why):
    true, told = numbers(truth["time_s"])[rows], numbers(tracks["time_s"])
    error = (told - told[0]) - (true - true[0])
    worst = float(np.max(np.abs(error[not_repeated])))
    row["time_ms"] = 1000 * worst
    frame_s = float(np.median(np.diff(true[not_repeated])))
    if worst > 1.001 * frame_s:
        why.append(f"a time {1000 * worst:.0f} ms off")


def judge(world, folder, result, code, told):
    """The row's verdict, why, and figures."""
    row = {}
    if code:
        message = told.split("\n")[-1]
        asked = (result / "candidates.csv").exists() and "no leg was found" not in message
        return row | {"verdict": "asked" if asked else "refused", "why": message[:300]}
    truth, tracks = read_table(folder / "truth.csv"), read_table(result / "tracks.csv")
    rows = numbers(tracks["frame"]).astype(int)
    not_repeated = numbers(truth["repeated"])[rows] == 0
    scale = world["processing"]["size"][0] / world["size"][0] if "processing" in world else 1
    why = []
    judge_times(truth, tracks, rows, not_repeated, row, why)
    judge_positions(truth, tracks, rows, not_repeated, world["radius_px"] * scale, row, why)
    if (result / "kinematics.csv").exists():
        judge_angles(truth, read_table(folder / "motion.csv"), read_table(result / "kinematics.csv"), row, why)
    if why:
        return row | {"verdict": "wrong", "why": "; ".join(why)}
    poor = [f"recall {row['recall']:.2f}"] * bool(row["recall"] < 0.95) + [f"error/sigma {row['z']:.2f}"] * (not 0.6 <= row["z"] <= 1.6)
    return row | {"verdict": "poor" if poor else "right", "why": "; ".join(poor)}


COLUMNS = ("seed", "verdict", "why", "recall", "z", "z_ankle", "z_knee", "z_hip", "z_waist", "knee_deg", "knee_fit_deg", "knee_raw_deg",
           "ratio", "knee_z", "knee_off", "time_ms", "seconds", "processor_s", "motion", "extra", "codec", "description")


def run(world, options):
    """The row of one recording."""
    folder = options.out / f"{world['seed']:04d}"
    stored = folder / "world.json"
    if options.rejudge and stored.exists():
        world = json.loads(stored.read_text(encoding="utf-8"))
    seed = world["seed"]
    row = {"seed": seed, "motion": world["motion"], "extra": int(world["extra"]), "codec": world["codec"]["kind"], "description": describe(world)}
    try:
        if not (stored.exists() and json.loads(stored.read_text(encoding="utf-8")) == json.loads(json.dumps(world))):
            if options.rejudge:
                raise Failure("is not there to be judged again")
            render(world, folder, options.bin)
        film = folder / ("film" + world["codec"]["ending"])
        result = options.csv.with_suffix("") / f"{seed:04d}"
        code, told, row["seconds"], row["processor_s"] = track(result, film, options.bin)
        row |= judge(world, folder, result, code, told)
        if not options.keep:
            shutil.rmtree(result, ignore_errors=True)
    except Failure as failure:
        row |= {"verdict": "not made", "why": str(failure)}
    if not (options.keep or options.rejudge):
        shutil.rmtree(folder, ignore_errors=True)
    return row


# --- the table --------------------------------------------------------------------------------------------------------

VERDICTS = ("right", "poor", "asked", "refused", "wrong", "not made")


def counts(rows):
    return [sum(row["verdict"] == verdict for row in rows) for verdict in VERDICTS]


def share(rows, column, low, high):
    values = [row[column] for row in rows if math.isfinite(row.get(column, math.nan))]
    inside = sum(low <= value <= high for value in values)
    return f"{inside} of {len(values)}, {100 * inside / max(1, len(values)):.0f} %; quartiles " + (
        " ".join(f"{value:.2f}" for value in np.quantile(values, (0, 0.25, 0.5, 0.75, 1))) if values else "–")


def table(rows):
    lines = [f"{'':34}" + "".join(f"{verdict:>9}" for verdict in VERDICTS)]

    def line(name, chosen):
        if chosen:
            lines.append(f"{name + f' ({len(chosen)})':34}" + "".join(f"{count:9d}" for count in counts(chosen)))

    alone = [row for row in rows if not row["extra"]]
    line("leg markers alone", alone)
    line("with extra markers", [row for row in rows if row["extra"]])
    for column in ("motion", "codec"):
        lines.append("")
        for value in sorted({row[column] for row in alone}):
            line(value, [row for row in alone if row[column] == value])
    lines.append("")
    for word in ("hidden", "clutter", "converted", "dropped", "gap of", "frozen", "variable", "light", "processed", "far side"):
        line(word, [row for row in alone if word in row["description"]])
    for rate in sorted({re.search(r"(\d+) Hz", row["description"])[1] for row in alone}, key=int):
        line(f"{rate} Hz", [row for row in alone if re.search(r"(\d+) Hz", row["description"])[1] == rate])
    lines += ["", "Within the aims (leg markers alone; smallest, quartiles, largest):",
              "  error/sigma of positions 0.8 to 1.25:  " + share(alone, "z", 0.8, 1.25),
              "  error/SD of the knee angle 0.7 to 1.4: " + share(alone, "knee_z", 0.7, 1.4),
              "  knee_deg over knee_raw_deg, at most 1.02: " + share(alone, "ratio", 0, 1.02)]
    for name, chosen in (("real", [row for row in alone if not row["motion"].startswith("drawn")]),
                         ("drawn", [row for row in alone if row["motion"].startswith("drawn")])):
        lines.append(f"    {name}: " + share(chosen, "ratio", 0, 1.02))
    lines += [f"  recall at least 0.95: " + share(alone, "recall", 0.95, 1),
              f"Processor time of lake track: {sum(row.get('processor_s', 0) for row in rows):.0f} s", ""]
    for verdict in reversed(VERDICTS[1:]):
        lines += [f"{verdict:9} {row['seed']:4d}  {row['description']}\n                {row['why']}" for row in rows if row["verdict"] == verdict]
    return "\n".join(lines) + "\n"


def write_rows(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(COLUMNS)
        for row in rows:
            out.writerow([f"{row[name]:.4g}" if isinstance(row.get(name), float) else row.get(name, "") for name in COLUMNS])


def seeds_of(text):
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("1-92"), help="1-92, or 3,7,20-30")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/test/bin", help="folder of the programs")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of the recordings")
    parser.add_argument("--csv", type=pathlib.Path, help="rows; OUT/worlds.csv")
    parser.add_argument("--keep", action="store_true", help="keep the recordings and what lake track wrote")
    parser.add_argument("--rejudge", action="store_true", help="track the recordings that are in OUT, render none")
    options = parser.parse_args()
    options.bin, options.out = options.bin.resolve(), options.out.resolve()
    options.csv = (options.csv or options.out / "worlds.csv").resolve()
    rows = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(run, draw(seed), options) for seed in options.seeds]):
            rows.append(done.result())
            row = rows[-1]
            print(f"{len(rows):4d}/{len(options.seeds)} seed {row['seed']:4d} {row['verdict']:8} {row['description']}"
                  + (f": {row['why']}" if row["why"] else ""), flush=True)
            rows.sort(key=lambda each: each["seed"])
            write_rows(options.csv, rows)
    text = table(rows)
    options.csv.with_suffix(".txt").write_text(text, encoding="utf-8")
    print("\n" + text)


if __name__ == "__main__":
    main()
