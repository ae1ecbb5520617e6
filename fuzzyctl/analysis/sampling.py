"""Search for witnesses at a few sample points, without numpy, for `check`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain, islice, pairwise, product
from typing import Final

from fuzzyctl.analysis.claims import Claim, Slope, bounds_in, named, speaks_of_all_points
from fuzzyctl.analysis.degrees import breakpoints
from fuzzyctl.analysis.verdicts import Witness
from fuzzyctl.analysis.witnesses import Judge, NoValueError
from fuzzyctl.expr import Binary, Call, Expr, ExprError, Number, children, walk
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.model.block import Guarantee

#: Most points tried.
POINTS: Final = 400
#: Most points looked at for those with signs of zeros.
_SIGNED: Final = 4000
#: Most points that differ in signs of zeros only.
SIGNS: Final = 16
#: Units of work for an operation in rational arithmetic.
_RATIONAL: Final = 4
#: Most rules of a system whose kernel is worth printing for this.
RULES: Final = 500


def witness_of(claim: Claim, plan: Plan, judge: Judge) -> Witness | None:
    """Look for a point that breaks a claim among the corners of terms and the middles between them."""
    if plan.states or plan.held or len(plan.rules) > RULES:
        return None
    for point in points(plan):
        if not judge.spends(units_of_claim(claim)):
            return None
        witness = _broken(claim, plan, judge, list(point))
        if witness is not None:
            return witness
    return None


def without_value(guarantee: Guarantee, claim: Claim, plan: Plan, judge: Judge) -> tuple[Expr, dict[str, float]] | None:
    """Look for a point of the region where a claim has no value; return the part that has none, and the point.

    Such parts are quotients by 0, roots and logarithms of negative numbers, and powers of such kinds.
    """
    parts = [part for part in (guarantee.claim, guarantee.when) if part is not None]
    variables = {*judge.inputs, *judge.outputs_named}
    partial = [n for part in parts for n in walk(part) if _is_partial(n) and variables & set(named(n))]
    if not partial or plan.states or plan.held or len(plan.rules) > RULES:
        return None
    for point in points(plan):
        if not judge.spends(units_of_claim(claim)):
            return None
        here = judge.outputs(point)
        for node in partial:
            if _has_none(judge, node, point, here) and not _is_answered(judge, claim, point):
                return node, dict(zip(judge.inputs, point, strict=True))
    return None


def _is_partial(expr: Expr) -> bool:
    if isinstance(expr, Binary):
        plain = isinstance(expr.right, Number) and expr.right.value >= 0.0 and expr.right.value % 1.0 == 0.0
        return expr.op == "/" or (expr.op == "^" and not plain)
    return isinstance(expr, Call) and expr.function in ("sqrt", "log", "mod", "fmod")


def _has_none(judge: Judge, expr: Expr, point: tuple[float, ...], here: dict[str, float]) -> bool:
    """Return whether an expression has no value at a point where its operands have one."""
    try:
        values = [judge.value(child, point, here)[0] for child in children(expr)]
    except (NoValueError, ExprError, OverflowError):
        return False
    match expr:
        case Binary(op="/"):
            return values[1] == 0
        case Binary(op="^"):
            base, exponent = values
            return (base == 0 and exponent < 0) or (base < 0 and exponent.denominator != 1)
        case Call(function="log"):
            return values[0] <= 0
        case Call(function="mod" | "fmod"):
            return values[1] == 0
    return values[0] < 0


def _is_answered(judge: Judge, claim: Claim, point: tuple[float, ...]) -> bool:
    """Return whether a point is outside the region of a claim, or the claim is true or false there all the same."""
    try:
        if not judge.holds(claim.region, point):
            return True
        if not speaks_of_all_points(claim.truth):
            judge.holds(claim.truth, point)
            return True
    except (NoValueError, ExprError, OverflowError):
        pass
    return False


def _broken(claim: Claim, plan: Plan, judge: Judge, point: list[float]) -> Witness | None:
    if not isinstance(claim.truth, Slope):
        return judge.broken(claim.truth, claim.region, point)
    slope, k = claim.truth, judge.inputs.index(claim.truth.input)
    error = judge.rounding(slope.output)
    for far in _coordinates(plan, k):
        result = judge.broken_slope(slope, point, far, error) if far > point[k] else None
        if result is not None:
            return result
    return None


def units_of_claim(claim: Claim) -> float:
    """Return the work of evaluating a claim in rational arithmetic at a point, without its outputs."""
    sides = [side for truth in (claim.truth, claim.region) for b in bounds_in(truth) for side in (b.left, b.right)]
    return 10 + sum(_RATIONAL for side in sides for _ in walk(side))


def points(plan: Plan) -> Iterator[tuple[float, ...]]:
    """Yield corners of terms and middles between them, then the same with -0.0."""
    coordinates = [_coordinates(plan, i) for i in range(len(plan.inputs))]
    signed = [[*axis, -0.0] if axis[0] <= 0.0 <= axis[-1] else axis for axis in coordinates]
    negative = filter(_has_minus_zero, islice(product(*signed), _SIGNED))
    yield from islice(chain(product(*coordinates), negative), POINTS)


def with_signs(point: Sequence[float], sides: Sequence[tuple[float, float]]) -> Iterator[list[float]]:
    """Yield a point of a box, and the same with -0.0 for inputs whose side holds 0.

    As floats compare, 0.0 and -0.0 are one, but `1 / x` and `atan2(x, -1)` tell them apart.

    Args:
        point: The point.
        sides: Ends of the box along each input.
    """
    choices = [[x, -0.0] if low <= 0.0 <= high else [x] for x, (low, high) in zip(point, sides, strict=True)]
    yield from (list(signed) for signed in islice(product(*choices), SIGNS))


def _has_minus_zero(point: tuple[float, ...]) -> bool:
    return any(x == 0.0 and math.copysign(1.0, x) < 0.0 for x in point)


def _coordinates(plan: Plan, position: int) -> list[float]:
    """Return corners and middles of an input; where they are too many for all inputs together, fewer."""
    variable = plan.inputs[position]
    corners = breakpoints(variable, [d.set for d in plan.degrees if d.variable == position])
    coordinates = sorted({*corners, *(0.5 * a + 0.5 * b for a, b in pairwise(corners))})
    most = max(3, round(POINTS ** (1.0 / len(plan.inputs))))
    if len(coordinates) <= most:
        return coordinates
    return [coordinates[round(k * (len(coordinates) - 1) / (most - 1))] for k in range(most)]
