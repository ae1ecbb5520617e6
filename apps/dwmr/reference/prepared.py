"""Reference trajectories: their settings, curves, and constants for the loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import islice
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict, model_validator

from dwmr.config.quantities import FARTHEST, Section, place, quantity
from dwmr.core.arrays import FloatArray, Reference
from dwmr.reference import splines
from dwmr.reference.path_files import PathRows
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import Places


def eight(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a figure eight at a time.

    Args:
        t: Time [s].
        shape: Half the width along x and along y [m]; period [s]; how often each of the two is travelled per period.

    Returns:
        The virtual robot's posture and velocities; its orientation is the direction of travel.

    Source:
        Goto, Bertol, Martins, Eq. (76) with x and y exchanged: only so do the obstacles of Table 11 lie on the path in
        the middle of the disturbance windows, as section 7.2 says; third row with the numerator's second derivatives
        restored.
    """
    w, a_x, a_y = 2.0 * math.pi / shape[2], shape[0], shape[1]
    w_x, w_y = shape[3] * w, shape[4] * w
    x_dot = w_x * a_x * math.cos(w_x * t)
    y_dot = w_y * a_y * math.cos(w_y * t)
    x = a_x * math.sin(w_x * t)
    y = a_y * math.sin(w_y * t)
    omega = (w_x * w_x * x * y_dot - w_y * w_y * y * x_dot) / (x_dot * x_dot + y_dot * y_dot)
    return Reference(x, y, math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot), omega)


