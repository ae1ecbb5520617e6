"""Animation of a run: bodies with their headings, trails, references, obstacles and their variable radii."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from dwmr.core.arrays import FloatArray
from dwmr.figures.style import COLOURS, STYLE, TITLES
from dwmr.results import derived
from dwmr.scenario.model import Robot, Scenario
from dwmr.scenario.outlines import centres, largest_speed
from dwmr.simulation.simulate import Trajectory

#: A picture's longer side [pixels]; both sides are even, as video formats ask for.
SIZE = 720
#: Left and lower edge, width and height of the panel, as shares of the picture.
PANEL = (0.09, 0.1, 0.88, 0.82)
DPI = 100
#: The least width left of the panel, for the label and the numbers of its axis [in].
MARGIN = 0.64
#: Colour behind the words about disturbances.
NOTE = "#f0e442"
#: Colours that a picture may hold and the first one need not: a palette must have them.
PALETTE = (*COLOURS, NOTE)
#: Points of a trail at most: it is drawn anew in every picture.
TRAIL_POINTS = 600


def moments(trajectory: Trajectory, speed: float, rate: float) -> list[int]:
    """Return the samples that are shown, the first and the last among them.

    Args:
        trajectory: A run.
        speed: Seconds of the run in one second of film [-].
        rate: Pictures in a second of film [1/s].
    """
    end = float(trajectory.t[-1])
    count = math.floor(end * rate / speed + 1e-9) + 1
    samples = np.searchsorted(trajectory.t, np.arange(count) * speed / rate - 1e-9)
    numbers: list[int] = np.union1d(samples, [len(trajectory.t) - 1]).tolist()
    return numbers


def body(robot: Robot, x: float, y: float, theta: float) -> FloatArray:
    """Return the outline of a robot whose reference point is at a posture, shape (5, 2) [m].

    It is the body with its front corners cut to a nose, or a rectangle with a nose in the circle of radius R_R.
    """
    if robot.body is None:
        half = min(1.15 * robot.half_track, 0.9 * robot.radius)
        rear, front = math.sqrt(robot.radius**2 - half**2), robot.radius
    else:
        half, rear, front = 0.5 * robot.body.width, robot.body.rear, robot.body.front
    outline = np.array([(-rear, half), (-rear, -half), (0.4 * front, -half), (front, 0.0), (0.4 * front, half)])
    c, s = math.cos(theta), math.sin(theta)
    turned: FloatArray = outline @ np.array([[c, s], [-s, c]])
    turned += np.array([x - robot.d * c, y - robot.d * s])
    return turned


class Film:
    """Draws the pictures of a run one by one; what never changes is drawn once.

    Attributes:
        size: Width and height of a picture [pixels].
    """

    def __init__(self, trajectory: Trajectory, scenario: Scenario) -> None:
        self.trajectory, self.scenario = trajectory, scenario
        with mpl.rc_context(STYLE):
            self.figure = Figure(dpi=DPI)
            self.canvas = FigureCanvasAgg(self.figure)
            self.axes = self.figure.add_axes(PANEL)
            self._lay_out()
            self._draw_what_stays()
            self._make_what_moves()
        self.canvas.draw()
        self._background = self.canvas.copy_from_bbox(self.figure.bbox)
        width, height = self.canvas.get_width_height()
        self.size = (width, height)

    def pictures(self, samples: list[int]) -> Iterator[FloatArray]:
        """Yield a picture for each sample, shape (height, width, 3), whole numbers from 0 to 255."""
        for k in samples:
            self.canvas.restore_region(self._background)
            self._move(k)
            for artist in self._moving:
                self.axes.draw_artist(artist)
            yield np.asarray(self.canvas.buffer_rgba())[:, :, :3]

    def _lay_out(self) -> None:
        """Choose limits that hold all that is drawn, and a picture of their shape."""
        self._places = centres(self.scenario, self.trajectory.t)
        low, high = extent(self.trajectory, self.scenario)
        across, up = high[0] - low[0], high[1] - low[1]
        # a very long or very high picture would leave no room for the texts
        ratio = min(max(up / across * PANEL[2] / PANEL[3], 0.6), 1.4)
        width, height = (SIZE, SIZE * ratio) if ratio <= 1.0 else (SIZE / ratio, SIZE)
        self.figure.set_size_inches(2 * round(width / 2) / DPI, 2 * round(height / 2) / DPI)
        left = max(PANEL[0], MARGIN / self.figure.get_figwidth())
        panel = (left, PANEL[1], PANEL[0] + PANEL[2] - left, PANEL[3])
        self.axes.set_position(panel)
        # one metre is as long in both directions when the limits have the shape of the panel
        shape = self.figure.get_figheight() * panel[3] / (self.figure.get_figwidth() * panel[2])
        across, up = max(across, up / shape), max(up, across * shape)
        middle, axes = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])), self.axes
        axes.set(xlim=(middle[0] - 0.5 * across, middle[0] + 0.5 * across), xlabel="x [m]")
        axes.set(ylim=(middle[1] - 0.5 * up, middle[1] + 0.5 * up), ylabel="y [m]")

    def _draw_what_stays(self) -> None:
        law = self.trajectory.controller
        self.axes.set_title(f"{TITLES.get(law, law)}", loc="left")
        for i, name in enumerate(self.trajectory.robots):
            if not self.scenario.robots[name].leaders:
                x_r, y_r = self.trajectory["x_r"][:, i], self.trajectory["y_r"][:, i]
                every = max(1, len(x_r) // 1000)
                self.axes.plot(x_r[::every], y_r[::every], color="black", lw=0.7, ls=(0, (2, 2)))
            self.axes.plot([], [], color=COLOURS[i % len(COLOURS)], lw=4, label=name)
        for one in self.scenario.obstacles:
            if largest_speed(one) == 0.0:
                self.axes.add_patch(Circle((one.x, one.y), one.radius, color="#444444"))
        names = len(self.trajectory.robots)
        self.axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=min(names, 6), fontsize=8)

    def _make_what_moves(self) -> None:
        axes, names = self.axes, self.trajectory.robots
        avoiders = derived.avoiders(self.scenario)
        self._radii = {n: derived.avoidance_radii(self.trajectory, self.scenario, n) for n in avoiders}
        moving: dict[str, list[Any]] = {"circles": [], "obstacles": [], "trails": [], "targets": [], "bodies": []}
        self._movers = [a for a, one in enumerate(self.scenario.obstacles) if largest_speed(one) > 0.0]
        for a in self._movers:
            disc = Circle((0.0, 0.0), self.scenario.obstacles[a].radius, color="#444444", animated=True)
            moving["obstacles"].append(axes.add_patch(disc))
        for _ in avoiders:
            for one in self.scenario.obstacles:
                moving["circles"].append(axes.add_patch(Circle((one.x, one.y), 1.0, fill=False, animated=True)))
        for i in range(len(names)):
            colour = COLOURS[i % len(COLOURS)]
            moving["trails"] += axes.plot([], [], color=colour, lw=1.2, alpha=0.8, animated=True)
            moving["targets"] += axes.plot([], [], "x", color=colour, ms=6, mew=1.5, animated=True)
            outline = Polygon(np.zeros((5, 2)), fc=colour, ec="black", lw=0.7, animated=True, zorder=4)
            moving["bodies"].append(axes.add_patch(outline))
        self._parts = moving
        style: dict[str, Any] = {"transform": axes.transAxes, "animated": True, "va": "bottom"}
        self._clock = axes.text(1.0, 1.015, "", ha="right", family="monospace", **style)
        box = {"facecolor": NOTE, "edgecolor": "none", "pad": 2.0}
        self._note = axes.text(0.5, 1.02, "", ha="center", fontsize=9, bbox=box, **style)
        self._moving = [*(a for kind in moving.values() for a in kind), self._clock]

    def _move(self, k: int) -> None:
        """Put everything that moves where it is at sample `k`."""
        t = self.trajectory
        every = max(1, len(t.t) // TRAIL_POINTS)
        for i, name in enumerate(t.robots):
            x, y = t["x"][: k + 1, i], t["y"][: k + 1, i]
            self._parts["trails"][i].set_data([*x[::every], x[-1]], [*y[::every], y[-1]])
            self._parts["targets"][i].set_data([t["x_r"][k, i]], [t["y_r"][k, i]])
            self._parts["bodies"][i].set_xy(body(self.scenario.robots[name], x[-1], y[-1], t["theta"][k, i]))
        for a, disc in zip(self._movers, self._parts["obstacles"], strict=True):
            disc.set_center(tuple(self._places[k, a]))
        self._move_circles(k)
        self._clock.set_text(f"t = {t.t[k]:6.1f} s")
        words = acting(self.trajectory, self.scenario, k)
        self._note.set_text(words)
        self._moving = [a for a in self._moving if a is not self._note] + ([self._note] if words else [])

    def _move_circles(self, k: int) -> None:
        """Draw R_d of every obstacle; it is thick while the obstacle is avoided."""
        circles = iter(self._parts["circles"])
        for name, radii in self._radii.items():
            avoided = int(self.trajectory["obstacle"][k, self.trajectory.robots.index(name)])
            for a, circle in zip(range(radii.shape[1]), circles, strict=False):
                active = a == avoided
                circle.set(
                    center=tuple(self._places[k, a]), radius=radii[k, a], lw=2.0 if active else 0.8,
                    ls="-" if active else "--", ec=COLOURS[1] if active else "#444444",
                )  # fmt: skip


def acting(trajectory: Trajectory, scenario: Scenario, k: int) -> str:
    """Return the disturbances of the robots at sample `k`, in words."""
    now, load = float(trajectory.t[k]), scenario.load
    kinds = [d.kind for d in scenario.disturbances if d.start <= now < d.stop]
    words = [f"disturbance: {', '.join(dict.fromkeys(kinds))}"] if kinds else []
    changed = load.mass_factor != 1.0 or load.inertia_factor != 1.0
    return "; ".join([*words, *(["load"] if changed and load.start <= now < load.stop else [])])


def extent(trajectory: Trajectory, scenario: Scenario, *, paths: bool = True) -> FloatArray:
    """Return the lower left and the upper right corner of the area of a run, shape (2, 2) [m].

    Args:
        trajectory: The run.
        scenario: Its scenario.
        paths: Whether paths of robots and places of followers count; starts, references and obstacles do anyway.
    """
    robots = scenario.robots
    reach = max(robot.radius for robot in robots.values())
    around = max([0.0, *(robots[n].radius + scenario.avoidance.margin for n in derived.avoiders(scenario))])
    ends = centres(scenario, trajectory.t)[[0, -1]]
    discs = [
        (float(x), float(y), sign * (obstacle.radius + around))
        for a, obstacle in enumerate(scenario.obstacles)
        for x, y in ends[:, a]
        for sign in (-1, 1)
    ]
    samples = slice(None if paths else 1)
    targets = [i for i, name in enumerate(trajectory.robots) if paths or not robots[name].leaders]
    xs = [*_ends(trajectory["x"][samples]), *_ends(trajectory["x_r"][:, targets]), *(x + r for x, _, r in discs)]
    ys = [*_ends(trajectory["y"][samples]), *_ends(trajectory["y_r"][:, targets]), *(y + r for _, y, r in discs)]
    room = 2.0 * reach + 0.03 * max(max(xs) - min(xs), max(ys) - min(ys))
    return np.array([(min(xs) - room, min(ys) - room), (max(xs) + room, max(ys) + room)])


def _ends(signal: FloatArray) -> tuple[float, float]:
    """Return the least and the greatest finite value [m]."""
    finite = signal[np.isfinite(signal)]
    return float(finite.min()), float(finite.max())
