"""Overview figures of a run: paths and tracking errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from dwmr.core.arrays import FloatArray
from dwmr.figures.panels import MARKS, bodies, colour, mark, obstacle_labels, obstacles, references, ways
from dwmr.figures.style import COLOURS, STYLE, TITLES
from dwmr.results.distances import meetings
from dwmr.results.logs import Log
from dwmr.results.metrics import errors, printed_frame
from dwmr.scenario.model import Scenario
from dwmr.scenario.outlines import centres, is_moving
from dwmr.simulation.simulate import Trajectory

#: Multiple of the size of the scene above which a panel has another scale,
FAR = 2.0
#: and the largest multiple that such a panel shows.
FARTHEST = 5.0


def draw_path(
    path: Path, trajectories: Sequence[Trajectory], scenario: Scenario, logs: Mapping[str, Log] | None = None
) -> None:
    """Draw the paths of all robots around the obstacles, one panel per control law.

    Args:
        path: File to write, of any format matplotlib knows.
        trajectories: One per control law.
        scenario: Scenario of the runs.
        logs: Logs of real robots to draw in each panel, by robot.
    """
    with mpl.rc_context(STYLE):
        count = len(trajectories)
        figure = Figure(
            figsize=(4.2 * count + (1.6 if count == 1 else 0.4), 6.4 if count == 1 else 5.0), layout="constrained"
        )
        panels = figure.subplots(1, count, squeeze=False)[0]
        for axes, trajectory in zip(panels, trajectories, strict=True):
            _path_panel(axes, trajectory, scenario)
            for robot, log in (logs or {}).items():
                x, y = (np.insert(log.signals[k], log.gaps + 1, np.nan) for k in ("x", "y"))
                edge = COLOURS[trajectory.robots.index(robot) % len(COLOURS)]
                axes.plot(x, y, color=edge, lw=3.5, alpha=0.35, zorder=1.5)
            if logs:
                axes.plot([], [], color="#555555", lw=3.5, alpha=0.35, label="log")
        _limit(panels, trajectories, scenario, [(one.signals["x"], one.signals["y"]) for one in (logs or {}).values()])
        panels[0].set_ylabel("y [m]")
        named = {label: one for axes in panels for one, label in zip(*axes.get_legend_handles_labels(), strict=True)}
        _draw_legend(figure, list(named.values()), list(named), 4 if count == 1 else 8)
        figure.savefig(path, metadata={"Software": None})


def draw_errors(path: Path, trajectories: Sequence[Trajectory], scenario: Scenario) -> None:
    """Draw the tracking errors of all robots over time, one column per control law, disturbance windows shaded."""
    rows = (("x_e", "m"), ("y_e", "m"), ("theta_e_unwrapped", "rad"))
    with mpl.rc_context(STYLE):
        count = len(trajectories)
        figure = Figure(figsize=(4.6 * count + 2.4 * (count == 1) + 0.6, 7.0), layout="constrained")
        panels = figure.subplots(len(rows), count, sharex=True, squeeze=False)
        for column, trajectory in enumerate(trajectories):
            _error_column(panels[:, column], trajectory, scenario, rows)
        for row in panels:
            _share_comparable_limits(row)
        frames = "errors as in Table 12: in inertial axes for a robot on the reference, in its own axes for a follower"
        _draw_legend(figure, *_legend(panels[0, 0]), 6, title=frames)
        figure.savefig(path, metadata={"Software": None})


def _draw_legend(figure: Figure, handles: Sequence[Any], labels: Sequence[str], most: int, **options: Any) -> None:
    """Draw a legend below the panels, in as many columns as the width of the figure has room for, `most` at most."""
    for columns in range(most, 0, -1):
        legend = figure.legend(handles, labels, loc="outside lower center", ncols=columns, **options)
        legend.get_title().set_fontsize("small")
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


def _limit(panels: Sequence[Any], trajectories: Sequence[Trajectory], scenario: Scenario, more: Sequence[Any]) -> None:
    """Give all panels the same limits, but those with a robot far from the scene limits that fit it, and say so.

    Lines `more` are part of the scene.
    """
    scene = _box([_scene(trajectories, scenario), *more])
    boxes = [_box([(one["x"], one["y"]), scene]) for one in trajectories]
    size = np.ptp(scene, axis=1).max()
    near = [box for box in boxes if np.ptp(box, axis=1).max() <= FAR * size] or [scene]
    common = _box(near)
    for axes, box, one in zip(panels, boxes, trajectories, strict=True):
        is_far = bool(np.ptp(box, axis=1).max() > FAR * size)
        middle, half = 0.5 * scene.sum(axis=1), 0.5 * FARTHEST * size
        limits = np.clip(box, (middle - half)[:, None], (middle + half)[:, None]) if is_far else common
        # squares, so that panels are of one size
        half = 0.54 * np.ptp(limits, axis=1).max()
        for k, limit in enumerate((axes.set_xlim, axes.set_ylim)):
            limit(limits[k].mean() - half, limits[k].mean() + half)
        if is_far and len(panels) > 1:
            axes.set_title("own scale", loc="right", size="small", style="italic")
        gone = [n for i, n in enumerate(one.robots) if not _is_within(one["x"][:, i], one["y"][:, i], limits)]
        if gone:
            text = f"{', '.join(gone)} out of the picture"
            axes.annotate(text, (0.5, 0.01), xycoords="axes fraction", ha="center", va="bottom", size="small")


def _scene(trajectories: Sequence[Trajectory], scenario: Scenario) -> FloatArray:
    """Return the limits of references, starts and obstacles, shape (2, 2): x, y by least, greatest [m]."""
    one = trajectories[0]
    follows = [i for i, n in enumerate(one.robots) if not scenario.robots[n].leaders]
    widest = max(robot.radius for robot in scenario.robots.values()) + scenario.avoidance.margin
    around = [(np.array([o.x - o.radius - widest, o.x + o.radius + widest]),
               np.array([o.y - o.radius - widest, o.y + o.radius + widest])) for o in scenario.obstacles]  # fmt: skip
    paths = [(t["x_r"][:, follows], t["y_r"][:, follows]) for t in trajectories]
    longest = max((t.t for t in trajectories), key=len)
    moved = centres(scenario, longest[[0, -1]]) if is_moving(scenario) else np.zeros((2, 0, 2))
    ends = [(moved[:, a, 0], moved[:, a, 1]) for a in range(moved.shape[1])]
    return _box([*paths, (one["x"][:1], one["y"][:1]), *around, *ends])


def _box(places: Sequence[Any]) -> FloatArray:
    """Return the least and greatest finite x and y of some places, shape (2, 2) [m]."""
    ends = np.array([[_ends(place[k]) for place in places] for k in (0, 1)])
    return np.stack([ends[:, :, 0].min(axis=1), ends[:, :, 1].max(axis=1)], axis=1)


def _ends(values: FloatArray) -> tuple[float, float]:
    seen = values[np.isfinite(values)]
    return (float(seen.min()), float(seen.max())) if seen.size else (0.0, 0.0)


def _is_within(x: FloatArray, y: FloatArray, box: FloatArray) -> bool:
    return all(bool(((v >= low) & (v <= high)).all()) for v, (low, high) in zip((x, y), box, strict=True))


def _path_panel(axes: Any, trajectory: Trajectory, scenario: Scenario) -> None:
    axes.set_title(TITLES.get(trajectory.controller, trajectory.controller))
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    references(axes, trajectory, scenario)
    for i, name in enumerate(trajectory.robots):
        x, y, edge = trajectory["x"][:, i], trajectory["y"][:, i], COLOURS[i % len(COLOURS)]
        axes.plot(x, y, lw=1.3, label=name, **colour(i))
        axes.plot(x[0], y[0], marker="o", ms=5, color="white", mec=edge, mew=1.4, ls="", zorder=5)
    bodies(axes, trajectory, scenario)
    axes.plot([], [], marker="o", ms=5, color="white", mec="#555555", ls="", label="start")
    met = meetings(trajectory, scenario)
    if len(met):
        axes.plot(*met.T, marker="x", ms=8, mew=2.0, color="#d00000", ls="", zorder=6, label="collision")
    obstacles(axes, scenario)
    ways(axes, trajectory, scenario)
    obstacle_labels(axes, scenario, r"avoidance radius $\bar{R}_d$")


def _error_column(panels: Any, trajectory: Trajectory, scenario: Scenario, rows: Sequence[tuple[str, str]]) -> None:
    panels[0].set_title(TITLES.get(trajectory.controller, trajectory.controller))
    series: Mapping[str, Any] = {n: errors(trajectory, n, printed_frame(scenario, n)) for n in trajectory.robots}
    for axes, (name, unit) in zip(panels, rows, strict=True):
        axes.set_ylabel(f"{_symbol(name)} [{unit}]")
        for i, robot in enumerate(trajectory.robots):
            axes.plot(trajectory.t, series[robot][name], lw=1.1, label=robot, **colour(i))
    mark(panels[:, None], trajectory, scenario)


def _share_comparable_limits(row: Any) -> None:
    """Give panels of similar range the same limits; one that is more than twice as tall keeps its limits."""
    limits = [axes.get_ylim() for axes in row]
    smallest = min(high - low for low, high in limits)
    alike = [k for k, (low, high) in enumerate(limits) if high - low <= 2.0 * smallest]
    for k in alike:
        row[k].set_ylim(min(limits[a][0] for a in alike), max(limits[a][1] for a in alike))


def _legend(axes: Any) -> tuple[list[Any], list[str]]:
    handles, labels = axes.get_legend_handles_labels()
    order = np.argsort([label in MARKS for label in labels], kind="stable")
    return [handles[k] for k in order], [labels[k] for k in order]


def _symbol(name: str) -> str:
    return {"x_e": "$x_e$", "y_e": "$y_e$", "theta_e_unwrapped": r"$\theta_e$, unwrapped"}[name]
