"""Terms of fuzzylite: their words, substitutes for degenerate parameters, and degrees at jumps.

A triangle with its top outside its feet, a sigmoid without slope, a step where an S-shape has no width: each has a
degree everywhere, measured with fuzzylite 6 and pyfuzzylite 8. Some are terms of another kind; the others are, in an
input, formulas. If these versions differ, or a degree is not a number, the parameters stay mistakes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Final, NamedTuple

from fuzzyctl.expr import Call, Expr, Name, Number
from fuzzyctl.formats.common.words import Shape, ShapeWord, Values
from fuzzyctl.formulas import MEMBERSHIP


@dataclass(frozen=True)
class Substitute:
    """A valid term with the degrees of a degenerate one.

    Args:
        kind: Its kind.
        arguments: Its arguments.
        description: Its description, behind `fuzzylite computes it`.
        share: The factor of its height.
    """

    kind: str
    arguments: tuple[Expr, ...]
    description: str
    share: float = 1.0


#: A substitute, or the degree as a formula of the input; None if there is no substitute.
Degree = Substitute | Callable[[Expr], Expr] | None


@dataclass(frozen=True)
class TermWord(ShapeWord):
    """A word of fuzzylite for a term; `degenerate` gives its degree for parameters that rule files refuse."""

    degenerate: Callable[[Values], Degree] = lambda _: None


def as_computed(kind: str, values: Values, variable: str | None) -> Substitute | None:
    """Return a term with the degrees that fuzzylite computes for degenerate parameters.

    Args:
        kind: The kind.
        values: Its parameters in the order of the model.
        variable: The input of the term, for formulas; None for a term of an output.

    Returns:
        The term; None for valid parameters, and if there is no such term.
    """
    if kind not in _DEGENERATE or any(map(math.isnan, values)):
        return None
    if MEMBERSHIP[kind].mistake(values) is None and not has_step(kind, values):
        return None
    return of_input(_DEGENERATE[kind](values), variable)


def of_input(degree: Degree, variable: str | None) -> Substitute | None:
    """Return a degree as a term; no term of an output is a formula of its place."""
    if degree is None or isinstance(degree, Substitute):
        return degree
    if variable is None:
        return None
    return Substitute("function", (degree(Name(variable)),), "0 everywhere" if degree is zero else "as a formula")


def zero(_: Expr) -> Expr:
    """Return the degree of a term to which no number belongs."""
    return Number(0.0)


def _term(kind: str, values: Sequence[float], description: str, share: float = 1.0) -> Substitute:
    return Substitute(kind, tuple(map(Number, values)), description, share)


def _constant(degree: float, place: float) -> Substitute:
    """Return a degree that is the same everywhere."""
    return _term("piecewise", (place, degree, _further(place), degree), f"{degree:g} everywhere")


def _further(place: float) -> float:
    return place + max(1.0, abs(place))


# --- straight sides ------------------------------------------------------------------------------------------------


def _triangle(p: Values) -> Degree:
    left, top, right = p
    return _trapezoid((left, top, top, right))


def _trapezoid(p: Values) -> Degree:
    """Return the sides between the feet: first the rising one, then the falling one."""
    left, left_top, right_top, right = p
    if math.isinf(left_top) or math.isinf(right_top):
        return None
    if right == math.inf and left < left_top > right_top:
        return None  # the order of its sides differs between the versions
    if left > right:
        return zero
    places = sorted({x for x in p if left <= x <= right and math.isfinite(x)})
    stretches = [left, *(x for x in places if x not in (left, right)), right]
    points: list[tuple[float, float]] = [] if math.isinf(left) else [(left, 0.0)]
    for start, end in pairwise(stretches):
        points += _stretch(p, start, end)
    if math.isfinite(right):
        points.append((right, 0.0))
    points = [point for point, _ in groupby(points)]
    if all(y <= 0.0 for _, y in points):
        return zero
    if len(points) == 1:
        points.append((_further(points[0][0]), points[0][1]))
    return _term("piecewise", [v for point in points for v in point], "cut off at the feet")


def _stretch(p: Values, start: float, end: float) -> Iterator[tuple[float, float]]:
    """Yield the finite ends of a stretch between corners.

    If the degree of the corner is lower than the limit of the stretch, its end is the next number inside.
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
    return _further(start) if math.isinf(end) else 0.5 * start + 0.5 * end


def _side(p: Values, x: float) -> Callable[[float], float]:
    """Return the straight side at a place between the feet."""
    left, left_top, right_top, right = p
    flat = left_top <= x <= right_top or (left == -math.inf and x < left_top) or (right == math.inf and x > right_top)
    if flat:
        return lambda _: 1.0
    if x < left_top:
        return lambda u: (u - left) / (left_top - left)
    return lambda u: (right - u) / (right - right_top)


