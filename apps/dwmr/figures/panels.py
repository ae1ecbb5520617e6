"""Panels shared by several figures: signals over time, paths around obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from dwmr.control.obstacle_avoidance import constant_radius
from dwmr.core.arrays import FloatArray
from dwmr.figures.animation import body
from dwmr.figures.style import COLOURS, DASHES
from dwmr.results.derived import avoiders, loaded, windows
from dwmr.scenario.model import Scenario
from dwmr.scenario.outlines import centres, is_moving, largest_speed
from dwmr.simulation.simulate import Trajectory

#: Stretches of time into which a signal is divided: more than a page has columns of ink.
BUCKETS = 1200
#: Stretches of time whose peaks are drawn: half a second each in a run of 200 s.
PEAKS = 400
#: A level is drawn down to this [unit of the level].
LEAST_LEVEL = 1e-3
#: Greatest width of a legend [width of its figure].
LEGEND_WIDTH = 0.98
#: Points of a path: a tenth of a second apart in a run of 200 s.
PATH_POINTS = 2000
#: Bodies along the way of a robot: the first at its start, one at its end.
BODIES = 11
#: Labels of the marks of `mark`, the last ones of a legend.
MARKS = ("disturbance", "load", "avoidance")


def grid(rows: int, columns: int, height: float = 2.3) -> tuple[Figure, Any]:
    """Return a figure with panels over one time axis, as a pair of figure and panels of shape (rows, columns).

    Args:
        rows, columns: Number of panels.
        height: Of one row [inch].
    """
    figure = Figure(figsize=(4.8 * columns if columns > 1 else 7.2, height * rows + 0.9), layout="constrained")
    return figure, figure.subplots(rows, columns, sharex=True, squeeze=False)


def colour(k: int) -> dict[str, Any]:
    """Return colour and dashes of the k-th line of a panel."""
    return {"color": COLOURS[k % len(COLOURS)], "ls": DASHES[k % len(DASHES)]}


def lines(
    axes: Any, t: FloatArray, signals: FloatArray, names: Sequence[str], label: str, styles: Sequence[int] | None = None
) -> None:
    """Draw one line per name over time, those that swing widely below the others.

    Args:
        axes: Panel.
        t: Times, shape (samples,) [s].
        signals: Shape (samples, names).
        names: Labels of the lines.
        label: Symbol and unit, beside the axis.
        styles: Numbers of their styles; absent: in order.
    """
    axes.set_ylabel(label)
    # a line that chatters is a band, which would hide lines below it
    wide = np.mean(np.abs(np.diff(signals, axis=0)), axis=0) if len(t) > 1 else np.zeros(len(names))
    order = np.argsort(np.argsort(-wide, kind="stable"), kind="stable")
    for k, name in enumerate(names):
        style = colour(k if styles is None else styles[k])
        axes.plot(*thin(t, signals[:, k], BUCKETS), lw=1.0, label=name, zorder=2.0 + 0.01 * order[k], **style)


def cut_peaks(axes: Any, signals: FloatArray) -> None:
    """Cut off peaks of less than a hundredth of the time that would flatten the rest, and note their size.

    Args:
        axes: Panel.
        signals: Drawn signals, shape (samples, lines).
    """
    seen = signals[np.isfinite(signals)]
    if not seen.size:
        return
    low, high = np.quantile(seen, 0.005), np.quantile(seen, 0.995)
    room = 0.3 * (high - low) + 1e-12
    least, greatest = float(seen.min()), float(seen.max())
    if greatest - least > 2.5 * (high - low + 2.0 * room):
        axes.set_ylim(max(low - room, least - 0.1 * room), min(high + room, greatest + 0.1 * room))
        text = f"peaks cut off, {least:.3g} to {greatest:.3g}".replace("-", "\u2212")
        axes.annotate(text, (0.99, 1.0), xycoords="axes fraction", ha="right", va="bottom", size=7)


def lengths(axes: Any, least: float) -> None:
    """Give a panel of distances [m] a logarithmic axis from `least` on, as small distances count."""
    axes.set_yscale("log")
    axes.set_ylim(bottom=least)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def peaks(axes: Any, t: FloatArray, levels: FloatArray, names: Sequence[str], label: str) -> None:
    """Draw the greatest value of every stretch of time on a logarithmic axis, one line per name.

    Args:
        axes: Panel.
        t: Times, shape (samples,) [s].
        levels: Shape (samples, names), >= 0.
        names: Labels of the lines.
        label: Text beside the axis.
    """
    size = max(1, -(-len(t) // PEAKS))
    starts = np.arange(0, len(t), size)
    axes.set_ylabel(label)
    for k, name in enumerate(names):
        axes.plot(t[starts], np.maximum.reduceat(levels[:, k], starts), lw=1.0, label=name, **colour(k))
    axes.set_yscale("log")
    axes.set_ylim(bottom=max(axes.get_ylim()[0], LEAST_LEVEL))


def mark(panels: Any, trajectory: Trajectory, scenario: Scenario) -> None:
    """Shade the disturbance windows, draw bars, and end the axis with the run.

    The bar at the head stands for the load on mass and inertia, that at the foot for avoidance.
    """
    end = float(trajectory.t[-1])
    active = (trajectory["obstacle"] >= 0).any(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], active, [False]]).astype(np.int8)))
    bars = [(trajectory.t[a], trajectory.t[b - 1]) for a, b in edges.reshape(-1, 2)]
    for axes in np.ravel(panels):
        for k, (start, stop) in enumerate(windows([(d.start, d.stop) for d in scenario.disturbances], end)):
            axes.axvspan(start, stop, color="#f0e442", alpha=0.25, lw=0, label="" if k else "disturbance")
        for start, stop in loaded(scenario, end):
            axes.axvspan(start, stop, 0.975, 1.0, color="#999999", lw=0, label="load")
        for k, (start, stop) in enumerate(bars):
            axes.axvspan(start, stop, 0.0, 0.025, color="#444444", lw=0, label="" if k else "avoidance")
        if end > 0.0:
            axes.set_xlim(0.0, end)
    for axes in panels[-1]:
        axes.set_xlabel("t [s]")


def finished(
    figure: Figure, rows: Any, trajectory: Trajectory, scenario: Scenario, *named: Any, columns: int = 6
) -> Figure:
    """Return a figure with marks in its panels over time `rows`, and a legend of the panels `named`."""
    mark(rows, trajectory, scenario)
    legend(figure, *named, columns=columns)
    return figure


def legend(figure: Figure, *panels: Any, columns: int = 6, title: str = "") -> None:
    """Put one legend with every line of some panels below a figure, the marks of `mark` last.

    It has as many columns as the width of the figure has room for, `columns` at most.
    """
    options: dict[str, Any] = {"loc": "outside lower center", "title": title, "title_fontsize": "small"}
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in handles:
                handles[label] = handle
    order = sorted(handles, key=lambda label: label in MARKS)
    for lines in range(math.ceil(len(order) / columns), len(order) + 1):
        count = math.ceil(len(order) / lines)
        drawn = figure.legend([handles[k] for k in order], order, ncols=count, **options)
        if count == 1 or drawn.get_window_extent().width <= LEGEND_WIDTH * figure.bbox.width:
            return
        drawn.remove()


def paths(axes: Any, trajectory: Trajectory, scenario: Scenario, radius: str = r"$\bar{R}_d$") -> None:
    """Draw the ways of all robots, their references, the obstacles and the constant avoidance radii, named `radius`."""
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    every = max(1, len(trajectory.t) // PATH_POINTS)
    references(axes, trajectory, scenario, every)
    for i, name in enumerate(trajectory.robots):
        x, y = trajectory["x"][:, i], trajectory["y"][:, i]
        rows = np.union1d(np.arange(0, len(x), every), np.union1d(kept(x, 200), kept(y, 200)))
        axes.plot(x[rows], y[rows], lw=1.2, label=name, **colour(i))
        axes.plot(
            x[0], y[0], marker="o", ms=4.5, color="white", mec=COLOURS[i % len(COLOURS)], mew=1.3, ls="", zorder=5
        )
    bodies(axes, trajectory, scenario)
    obstacles(axes, scenario)
    obstacle_labels(axes, scenario, radius)
    ways(axes, trajectory, scenario)


def references(axes: Any, trajectory: Trajectory, scenario: Scenario, every: int) -> None:
    """Draw the references of all robots that follow no robot."""
    for i in (k for k, n in enumerate(trajectory.robots) if not scenario.robots[n].leaders):
        x_r, y_r = trajectory["x_r"][::every, i], trajectory["y_r"][::every, i]
        axes.plot(x_r, y_r, color="black", lw=0.9, ls=(0, (2, 2)), label="reference")


def bodies(axes: Any, trajectory: Trajectory, scenario: Scenario) -> None:
    """Draw the bodies of all robots, each with a nose, at `BODIES` moments that divide the run evenly."""
    for k in np.linspace(0, len(trajectory.t) - 1, BODIES).round().astype(int):
        for i, name in enumerate(trajectory.robots):
            x, y, theta = (float(trajectory[signal][k, i]) for signal in ("x", "y", "theta"))
            if math.isfinite(x + y + theta):  # the last place of a run that diverged may be none
                edge = COLOURS[i % len(COLOURS)]
                outline = body(scenario.robots[name], x, y, theta)
                axes.add_patch(Polygon(outline, fc="white", ec=edge, lw=0.9, zorder=4))


def ways(axes: Any, trajectory: Trajectory, scenario: Scenario) -> None:
    """Draw where obstacles move from their starts, and where they are at the end of a run."""
    if not is_moving(scenario):
        return
    every = max(1, len(trajectory.t) // PATH_POINTS)
    at = centres(scenario, np.append(trajectory.t[::every], trajectory.t[-1]))
    for a, one in enumerate(scenario.obstacles):
        if largest_speed(one) > 0.0:
            axes.plot(at[:, a, 0], at[:, a, 1], color="#444444", lw=0.8, ls=":")
            axes.add_patch(Circle(tuple(at[-1, a]), one.radius, fill=False, ec="#444444", lw=0.8, ls=":"))
    axes.plot([], [], color="#444444", lw=0.8, ls=":", label="way of an obstacle")


def obstacles(axes: Any, scenario: Scenario) -> None:
    """Draw the obstacles with the constant radius around those that are avoided."""
    avoiding = [scenario.robots[name].radius for name in avoiders(scenario)]
    for one in scenario.obstacles:
        axes.add_patch(Circle((one.x, one.y), one.radius, color="#444444"))
        if avoiding:
            reach = constant_radius(one.radius, max(avoiding), scenario.avoidance.margin)
            axes.add_patch(Circle((one.x, one.y), reach, fill=False, ec="#444444", lw=0.8, ls="--"))


def obstacle_labels(axes: Any, scenario: Scenario, radius: str) -> None:
    """Add the obstacles and their radius, named `radius`, to a legend, which draws patches as boxes."""
    if scenario.obstacles:
        axes.plot([], [], marker="o", ms=6, color="#444444", ls="", label="obstacle")
    if avoiders(scenario):
        axes.plot([], [], color="#444444", lw=0.8, ls="--", label=radius)


def kept(signal: FloatArray, buckets: int) -> np.ndarray:
    """Return which samples draw the same picture: the least and the greatest of every bucket, first and last.

    Every peak stays at its time, so that chattering shows as the band it fills.

    Args:
        signal: Shape (samples,), any unit.
        buckets: Stretches of equal length; a picture needs about one for each of its columns of pixels.

    Returns:
        Increasing indices, shape (k,) with k <= 2 buckets + 2, or all where there are no more samples than that.
    """
    count = len(signal)
    if count <= 2 * buckets + 2:
        return np.arange(count)
    size = -(-count // buckets)
    # the last bucket is filled up with the last sample
    rows = np.pad(signal, (0, -count % size), mode="edge").reshape(-1, size)
    starts = np.arange(len(rows)) * size
    samples = np.concatenate([[0, count - 1], starts + rows.argmin(axis=1), starts + rows.argmax(axis=1)])
    return np.unique(np.minimum(samples, count - 1))


def thin(t: FloatArray, signal: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Return times and values of the samples that are kept, both of shape (k,)."""
    index = kept(signal, buckets)
    return t[index], signal[index]
