"""Limits of vehicles: velocity commands within them, and scenarios that exceed them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.reference.prepared import Shape
from dwmr.scenario.graph import way
from dwmr.scenario.model import Ackermann, Edge, Omnidirectional, Robot, Scenario
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.scenario_keys import Places

#: Places of the path at which its curvature is taken, and the way between two that gives it, as a share of a step.
PLACES = 4000
_NEAR = 0.05


def others(scenario: Scenario) -> dict[str, Ackermann | Omnidirectional]:
    """Return the vehicles without a differential drive, by the names of their robots."""
    return {
        name: robot.vehicle
        for name, robot in scenario.robots.items()
        if isinstance(robot.vehicle, Ackermann | Omnidirectional)
    }


def vehicles(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse settings that need two driven wheels."""
    special = others(scenario)
    if not special:
        return
    name, vehicle = next(iter(special.items()))
    what = f"robots.{name} is {vehicle.kind}"
    if scenario.run.plant == "mujoco":
        message = f"run.plant = 'mujoco' has bodies with two driven wheels, and {what}"
        yield places.diagnostic("FZ904", "run.plant", message, help="set run.plant to 'equations'")
    if scenario.safety is not None:
        why = (
            "which cannot turn on the spot: its guarded point does not take every velocity"
            if isinstance(vehicle, Ackermann)
            else "whose third command the filter does not plan"
        )
        message = f"[safety] plans the two commands of two driven wheels, and {what}, {why}"
        yield places.diagnostic("FZ904", "safety", message, help="leave out the table safety")
    for name, vehicle in special.items():
        robot = scenario.robots[name]
        if not isinstance(vehicle, Omnidirectional):
            continue
        if robot.sensors.pose == "odometry":
            key = f"robots.{name}.sensors.pose"
            message = f"{places.resolve(tuple(key.split('.')))[0]} = 'odometry' counts no way sideways, and {what}"
            yield places.diagnostic("FZ904", key, message, help="set it to 'exact'")
        least = robot.mass * robot.com_offset**2
        if robot.inertia <= least:
            key = f"robots.{name}.inertia"
            message = (
                f"{places.resolve(tuple(key.split('.')))[0]} = {robot.inertia:g} kg m² about the centre must be more "
                f"than mass · com_offset² = {least:.4g} kg m²"
            )
            yield places.diagnostic("FZ904", key, message)


class Bends(NamedTuple):
    """Curvature of a path at some places.

    Attributes:
        t: Times, shape (n,) [s].
        x, y: Places [m].
        curvature: Positive to the left [1/m].
    """

    t: FloatArray
    x: FloatArray
    y: FloatArray
    curvature: FloatArray

    def at(self, places: Any) -> Bends:
        """Return those at some places."""
        return Bends(*(column[places] for column in self))


def bends(scenario: Scenario, shape: Shape) -> Bends:
    """Return the curvature of the reference all along the run, where it is finite."""
    end = min(scenario.run.horizon, shape.end, shape.period or math.inf)
    way = _NEAR * end / PLACES
    t = np.linspace(0.0, end, PLACES + 1)[:-1]
    x, y, theta, v, _ = np.transpose(shape.along(t.tolist()))
    turned = np.transpose(shape.along((t + way).tolist()))[2] - theta
    with np.errstate(all="ignore"):
        turned -= 2.0 * math.pi * np.round(turned / (2.0 * math.pi))
        curve = Bends(t, x, y, turned / (way * v))
    return curve.at(np.isfinite(curve.curvature))


def turning(scenario: Scenario, shapes: Mapping[str, Shape], places: Places) -> Iterable[Diagnostic]:
    """Refuse paths, and places in a formation, whose bends are closer, or change faster, than a car can be steered."""
    cars = {name: one for name, one in others(scenario).items() if isinstance(one, Ackermann)}
    paths: dict[int, Bends] = {}
    for name, car in cars.items():
        robot, robots = scenario.robots[name], way(scenario, name)
        shape = shapes[robots[0][0]]
        if id(shape) not in paths:
            paths[id(shape)] = bends(scenario, shape)
        along = paths[id(shape)]
        if not along.curvature.any():
            continue
        with np.errstate(divide="ignore"):  # a straight part has an infinite radius
            radii, axles = turn_radii(scenario, robots, 1.0 / along.curvature)
            angles = np.arctan(car.wheelbase / axles)
        k = int(np.argmin(np.round(radii, 6)))  # the first one of a circle
        if math.hypot(car.turning_radius, robot.d) > radii[k]:
            yield _too_close(name, robot, car, along.at(k), float(radii[k]), places)
            continue
        rates = np.abs(np.diff(angles)) / np.diff(along.t)
        if rates.max(initial=0.0) > car.steering_rate:
            k = int(rates.argmax())
            yield _too_sudden(name, robot, car, along.at(k), float(rates[k]), places)


