"""Interactive plots of runs; the only module that imports plotly."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from dwmr.control.obstacle_avoidance import constant_radius
from dwmr.core.arrays import FloatArray
from dwmr.results import derived, lyapunov
from dwmr.results.decimation import kept, thin
from dwmr.results.metrics import errors, printed_frame
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Okabe and Ito's colours and plotly's names of dashes, as in the other pictures.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("solid", "dash", "dot", "dashdot")
#: Points of all lines of a page together: most of a megabyte beside the 4.8 of plotly.js.
MOST_POINTS = 75_000
#: Smallest chattering that a logarithmic axis shows [m/s² or rad/s²].
LEAST_LEVEL = 1e-3
#: plotly.js offers a button that would send a plot to a server of its makers: it is taken away.
CONFIG = {"displaylogo": False, "responsive": True, "showSendToCloud": False, "plotlyServerURL": ""}


class Plot(NamedTuple):
    """A plot and what it shows, in words."""

    title: str
    caption: str
    figure: Any


class Panel(NamedTuple):
    """Lines over time: one per robot.

    Attributes:
        label: Beside the axis: symbol and unit.
        signals: Shape (samples, robots).
        suffix: Behind the robots' names, for a second line of each robot.
    """

    label: str
    signals: FloatArray
    suffix: str = ""


def available() -> bool:
    """Return whether plotly is installed."""
    return find_spec("plotly") is not None


def library() -> str:
    """Return the text of plotly.js."""
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


def to_html(plot: Plot, name: str) -> str:
    """Return a plot as a piece of HTML that needs the library; `name` is the id of its element."""
    text: str = plot.figure.to_html(full_html=False, include_plotlyjs=False, div_id=name, config=CONFIG)
    return text


def buckets(trajectories: Sequence[Trajectory]) -> int:
    """Return into how many stretches a line is divided, so that the page keeps within `MOST_POINTS`."""
    lines = sum(len(t.robots) * (13 + len(t.law_signals)) for t in trajectories)
    return max(40, min(800, MOST_POINTS // (2 * lines)))


def of(trajectory: Trajectory, scenario: Scenario, count: int) -> list[Plot]:
    """Return all plots of one run.

    Args:
        trajectory: A run.
        scenario: What was run.
        count: Stretches into which a line is divided, from `buckets`.
    """
    draw = _Drawing(trajectory, scenario, count)
    return [draw.path(), draw.errors(), draw.velocities(), draw.chattering(), *draw.law(), *draw.lyapunov()]


class _Drawing:
    """Draws the plots of one run."""

    def __init__(self, trajectory: Trajectory, scenario: Scenario, count: int) -> None:
        self.trajectory, self.scenario, self.count = trajectory, scenario, count

    def path(self) -> Plot:
        """Draw where the robots went."""
        from plotly.graph_objects import Figure

        figure, t = Figure(), self.trajectory
        for i, robot in enumerate(t.robots):
            if self.scenario.robots[robot].formation is None:
                style = {"color": "black", "width": 1, "dash": "dot"}
                figure.add_scatter(**self._track(t["x_r"][:, i], t["y_r"][:, i]), name="reference", line=style)
            track = self._track(t["x"][:, i], t["y"][:, i])
            figure.add_scatter(**track, name=escape(robot), line=_style(i), hovertemplate="x %{x:.3f} m, y %{y:.3f} m")
        self._obstacles(figure)
        figure.update_layout(**_layout(640))
        figure.update_xaxes(title_text="x [m]")
        figure.update_yaxes(title_text="y [m]", scaleanchor="x", scaleratio=1)
        caption = "Paths of the reference points, with the obstacles and the constant radius R̄_d around them."
        return Plot("Paths", caption, figure)

    def _track(self, x: FloatArray, y: FloatArray) -> dict[str, Any]:
        even = np.linspace(0, len(x) - 1, min(len(x), self.count)).astype(int)
        rows = np.unique(np.concatenate([even, kept(x, self.count // 8), kept(y, self.count // 8)]))
        return {"x": _single(x[rows]), "y": _single(y[rows]), "mode": "lines"}

    def _obstacles(self, figure: Any) -> None:
        avoiders = derived.avoiders(self.scenario)
        largest = max((self.scenario.robots[n].radius for n in avoiders), default=0.0)
        for one in self.scenario.obstacles:
            reach = constant_radius(one.radius, largest, self.scenario.avoidance.margin)
            for radius, fill, dash in ((one.radius, "#444444", "solid"), (reach, "rgba(0,0,0,0)", "dash")):
                if radius == one.radius or avoiders:
                    figure.add_shape(
                        type="circle", x0=one.x - radius, x1=one.x + radius, y0=one.y - radius, y1=one.y + radius,
                        fillcolor=fill, line={"color": "#444444", "width": 1, "dash": dash},
                    )  # fmt: skip
                    self._room(figure, one.x, one.y, radius)

    def _room(self, figure: Any, x: float, y: float, radius: float) -> None:
        """Make the axes contain a circle, which plotly does not count when it scales axes."""
        figure.add_scatter(
            x=_single(np.array([x - radius, x + radius])), y=_single(np.array([y - radius, y + radius])),
            mode="lines", line={"width": 0}, name="room", hoverinfo="skip", showlegend=False,
        )  # fmt: skip

    def errors(self) -> Plot:
        """Draw the tracking errors as Table 12 takes them."""
        t = self.trajectory
        found = [errors(t, robot, printed_frame(self.scenario, robot)) for robot in t.robots]
        labels = (("x_e", "x_e [m]"), ("y_e", "y_e [m]"), ("theta_e", "θ_e [rad]"))
        rows = [[Panel(label, np.stack([one[key] for one in found], axis=1))] for key, label in labels]
        caption = "As in Table 12: inertial axes for a robot on the reference, its own axes for a follower."
        return Plot("Tracking errors", caption, self._over_time([[row] for row in rows]))

    def velocities(self) -> Plot:
        """Draw the velocities asked for and those from the wheels."""
        t = self.trajectory
        rows = [
            [[Panel(f"{symbol} [{unit}]", t[name]), Panel("", t[f"{name}_c"], ", asked for")]]
            for name, symbol, unit in (("v", "v", "m/s"), ("omega", "ω", "rad/s"))
        ]
        return Plot("Velocities", "From the wheels, and as the control law asks for them.", self._over_time(rows))

    def chattering(self) -> Plot:
        """Draw the peaks of |dv_c/dt| of both channels."""
        rows = [
            [[Panel(label, self._peaks(derived.chattering(self.trajectory, channel, self.scenario.run.dt)))]]
            for channel, label in (("v", "|dv_c/dt| [m/s²]"), ("omega", "|dω_c/dt| [rad/s²]"))
        ]
        figure = self._over_time(rows)
        figure.update_yaxes(type="log", exponentformat="power")
        return Plot("Chattering", "The greatest |dv_c/dt| of every stretch of time, on logarithmic axes.", figure)

    def _peaks(self, levels: FloatArray) -> FloatArray:
        """Replace every sample by the greatest of its stretch of time."""
        size = max(1, -(-len(levels) // self.count))
        starts = np.arange(0, len(levels), size)
        peaks = np.maximum.reduceat(levels, starts, axis=0)
        return np.repeat(np.maximum(peaks, LEAST_LEVEL), size, axis=0)[: len(levels)]

    def law(self) -> list[Plot]:
        """Draw what the control law has recorded, one row per signal, one column per channel."""
        t = self.trajectory
        signals = {s.name: s for s in t.law_signals}
        stems = dict.fromkeys(name.removesuffix("_v") for name in signals if name.endswith("_v"))
        paired = [stem for stem in stems if f"{stem}_omega" in signals]
        names = [[f"{stem}_v", f"{stem}_omega"] for stem in paired]
        names += [[name] for name in signals if not any(name in row for row in names)]
        if not names:
            return []
        rows = [[[Panel(f"{name} [{signals[name].unit}]", t[name])] for name in row] for row in names]
        said = "; ".join(f"{stem}: {signals[f'{stem}_v'].doc.removesuffix(', v channel')}" for stem in paired)
        return [Plot("Sliding variables and gains", f"{said}." if said else "As recorded.", self._over_time(rows))]

    def lyapunov(self) -> list[Plot]:
        """Draw the Lyapunov function and its derivative, if the law has one."""
        found = lyapunov.signals(self.trajectory, self.scenario)
        if not found:
            return []
        values, rates = lyapunov.last(found, "V"), lyapunov.last(found, "V_dot")
        rows = [[[Panel("V [m² + rad²]", values)]], [[Panel("dV/dt [(m² + rad²)/s]", rates)]]]
        caption = f"V of Eq. ({'23' if 'V_23' in found else '10'}) and its derivative, for each robot."
        return [Plot("Lyapunov function", caption, self._over_time(rows))]

    def _over_time(self, rows: Sequence[Sequence[Sequence[Panel]]]) -> Any:
        """Draw panels over one time axis; the windows of disturbances are shaded."""
        from plotly.subplots import make_subplots

        columns = max(len(row) for row in rows)
        figure = make_subplots(len(rows), columns, shared_xaxes="all", vertical_spacing=0.25 / (len(rows) + 1))
        seen: set[str] = set()
        for r, row in enumerate(rows, start=1):
            for c, panels in enumerate(row, start=1):
                for nth, panel in enumerate(panels):
                    self._lines(figure, r, c, panel, nth, seen)
                figure.update_yaxes(title_text=panels[0].label, row=r, col=c)
        for start, stop in derived.windows(
            [(d.start, d.stop) for d in self.scenario.disturbances], float(self.trajectory.t[-1])
        ):
            figure.add_vrect(x0=start, x1=stop, fillcolor="#f0e442", opacity=0.25, line_width=0, layer="below")
        figure.update_layout(**_layout(120 + 180 * len(rows)))
        for c in range(1, columns + 1):
            figure.update_xaxes(title_text="t [s]", row=len(rows), col=c)
        return figure

    def _lines(self, figure: Any, row: int, column: int, panel: Panel, nth: int, seen: set[str]) -> None:
        for i, robot in enumerate(self.trajectory.robots):
            name = escape(robot + panel.suffix)
            t, values = thin(self.trajectory.t, panel.signals[:, i], self.count)
            figure.add_scatter(
                x=_single(t), y=_single(values), mode="lines", name=name, legendgroup=name,
                showlegend=name not in seen, line=_style(i, nth), opacity=0.5 if nth else 1.0, row=row, col=column,
                hovertemplate="%{y:.4g} at %{x:.2f} s",
            )  # fmt: skip
            seen.add(name)


def _single(values: FloatArray) -> Any:
    """Return numbers in half the space; what does not fit, of a run that diverged, becomes NaN: a gap in a line."""
    return np.where(np.abs(values) <= np.finfo(np.float32).max, values, np.nan).astype(np.float32)


def _style(i: int, nth: int = 0) -> dict[str, Any]:
    """Return the style of a robot's line; a second line has the dashes of the first one and is wider and paler."""
    return {
        "color": COLOURS[i % len(COLOURS)],
        "width": 3.0 if nth else 1.3,
        "dash": DASHES[i % len(DASHES)],
    }


def _layout(height: int) -> dict[str, Any]:
    return {
        "template": "none",
        "height": height,
        "margin": {"l": 70, "r": 20, "t": 30, "b": 60},
        "legend": {"orientation": "h", "yanchor": "bottom", "y": 1.0},
        "font": {"family": "system-ui, sans-serif", "size": 12},
    }
