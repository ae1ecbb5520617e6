"""Band of a MacVicar-Whelan table: the window of rules that act, found by index arithmetic.

Let two inputs have partitions of triangles and a full table whose consequents are numbered i + j, held at both ends of
the output's terms (P. J. MacVicar-Whelan, *Fuzzy sets for man-machine interaction*, International Journal of
Man-Machine Studies 8, 1976). Wherever the inputs are, four rules act, and their consequents are three neighbours. So
the exact centroid under `min` and `max` needs four pieces of the output's range, whatever the number of rules and
terms, and their positions follow from index arithmetic, without look-up.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Name, Number, Where, minus, plus, times
from fuzzyctl.kernels.algorithms.grid import degree_at, is_continuous, knots_of, too_close
from fuzzyctl.kernels.inference.defuzzify.centroid import handover
from fuzzyctl.kernels.inference.defuzzify.defuzzify import closed_form, middle, support_hull
from fuzzyctl.kernels.inference.inference import raw_names
from fuzzyctl.kernels.plan.build import OutputPlan, Plan, SetPlan, degree_name
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, Program
from fuzzyctl.records import record

_HALF: Final = Number(0.5)
_SIXTH: Final = Number(1 / 6)
#: What differs by less, as a part of the range, differs by rounding only.
_SAME: Final = 8 * 2.0**-52


@record(frozen=True)
class Axis:
    """An input with a partition of triangles.

    Args:
        position: Its position.
        knots: The peaks of its terms, rising.
    """

    position: int
    knots: tuple[float, ...]

    @property
    def is_even(self) -> bool:
        """Whether the peaks stand in equal distances, but for rounding."""
        return _is_even(self.knots)


@record(frozen=True)
class Band:
    """An output whose table holds the term `signs[0]`·i + `signs[1]`·j + `offset`, held within those there are.

    Args:
        signs: 1 or -1 for each input.
        offset: What is added.
        last: Number of the last term that the table names; the first is 0.
        shift: How far the peak of term 1 lies from the middle of the range, in steps.
        step: Distance of neighbouring peaks.
        low, high: First and last piece of the range in which a term is not 0; piece k begins at the peak of term k.
        hull: What the centroid lies within.
        middle: Middle of the range.
    """

    signs: tuple[int, int]
    offset: int
    last: int
    shift: float
    step: float
    low: int
    high: int
    hull: tuple[float, float]
    middle: float


@record(frozen=True)
class Diagonals:
    """A system whose outputs are all such bands over the same two inputs."""

    axes: tuple[Axis, Axis]
    bands: tuple[Band, ...]


def diagonals_of(plan: Plan) -> Diagonals | str:
    """Return the bands of a system, or why it has none."""
    if plan.has_formulas or not all(map(_is_centroid, plan.outputs)):  # this alone rules most systems out
        return "not every output is an exact centroid under 'min' and 'max' of terms with straight sides"
    if len(plan.inputs) != 2:
        return "it has not two inputs"
    if not _is_plain(plan):
        return "rules do not act as they are, or terms of inputs have no straight sides"
    axes: list[Axis] = []
    for position, variable in enumerate(plan.inputs):
        axis = _axis(plan, position)
        if axis is None:
            return f"the terms of '{variable.name}' are no partition of triangles"
        axes.append(axis)
    both = (axes[0], axes[1])
    cells = _cells(plan, both)
    if cells is None:
        return "rules are no conjunctions of both inputs by 'min'"
    bands: list[Band] = []
    for output in plan.outputs:
        band = _band(output, both, cells)
        if band is None:
            return f"'{output.name}' has no full table along diagonals, or no even terms"
        bands.append(band)
    return Diagonals(both, tuple(bands))


def window(plan: Plan, own: Diagonals) -> Program:
    """Write the program that integrates over the pieces around the rules that act.

    Args:
        plan: The plan.
        own: Its bands.
    """
    builder, raw = Builder(), raw_names(plan)
    places = [_place(builder, raw[a.position], a) for a in own.axes]
    results = [Where(any_nan(raw), NAN, _centroid(builder, own.axes, band, places)) for band in own.bands]
    return builder.program(raw, results)


def _is_plain(plan: Plan) -> bool:
    """Whether rules act as they are, on continuous terms with straight sides."""
    return (
        not (plan.states or plan.held or plan.chains)
        and plan.all_act
        and plan.least in (None, 0.0)
        and all(rule.weight == 1.0 for rule in plan.rules)
        and all(is_continuous(d.set) for d in plan.degrees)
    )


def _is_centroid(output: OutputPlan) -> bool:
    terms = [output.terms[e.term] for e in output.implied]
    return (
        (output.kind, output.resolution, output.rule) == ("centroid", None, None)
        and (output.implication, output.aggregation) == ("min", "max")
        and not output.reads
        and closed_form(output, terms)
        and all(e.change is None and e.factor == 1.0 for e in output.implied)
    )


def _axis(plan: Plan, position: int) -> Axis | None:
    """Return an input if its terms are a partition: at each knot one of them is 1 and all others are 0."""
    sets = [d.set for d in plan.degrees if d.variable == position]
    knots = knots_of(plan.inputs[position], sets) if sets else ()
    if not 2 <= len(knots) == len(sets) or too_close(knots, sets):
        return None
    tops = {_top(s, knots) for s in sets}
    return Axis(position, knots) if None not in tops and len(tops) == len(sets) else None


def _top(term: SetPlan, knots: Sequence[float]) -> int | None:
    """Return the one knot where a term is 1, None where it is something between 0 and 1 at a knot."""
    degrees = [degree_at(term, x) for x in knots]
    tops = [k for k, d in enumerate(degrees) if abs(d - 1.0) <= _SAME]
    others = [d for k, d in enumerate(degrees) if k not in tops]
    return tops[0] if len(tops) == 1 and all(abs(d) <= _SAME for d in others) else None


def _cells(plan: Plan, axes: tuple[Axis, Axis]) -> list[tuple[int, int]] | None:
    """Return the cell of a table that each rule stands in, None where one is no minimum of two inputs."""
    place: dict[str, tuple[int, int]] = {}
    for k, degree in enumerate(plan.degrees):
        top = _top(degree.set, axes[degree.variable].knots)
        assert top is not None, "terms of an axis have a top"
        place[degree_name(k)] = (degree.variable, top)
    found: list[tuple[int, int]] = []
    for rule in plan.rules:
        match plan.strengths[rule.strength]:
            case Call(function="min", arguments=(Name(name=a), Name(name=b))) if a in place and b in place:
                (v, i), (w, j) = sorted((place[a], place[b]))
                if (v, w) != (0, 1):
                    return None
                found.append((i, j))
            case _:
                return None
    return found


def _band(output: OutputPlan, axes: tuple[Axis, Axis], cells: Sequence[tuple[int, int]]) -> Band | None:
    """Return an output as a band, None where its terms or its table are no such thing."""
    table = {cells[e.rule]: e.term for e in output.implied}
    whole = len(axes[0].knots) * len(axes[1].knots)
    used = sorted(set(table.values()), key=lambda t: output.terms[t].peak)
    if not len(table) == len(output.implied) == whole or len(used) < 3:
        return None
    peaks = tuple(output.terms[t].peak for t in used)
    pieces = _pieces(output, [output.terms[t] for t in used], peaks)
    numbers = {t: k for k, t in enumerate(used)}
    run = _run({cell: numbers[t] for cell, t in table.items()}, len(used) - 1)
    if pieces is None or run is None or not _is_even(peaks):
        return None
    signs, offset = run
    step = (peaks[-1] - peaks[0]) / (len(peaks) - 1)
    shift = 1.0 - 0.5 * (len(used) - 1) + (0.5 * peaks[0] + 0.5 * peaks[-1] - middle(output)) / step
    return Band(signs, offset, len(used) - 1, shift, step, *pieces, support_hull(output, used), middle(output))


def _is_even(knots: Sequence[float]) -> bool:
    step = (knots[-1] - knots[0]) / (len(knots) - 1)
    slack = _SAME * (knots[-1] - knots[0])
    # Far from 0 the sum would be rounded as the knots are, and look even where the differences are not.
    return all(abs((x - knots[0]) - k * step) <= slack for k, x in enumerate(knots))


def _pieces(output: OutputPlan, terms: Sequence[SetPlan], peaks: Sequence[float]) -> tuple[int, int] | None:
    """Return the first and the last piece where a term is not 0; None for terms that are no even triangles.

    Beside the outer peaks the range has a whole piece or none.
    """
    step = (peaks[-1] - peaks[0]) / (len(peaks) - 1)
    slack = _SAME * (peaks[-1] - peaks[0])
    ends: list[int] = []
    for end, peak, sign in ((output.lower, peaks[0], -1), (output.upper, peaks[-1], 1)):
        room = sign * (end - peak)
        if abs(room) > slack and room < step - slack:
            return None
        ends.append(0 if abs(room) <= slack else 1)
    low, high = -ends[0], len(peaks) - 2 + ends[1]
    grid = [peaks[0] + k * step for k in range(low, high + 2)]
    for k, term in enumerate(terms):
        corners = [x for x, _ in term.vertices if output.lower + slack < x < output.upper - slack]
        strays = any(min(abs(x - g) for g in grid) > slack for x in corners)
        if strays or any(abs(degree_at(term, g) - (n + low == k)) > 4 * _SAME for n, g in enumerate(grid)):
            return None
        # Beyond the feet of the outer ones the range may go on, where all of them are 0.
        beyond = [end for end, goes_on in zip((output.lower, output.upper), ends, strict=True) if goes_on]
        if any(degree_at(term, end) > 4 * _SAME for end in beyond):
            return None
    return low, high


def _run(table: dict[tuple[int, int], int], last: int) -> tuple[tuple[int, int], int] | None:
    """Return signs and offset of a table that numbers its consequents along diagonals."""
    (i, j), inner = next((c, t) for c, t in table.items() if 0 < t < last)
    for a, b in product((1, -1), repeat=2):
        offset = inner - a * i - b * j
        if all(t == min(max(a * k + b * m + offset, 0), last) for (k, m), t in table.items()):
            return (a, b), offset
    return None


def _place(builder: Builder, x: Expr, axis: Axis) -> tuple[Expr, Expr]:
    """Write between which knots an input lies, and how far beyond the first of them, from 0 to 1."""
    knots = axis.knots
    held = builder.let(clip(x, knots[0], knots[-1]))
    shares = [times(minus(held, Number(a)), Number(1.0 / (b - a))) for a, b in pairwise(knots)]
    beyond = [Compare(">=", held, Number(k)) for k in knots[1:-1]]
    number = builder.total(Where(c, ONE, ZERO) for c in beyond)
    if axis.is_even:
        whole = times(minus(held, Number(knots[0])), Number((len(knots) - 1) / (knots[-1] - knots[0])))
        return number, builder.let(minus(whole, number))
    share = builder.let(shares[0])
    for c, own in zip(beyond, shares[1:], strict=True):
        share = builder.let(Where(c, builder.let(own), share))
    return number, share


def _centroid(builder: Builder, axes: tuple[Axis, Axis], band: Band, places: Sequence[tuple[Expr, Expr]]) -> Expr:
    """Write the centroid of an output from where the inputs lie."""
    start, reach = _start(builder, axes, band, [number for number, _ in places])
    heights = _gathered(builder, band, start, _heights(builder, band, [share for _, share in places]), reach)
    if reach[0] < -2.0 or reach[1] > band.last:
        start = builder.let(clip(start, -2.0, float(band.last)))
    held = max(reach[0], -2.0), min(reach[1], float(band.last))
    area, moment = _moments(builder, band, start, heights, held)
    # Counted from the middle of the range, so that a system as symmetric as its table gives opposite numbers.
    steps = plus(plus(start, Number(band.shift)), moment / area)
    value = builder.let(plus(Number(band.middle), times(Number(band.step), steps)))
    return builder.let(clip(value, *band.hull))


def _start(
    builder: Builder, axes: tuple[Axis, Axis], band: Band, numbers: Sequence[Expr]
) -> tuple[Expr, tuple[float, float]]:
    """Write the number of the lowest consequent of the rules that act, before it is held; return what it lies between.

    Of a falling number the second of two neighbours is the lower one.
    """
    first = float(band.offset - sum(sign < 0 for sign in band.signs))
    start: Expr = Number(first)
    low = high = first
    for sign, number, axis in zip(band.signs, numbers, axes, strict=True):
        start = plus(start, number) if sign > 0 else minus(start, number)
        most = sign * (len(axis.knots) - 2)
        low, high = low + min(most, 0), high + max(most, 0)
    return builder.let(start), (low, high)


def _heights(builder: Builder, band: Band, shares: Sequence[Expr]) -> tuple[Expr, Expr, Expr]:
    """Write how far the three neighbours are activated, from the lowest to the highest."""
    rests = [builder.let(minus(ONE, share)) for share in shares]
    low = [rest if sign > 0 else share for sign, share, rest in zip(band.signs, shares, rests, strict=True)]
    high = [share if sign > 0 else rest for sign, share, rest in zip(band.signs, shares, rests, strict=True)]
    crossed = [builder.let(Call("min", pair)) for pair in ((low[0], high[1]), (high[0], low[1]))]
    a, c = (builder.let(Call("min", tuple(pair))) for pair in (low, high))
    return a, builder.let(Call("max", tuple(crossed))), c


def _gathered(
    builder: Builder, band: Band, start: Expr, heights: tuple[Expr, Expr, Expr], reach: tuple[float, float]
) -> tuple[Expr, Expr, Expr]:
    """Write the heights of three neighbours; consequents beyond the outer terms count for these."""
    a, b, c = heights
    last = float(band.last)

    def moved(bound: float, op: str, low: Expr, high: Expr) -> tuple[Expr, Expr]:
        """Give the height of one term to its neighbour: the result is (what is left, what the neighbour has)."""
        beyond = Compare("<=" if op == "<=" else ">=", start, Number(bound))
        both = builder.let(Call("max", (low, high)))
        return builder.let(Where(beyond, ZERO, low)), builder.let(Where(beyond, both, high))

    if reach[0] <= -1.0:
        a, b = moved(-1.0, "<=", a, b)
    if reach[0] <= -2.0:
        b, c = moved(-2.0, "<=", b, c)
    if reach[1] >= last - 1.0:
        c, b = moved(last - 1.0, ">=", c, b)
    if reach[1] >= last:
        b, a = moved(last, ">=", b, a)
    return a, b, c


def _moments(
    builder: Builder, band: Band, start: Expr, heights: tuple[Expr, Expr, Expr], reach: tuple[float, float]
) -> tuple[Expr, Expr]:
    """Write area and first moment about the middle one of three neighbours, both in units of their distance."""
    a, b, c = heights
    sides: list[list[tuple[Expr, Expr]]] = []
    for sign, outer in ((-1, a), (1, c)):
        area, moment = _alone(builder, outer)
        pieces = [handover(builder, b, outer), (area, builder.let(plus(area, moment)))]
        numbers = (-1, -2) if sign < 0 else (0, 1)
        there = [_is_there(band, start, 1 + k, reach) for k in numbers]
        sides.append([_kept(builder, *pair) for pair in zip(there, pieces, strict=True)])
    left, right = sides
    total = builder.total(area for area, _ in (*left, *right))
    before, behind = (builder.total(moment for _, moment in side) for side in (left, right))
    return total, builder.let(minus(behind, before))


def _is_there(band: Band, start: Expr, number: int, reach: tuple[float, float]) -> Expr | None:
    """Return whether the range has a piece, counted from the lowest of three neighbours; None where it always does."""
    conditions: list[Expr] = []
    if reach[0] + number < band.low:
        conditions.append(Compare(">=", start, Number(float(band.low - number))))
    if reach[1] + number > band.high:
        conditions.append(Compare("<=", start, Number(float(band.high - number))))
    if not conditions:
        return None
    return conditions[0] if len(conditions) == 1 else Logic("and", tuple(conditions))


def _kept(builder: Builder, there: Expr | None, moments: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
    if there is None:
        return moments
    area, moment = (builder.let(Where(there, m, ZERO)) for m in moments)
    return area, moment


def _alone(builder: Builder, height: Expr) -> tuple[Expr, Expr]:
    """Integrate min(h, 1 - t) over [0, 1], the moment about 0."""
    square = builder.let(times(height, height))
    cube = builder.let(times(height, square))
    area = builder.let(minus(height, times(_HALF, square)))
    return area, builder.let(plus(times(_HALF, minus(height, square)), times(_SIXTH, cube)))
