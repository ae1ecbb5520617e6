"""Centroid and bisector of curved sets by adaptive integrals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Name, Number, Where, minus, names_in, plus, times, walk
from fuzzyctl.formulas import AGGREGATIONS, IMPLICATIONS, MEMBERSHIP, alpha_cut
from fuzzyctl.formulas.sigmoids import bisected
from fuzzyctl.kernels.inference.defuzzify.centroid import Height, in_units, unit_of
from fuzzyctl.kernels.inference.defuzzify.maxima import has_cuts
from fuzzyctl.kernels.inference.defuzzify.sampling import aggregated, implied_degrees
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan, degree_of
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.quadrature import NODES
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.kernels.program.traversal import parts as parts_of
from fuzzyctl.kernels.program.traversal import writes
from fuzzyctl.records import record

#: Intervals of degrees are halved so often: turning points are isolated to 2^-54.
_HALVINGS: Final = 54
#: From this halving on, longer runs of neighbouring undecided intervals are given up, and all beyond a number.
_PATIENCE: Final = 10
_LONGEST_RUN: Final = 16
_MOST_UNDECIDED: Final = 2048
#: An undecided part is still known well enough if it is so narrow, or if degrees differ by so little.
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
    """An interval of degrees: the sign of the slope of a hedge, NaN if it is undecided, and the range of its values."""

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
        complete: Whether these are all; if not, the ends of the unknown intervals are among them.
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
    count = len(places)
    for k, change in enumerate(term.changes):
        degrees = monotone_parts(change).degrees if is_own(change) else ()
        if degrees and len(places) <= MOST_PLACES:
            places = _with_levels(replace(term, changes=term.changes[:k]), places, degrees)[: MOST_PLACES + 1]
    return _with_halves(term, places) if len(places) > count else ()


def is_resolved(term: SetPlan, lower: float, upper: float) -> bool:
    """Return whether a term is monotone between its `turning_points`."""
    changes = [monotone_parts(change) for change in own_changes(term)]
    return all(o.complete for o in changes) and len(turning_points(term, lower, upper)) <= 2 * MOST_PLACES


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
    levels = set(places)
    for a, b, low, high in _sides(degree, places):
        levels |= {_reached(degree, a, b, d) for d in degrees if min(low, high) < d < max(low, high)}
        if len(levels) > MOST_PLACES:
            break
    return sorted(levels)


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
        enclosure = Interpreter({ITSELF: boxes(low[None], high[None])[0]}).enclose(change)
    falls, rises = (np.zeros(1), np.zeros(1)) if enclosure.slopes is None else (s[0] for s in enclosure.slopes)
    sign = np.where(falls >= 0.0, np.where(rises > 0.0, 1.0, 0.0), np.where(rises <= 0.0, -1.0, np.nan))
    columns = [np.broadcast_to(a, low.shape).tolist() for a in (low, high, sign, enclosure.lo, enclosure.hi)]
    return [_Part(*row) for row in zip(*columns, strict=True)]


def _runs(parts: Sequence[_Part]) -> list[list[_Part]]:
    """Return intervals in runs that follow each other without a gap."""
    runs: list[list[_Part]] = []
    for part in parts:
        if runs and runs[-1][-1].end == part.start:
            runs[-1].append(part)
        else:
            runs.append([part])
    return runs


def _is_known(run: Sequence[_Part]) -> bool:
    """Return whether the undecided part is too small to matter."""
    is_narrow = run[-1].end - run[0].start <= _NARROW
    return is_narrow or max(p.most for p in run) - min(p.least for p in run) <= _LEVEL


def _turns(parts: Sequence[_Part]) -> tuple[float, ...]:
    """Return where the sign of the slope changes, and the ends of undecided parts between known ones."""
    turns: list[float] = []
    last, sign = 0.0, math.nan
    for part in [*parts, _Part(1.0, 1.0, math.nan, 0.0, 0.0)]:
        if part.start - last > _NARROW:
            turns += [last, part.start]
        elif part.start > last or part.sign != sign:
            turns.append(0.5 * last + 0.5 * part.start)
        last, sign = part.end, part.sign
    return tuple(dict.fromkeys(d for d in turns if 0.0 < d < 1.0))


#: Where the slopes of curved terms change much, in multiples of their widths: bell-shaped ones that vanish fast, those
#: that vanish as an exponential does, and those that vanish as a power does.
_MULTIPLES: Final = {
    "normal": (1.5, 4.0, 10.0, 20.0, 39.0),
    "exponential": (2.0, 8.0, 30.0, 100.0, 300.0, 750.0),
    "power": tuple(0.5 * 3.0**k for k in range(40)),
}
#: Where a set vanishes, or is 1, the values on both sides of a jump near that place tell too little from each other for
#: the integral to see it. Such places get neighbours at these parts of the range.
_BESIDE: Final = (1e-8, 1e-6, 1e-4, 1e-2)
#: Places nearer to another one than this part of their distance from the middle of their term are left out.
_NEAR: Final = 0.3


def adaptive(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the integrals of an aggregated set.

    Returns:
        For a centroid the moment about the middle of the range, for a bisector its place counted from there; and the
        area. All are in the unit of the output (`unit_of`).
    """
    if not heights:
        return ZERO, ZERO
    middle = 0.5 * output.lower + 0.5 * output.upper
    inner, x = builder.inner(), builder.fresh()
    unit = unit_of(output)
    place = inner.let(plus(times(Name(x), Number(unit)), Number(middle)))
    parts = [(h, inner.let(degree_of(inner, output.terms[t], place)), output.terms[t]) for t, h, _ in heights]
    implied = implied_degrees(output, inner, parts)
    value = inner.let(aggregated(output, inner, implied))
    body = tuple(inner.statements)
    locals_ = {x}.union(*map(writes, body))
    named = [n.name for e in (*(e for s in body for e in parts_of(s).values), value) for n in names_in(e)]
    arguments = tuple(dict.fromkeys(n for n in named if n not in locals_))
    table = builder.table((p - middle) / unit for p in places_of(output, [output.terms[t] for t, _, _ in heights]))
    result, area = builder.fresh(), builder.fresh()
    kind = "half" if output.kind == "bisector" else "moments"
    marks: list[Expr] = []
    for t, h, _ in heights:
        ends = [e for e in _ends(builder, output, output.terms[t], h) if not isinstance(e, Number)]
        marks += dict.fromkeys(builder.let(in_units(e, unit)) for e in ends)
    builder.statements.append(Quadrature(result, area, kind, x, body, value, arguments, table, tuple(marks)))
    return Name(result), Name(area)


