"""Turning points of consequents under hedges of the system, for adaptive integrals.

A membership function is monotone between the places of its kind, and built-in hedges and weights keep it so. A hedge of
one's own may turn, touch 0 or jump at any degree. These degrees are isolated by interval arithmetic, once for each
hedge, and then located in the range of the output.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import Call, Expr, walk
from fuzzyctl.formulas.sigmoid_extrema import bisected
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.records import record

#: Intervals of degrees are halved so often: turning points are isolated to 2^-54.
_HALVINGS: Final = 54
#: From this halving on, longer runs of neighbouring undecided intervals are given up, and all beyond a number.
_PATIENCE: Final = 10
_LONGEST_RUN: Final = 16
_MOST_UNDECIDED: Final = 2048
#: What is given up is still known well enough where it is so narrow, or where degrees differ by so little.
_NARROW: Final = 1e-12
_LEVEL: Final = 1e-13
#: Largest number of turning points of a hedge, and of locations of a term.
MOST_DEGREES: Final = 200
MOST_PLACES: Final = 500
#: Most operands and operators of a hedge that are enclosed over intervals of degrees; it is given up beyond.
_MOST_ENCLOSED: Final = 500_000
#: Units of `analysis.work`, that is microseconds: for a hedge, for an operand or operator enclosed, and for a place.
_UNITS_OF_HEDGE: Final = 10_000.0
_UNITS_OF_ENCLOSED: Final = 2.5
_UNITS_OF_PLACE: Final = 300.0
#: Terms and hedges for which results are kept, such as those of a kernel that is compiled in several variants.
_KEPT: Final = 1000


@record(frozen=True)
class _Part:
    """An interval of degrees: the sign of the slope of a hedge, NaN where it is undecided, and what its values are."""

    start: float
    end: float
    sign: float
    least: float
    most: float


@record(frozen=True)
class MonotoneParts:
    """The degrees between which a hedge is monotone.

    Args:
        degrees: Rising.
        complete: Whether these are all; if not, the ends of the intervals in which nothing is known are among them.
        enclosed: How many operands and operators were enclosed.
    """

    degrees: tuple[float, ...]
    complete: bool
    enclosed: int = 0


@lru_cache(maxsize=_KEPT)
def turning_points(term: SetPlan, lower: float, upper: float) -> tuple[float, ...]:
    """Return places between which a term with own hedges is monotone, and one halfway up each of these sides.

    The place halfway lies near the steep part of a side, however narrow that is.

    Returns:
        Rising places, those of the kind included; nothing for a term that turns at these only.
    """
    places = [lower, *(x for x in term.pieces if lower < x < upper), upper]
    known = len(places)
    for k, change in enumerate(term.changes):
        degrees = monotone_parts(change).degrees if is_own(change) else ()
        if degrees and len(places) <= MOST_PLACES:
            places = _with_levels(replace(term, changes=term.changes[:k]), places, degrees)[: MOST_PLACES + 1]
    return _with_halves(term, places) if len(places) > known else ()


def is_resolved(term: SetPlan, lower: float, upper: float) -> bool:
    """Return whether a term is monotone between its `turning_points`."""
    own = [monotone_parts(change) for change in own_changes(term)]
    return all(o.complete for o in own) and len(turning_points(term, lower, upper)) <= 2 * MOST_PLACES


def own_changes(term: SetPlan) -> list[Expr]:
    """Return what own hedges make of the degree of a term."""
    return [change for change in term.changes if is_own(change)]


def units_of_hedge(change: Expr) -> float:
    """Return the work of isolating the degrees at which an own hedge turns; they are isolated for that."""
    return _UNITS_OF_HEDGE + _UNITS_OF_ENCLOSED * monotone_parts(change).enclosed


def units_of_places(term: SetPlan, lower: float, upper: float) -> float:
    """Return the work of locating the turning points of a term; they are located for that."""
    return _UNITS_OF_PLACE * len(turning_points(term, lower, upper))


def is_own(change: Expr) -> bool:
    """Return whether a change of degrees is an own hedge."""
    return isinstance(change, Call) and change.function == "held"


def _with_levels(term: SetPlan, places: Sequence[float], degrees: Sequence[float]) -> list[float]:
    """Return places between which a term is monotone, and between them those where it has one of some degrees."""
    degree = scalar_function(term.degree_of_x)
    found = set(places)
    for a, b, low, high in _sides(degree, places):
        found |= {_reached(degree, a, b, d) for d in degrees if min(low, high) < d < max(low, high)}
        if len(found) > MOST_PLACES:
            break
    return sorted(found)


def _with_halves(term: SetPlan, places: Sequence[float]) -> tuple[float, ...]:
    degree = scalar_function(term.degree_of_x)
    halves = [_reached(degree, a, b, 0.5 * low + 0.5 * high) for a, b, low, high in _sides(degree, places)]
    return tuple(sorted({*places, *halves}))


def _sides(degree: Callable[[float], float], places: Sequence[float]) -> Iterator[tuple[float, float, float, float]]:
    """Yield the first and the last float inside each stretch that is not level, and the degrees there.

    At a place itself the degree may jump.
    """
    for start, end in pairwise(places):
        a, b = math.nextafter(start, math.inf), math.nextafter(end, -math.inf)
        if a < b and degree(a) != degree(b):
            yield a, b, degree(a), degree(b)


def _reached(degree: Callable[[float], float], a: float, b: float, level: float) -> float:
    """Return where a monotone side has a degree."""
    rises = degree(a) < degree(b)
    return bisected(lambda x: degree(x) >= level if rises else degree(x) <= level, a, b)


@lru_cache(maxsize=_KEPT)
def monotone_parts(change: Expr) -> MonotoneParts:
    """Isolate the degrees from 0 to 1 at which an own hedge turns or jumps, by halving intervals of degrees."""
    decided: list[_Part] = []
    halves = [(0.0, 1.0)]
    complete = True
    size, enclosed = sum(1 for _ in walk(change)), 0
    for halving in range(_HALVINGS + 1):
        enclosed += size * len(halves)
        if enclosed > _MOST_ENCLOSED:
            complete = False
            break
        parts = _parts(change, halves)
        decided += [p for p in parts if p.sign == p.sign]
        undecided = [p for p in parts if p.sign != p.sign]
        if halving >= _PATIENCE:
            runs = _runs(undecided)
            most = _LONGEST_RUN if len(undecided) <= _MOST_UNDECIDED else 0
            complete = complete and all(_is_known(run) for run in runs if len(run) > most)
            undecided = [part for run in runs if len(run) <= most for part in run]
        middles = [(p.start, 0.5 * p.start + 0.5 * p.end, p.end) for p in undecided]
        halves = [half for a, b, c in middles for half in ((a, b), (b, c))]
    degrees = _turns(sorted(decided, key=lambda p: p.start))
    return MonotoneParts(degrees[:MOST_DEGREES], complete and len(degrees) <= MOST_DEGREES, enclosed)


def _parts(change: Expr, intervals: Sequence[tuple[float, float]]) -> list[_Part]:
    """Enclose values and slopes of a hedge over intervals of degrees."""
    if not intervals:
        return []
    import numpy as np

    from fuzzyctl.kernels.interval.program import Interpreter
    from fuzzyctl.kernels.interval.vector import boxes

    low, high = np.array(intervals).T
    with np.errstate(all="ignore"):
        found = Interpreter({ITSELF: boxes(low[None], high[None])[0]}).enclose(change)
    falls, rises = (np.zeros(1), np.zeros(1)) if found.slopes is None else (s[0] for s in found.slopes)
    sign = np.where(falls >= 0.0, np.where(rises > 0.0, 1.0, 0.0), np.where(rises <= 0.0, -1.0, np.nan))
    columns = [np.broadcast_to(a, low.shape).tolist() for a in (low, high, sign, found.lo, found.hi)]
    return [_Part(*row) for row in zip(*columns, strict=True)]


def _runs(parts: Sequence[_Part]) -> list[list[_Part]]:
    """Return intervals in runs that follow each other without a gap."""
    found: list[list[_Part]] = []
    for part in parts:
        if found and found[-1][-1].end == part.start:
            found[-1].append(part)
        else:
            found.append([part])
    return found


def _is_known(run: Sequence[_Part]) -> bool:
    """Return whether what is undecided is too little to matter."""
    is_narrow = run[-1].end - run[0].start <= _NARROW
    return is_narrow or max(p.most for p in run) - min(p.least for p in run) <= _LEVEL


def _turns(parts: Sequence[_Part]) -> tuple[float, ...]:
    """Return where the sign of the slope changes, and where what lies undecided between known parts begins and ends."""
    found: list[float] = []
    last, sign = 0.0, math.nan
    for part in [*parts, _Part(1.0, 1.0, math.nan, 0.0, 0.0)]:
        if part.start - last > _NARROW:
            found += [last, part.start]
        elif part.start > last or part.sign != sign:
            found.append(0.5 * last + 0.5 * part.start)
        last, sign = part.end, part.sign
    return tuple(dict.fromkeys(d for d in found if 0.0 < d < 1.0))