def curvature(scenario: Scenario, name: str, key: str, asked: float, places: Places) -> Iterable[Diagnostic]:
    """Warn of a law that may ask a car for more curvature than its steering gives.

    Args:
        scenario: The scenario.
        name: The robot.
        key: Of the law's greatest curvature.
        asked: That curvature, at the rear axle [1/m].
        places: Locations of the keys.
    """
    car = scenario.robots[name].vehicle
    if isinstance(car, Ackermann) and asked * car.turning_radius > 1.0 + 1e-9:
        message = (
            f"{key} = {asked:g} 1/m asks for a radius of {1.0 / asked:.4g} m, and the car turns on one of "
            f"{car.turning_radius:.4g} m at the least: it would leave its way"
        )
        facts = (
            f"wheelbase / tan(steering_limit) = {car.wheelbase:g} m / tan({car.steering_limit:g} rad) = "
            f"{car.turning_radius:.4g} m at the rear axle",
        )
        help_text = f"set {key.rpartition('.')[2]} to {math.floor(1e3 / car.turning_radius) / 1e3:g} 1/m or less"
        yield replace(places.diagnostic("FZ904", key, message, facts=facts, help=help_text), severity="warning")


#: Robots from the reference on, each with its edge, see `graph.way`.
Way = Sequence[tuple[str, Edge | None]]


def turn_radii(scenario: Scenario, robots: Way, radii: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the radii of a robot while the formation turns about one centre.

    Args:
        scenario: The formation.
        robots: The way to the robot.
        radii: Of the reference, positive to the left, infinite where it is straight [m].

    Returns:
        Of its reference point, and of the middle of its axle, positive to the left [m].
    """
    point, axle = np.abs(radii), radii
    for name, edge in robots:
        if edge is not None:
            point = np.hypot(edge.separation * math.cos(edge.bearing), axle - edge.separation * math.sin(edge.bearing))
        axle = np.copysign(np.sqrt(np.maximum(0.0, point**2 - scenario.robots[name].d ** 2)), radii)
    return point, axle


def _too_close(name: str, robot: Robot, car: Ackermann, bend: Bends, radius: float, places: Places) -> Diagnostic:
    least = math.hypot(car.turning_radius, robot.d)
    where = f"({bend.x:.4g}, {bend.y:.4g}) at t = {bend.t:.4g} s"
    path = "the path" if robot.formation is None else "its place in the formation"
    message = (
        f"robots.{name} turns on a radius of {least:.4g} m at the least, and {path} has one of {radius:.4g} m where "
        f"the reference is at {where}"
    )
    key = f"robots.{name}.vehicle.steering_limit"
    facts = (
        f"wheelbase / tan(steering_limit) = {car.turning_radius:.4g} m at the rear axle, {least:.4g} m at the "
        f"reference point {robot.d:g} m ahead of it",
    )
    repair = "widen the path"
    if radius > robot.d:
        needed = math.atan2(car.wheelbase, math.sqrt(radius**2 - robot.d**2))
        needed = math.ceil(1e3 * needed) / 1e3
        repair = f"set steering_limit to {needed:g} rad or more, or widen the path"
    if robot.formation is not None:
        repair += ", or change the robot's separation and bearing"
    return places.diagnostic("FZ904", key, message, facts=facts, help=repair)


def _too_sudden(name: str, robot: Robot, car: Ackermann, bend: Bends, rate: float, places: Places) -> Diagnostic:
    path, repair = "the path", "widen or slow the path"
    if robot.formation is not None:
        path, repair = "its place in the formation", f"{repair}, or change the robot's separation and bearing"
    needed = math.ceil(1e3 * rate) / 1e3
    message = (
        f"robots.{name} is steered by {car.steering_rate:g} rad/s at the most, and {path} needs {rate:.4g} rad/s where "
        f"the reference is at ({bend.x:.4g}, {bend.y:.4g}) at t = {bend.t:.4g} s"
    )
    facts = ("the steering angle of a bend is atan(wheelbase * curvature), and the curvature changes along the path",)
    key = f"robots.{name}.vehicle.steering_rate"
    repair = f"set steering_rate to {needed:g} rad/s or more, or {repair}"
    return places.diagnostic("FZ904", key, message, facts=facts, help=repair)


def limited(asked: FloatArray, robot: Robot) -> FloatArray:
    """Return velocity commands within the limits of a robot.

    A car gets the commanded curvature, or that of its steering at the stop, whatever its velocity is cut to; at
    rest it does not turn.

    Args:
        asked: Velocities ahead, to the left, and turning, shape (..., 3) [m/s, m/s, rad/s].
        robot: Its settings.

    Returns:
        Same shape.
    """
    v, omega = robot.actuator.v_limit, robot.actuator.omega_limit
    result: FloatArray = np.clip(asked, (-v, -v, -omega), (v, v, omega))
    if isinstance(robot.vehicle, Ackermann):
        ahead, bend = asked[..., 0], math.tan(robot.vehicle.steering_limit) / robot.vehicle.wheelbase
        with np.errstate(over="ignore"):  # of a car nearly at rest
            curvature = np.divide(asked[..., 2], ahead, out=np.zeros_like(ahead), where=ahead != 0.0)
        curvature = np.clip(curvature, -bend, bend)
        slower = np.minimum(v, omega / np.maximum(np.abs(curvature), omega / v))
        result[..., 0] = np.clip(ahead, -slower, slower)
        result[..., 2] = curvature * result[..., 0]
    return result