def _ends(builder: Builder, output: OutputPlan, term: SetPlan, activation: Expr) -> list[Expr]:
    """Return where an implied set bends or jumps: where its term reaches the activation, or for some norms the rest.

    Terms whose places have no closed form have none; there stretches are halved until they are short.
    """
    bends = IMPLICATIONS[output.implication_of(term)].bends
    if bends is None or not has_cuts(term):
        return []
    level = activation if bends == "equal" else builder.let(minus(ONE, activation))
    share = builder.let(term.share(level))
    inside = Logic("and", (Compare(">", share, ZERO), Compare("<=", share, ONE)))
    cut = alpha_cut(term.kind, builder.let(Where(inside, share, ONE)), term.parameters)
    assert cut is not None
    middle = 0.5 * output.lower + 0.5 * output.upper
    ends = [builder.let(clip(builder.let(e), output.lower, output.upper)) for e in cut]
    # Without a value, as of inputs that have none, nothing could be sorted.
    atoms = [builder.let(Where(Compare("==", e, e), e, Number(output.lower))) for e in ends]
    return [e if isinstance(e, Number) else builder.let(minus(e, Number(middle))) for e in atoms]


def places_of(output: OutputPlan, terms: Sequence[SetPlan]) -> list[float]:
    """Return places between which terms are smooth, from end to end of the range."""
    lower, upper = output.lower, output.upper
    places = {lower, upper} | {x for t in terms for x in t.pieces if lower < x < upper}
    places |= {x for t in terms for x in turning_points(t, lower, upper)}
    for term in terms:
        for center, width, multiples in _scales(term):
            for multiple in multiples:
                for x in (center - multiple * width, center + multiple * width):
                    if lower < x < upper and all(abs(x - p) > _NEAR * multiple * width for p in places):
                        places.add(x)
    places |= {x for t in terms for x in _beside_jumps(output, t) if lower < x < upper}
    return sorted(places)


def _beside_jumps(output: OutputPlan, term: SetPlan) -> Iterator[float]:
    """Yield places beside those of a term whose implied set jumps where no closed form says."""
    lower, upper = output.lower, output.upper
    norms = IMPLICATIONS[output.implication_of(term)], AGGREGATIONS[output.aggregation]
    if has_cuts(term) or not any(norm.jumps and norm.bends for norm in norms):
        return
    for place in (lower, upper, *term.pieces, *turning_points(term, lower, upper)):
        for part in _BESIDE:
            yield from (place - part * (upper - lower), place + part * (upper - lower))


def _scales(term: SetPlan) -> Iterator[tuple[float, float, tuple[float, ...]]]:
    """Yield around which places a curved term changes, over which width, and the multiples of it to look at."""
    kind = term.kind.split()[0]
    for center, width, decay in MEMBERSHIP[kind].scales(term.parameters) if kind in MEMBERSHIP else ():
        yield center, width, _MULTIPLES[decay]


def nodes_of(output: OutputPlan, term: SetPlan) -> list[float]:
    """Return where the adaptive integral of a set of one term looks at it first.

    Other terms only cut the stretches shorter, so that its core is looked at more closely.
    """
    nodes: list[float] = []
    for a, b in pairwise(places_of(output, [term])):
        center, half = 0.5 * a + 0.5 * b, 0.5 * (b - a)
        nodes += [center, *(center + side * half * node for node in NODES for side in (-1.0, 1.0))]
    return nodes
