"""Degenerate terms of fuzzylite: parameters that a rule file refuses, replaced by equal valid terms.

A triangle with its top outside its feet, a sigmoid without slope, a step where an S-shape has no width: each has a
degree everywhere, measured with fuzzylite 6 and pyfuzzylite 8. Some are terms of another kind; the others are, in an
input, formulas. Where these versions differ, or a degree is no number, nothing is made of them, and they stay mistakes.
Other parameters are in order, but of a term that jumps, where fuzzylite has other degrees at the jump itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Call, Expr, Name, Number
from fuzzyctl.formats.common.report import Reporter
from fuzzyctl.formats.fuzzylite.discontinuities import has_step, polygon_as_computed, tools_differ
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.variable import Membership

Values = tuple[float, ...]

#: Why degrees beyond 1, which fuzzylite computes with, are refused.
NOT_BEYOND: Final = "degrees are truths between 0 and 1, and norms and proofs hold for no others; scale the term down"


@dataclass(frozen=True)
class Made:
    """What a term is read as.

    Args:
        kind: Its kind.
        arguments: Its arguments.
        is_what: What it is, to be said behind `it is`.
        share: What its height is multiplied by.
    """

    kind: str
    arguments: tuple[Expr, ...]
    is_what: str
    share: float = 1.0


def membership_as_computed(
    own: Membership, variable: str | None, findings: Reporter, *, word: str = "", python: bool = False
) -> Membership | None:
    """Return the membership function that fuzzylite computes with, which is said; None for one that it cannot have.

    Args:
        own: What the file says, with numbers as arguments and as its height.
        variable: The input that it is a term of; None for a term of an output.
        findings: Where the warning goes, or the mistake.
        word: What the file calls it.
        python: Whether it is read as pyfuzzylite computes it, where that makes a difference.
    """
    values = tuple(a.value for a in own.arguments if isinstance(a, Number))
    if len(values) < len(own.arguments) or not isinstance(own.height, Number):
        return own
    height = own.height.value
    named = f"'{word}'" if word else f"the {own.kind}"
    if not 0.0 <= height <= 1.0:
        message = f"the height {height:g} of {named} lies outside [0, 1]"
        findings.error("FZ302", message, own.height.span or own.span, help=NOT_BEYOND)
        return None
    mistake = MEMBERSHIP[own.kind].mistake(values)
    made = nothing(variable) if height == 0.0 else as_computed(own.kind, values, variable)
    if made is None:
        return own if mistake is not None else _with_jumps(own, values, findings, named, python=python)
    said = mistake or ("its height is 0" if height == 0.0 else "its left side has no width")
    message = f"{named}: {said}; it is read as fuzzylite computes it, {made.is_what}"
    findings.warning("FZ609", message, own.span, help="other tools refuse it, or take it for something else")
    share = height * made.share
    if made.kind == "function" and share not in (0.0, 1.0):  # formulas have no height of their own
        formula = share * made.arguments[0]
        return Membership(kind="function", arguments=(formula,), span=own.span)
    lower = made.kind != "function" and share != 1.0
    return Membership(kind=made.kind, arguments=made.arguments, height=Number(share) if lower else ONE, span=own.span)


def _with_jumps(own: Membership, values: Values, findings: Reporter, named: str, *, python: bool) -> Membership | None:
    """Return a term with the degrees of fuzzylite at its jumps; where its two engines differ, that is said."""
    if has_step(own.kind, values):
        findings.error("FZ302", f"{named} has no width, so that it is 0 everywhere", own.span)
        return None
    if own.kind != "piecewise":
        return own
    if not python and (found := next(iter(tools_differ(values)), None)) is not None:
        corner, other = found
        jump = f"{named} jumps at {corner.place:.6g} from {corner.first:.6g} to {corner.last:.6g}"
        message = f"{jump}; there it is {corner.held:.6g}, as fuzzylite computes it"
        help_text = f"pyfuzzylite has {other.held:.6g} there; move one of the points, if it is to be the same"
        findings.warning("FZ609", message, own.span, help=help_text)
    points = polygon_as_computed(values, python=python)
    if points == values:
        return own
    return own.model_copy(update={"arguments": tuple(map(Number, points))})


def with_places(parameters: Sequence[float], given: Sequence[Number]) -> tuple[Number, ...]:
    """Return parameters with the places of the numbers that they were made of, each place once."""
    left = list(given)
    found = []
    for value in parameters:
        own = next((n for n in left if n.value == value), None) or next((n for n in left if n.value == -value), None)
        if own is not None:
            left.remove(own)
        found.append(Number(value, span=own.span if own is not None else None))
    return tuple(found)


def as_computed(kind: str, values: Values, variable: str | None) -> Made | None:
    """Return a term that has the degrees which fuzzylite computes for parameters that are a mistake, or a step.

    Args:
        kind: The kind that the word of the file stands for.
        values: Its parameters in the order of the model.
        variable: The input that it is a term of, over which formulas are; None for a term of an output.

    Returns:
        The term; None for parameters that are in order, and where there is no such term.
    """
    maker = _MAKERS.get(kind)
    if maker is None or any(map(math.isnan, values)):
        return None
    if MEMBERSHIP[kind].mistake(values) is None and not has_step(kind, values):
        return None
    made = maker(values)
    if made is None:
        return None
    if isinstance(made, Made):
        return made
    if variable is None:
        return None
    return Made("function", (made(Name(variable)),), _NOTHING if made is _nothing else "as a formula")


def nothing(variable: str | None) -> Made | None:
    """Return a term that nothing belongs to, which an input alone can have."""
    return Made("function", (Number(0.0),), _NOTHING) if variable is not None else None


def step_to_itself(variable: str | None, span: Span, findings: Reporter, *, word: str) -> Membership | None:
    """Return fuzzylite's step from a place towards that place, which is said; None, a mistake, in an output.

    Args:
        variable: The input that it is a term of; None for a term of an output, where something has to belong to it.
        span: Where it stands.
        findings: Where the warning goes, or the mistake.
        word: What the file calls it.
    """
    made = nothing(variable)
    if made is None:
        message = f"'{word}' has its start as its direction, so that it is 0 everywhere"
        findings.error("FZ302", message, span)
        return None
    message = f"'{word}' has its start as its direction; it is read as fuzzylite computes it, {made.is_what}"
    findings.warning("FZ609", message, span)
    return Membership(kind=made.kind, arguments=made.arguments, span=span)


#: A term, or its degree as a formula of the input.
_Found = Made | Callable[[Expr], Expr] | None

_NOTHING: Final = "0 everywhere"


def _nothing(_: Expr) -> Expr:
    return Number(0.0)


def _constant(degree: float, place: float) -> Made:
    """Return a degree that is the same everywhere."""
    further = place + max(1.0, abs(place))
    points = tuple(map(Number, (place, degree, further, degree)))
    return Made("piecewise", points, f"{degree:g} everywhere")


def _step(first: float, last: float, what: str) -> Made:
    return Made("rectangle", (Number(first), Number(last)), what)


# --- straight sides ------------------------------------------------------------------------------------------------


def _triangle(p: Values) -> _Found:
    left, top, right = p
    return _trapezoid((left, top, top, right))


def _trapezoid(p: Values) -> _Found:
    """Return what is left of the sides between the feet: of the rising one first, then of the falling one."""
    left, left_top, right_top, right = p
    if math.isinf(left_top) or math.isinf(right_top):
        return None
    if right == math.inf and left < left_top > right_top:
        return None  # which of its sides counts first is not the same in both versions
    if left > right:
        return _nothing
    places = sorted({x for x in p if left <= x <= right and math.isfinite(x)})
    stretches = [left, *(x for x in places if x not in (left, right)), right]
    points: list[tuple[float, float]] = [] if math.isinf(left) else [(left, 0.0)]
    for start, end in pairwise(stretches):
        points += _stretch(p, start, end)
    if math.isfinite(right):
        points.append((right, 0.0))
    kept = [a for k, a in enumerate(points) if k == 0 or a != points[k - 1]]
    if all(y <= 0.0 for _, y in kept):
        return _nothing
    if len(kept) == 1:
        kept.append((kept[0][0] + max(1.0, abs(kept[0][0])), kept[0][1]))
    return Made("piecewise", tuple(Number(v) for point in kept for v in point), "cut off at the feet")


def _stretch(p: Values, start: float, end: float) -> Iterator[tuple[float, float]]:
    """Yield the finite ends of a stretch between corners.

    Where the corner itself has less than the stretch tends to, the stretch begins or ends just beside it.
    """
    side = _side(p, _within(start, end))
    for x, further in ((start, end), (end, start)):
        if math.isfinite(x):
            y = side(x)
            yield (math.nextafter(x, further) if y > _side(p, x)(x) else x), y


def _within(start: float, end: float) -> float:
    """Return a point between two ends; either end may be infinite."""
    if math.isinf(start):
        return end - max(1.0, abs(end))
    return start + max(1.0, abs(start)) if math.isinf(end) else 0.5 * start + 0.5 * end


def _side(p: Values, x: float) -> Callable[[float], float]:
    """Return the straight side that holds at a place between the feet."""
    left, left_top, right_top, right = p
    flat = left_top <= x <= right_top or (left == -math.inf and x < left_top) or (right == math.inf and x > right_top)
    if flat:
        return lambda _: 1.0
    if x < left_top:
        return lambda u: (u - left) / (left_top - left)
    return lambda u: (right - u) / (right - right_top)


def _rectangle(p: Values) -> _Found:
    return _constant(1.0, 0.0) if p == (-math.inf, math.inf) else None


def _semi_ellipse(p: Values) -> _Found:
    start, end = p
    return Made("semi_ellipse", (Number(end), Number(start)), "the same from end to start") if start > end else None


# --- splines -------------------------------------------------------------------------------------------------------


def _s_shape(p: Values) -> _Found:
    """Return a step: fuzzylite is 0 up to the start, and 1 behind it."""
    start, end = p
    return _step(math.nextafter(start, math.inf), math.inf, "a step behind its start") if start >= end else None


def _z_shape(p: Values) -> _Found:
    start, end = p
    return _step(-math.inf, start, "a step at its start") if start >= end else None


def _pi_shape(p: Values) -> _Found:
    """Return the product of a rise and a fall; either may be a step, or begin before the other ends."""
    left, left_top, right_top, right = p
    if any(map(math.isinf, p[:3])) or right == -math.inf:
        return None
    rises, falls = left < left_top, right_top < right
    behind = math.nextafter(left, math.inf)
    if left >= (right if falls else right_top):
        return _nothing
    if not rises and left <= right_top:
        parameters = (behind, behind, max(behind, right_top), right if falls else right_top)
        return Made("pi_shape", tuple(map(Number, parameters)), "a step at its left, and 0 at its foot")
    if not falls and left_top <= right_top:
        return Made("pi_shape", tuple(map(Number, (left, left_top, right_top, right_top))), "a step at its right")
    if right == math.inf:
        return None
    return lambda x: _rise(x, left, left_top) * _fall(x, right_top, right)


def _rise(x: Expr, foot: float, top: float) -> Expr:
    return _spline(x, foot, top) if foot < top else Call("gt", (x, Number(foot)))


def _fall(x: Expr, top: float, foot: float) -> Expr:
    return _spline(x, foot, top) if top < foot else Call("le", (x, Number(top)))


def _spline(x: Expr, foot: float, top: float) -> Expr:
    """Return the s-shape from foot to top without choices: two parabolas, each on its half of the way."""
    way = (x - foot) / (top - foot)
    first = _clip(way, 0.0, 0.5)
    rest = 1.0 - _clip(way, 0.5, 1.0)
    rise, missing = (2.0 * (half * half) for half in (first, rest))
    return rise + (0.5 - missing)


def _clip(x: Expr, low: float, high: float) -> Expr:
    return Call("min", (Number(high), Call("max", (Number(low), x))))


# --- sigmoids and bells --------------------------------------------------------------------------------------------


def _sigmoid(p: Values) -> _Found:
    inflection, slope = p
    return _constant(0.5, inflection) if slope == 0.0 else None


def _sigmoid_product(p: Values) -> _Found:
    left, rising, falling, right = p
    if rising == falling == 0.0:
        return _constant(0.25, left)
    kept = (left, rising) if falling == 0.0 else (right, falling)
    return Made("sigmoid", tuple(map(Number, kept)), "half of the other sigmoid", 0.5)


def _sigmoid_difference(p: Values) -> _Found:
    left, rising, falling, right = p
    if any(map(math.isinf, p)):
        return None
    if rising == falling == 0.0:
        return _nothing
    place, slope = (left, rising) if falling == 0.0 else (right, falling)

    def formula(x: Expr) -> Expr:
        power = Call("exp", (-slope * (x - place),))
        return Call("abs", (0.5 - 1.0 / (1.0 + power),))

    return formula


def _bell(p: Values) -> _Found:
    center, width, slope = p
    if width == 0.0 or any(map(math.isinf, p)):
        return None
    if slope == 0.0:
        return _constant(0.5, center)
    if slope > 0.0:
        return None

    def formula(x: Expr) -> Expr:  # a bell upside down
        away = Call("abs", ((x - center) / width,))
        power = away ** (-2.0 * slope)
        return 1.0 - 1.0 / (1.0 + power)

    return formula


def _cosine(p: Values) -> _Found:
    return _nothing if p[1] < 0.0 else None


def _points(p: Values) -> _Found:
    """Return a degree that is the same everywhere: that of a single point, or 0."""
    if len(p) % 2 or not p:
        return None
    if not any(p[1::2]) and _rises(p[::2]):
        return _nothing
    return _constant(p[1], p[0]) if len(p) == 2 and 0.0 <= p[1] <= 1.0 else None


def _rises(places: Values) -> bool:
    return all(a <= b for a, b in pairwise(places))


_MAKERS: Final[dict[str, Callable[[Values], _Found]]] = {
    "triangle": _triangle,
    "trapezoid": _trapezoid,
    "rectangle": _rectangle,
    "semi_ellipse": _semi_ellipse,
    "s_shape": _s_shape,
    "z_shape": _z_shape,
    "pi_shape": _pi_shape,
    "sigmoid": _sigmoid,
    "sigmoid_product": _sigmoid_product,
    "sigmoid_difference": _sigmoid_difference,
    "bell": _bell,
    "cosine": _cosine,
    "piecewise": _points,
}
