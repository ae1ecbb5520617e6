"""Overview figures of a run: paths and tracking errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from dwmr.core.arrays import FloatArray
from dwmr.figures import panels
from dwmr.figures.animation import extent
from dwmr.figures.style import COLOURS, STYLE, TITLES
from dwmr.results.distances import meetings
from dwmr.results.logs import Log
from dwmr.results.metrics import errors, printed_frame
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Multiple of the size of the scene above which a panel has another scale,
FAR = 2.0
#: and the largest multiple that such a panel shows.
FARTHEST = 5.0
#: Errors and their labels.
_ERRORS = (("x_e", "$x_e$ [m]"), ("y_e", "$y_e$ [m]"), ("theta_e_unwrapped", r"$\theta_e$, unwrapped [rad]"))


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
        row = figure.subplots(1, count, squeeze=False)[0]
        for axes, trajectory in zip(row, trajectories, strict=True):
            axes.set_title(TITLES.get(trajectory.controller, trajectory.controller))
            panels.paths(axes, trajectory, scenario, r"avoidance radius $\bar{R}_d$")
            axes.plot([], [], marker="o", ms=5, color="white", mec="#555555", ls="", label="start")
            met = meetings(trajectory, scenario)
            if len(met):
                axes.plot(*met.T, marker="x", ms=8, mew=2.0, color="#d00000", ls="", zorder=6, label="collision")
            for robot, log in (logs or {}).items():
                x, y = (np.insert(log.signals[k], log.gaps + 1, np.nan) for k in ("x", "y"))
                edge = COLOURS[trajectory.robots.index(robot) % len(COLOURS)]
                axes.plot(x, y, color=edge, lw=3.5, alpha=0.35, zorder=1.5)
            if logs:
                axes.plot([], [], color="#555555", lw=3.5, alpha=0.35, label="log")
        for axes in row[1:]:
            axes.set_ylabel("")
        places = [np.stack([one.signals["x"], one.signals["y"]], axis=1) for one in (logs or {}).values()]
        _limit(row, trajectories, scenario, places)
        panels.legend(figure, *row, columns=4 if count == 1 else 8)
        figure.savefig(path, metadata={"Software": None})


def draw_errors(path: Path, trajectories: Sequence[Trajectory], scenario: Scenario) -> None:
    """Draw the tracking errors of all robots over time, one column per control law, disturbance windows shaded."""
    with mpl.rc_context(STYLE):
        count = len(trajectories)
        figure = Figure(figsize=(4.6 * count + 2.4 * (count == 1) + 0.6, 7.0), layout="constrained")
        rows = figure.subplots(len(_ERRORS), count, sharex=True, squeeze=False)
        for column, one in zip(rows.T, trajectories, strict=True):
            column[0].set_title(TITLES.get(one.controller, one.controller))
            series = [errors(one, robot, printed_frame(scenario, robot)) for robot in one.robots]
            for axes, (name, label) in zip(column, _ERRORS, strict=True):
                panels.lines(axes, one.t, np.stack([each[name] for each in series], axis=1), one.robots, label)
            panels.mark(column[:, None], one, scenario)
        for row in rows:
            _share_comparable_limits(row)
        frames = "errors as in Table 12: in inertial axes for a robot on the reference, in its own axes for a follower"
        panels.legend(figure, rows[0, 0], title=frames)
        figure.savefig(path, metadata={"Software": None})


def _limit(
    row: Sequence[Any], trajectories: Sequence[Trajectory], scenario: Scenario, more: Sequence[FloatArray]
) -> None:
    """Give all panels the same limits, but those with a robot far from the scene limits that fit it, and say so.

    Places `more` are part of the scene, each of shape (n, 2) [m].
    """
    longest = max(trajectories, key=lambda one: len(one.t))
    scene = _box([extent(longest, scenario, paths=False), *more])
    boxes = [_box([extent(one, scenario), scene]) for one in trajectories]
    size = np.ptp(scene, axis=0).max()
    are_far = [bool(np.ptp(box, axis=0).max() > FAR * size) for box in boxes]
    common = _box([box for box, is_far in zip(boxes, are_far, strict=True) if not is_far] or [scene])
    for axes, box, is_far, one in zip(row, boxes, are_far, trajectories, strict=True):
        middle, half = scene.mean(axis=0), 0.5 * FARTHEST * size
        limits = np.clip(box, middle - half, middle + half) if is_far else common
        # squares, so that panels are of one size
        low, high = limits.mean(axis=0) + 0.5 * np.ptp(limits, axis=0).max() * np.array([[-1.0], [1.0]])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        if is_far and len(row) > 1:
            axes.set_title("own scale", loc="right", size="small", style="italic")
        places = np.stack([one["x"], one["y"]], axis=2)
        inside = ((places >= low) & (places <= high)).all(axis=(0, 2))
        if not inside.all():
            text = (
                f"{', '.join(n for n, is_in in zip(one.robots, inside, strict=True) if not is_in)} out of the picture"
            )
            axes.annotate(text, (0.5, 0.01), xycoords="axes fraction", ha="center", va="bottom", size="small")


def _box(places: Sequence[FloatArray]) -> FloatArray:
    """Return the corners of the area of some places, each of shape (n, 2), shape (2, 2) [m]."""
    whole = np.concatenate(places)
    return np.stack([whole.min(axis=0), whole.max(axis=0)])


def _share_comparable_limits(row: Any) -> None:
    """Give panels of similar range the same limits; one that is more than twice as tall keeps its limits."""
    limits = [axes.get_ylim() for axes in row]
    smallest = min(high - low for low, high in limits)
    alike = [k for k, (low, high) in enumerate(limits) if high - low <= 2.0 * smallest]
    for k in alike:
        row[k].set_ylim(min(limits[a][0] for a in alike), max(limits[a][1] for a in alike))
