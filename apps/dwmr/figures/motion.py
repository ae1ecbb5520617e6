"""Figures of the robots' motion: paths, velocities, formation, avoidance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from dwmr.control.obstacle_avoidance import constant_radius
from dwmr.core.geometry import wrap_array
from dwmr.figures import panels
from dwmr.figures.panels import thin
from dwmr.figures.style import COLOURS
from dwmr.results import derived
from dwmr.results.distances import obstacle_gaps
from dwmr.results.metrics import distances
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Symbol and unit of the two channels: velocity, acceleration.
VELOCITY = {"v": ("v", "m/s"), "omega": (r"\omega", "rad/s")}
#: Styles of velocity errors and their compensation: none of a robot that another panel of the picture shows.
PORTION = (0, 3)


def path_and_chattering(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw the paths around the obstacles, and the peaks of |dv_c/dt| of both channels."""
    figure = Figure(figsize=(10.0, 5.4), layout="constrained")
    places = figure.add_gridspec(2, 2)
    path = figure.add_subplot(places[:, 0])
    panels.paths(path, trajectory, scenario)
    above = figure.add_subplot(places[0, 1])
    below = figure.add_subplot(places[1, 1], sharex=above)
    for axes, (channel, symbol, unit) in zip(
        (above, below), (("v", "v", "m/s²"), ("omega", r"\omega", "rad/s²")), strict=True
    ):
        level = derived.chattering(trajectory, channel)
        panels.peaks(axes, trajectory.t, level, trajectory.robots, rf"peaks of $|\dot{{{symbol}}}_c|$ [{unit}]")
    return panels.finished(figure, np.array([[above], [below]]), trajectory, scenario, path, above, columns=8)


def _velocity_rows(rows: Any, trajectory: Trajectory, scenario: Scenario, robots: Sequence[str]) -> None:
    """Draw v_e and the sliding mode portion of some robots, one row each, one column per channel."""
    for column, channel in enumerate(derived.CHANNELS):
        error = derived.velocity_error(trajectory, channel)
        portion = derived.compensation(trajectory, scenario, channel)
        symbol, unit = VELOCITY[channel]
        for axes, robot in zip(rows[:, column], robots, strict=True):
            i = trajectory.robots.index(robot)
            signals, names = [error[:, i]], ["auxiliary velocity tracking error"]
            if portion is not None:
                signals, names = [*signals, portion[:, i]], [*names, "compensation by the sliding mode portion"]
            label = rf"${symbol}_e$ [{unit}]"
            panels.lines(axes, trajectory.t, np.stack(signals, axis=1), names, label, PORTION)
            panels.cut_peaks(axes, np.stack(signals, axis=1))
            axes.set_title(robot, loc="left")  # at the right a note says how far peaks go


def velocity_errors(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw velocity errors and their compensation for the first two robots."""
    robots = trajectory.robots[:2]
    figure, rows = panels.grid(len(robots), 2)
    _velocity_rows(rows, trajectory, scenario, robots)
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0])


def velocity_and_formation_errors(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw velocity errors of the other robots, and separation and bearing errors of all followers."""
    robots, followers = trajectory.robots[2:], derived.followers(scenario)
    figure, rows = panels.grid(len(robots) + 1, 2)
    _velocity_rows(rows[:-1], trajectory, scenario, robots)
    errors = [derived.formation_error(trajectory, scenario, robot) for robot in followers]
    errors = [(separation, np.unwrap(bearing)) for separation, bearing in errors]
    titles = ((r"$L_d - L$ [m]", "separation error"), (r"$\Psi_d - \Psi$ [rad]", "bearing error"))
    for column, (label, title) in enumerate(titles):
        # a follower keeps the colour it has among all robots
        for robot, one in zip(followers, errors, strict=True):
            style = panels.colour(trajectory.robots.index(robot))
            rows[-1, column].plot(*thin(trajectory.t, one[column], panels.BUCKETS), lw=1.0, label=robot, **style)
        rows[-1, column].set(ylabel=label, title=title)
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0], rows[-1, 0], columns=4)