def circle(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a circle at a time.

    Args:
        t: Time [s].
        shape: Centre x, y and radius [m]; angle of the place at t = 0 [rad]; angular velocity, positive
            counter-clockwise [rad/s].
    """
    angle = shape[3] + shape[4] * t
    c, s = math.cos(angle), math.sin(angle)
    turn = 1.0 if shape[4] > 0.0 else -1.0
    theta = math.atan2(turn * c, -turn * s)
    return Reference(shape[0] + shape[2] * c, shape[1] + shape[2] * s, theta, shape[2] * abs(shape[4]), shape[4])


def line(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a straight line at a time.

    Args:
        t: Time [s].
        shape: Place x, y at t = 0 [m]; direction [rad]; velocity [m/s].
    """
    way = shape[3] * t
    theta = math.atan2(math.sin(shape[2]), math.cos(shape[2]))
    return Reference(shape[0] + way * math.cos(theta), shape[1] + way * math.sin(theta), theta, shape[3], 0.0)


def spline(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a piecewise cubic path at a time.

    Before its first knot and behind its last one an open path goes on straight, at the velocity it has there: a
    reference must not rest.

    Args:
        t: Time [s].
        shape: Number n of pieces; period [s], 0 for an open path; n + 1 knots [s]; and for each piece the coefficients
            of x and then of y, lowest power of the time since the piece's first knot first [m, m/s, m/s², m/s³].
    """
    n, period, first = int(shape[0]), shape[1], shape[2]
    if period > 0.0:
        t -= period * math.floor((t - first) / period)
    inside = min(max(t, first), shape[2 + n])
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if shape[2 + middle] <= inside:
            low = middle
        else:
            high = middle
    c, tau = 3 + n + 8 * low, inside - shape[2 + low]
    x_dot = shape[c + 1] + tau * (2.0 * shape[c + 2] + tau * 3.0 * shape[c + 3])
    y_dot = shape[c + 5] + tau * (2.0 * shape[c + 6] + tau * 3.0 * shape[c + 7])
    x = shape[c] + tau * (shape[c + 1] + tau * (shape[c + 2] + tau * shape[c + 3]))
    y = shape[c + 4] + tau * (shape[c + 5] + tau * (shape[c + 6] + tau * shape[c + 7]))
    beyond, omega = t - inside, 0.0
    if beyond == 0.0:
        x_ddot = 2.0 * shape[c + 2] + 6.0 * tau * shape[c + 3]
        y_ddot = 2.0 * shape[c + 6] + 6.0 * tau * shape[c + 7]
        omega = (y_ddot * x_dot - x_ddot * y_dot) / max(x_dot * x_dot + y_dot * y_dot, 1e-300)
    return Reference(x + beyond * x_dot, y + beyond * y_dot, math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot), omega)


#: A place in the plane, x and y [m].
Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Point = Annotated[tuple[Coordinate, Coordinate], Strict(False)]


class Eight(Section):
    """Figure eight, Eq. (76)."""

    kind: Literal["eight"]
    amplitude_x: float = quantity("half the extent along x", "m", gt=0, le=FARTHEST)
    amplitude_y: float = quantity("half the extent along y", "m", gt=0, le=FARTHEST)
    period: float = quantity("time of one round", "s", ge=1e-3)
    along: Literal["x", "y"] = Field(
        default="y", description="axis along which the two loops lie; the other one is travelled twice per period"
    )


class Circle(Section):
    """Circle at constant speed."""

    kind: Literal["circle"]
    centre_x: float = place("centre, x")
    centre_y: float = place("centre, y")
    radius: float = quantity("radius", "m", gt=0, le=FARTHEST)
    period: float = quantity("time of one round", "s", ge=1e-3)
    direction: Literal["counter-clockwise", "clockwise"] = Field(description="sense of travel")
    start_angle: float = quantity("angle of the place at t = 0, seen from the centre", "rad", default=0.0)


class Line(Section):
    """Straight line at constant speed."""

    kind: Literal["line"]
    start_x: float = place("place at t = 0, x")
    start_y: float = place("place at t = 0, y")
    angle: float = quantity("direction, counter-clockwise from the x axis", "rad")
    speed: float = quantity("speed", "m/s", gt=0, le=1e6)


class Waypoints(Section):
    """Smooth path through places at nearly constant speed; an open one goes on straight behind its last place."""

    kind: Literal["waypoints"]
    points: Annotated[tuple[Point, ...], Strict(False)] = Field(
        description="places [x, y] in order", min_length=2, max_length=2000, json_schema_extra={"unit": "m"}
    )
    closed: bool = Field(default=False, description="whether the path leads back to its first place, again and again")
    speed: float | None = quantity("speed", "m/s", gt=0, le=1e6, default=None)
    duration: float | None = quantity("time of the whole way, or of one round", "s", ge=1e-3, default=None)

    @model_validator(mode="after")
    def _one_tempo(self) -> Waypoints:
        if (self.speed is None) == (self.duration is None):
            raise ValueError(f"give speed or duration{', not both' if self.speed is not None else ''}")
        return self


class CsvPath(Section):
    """Smooth path through the rows of a CSV file; an open one goes on straight behind its last row."""

    kind: Literal["csv"]
    file: str = Field(description="CSV file with the columns t [s], x [m], y [m], beside the scenario", min_length=1)
    closed: bool = Field(default=False, description="whether the last row is the first place again, and so on")


#: Curves by name; the loop compiles them, `Shape.at` calls them as Python.
CURVES: dict[str, Callable[[float, FloatArray], Reference]] = {
    "eight": eight, "circle": circle, "line": line, "spline": spline,
}  # fmt: skip

ReferenceSettings = Annotated[Eight | Circle | Line | Waypoints | CsvPath, Field(discriminator="kind")]


#: Below this a reference counts as standing still: its direction is then undefined [m/s].
SLOWEST = 1e-3
#: The spline through waypoints has a speed near 1 everywhere; where it is less than this it turns back on the spot.
CUSP = 0.02
#: Places nearer to each other than this are the same [m].
SAME = 1e-6
#: Places given twice that are reported; a list with more of them is another list.
MOST_TWICE = 10

Settings = Eight | Circle | Line | Waypoints | CsvPath


class Shape(NamedTuple):
    """A reference trajectory as the loop wants it.

    Attributes:
        path: Name of a function of `CURVES`.
        constants: Its arguments, shape (c,).
        end: Time from which an open path goes on straight; infinite where it never ends [s].
        period: Time after which it repeats, 0 where it does not [s].
    """

    path: str
    constants: FloatArray
    end: float = math.inf
    period: float = 0.0

    def at(self, t: float) -> Reference:
        """Return posture and velocity at a time [s]."""
        return self.along([t])[0]

    def along(self, times: Iterable[float]) -> list[Reference]:
        """Return postures and velocities at times [s]."""
        with np.errstate(all="ignore"):  # as compiled: an overflow is infinite, and the run stops there
            return [CURVES[self.path](t, self.constants) for t in times]


def shape_of(
    settings: Settings, rows: Callable[[str, str], PathRows], places: Places, table: str = "reference"
) -> Shape:
    """Make a reference ready.

    Args:
        settings: A reference of the scenario.
        rows: Reads the file that a key names.
        places: Locations of the scenario's keys.
        table: Key of the reference.

    Raises:
        DiagnosticError: When it rests somewhere, or its file is malformed.
    """
    match settings:
        case Eight():
            return _eight(settings, places, table)
        case Circle():
            rate = 2.0 * math.pi / settings.period * (1.0 if settings.direction == "counter-clockwise" else -1.0)
            _require_motion(settings.radius * abs(rate), 0.0, f"{table}.period", places)
            constants = [settings.centre_x, settings.centre_y, settings.radius, settings.start_angle, rate]
            return Shape("circle", np.array(constants), period=settings.period)
        case Line():
            _require_motion(settings.speed, 0.0, f"{table}.speed", places)
            return Shape("line", np.array([settings.start_x, settings.start_y, settings.angle, settings.speed]))
        case Waypoints():
            return _waypoints(settings, places, table)
    return _csv(settings, rows(f"{table}.file", settings.file), places, table)


def _eight(settings: Eight, places: Places, table: str) -> Shape:
    turns = (2.0, 1.0) if settings.along == "y" else (1.0, 2.0)
    shape = Shape(
        "eight", np.array([settings.amplitude_x, settings.amplitude_y, settings.period, *turns]), period=settings.period
    )
    twice, once = settings.amplitude_x, settings.amplitude_y
    if settings.along == "x":
        twice, once = once, twice
    w = 2.0 * math.pi / settings.period
    # with z = cos² of the slower angle, the square of the speed is a parabola w² (4 twice² (2 z − 1)² + once² z)
    z = max(0.0, 0.5 - (once / twice) ** 2 / 32.0) if once < 4.0 * twice else 0.0
    speed = w * math.hypot(2.0 * twice * (2.0 * z - 1.0), once * math.sqrt(z))
    when = math.acos(math.sqrt(z)) / w if w > 0.0 else 0.0
    _require_motion(speed, when, f"{table}.period", places)
    return shape


def _waypoints(settings: Waypoints, places: Places, table: str) -> Shape:
    points = np.array(settings.points)
    closed = settings.closed
    if closed and not np.array_equal(points[0], points[-1]):
        points = np.vstack([points, points[:1]])
    if closed and len(points) < 4:
        message = f"{table}.points: a closed path needs at least 3 places"
        raise DiagnosticError([places.diagnostic("FZ904", f"{table}.points", message)])
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if mistakes := list(islice(_twice(gaps, len(settings.points), places, f"{table}.points"), MOST_TWICE)):
        raise DiagnosticError(mistakes)
    u = np.concatenate([[0.0], np.cumsum(gaps)])
    coefficients = splines.cubic(u, points, closed)
    slow, where = splines.slowest(u, coefficients)
    if slow < CUSP:
        k = int(np.argmin(np.abs(u - where))) % len(settings.points)
        message = (
            f"{table}.points.{k}: the path turns back on the spot near place {k}, where its direction is undefined"
        )
        help_text = "lead it around the corner with one more place"
        raise DiagnosticError([places.diagnostic("FZ904", f"{table}.points", message, help=help_text)])
    s, by_length = splines.by_length(u, coefficients, closed)
    tempo = settings.speed if settings.speed is not None else float(s[-1]) / (settings.duration or math.inf)
    _require_motion(tempo, 0.0, f"{table}.{'speed' if settings.speed is not None else 'duration'}", places)
    return _spline(s / tempo, by_length * tempo ** np.arange(4), closed)


def _twice(gaps: FloatArray, count: int, places: Places, key: str) -> Iterable[Diagnostic]:
    """Refuse places that are the same as the ones before them."""
    for k in np.flatnonzero(gaps < SAME):
        after = (int(k) + 1) % count
        message = f"{key}.{after} is the same place as {key}.{int(k)}"
        yield places.diagnostic("FZ904", key, message, facts=("a reference must not rest",))


def _csv(settings: CsvPath, rows: PathRows, places: Places, table: str) -> Shape:
    coefficients = splines.cubic(rows.t, rows.points, settings.closed)
    if settings.closed and np.linalg.norm(rows.points[-1] - rows.points[0]) > SAME:
        first, last = (f"({x:g}, {y:g})" for x, y in (rows.points[0], rows.points[-1]))
        message = f"{table}.closed = true, but {settings.file} begins at {first} and ends at {last}"
        raise DiagnosticError([places.diagnostic("FZ904", f"{table}.closed", message)])
    slow, when = splines.slowest(rows.t, coefficients)
    if slow < SLOWEST:
        raise DiagnosticError([rows.standstill(when, slow, SLOWEST)])
    return _spline(rows.t, coefficients, settings.closed)


def _spline(t: FloatArray, coefficients: FloatArray, closed: bool) -> Shape:
    """Lay the pieces out as `spline` reads them."""
    period = float(t[-1] - t[0]) if closed else 0.0
    constants = np.concatenate([[len(t) - 1, period], t, coefficients.reshape(-1)])
    return Shape("spline", constants, end=math.inf if closed else float(t[-1]), period=period)


def _require_motion(speed: float, when: float, key: str, places: Places) -> None:
    if not speed < SLOWEST:
        return
    message = f"the reference stands still: its speed is {speed:.3g} m/s at t = {when:.6g} s"
    facts = (f"below {SLOWEST:g} m/s its direction is undefined, and with it the auxiliary angular velocity",)
    raise DiagnosticError([places.diagnostic("FZ904", key, message, facts=facts)])
