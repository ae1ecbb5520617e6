"""Normal form of guarantees: `left >= right` with a tolerance, joined by all and any, and claims about all points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Final

from fuzzyctl.expr import (
    COMPARISONS,
    ONE,
    ZERO,
    Binary,
    Call,
    Compare,
    Expr,
    Logic,
    Name,
    Number,
    names_in,
    to_text,
    walk,
)
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.inlined_lets import inlined
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record

#: Words about two points of an input.
SLOPES: Final = ("increasing", "decreasing", "lipschitz")

#: Most comparisons that one is written as.
MOST_PARTS: Final = 256


@record(frozen=True, eq=False)
class Bound:
    """`left >= right - tolerance`, or `>` if it is strict; each is equal to itself only, which makes it a quick key.

    Args:
        left, right: Expressions over params, inputs and outputs.
        tolerance: At least 0.
        strict: Whether equality does not do.
        origin: The comparison it was written as.
    """

    left: Expr
    right: Expr
    tolerance: Fraction
    strict: bool
    origin: Expr


@record(frozen=True)
class Slope:
    """A word about an output along an input.

    Args:
        word: One of `SLOPES`.
        output, input: Their names.
        limit: The bound of `lipschitz`, else 0.
        tolerance: How far values may be off.
        origin: As it was written.
    """

    word: str
    output: str
    input: str
    limit: float
    tolerance: Fraction
    origin: Expr


@record(frozen=True)
class Total:
    """Some rule fires everywhere for an output."""

    output: str
    origin: Expr


@record(frozen=True)
class Every:
    """All of some truths; of none it is true."""

    parts: tuple[Truth, ...]


@record(frozen=True)
class Some:
    """At least one of some truths."""

    parts: tuple[Truth, ...]


@record(frozen=True)
class Denied:
    """The negation of a word about all points."""

    part: Slope | Total


Truth = Bound | Slope | Total | Every | Some | Denied
Pointwise = Bound | Every | Some

ALWAYS: Final = Every(())


@record(frozen=True)
class Claim:
    """A guarantee of a system or a controller.

    Args:
        text: As a rule file writes it.
        truth: What must hold.
        region: Where it must hold.
    """

    text: str
    truth: Truth
    region: Truth


def claim_of(system: FuzzySystem | Controller, guarantee: Guarantee) -> Claim:
    """Return a guarantee in normal form."""
    tolerance = Fraction(0)
    text = to_text(guarantee.claim)
    written = inlined(system, guarantee)
    if guarantee.within is not None:
        tolerance = Fraction(system.number(guarantee.within))
        text += f" within {to_text(guarantee.within)}"
    region: Truth = ALWAYS
    if guarantee.when is not None and written.when is not None:
        region = _truth(system, written.when, Fraction(0), True)
        text += f" when {to_text(guarantee.when)}"
    return Claim(text, _truth(system, written.claim, tolerance, True), region)


def outside(system: FuzzySystem | Controller, guarantee: Guarantee) -> Claim | None:
    """Return the claim that no point is in the region of a guarantee, None for one that speaks of all points."""
    when = inlined(system, guarantee).when
    if guarantee.when is None or when is None:
        return None
    text = to_text(guarantee.when)
    return Claim(f"not ({text})", _truth(system, when, Fraction(0), False), ALWAYS)


def speaks_of_all_points(truth: Truth) -> bool:
    """Return whether a truth holds a word about all points, so that no single point has it or not."""
    if isinstance(truth, Every | Some):
        return any(speaks_of_all_points(p) for p in truth.parts)
    return not isinstance(truth, Bound)


def bounds_in(truth: Truth) -> Iterator[Bound]:
    """Yield all comparisons."""
    if isinstance(truth, Bound):
        yield truth
    elif isinstance(truth, Every | Some):
        for part in truth.parts:
            yield from bounds_in(part)


def outputs_in(truth: Truth) -> set[str]:
    """Return the names in comparisons and words about slopes, among which are the outputs that are spoken of."""
    if isinstance(truth, Slope):
        return {truth.output}
    return {n for b in bounds_in(truth) for side in (b.left, b.right) for n in named(side)}


def compared_outputs(system: FuzzySystem) -> set[str]:
    """Return the outputs of other systems that guarantees may name."""
    return {f"{c.name}.{o.name}" for c in system.compared for o in c.outputs}


def named(expr: Expr) -> Iterator[str]:
    """Yield the names of variables and of called functions and systems."""
    for node in walk(expr):
        if isinstance(node, Name):
            yield node.name
        elif isinstance(node, Call):
            yield node.function


def is_limit(system: FuzzySystem, bound: Bound) -> bool:
    """Return whether one side is a number: such a claim is about the numbers that kernels return."""
    variables = {v.name for v in (*system.inputs, *system.outputs)} | compared_outputs(system)
    return any(not variables & set(named(side)) for side in (bound.left, bound.right))


def _truth(system: FuzzySystem | Controller, expr: Expr, tolerance: Fraction, wanted: bool) -> Truth:
    """Return a claim, or its negation if `wanted` is false, with `not` carried down to the comparisons."""
    match expr:
        case Logic(op="not", operands=(operand,)):
            return _truth(system, operand, tolerance, not wanted)
        case Logic(op=op, operands=operands):
            parts = tuple(_truth(system, o, tolerance, wanted) for o in operands)
            return Every(parts) if (op == "and") == wanted else Some(parts)
        case Compare(op="<=", left=Call(function="lipschitz") as call, right=right):
            limit = system.number(right)
            slope = Slope("lipschitz", *_two_names(call), limit, tolerance, expr)
            return slope if wanted else Denied(slope)
        case Compare():
            return _comparison(expr, tolerance, wanted)
        case Call(function="bounded", arguments=(output, low, high)):
            joined = (Compare(">=", output, low), Compare("<=", output, high))
            return _truth(system, Logic("and", joined), tolerance, wanted)
        case Call(function="total", arguments=(Name(name=name),)):
            return Total(name, expr) if wanted else Denied(Total(name, expr))
        case Call(function=word) if word in SLOPES:
            slope = Slope(word, *_two_names(expr), 0.0, tolerance, expr)
            return slope if wanted else Denied(slope)
        case Name(name=name) if name in system.conditions:
            return _truth(system, system.conditions[name], tolerance, wanted)
        # A let of a system is a number: `and` is the minimum, `or` the maximum, `not` the difference from 1.
        case Call(function="min" | "max" as joined, arguments=parts):
            return _truth(system, Logic("and" if joined == "min" else "or", parts), tolerance, wanted)
        case Call(function=function, arguments=(left, right)) if function in COMPARISONS:
            return _comparison(Compare(COMPARISONS[function], left, right), tolerance, wanted)
        case Binary(op="-", left=left, right=right) if left == ONE:
            return _truth(system, right, tolerance, not wanted)
    return _comparison(Compare(">", expr, ZERO), Fraction(0), wanted)


def _two_names(call: Call) -> tuple[str, str]:
    first, second = (n.name for n in names_in(call))
    return first, second


_OPPOSITE: Final = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def _comparison(expr: Compare, tolerance: Fraction, wanted: bool) -> Truth:
    op: str = expr.op if wanted else _OPPOSITE[expr.op]
    left, right = expr.left, expr.right
    match op:
        case ">=" | ">":
            return _simplified(Bound(left, right, tolerance, op == ">", expr))
        case "<=" | "<":
            return _simplified(Bound(right, left, tolerance, op == "<", expr))
        case "==":
            return Every(tuple(_simplified(Bound(*p, tolerance, False, expr)) for p in ((left, right), (right, left))))
    # Numbers that differ at all differ; with a tolerance the claim would be true for all numbers.
    return Some(tuple(_simplified(Bound(*p, Fraction(0), True, expr)) for p in ((left, right), (right, left))))


def _simplified(bound: Bound) -> Truth:
    """Write a magnitude, minimum or maximum that is a whole side as several comparisons, unless they are too many."""
    if _alternatives(bound.left) * _alternatives(bound.right) > MOST_PARTS:
        return bound

    def parts(sides: Sequence[tuple[Expr, Expr]]) -> tuple[Truth, ...]:
        return tuple(_simplified(Bound(a, b, bound.tolerance, bound.strict, bound.origin)) for a, b in sides)

    left, right = bound.left, bound.right
    match left:
        case Call(function="abs", arguments=(a,)):
            return Some(parts([(a, right), (_negative(a), right)]))
        case Call(function="max", arguments=several):
            return Some(parts([(a, right) for a in several]))
        case Call(function="min", arguments=several):
            return Every(parts([(a, right) for a in several]))
    match right:
        case Call(function="abs", arguments=(a,)):
            return Every(parts([(left, a), (left, _negative(a))]))
        case Call(function="max", arguments=several):
            return Every(parts([(left, a) for a in several]))
        case Call(function="min", arguments=several):
            return Some(parts([(left, a) for a in several]))
    return bound


def _alternatives(expr: Expr) -> int:
    """Return the number of expressions that a magnitude, minimum or maximum chooses from."""
    match expr:
        case Call(function="abs", arguments=(a,)):
            return 1 + _alternatives(a)
        case Call(function="min" | "max", arguments=several):
            return sum(map(_alternatives, several))
    return 1


def _negative(expr: Expr) -> Expr:
    return Number(-expr.value) if isinstance(expr, Number) else -expr