def _rectangle(p: Values) -> Degree:
    return _constant(1.0, 0.0) if p == (-math.inf, math.inf) else None


def _semi_ellipse(p: Values) -> Degree:
    start, end = p
    return _term("semi_ellipse", (end, start), "the same from end to start") if start > end else None


# --- splines -------------------------------------------------------------------------------------------------------


def _s_shape(p: Values) -> Degree:
    """Return a step: in fuzzylite the degree is 0 up to the start, then 1."""
    start, end = p
    behind = math.nextafter(start, math.inf)
    return _term("rectangle", (behind, math.inf), "a step behind its start") if start >= end else None


def _z_shape(p: Values) -> Degree:
    start, end = p
    return _term("rectangle", (-math.inf, start), "a step at its start") if start >= end else None


def _pi_shape(p: Values) -> Degree:
    """Return the product of a rise and a fall; either may be a step, or begin before the other ends."""
    left, left_top, right_top, right = p
    if any(map(math.isinf, p[:3])) or right == -math.inf:
        return None
    rises, falls = left < left_top, right_top < right
    behind = math.nextafter(left, math.inf)
    if left >= (right if falls else right_top):
        return zero
    if not rises and left <= right_top:
        parameters = (behind, behind, max(behind, right_top), right if falls else right_top)
        return _term("pi_shape", parameters, "a step at its left, and 0 at its foot")
    if not falls and left_top <= right_top:
        return _term("pi_shape", (left, left_top, right_top, right_top), "a step at its right")
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


def _sigmoid(p: Values) -> Degree:
    inflection, slope = p
    return _constant(0.5, inflection) if slope == 0.0 else None


def _sigmoid_product(p: Values) -> Degree:
    left, rising, falling, right = p
    if rising == falling == 0.0:
        return _constant(0.25, left)
    parameters = (left, rising) if falling == 0.0 else (right, falling)
    return _term("sigmoid", parameters, "half of the other sigmoid", 0.5)


def _sigmoid_difference(p: Values) -> Degree:
    left, rising, falling, right = p
    if any(map(math.isinf, p)):
        return None
    if rising == falling == 0.0:
        return zero
    place, slope = (left, rising) if falling == 0.0 else (right, falling)

    def formula(x: Expr) -> Expr:
        power = Call("exp", (-slope * (x - place),))
        return Call("abs", (0.5 - 1.0 / (1.0 + power),))

    return formula


def _bell(p: Values) -> Degree:
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


def _cosine(p: Values) -> Degree:
    return zero if p[1] < 0.0 else None


def _points(p: Values) -> Degree:
    """Return a degree that is the same everywhere: that of a single point, or 0."""
    if len(p) % 2 or not p:
        return None
    if not any(p[1::2]) and all(a <= b for a, b in pairwise(p[::2])):
        return zero
    return _constant(p[1], p[0]) if len(p) == 2 and 0.0 <= p[1] <= 1.0 else None


# --- jumps ---------------------------------------------------------------------------------------------------------
#
# At a jump of a Discrete term fuzzylite takes the degree of the first point there, behind the last point of all that of
# the last one; pyfuzzylite always takes that of the last point; the model takes the larger one. A PiShape whose left
# side has no width is 0 at its foot. Measured with fuzzylite 6.0 and pyfuzzylite 8.0.6. A jump of the model at the next
# floating-point number has these degrees at every number.


class Corner(NamedTuple):
    """A place of a polygon with one point or, at a jump, several.

    Args:
        place: The place.
        first: The degree of the first point, to which the polygon tends from the left.
        last: The degree of the last point, to which it tends from the right.
        top: The largest degree, which holds there in the model.
        degree: The degree that holds there in the file's tool.
    """

    place: float
    first: float
    last: float
    top: float
    degree: float


def corners(points: Sequence[float], *, python: bool) -> list[Corner]:
    """Return the corners of a polygon.

    Args:
        points: x1, y1, x2, y2, ..., with places that do not fall.
        python: Whether the file's tool is pyfuzzylite.
    """
    pairs = zip(points[::2], points[1::2], strict=True)
    groups = [(x, [y for _, y in group]) for x, group in groupby(pairs, lambda point: point[0])]
    last = len(groups) - 1
    return [
        Corner(x, ys[0], ys[-1], max(ys), ys[-1] if python or k == last > 0 else ys[0])
        for k, (x, ys) in enumerate(groups)
    ]


