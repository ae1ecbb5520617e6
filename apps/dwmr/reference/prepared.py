"""References prepared for the loop: the name of a curve and its flat constants."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import islice
from typing import NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.reference import Reference
from dwmr.reference import curves, splines
from dwmr.reference.path_files import PathRows
from dwmr.reference.settings import Circle, CsvPath, Eight, Line, Waypoints
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import Places

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
        path: Name of a function of `curves`.
        constants: What it reads, shape (c,).
        end: Time from which an open path goes on straight; infinite where it never ends [s].
        period: Time after which it repeats, 0 where it does not [s].
    """

    path: str
    constants: FloatArray
    end: float = math.inf
    period: float = 0.0

    def at(self, t: float) -> Reference:
        """Return posture and velocity at a time [s]."""
        function: Callable[[float, FloatArray], Reference] = getattr(curves, self.path)
        with np.errstate(all="ignore"):  # as compiled: what overflows is infinite, and the run stops there
            return function(t, self.constants)


def shape_of(settings: Settings, rows: Callable[[str], PathRows], places: Places) -> Shape:
    """Make a reference ready.

    Args:
        settings: The scenario's reference.
        rows: Reads a file of the scenario's own.
        places: Where the scenario's keys stand.

    Raises:
        DiagnosticError: When it stands still somewhere, or its file is malformed.
    """
    match settings:
        case Eight():
            return _eight(settings, places)
        case Circle():
            rate = 2.0 * math.pi / settings.period * (1.0 if settings.direction == "counter-clockwise" else -1.0)
            _require_motion(settings.radius * abs(rate), 0.0, "reference.period", places)
            constants = [settings.centre_x, settings.centre_y, settings.radius, settings.start_angle, rate]
            return Shape("circle", np.array(constants), period=settings.period)
        case Line():
            _require_motion(settings.speed, 0.0, "reference.speed", places)
            return Shape("line", np.array([settings.start_x, settings.start_y, settings.angle, settings.speed]))
        case Waypoints():
            return _waypoints(settings, places)
    return _csv(settings, rows(settings.file), places)


def _eight(settings: Eight, places: Places) -> Shape:
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
    _require_motion(speed, when, "reference.period", places)
    return shape


def _waypoints(settings: Waypoints, places: Places) -> Shape:
    points = np.array(settings.points)
    closed = settings.closed
    if closed and not np.array_equal(points[0], points[-1]):
        points = np.vstack([points, points[:1]])
    if closed and len(points) < 4:
        message = "reference.points: a closed path needs at least 3 places"
        raise DiagnosticError([places.diagnostic("FZ904", "reference.points", message)])
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if mistakes := list(islice(_twice(gaps, len(settings.points), places), MOST_TWICE)):
        raise DiagnosticError(mistakes)
    u = np.concatenate([[0.0], np.cumsum(gaps)])
    coefficients = splines.cubic(u, points, closed)
    slow, where = splines.slowest(u, coefficients)
    if slow < CUSP:
        k = int(np.argmin(np.abs(u - where))) % len(settings.points)
        message = (
            f"reference.points.{k}: the path turns back on the spot near place {k}, where its direction is undefined"
        )
        help_text = "lead it around the corner with one more place"
        raise DiagnosticError([places.diagnostic("FZ904", "reference.points", message, help=help_text)])
    s, by_length = splines.by_length(u, coefficients, closed)
    tempo = settings.speed if settings.speed is not None else float(s[-1]) / (settings.duration or math.inf)
    key = "reference.speed" if settings.speed is not None else "reference.duration"
    _require_motion(tempo, 0.0, key, places)
    return _spline(s / tempo, by_length * tempo ** np.arange(4), closed)


def _twice(gaps: FloatArray, count: int, places: Places) -> Iterable[Diagnostic]:
    """Refuse places that are the same as the ones before them."""
    for k in np.flatnonzero(gaps < SAME):
        after = (int(k) + 1) % count
        message = f"reference.points.{after} is the same place as reference.points.{int(k)}"
        yield places.diagnostic("FZ904", "reference.points", message, facts=("a reference must not stand still",))


def _csv(settings: CsvPath, rows: PathRows, places: Places) -> Shape:
    coefficients = splines.cubic(rows.t, rows.points, settings.closed)
    if settings.closed and np.linalg.norm(rows.points[-1] - rows.points[0]) > SAME:
        first, last = (f"({x:g}, {y:g})" for x, y in (rows.points[0], rows.points[-1]))
        message = f"reference.closed = true, but {settings.file} begins at {first} and ends at {last}"
        raise DiagnosticError([places.diagnostic("FZ904", "reference.closed", message)])
    slow, when = splines.slowest(rows.t, coefficients)
    if slow < SLOWEST:
        raise DiagnosticError([rows.standstill(when, slow, SLOWEST)])
    return _spline(rows.t, coefficients, settings.closed)


def _spline(t: FloatArray, coefficients: FloatArray, closed: bool) -> Shape:
    """Lay the pieces out as `curves.spline` reads them."""
    period = float(t[-1] - t[0]) if closed else 0.0
    constants = np.concatenate([[len(t) - 1, period], t, coefficients.reshape(-1)])
    return Shape("spline", constants, end=math.inf if closed else float(t[-1]), period=period)


def _require_motion(speed: float, when: float, key: str, places: Places) -> None:
    if not speed < SLOWEST:
        return
    message = f"the reference stands still: its speed is {speed:.3g} m/s at t = {when:.6g} s"
    facts = (f"below {SLOWEST:g} m/s its direction is undefined, and with it the auxiliary angular velocity",)
    raise DiagnosticError([places.diagnostic("FZ904", key, message, facts=facts)])
