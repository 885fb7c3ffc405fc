"""Figures of the tables, drawn with matplotlib: each function takes a folder of results, draws into `axes` or into a new figure, and returns the axes."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Dict, Optional

from .files import Folder

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def _axes(axes: Optional["Axes"]) -> "Axes":
    if axes is not None:
        return axes
    import matplotlib.pyplot

    return matplotlib.pyplot.subplots()[1]


def _labelled(axes: "Axes", x: str, y: str, title: str) -> "Axes":
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title)
    axes.grid(alpha=0.3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False)
    return axes


def knee_angle(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """Knee angle over time with its 95 % band; the rises are shaded."""
    axes, table = _axes(axes), folder["kinematics"]
    axes.plot(table["time_s"], table["knee_deg"], color="C0")
    band = 1.96 * table["knee_sigma_deg"]
    axes.fill_between(table["time_s"], table["knee_deg"] - band, table["knee_deg"] + band, color="C0", alpha=0.3, linewidth=0)
    if "events" in folder:
        times = folder["events"].pivot(index="repetition", columns="event", values="time_s")
        if {"onset", "standing"} <= set(times.columns):
            for begin, end in times[["onset", "standing"]].dropna().to_numpy():
                axes.axvspan(begin, end, color="0.92", zorder=0)
    return _labelled(axes, "time, s", "knee angle, deg", "Knee angle, rises shaded")


def marker_paths(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """Where the markers went: in the sagittal plane if there is a trajectory, else in the picture."""
    axes = _axes(axes)
    name, unit = ("trajectory", "mm") if "trajectory" in folder else ("tracks", "px")
    table = folder[name]
    for column in table.columns:
        if column.endswith("_status"):
            marker = column[:-len("_status")]
            axes.plot(table[f"{marker}_x_{unit}"], table[f"{marker}_y_{unit}"], label=marker, linewidth=1)
    axes.set_aspect("equal")
    if unit == "px":
        axes.invert_yaxis()
    return _labelled(axes, f"x, {unit}", f"y, {unit}", "Paths of the markers")


def misalignment(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """How far the exoskeleton's joint is from the knee over the rise."""
    axes, table = _axes(axes), folder["misalignment"]
    axes.plot(table["percent"], table["distance_mm"], label="distance")
    axes.plot(table["percent"], table["dx_mm"], "--", label="anterior")
    axes.plot(table["percent"], table["dy_mm"], ":", label="upward")
    return _labelled(axes, "rise, %", "mm", "From the knee to the exoskeleton's joint")


def moments(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """The joints' moments over the mean rise, the knee's with its 95 % band."""
    axes, table = _axes(axes), folder["loads"]
    mean = table[table["repetition"].astype(str) == "mean"]
    for joint in ("ankle", "knee", "hip"):
        axes.plot(mean["percent"], mean[f"{joint}_nm"], label=joint)
    axes.fill_between(mean["percent"], mean["knee_low_nm"], mean["knee_high_nm"], color="C1", alpha=0.2, linewidth=0)
    return _labelled(axes, "rise, %", "extension moment of one leg, N m", "Moments over the rise")


def angle_against_stroke(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """The knee angle that a linkage gives at each length of its actuator."""
    axes, table = _axes(axes), folder["angle_vs_stroke"]
    axes.plot(table["stroke_mm"], table["knee_deg"])
    return _labelled(axes, "stroke, mm", "knee angle, deg", "Knee angle against stroke")


def pareto(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """Range of rotation against misalignment: what more of the one costs of the other."""
    axes, table = _axes(axes), folder["pareto"]
    for program, front in table[table["design"] == "front"].groupby("program"):
        axes.plot(front["misalignment_percent"], front["range_deg"], "o-", label=f"{program} program")
    for design, point in table[table["design"] != "front"].groupby("design"):
        axes.scatter(point["misalignment_percent"], point["range_deg"], marker="x", label=design.replace("_", " "))
    return _labelled(axes, "misalignment, % of the shank", "range of rotation, deg", "What more range costs")


def stroke_program(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """The actuator's length over time."""
    axes, table = _axes(axes), folder["program"]
    axes.plot(table["time_s"], table["stroke_mm"])
    return _labelled(axes, "time, s", "stroke, mm", "Stroke program")


# The figure that says most of a folder, by the first table of it that is there.
_FIGURE_OF: Dict[str, Callable[..., Any]] = {
    "misalignment": misalignment, "loads": moments, "pareto": pareto, "angle_vs_stroke": angle_against_stroke, "program": stroke_program,
    "kinematics": knee_angle, "trajectory": marker_paths, "tracks": marker_paths}


def plot(folder: Folder, axes: Optional["Axes"] = None) -> "Axes":
    """The figure that suits what is in the folder."""
    for table, figure in _FIGURE_OF.items():
        if table in folder:
            return figure(folder, axes)
    raise ValueError(f"{folder.path}: no table that there is a figure of; there are {', '.join(folder.tables) or 'none'}")
