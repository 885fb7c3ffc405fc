#!/usr/bin/env python3
"""Draws the README's picture story of a study in five panels: overlay, knee angle, misalignment, design, firmware.

    libs/present/manual/story.py lake-out/sts-study libs/present/manual/story.png

The folder is one of `lake run`, or has the folders human, comparison, simulation and stroke."""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "apps/python"))
import lake  # noqa: E402
import lake.plot  # noqa: E402


def frame_of(video, time_s):
    """A frame with the subject, without what stands beside."""
    import matplotlib.pyplot as plt

    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "frame.png"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-nostdin", "-ss", str(time_s), "-i", video, "-frames:v", "1", picture], check=True)
        frame = plt.imread(picture)
    height, width = frame.shape[:2]
    return frame[:, int(0.28 * width):int(0.72 * width) // 2 * 2]


def firmware_text(folder):
    """How the table of strokes begins, as the board gets it: until when, how fast, with which pulse width."""
    lines = (folder / "stroke_table.h").read_text(encoding="utf-8").splitlines()
    begin = next(i for i, line in enumerate(lines) if " lake_segments[" in line)
    return "\n".join(["lake_segments[] = {", "  // ms, um/s, PWM", *(line[2:] for line in lines[begin + 1:begin + 15]), "  …"])


def draw(folder, out):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    folder = pathlib.Path(folder)
    figure, axes = plt.subplots(1, 5, figsize=(20, 4.4), constrained_layout=True)
    axes[0].imshow(frame_of(folder / "human/overlay.mp4", 2.1))
    lake.plot.knee_angle(lake.read(folder / "human"), axes[1])
    lake.plot.misalignment(lake.read(folder / "comparison"), axes[2])
    pose = plt.imread(folder / "simulation/pose_70.png")
    height, width = pose.shape[:2]
    axes[3].imshow(pose[int(0.13 * height):, width // 2:])  # the mechanism itself
    axes[4].text(0.02, 0.98, firmware_text(folder / "stroke"), family="monospace", fontsize=11, va="top", transform=axes[4].transAxes)
    titles = ["1  Film a rise, track it", "2  How the knee moves", "3  How far the joint is off", "4  A linkage for this person", "5  Its firmware"]
    for ax, title in zip(axes, titles):
        ax.set_title("")
        ax.set_title(title, loc="left", fontsize=13)
    for ax in (axes[0], axes[3], axes[4]):
        ax.set_xticks([])
        ax.set_yticks([])
        for side in ax.spines.values():
            side.set_visible(False)
    # The same study gives the same bytes: no time and no version in the file.
    figure.savefig(out, dpi=80, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    draw(sys.argv[1], sys.argv[2])
