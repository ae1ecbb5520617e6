"""Plots of runs as data for `PanelPlot` of pages: laws over each other, a panel for each signal and robot."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from dwmr.control.obstacle_avoidance import constant_radius
from dwmr.core.arrays import FloatArray
from dwmr.figures.animation import body
from dwmr.figures.panels import BODIES, kept, thin
from dwmr.figures.style import COLOURS
from dwmr.results import derived, lyapunov
from dwmr.results.metrics import errors, printed_frame
from dwmr.scenario.model import Scenario
from dwmr.scenario.outlines import centres, is_moving, largest_speed
from dwmr.simulation.simulate import Trajectory
from fuzzyctl.plot import limits

#: Dashes of lines [pixels].
DASHES = ("", "7 3", "2 2", "8 3 2 3")
#: Points of all lines of a page together: most of a megabyte.
MOST_POINTS = 75_000
#: Smallest chattering that a logarithmic axis shows [m/s² or rad/s²].
LEAST_LEVEL = 1e-3
#: Robots side by side; more of them are below each other.
MOST_COLUMNS = 4


class Plot(NamedTuple):
    """A plot with its title and caption; `data` is the input of `PanelPlot`."""

    title: str
    caption: str
    data: dict[str, Any]


class Signal(NamedTuple):
    """Signals of one row of panels.

    Attributes:
        label: Beside the axis: symbol and unit.
        by_law: Values of each law that has the signal, shape (samples, robots).
        commanded: The same of the command that belongs to it; empty without one.
        is_log: Whether the axis is logarithmic.
        about: Description; empty if the label and the caption have it.
    """

    label: str
    by_law: Mapping[str, FloatArray]
    commanded: Mapping[str, FloatArray] = {}
    is_log: bool = False
    about: str = ""


def buckets(trajectories: Sequence[Trajectory]) -> int:
    """Return into how many stretches a line is divided, so that the page keeps within `MOST_POINTS`."""
    lines = sum(len(t.robots) * (13 + len(t.law_signals)) for t in trajectories)
    return max(40, min(800, MOST_POINTS // (2 * lines)))


def of(trajectories: Sequence[Trajectory], scenario: Scenario) -> list[Plot]:
    """Return all plots of runs of one scenario."""
    draw = _Drawing(trajectories, scenario)
    return [draw.path(), draw.errors(), draw.velocities(), draw.chattering(), *draw.law(), *draw.lyapunov()]


class _Drawing:
    """Makes the plots: lines are laws and panels robots where there are several laws, otherwise lines are robots."""

    def __init__(self, trajectories: Sequence[Trajectory], scenario: Scenario) -> None:
        self.runs = {t.controller: t for t in trajectories}
        self.scenario, self.count = scenario, buckets(trajectories)
        self.laws, self.robots = list(self.runs), list(scenario.robots)
        self.has_many_laws = len(self.laws) > 1
        self.names = self.laws if self.has_many_laws else self.robots
        self.end = max(float(t.t[-1]) for t in trajectories)

    def path(self) -> Plot:
        """Draw where the robots went."""
        circles = self._obstacles()
        panels = []
        for group in self._groups():
            lines = [line for i in group for line in self._tracks(i)]
            corners = [(x + s * r, y + s * r) for x, y, r, _ in circles for s in (-1.0, 1.0)]
            xs = np.concatenate([line["points"][0] for line in lines] + [[x for x, _ in corners]])
            ys = np.concatenate([line["points"][1] for line in lines] + [[y for _, y in corners]])
            panels.append(
                {
                    "title": self._title(group), "label": "y [m]", "x": limits.whole(xs), "y": limits.whole(ys),
                    "lines": [_encoded(line) for line in lines], "circles": circles,
                }
            )  # fmt: skip
        caption = "Paths of the reference points, robots at even times, and obstacles with the radius R̄_d around them."
        if is_moving(self.scenario):
            caption += " Obstacles that move are drawn at their starts, and outlined where they are at the end."
        reference = {"name": "reference", "colour": "", "dash": "2 3"}
        return self._plot("Paths", caption, panels, "x [m]", extra=[reference], is_map=True)

    def _tracks(self, i: int) -> list[dict[str, Any]]:
        lines = []
        for law, t in self.runs.items():
            series = self.names.index(law if self.has_many_laws else self.robots[i])
            lines.append({"series": series, "points": self._track(t["x"][:, i], t["y"][:, i])})
            lines.append({"series": series, "points": self._bodies(t, i), "body": True})
        if not self.scenario.robots[self.robots[i]].leaders:
            longest = max(self.runs.values(), key=lambda t: len(t.t))
            points = self._track(longest["x_r"][:, i], longest["y_r"][:, i])
            lines.append({"series": len(self.names), "points": points})
        return lines

    def _track(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        even = np.linspace(0, len(x) - 1, min(len(x), self.count)).astype(int)
        rows = np.unique(np.concatenate([even, kept(x, self.count // 8), kept(y, self.count // 8)]))
        return x[rows], y[rows]

    def _bodies(self, t: Trajectory, i: int) -> tuple[FloatArray, FloatArray]:
        """Return the outlines of a robot at moments that divide its run evenly, as one line with gaps."""
        robot, outlines = self.scenario.robots[self.robots[i]], [np.full((1, 2), np.nan)]
        for k in np.linspace(0, len(t.t) - 1, BODIES).round().astype(int):
            outline = body(robot, *(float(t[signal][k, i]) for signal in ("x", "y", "theta")))
            outlines += [outline, outline[:1], outlines[0]]
        x, y = np.concatenate(outlines).T
        return x, y

    def _obstacles(self) -> list[tuple[float, float, float, bool]]:
        """Return circles: centre and radius [m], and whether it is an obstacle's body."""
        avoiders = derived.avoiders(self.scenario)
        largest = max((self.scenario.robots[n].radius for n in avoiders), default=0.0)
        circles = []
        for a, one in enumerate(self.scenario.obstacles):
            circles.append((one.x, one.y, one.radius, True))
            if largest_speed(one) > 0.0:
                x, y = centres(self.scenario, np.array([self.end]))[0, a]
                circles.append((float(x), float(y), one.radius, False))
            if avoiders:
                reach = constant_radius(one.radius, largest, self.scenario.avoidance.margin)
                circles.append((one.x, one.y, reach, False))
        return circles

    def errors(self) -> Plot:
        """Draw the tracking errors as Table 12 takes them."""
        by_law = {
            law: [errors(t, robot, printed_frame(self.scenario, robot)) for robot in t.robots]
            for law, t in self.runs.items()
        }
        labels = (("x_e", "x_e [m]"), ("y_e", "y_e [m]"), ("theta_e", "θ_e [rad]"))
        signals = [
            Signal(label, {law: np.stack([one[key] for one in each], axis=1) for law, each in by_law.items()})
            for key, label in labels
        ]
        caption = "As in Table 12: inertial axes for a robot on the reference, its own axes for a follower."
        return self._over_time("Tracking errors", caption, signals)

    def velocities(self) -> Plot:
        """Draw the velocities from the wheels and those that the law commands."""
        signals = [
            Signal(f"{symbol} [{unit}]", self._recorded(name), self._recorded(f"{name}_c"))
            for name, symbol, unit in (("v", "v", "m/s"), ("omega", "ω", "rad/s"))
        ]
        return self._over_time("Velocities", "From the wheels, and wide and pale as the law commands them.", signals)

    def chattering(self) -> Plot:
        """Draw the peaks of |dv_c/dt| of both channels."""
        signals = [
            Signal(label, {law: self._peaks(derived.chattering(t, name)) for law, t in self.runs.items()}, is_log=True)
            for name, label in (("v", "|dv_c/dt| [m/s²]"), ("omega", "|dω_c/dt| [rad/s²]"))
        ]
        caption = "The greatest |dv_c/dt| of every stretch of time, on logarithmic axes."
        return self._over_time("Chattering", caption, signals)

    def _peaks(self, levels: FloatArray) -> FloatArray:
        """Replace every sample by the greatest of its stretch of time."""
        size = max(1, -(-len(levels) // self.count))
        starts = np.arange(0, len(levels), size)
        peaks = np.maximum.reduceat(levels, starts, axis=0)
        return np.repeat(np.maximum(peaks, LEAST_LEVEL), size, axis=0)[: len(levels)]

    def law(self) -> list[Plot]:
        """Draw the records of the control laws; signals of the same name and unit share their panels."""
        by_signal: dict[tuple[str, str], dict[str, FloatArray]] = {}
        docs: dict[tuple[str, str], dict[str, None]] = {}
        legend: dict[str, None] = {}
        for law, t in self.runs.items():
            for one in t.law_signals:
                by_signal.setdefault((one.name, one.unit), {})[law] = t[one.name]
                docs.setdefault((one.name, one.unit), {})[one.doc] = None
                stem, doc = one.name.removesuffix("_v"), one.doc.removesuffix(", v channel")
                if not one.name.endswith("_omega"):
                    legend[f"{stem}: {doc}"] = None
        if not by_signal:
            return []
        signals = [
            Signal(name if unit == "-" else f"{name} [{unit}]", by_law, about="; ".join(docs[name, unit]))
            for (name, unit), by_law in by_signal.items()
        ]
        return [self._over_time("Sliding variables and gains", f"{'; '.join(legend)}.", signals, columns=2)]

    def lyapunov(self) -> list[Plot]:
        """Draw the Lyapunov functions and their derivatives, of the laws that have one."""
        by_law = {law: lyapunov.signals(t, self.scenario) for law, t in self.runs.items()}
        by_law = {law: one for law, one in by_law.items() if one}
        if not by_law:
            return []
        signals = [
            Signal(label, {law: lyapunov.last(one, name) for law, one in by_law.items()})
            for name, label in (("V", "V [m² + rad²]"), ("V_dot", "dV/dt [(m² + rad²)/s]"))
        ]
        functions = ", ".join(f"{law} V of Eq. ({'23' if 'V_23' in one else '10'})" for law, one in by_law.items())
        return [self._over_time("Lyapunov function", f"V and its derivative: {functions}.", signals)]

    def _recorded(self, name: str) -> dict[str, FloatArray]:
        return {law: t[name] for law, t in self.runs.items()}

    def _groups(self) -> list[list[int]]:
        """Return the robots of each panel of a signal."""
        every = range(len(self.robots))
        return [[i] for i in every] if self.has_many_laws else [list(every)]

    def _title(self, group: Sequence[int]) -> str:
        return self.robots[group[0]] if self.has_many_laws else ""

    def _over_time(self, title: str, caption: str, signals: Sequence[Signal], columns: int = 1) -> Plot:
        panels = [self._panel(signal, group) for signal in signals for group in self._groups()]
        return self._plot(title, caption, panels, "t [s]", columns)

    def _panel(self, signal: Signal, group: Sequence[int]) -> dict[str, Any]:
        drawn, lines = [], []
        for law in signal.by_law:
            t = self.runs[law].t
            for i in group:
                name = law if self.has_many_laws else self.robots[i]
                for is_wide, source in ((True, signal.commanded), (False, signal.by_law)):
                    if law in source:
                        drawn.append(limits.Line(name, t, source[law][:, i]))
                        points = thin(t, source[law][:, i], self.count)
                        lines.append(_encoded({"series": self.names.index(name), "points": points, "wide": is_wide}))
        limit = limits.of(drawn, is_log=signal.is_log)
        return {
            "title": self._title(group), "label": signal.label, "x": (0.0, self.end), "y": limit.shown,
            "whole": limit.whole, "note": limit.note, "log": signal.is_log, "lines": lines, "about": signal.about,
        }  # fmt: skip

    def _plot(
        self, title: str, caption: str, panels: list[dict[str, Any]], x: str, columns: int = 1,
        extra: Sequence[Mapping[str, str]] = (), is_map: bool = False,
    ) -> Plot:  # fmt: skip
        series = [
            {"name": name, "colour": COLOURS[i % len(COLOURS)], "dash": DASHES[i % len(DASHES)]}
            for i, name in enumerate(self.names)
        ]
        windows = derived.windows([(d.start, d.stop) for d in self.scenario.disturbances], self.end)
        data = {
            "title": title, "x": x, "map": is_map, "series": [*series, *extra], "panels": panels,
            "columns": min(len(self.robots), MOST_COLUMNS) if self.has_many_laws else columns,
            "windows": [] if is_map else list(windows),
            "bars": [] if is_map else derived.loaded(self.scenario, self.end),
        }  # fmt: skip
        return Plot(title, caption, data)


def _encoded(line: Mapping[str, Any]) -> dict[str, Any]:
    x, y = line["points"]
    encoded = {"series": line["series"], "wide": line.get("wide", False), "x": _single(x), "y": _single(y)}
    return {**encoded, "body": True} if "body" in line else encoded


def _single(values: FloatArray) -> str:
    """Return numbers in half the space; larger ones, of a run that diverged, become NaN: a gap in a line."""
    fits = np.abs(values) <= np.finfo(np.float32).max
    return base64.b64encode(np.where(fits, values, np.nan).astype("<f4").tobytes()).decode()