def polygon(points: Sequence[float], *, python: bool = False, written: bool = False) -> tuple[float, ...]:
    """Return the points of a polygon with the same degrees in the model.

    Args:
        points: The points in a file.
        python: Whether the file's tool is pyfuzzylite.
        written: Whether `points` are those of the model, and those of the file are returned.
    """
    result: list[float] = []
    for place, first, last, top, degree in corners(points, python=python):
        if written and top > max(first, last):  # a degree of one place
            before, behind = (math.nextafter(place, end) for end in (-math.inf, math.inf))
            result += (before, first, place, top, behind, last)
        elif first == last:
            result += (place, first)
        else:  # the jump goes beside a place with the lower degree
            beside = math.nextafter(place, math.inf if (degree == first) != written else -math.inf)
            jump = place if degree == max(first, last) else beside
            result += (jump, first, jump, last)
    if len(result) == 2:
        result += [_further(result[0]), result[1]]
    return tuple(result)


def has_step(kind: str, parameters: Sequence[float]) -> bool:
    """Whether a term is a PiShape whose left side has no width."""
    return kind == "pi_shape" and parameters[0] == parameters[1] and math.isfinite(parameters[0])


def as_written(kind: str, parameters: Sequence[float], *, python: bool = False) -> Sequence[float]:
    """Return the parameters for which fuzzylite, or pyfuzzylite, computes the degrees of the model."""
    if kind == "piecewise":
        return polygon(parameters, python=python, written=True)
    if has_step(kind, parameters):
        before = math.nextafter(parameters[0], -math.inf)
        return (before, before, *parameters[2:])
    return parameters


# --- words ---------------------------------------------------------------------------------------------------------


def _read_binary(p: Values) -> Shape:
    """Return a step; the direction may be any number on the side of its 1."""
    start, direction = p
    return "rectangle", ((start, math.inf) if direction > start else (-math.inf, start))


def _read_trapezoid(p: Values) -> Shape:
    """Return a trapezoid, whose shoulders fuzzylite also writes with two infinite corners."""
    left, left_top, right_top, right = p
    if left == left_top == -math.inf:
        left_top = right_top if math.isfinite(right_top) else 0.0
    if right == right_top == math.inf:
        right_top = left_top
    return "trapezoid", (left, left_top, right_top, right)


#: Terms by name, besides Constant, Linear, Discrete and Function.
TERM_WORDS: Final[dict[str, TermWord]] = {
    "Arc": TermWord("arc", "start end"),
    "Bell": TermWord("bell", "center width slope", magnitudes=(1,), degenerate=_bell),
    "Binary": TermWord("rectangle", "start direction", read=_read_binary, degenerate=_rectangle),
    "Concave": TermWord("concave", "inflection end"),
    "Cosine": TermWord("cosine", "center width", degenerate=_cosine),
    "Gaussian": TermWord("gaussian", "mean sigma", magnitudes=(1,)),
    "GaussianProduct": TermWord("gaussian2", "mean_a sigma_a mean_b sigma_b", magnitudes=(1, 3)),
    "PiShape": TermWord("pi_shape", "left left_top right_top right", degenerate=_pi_shape),
    "Ramp": TermWord("ramp", "start end"),
    "Rectangle": TermWord("rectangle", "start end", degenerate=_rectangle),
    "SemiEllipse": TermWord("semi_ellipse", "start end", degenerate=_semi_ellipse),
    "Sigmoid": TermWord("sigmoid", "inflection slope", degenerate=_sigmoid),
    "SigmoidDifference": TermWord("sigmoid_difference", "left rising falling right", degenerate=_sigmoid_difference),
    "SigmoidProduct": TermWord("sigmoid_product", "left rising falling right", degenerate=_sigmoid_product),
    "Spike": TermWord("spike", "center width", magnitudes=(1,)),
    "SShape": TermWord("s_shape", "start end", degenerate=_s_shape),
    "Trapezoid": TermWord("trapezoid", "left left_top right_top right", read=_read_trapezoid, degenerate=_trapezoid),
    "Triangle": TermWord("triangle", "left top right", degenerate=_triangle),
    "ZShape": TermWord("z_shape", "start end", degenerate=_z_shape),
}

#: All names of terms.
TERMS: Final[dict[str, TermWord]] = {
    **TERM_WORDS,
    "Constant": TermWord("constant", "value"),
    "Discrete": TermWord("piecewise", "x1 y1 x2 y2 ...", degenerate=_points),
    "Function": TermWord("function", "formula"),
    "Linear": TermWord("linear", "coefficients constant"),
}

_DEGENERATE: Final = {word.kind: word.degenerate for word in TERMS.values()}