def blending(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw the blending vectors near every obstacle that is avoided, and both orientations of the reference."""
    robots = derived.avoiders(scenario)
    avoided = sorted({int(a) for a in np.unique(trajectory["obstacle"]) if a >= 0})
    rows = -(-len(avoided) // 3)
    figure = Figure(figsize=(9.6, 3.4 * rows + 3.0), layout="constrained")
    places = figure.add_gridspec(rows + 1, 3)
    for k, a in enumerate(avoided):
        _vectors(figure.add_subplot(places[divmod(k, 3)]), trajectory, scenario, a)
    time = np.array([[figure.add_subplot(places[rows, :])]])
    for robot in robots:
        i, tail = trajectory.robots.index(robot), f" of {robot}" if len(robots) > 1 else ""
        original = np.unwrap(derived.path_orientation(trajectory, robot))
        # within half a turn of the path: where avoidance ends, both are one again
        active = original + wrap_array(trajectory["theta_r"][:, i] - original)
        orientations = np.stack([original, active], axis=1)
        names = [f"original path, tt{tail}", f"in force, oa during avoidance{tail}"]
        panels.lines(time[0, 0], trajectory.t, orientations, names, r"$\theta_r$ [rad]")
    return panels.finished(figure, time, trajectory, scenario, time[0, 0], columns=4)


def _vectors(axes: Any, trajectory: Trajectory, scenario: Scenario, a: int) -> None:
    """Draw U_b, U_f and the direction of their sum along the way around obstacle `a`, every second."""
    obstacle, every = scenario.obstacles[a], max(1, round(1.0 / trajectory.step))
    panels.obstacles(axes, scenario)
    panels.obstacle_labels(axes, scenario, r"$\bar{R}_d$")
    for robot in derived.avoiders(scenario):
        i = trajectory.robots.index(robot)
        x, y = trajectory["x"][:, i], trajectory["y"][:, i]
        around = np.flatnonzero(trajectory["obstacle"][:, i] == a)[::every]
        parts = derived.blending(trajectory, scenario, robot)[:, around]
        whole = parts.sum(axis=0)
        whole /= np.maximum(np.hypot(whole[:, 0], whole[:, 1]), 1e-12)[:, None]
        axes.plot(x[:: max(1, every // 10)], y[:: max(1, every // 10)], lw=1.0, **panels.colour(i))
        for vector, name, scale, colour in (
            (parts[0], "$U_b$", 2.0, COLOURS[2]), (parts[1], "$U_f$", 2.0, COLOURS[3]), (whole, "$U$", 1.3, COLOURS[1]),
        ):  # fmt: skip
            axes.quiver(
                x[around], y[around], vector[:, 0], vector[:, 1], angles="xy", scale=scale, scale_units="xy",
                width=0.006, color=colour, label=name,
            )  # fmt: skip
    named = [(handle, name) for handle, name in zip(*axes.get_legend_handles_labels(), strict=True) if "U" in name]
    axes.legend(*zip(*{name: (handle, name) for handle, name in named}.values(), strict=True), fontsize="x-small")
    reach = 1.6 * constant_radius(
        obstacle.radius, max(r.radius for r in scenario.robots.values()), scenario.avoidance.margin
    )
    axes.set(xlim=(obstacle.x - reach, obstacle.x + reach), ylim=(obstacle.y - reach, obstacle.y + reach))
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"obstacles.{a}: $U_b$, $U_f$, direction of $U$")


def radii(trajectory: Trajectory, scenario: Scenario, chosen: slice, distance: bool) -> Figure:
    """Draw R_d of some obstacles, and, if wanted, the distances of the avoiding robots from all obstacles.

    Args:
        trajectory, scenario: A run and its scenario.
        chosen: Which obstacles.
        distance: Whether to add the distances.
    """
    numbers = range(len(scenario.obstacles))[chosen]
    robots = derived.avoiders(scenario)
    figure, rows = panels.grid(len(numbers) + (len(robots) if distance else 0), 1, height=2.1)
    for robot in robots:
        i, tail = trajectory.robots.index(robot), f" of {robot}" if len(robots) > 1 else ""
        radius, gap = derived.avoidance_radii(trajectory, scenario, robot), distances(trajectory, scenario, robot)
        for axes, a in zip(rows[:, 0], numbers, strict=False):
            least = constant_radius(
                scenario.obstacles[a].radius, scenario.robots[robot].radius, scenario.avoidance.margin
            )
            axes.set_ylabel("$R_d$ [m]")
            axes.set_title(f"obstacles.{a}")
            style = {"color": COLOURS[3] if len(robots) == 1 else COLOURS[i % len(COLOURS)]}
            axes.plot(
                *thin(trajectory.t, gap[:, a], panels.BUCKETS),
                lw=0.8,
                ls=":",
                label=f"$d_{{ia}}${tail}",
                **style,
            )
            axes.plot(*thin(trajectory.t, radius[:, a], panels.BUCKETS), lw=1.4, label=f"$R_d${tail}", **style)
            axes.axhline(least, color="#444444", lw=0.8, ls="--", label=r"constant part $\bar{R}_d$")
            swell = max(float(radius[:, a].max()) - least, 0.02 * least)
            axes.set_ylim(least - 0.8 * swell, least + 1.8 * swell)
    for axes, robot in zip(rows[len(numbers) :, 0], robots, strict=False):
        _distances(axes, trajectory, scenario, robot)
    return panels.finished(figure, rows, trajectory, scenario, *rows[:, 0], columns=5)


def follower_distances(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw the distances of all followers from all obstacles."""
    robots = derived.followers(scenario)
    figure, rows = panels.grid(len(robots), 1, height=2.1)
    for axes, robot in zip(rows[:, 0], robots, strict=True):
        _distances(axes, trajectory, scenario, robot)
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0], columns=6)


def _distances(axes: Any, trajectory: Trajectory, scenario: Scenario, robot: str) -> None:
    names = [f"obstacles.{a}" for a in range(len(scenario.obstacles))]
    panels.lines(axes, trajectory.t, distances(trajectory, scenario, robot), names, r"$d_{ia}$ [m]")
    touch = max(o.radius for o in scenario.obstacles) + scenario.robots[robot].radius
    axes.axhline(touch, color="black", lw=0.8, ls=":", label="$r_a + R_R$")
    panels.lengths(axes, 0.5 * touch)
    gap = obstacle_gaps(trajectory, scenario, robot)
    nearest = int(np.argmin(gap.min(axis=0)))
    axes.set_title(f"{robot}; least gap of its body {gap.min():.2f} m, from obstacles.{nearest}")
