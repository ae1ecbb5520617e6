"""Membership functions of `.fis` files, `'trimf',[0 1 2]`: their words, read and written."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from fuzzyctl.expr import number_text
from fuzzyctl.formats.common.ranges import simplest
from fuzzyctl.formats.common.words import Shape, ShapeWord, Values, words_by_kind
from fuzzyctl.formats.fll.shapes import TERM_WORDS, as_written


def _step(at: float, *, rising: bool) -> Shape:
    return "rectangle", ((at, math.inf) if rising else (-math.inf, at))


def _edge(kind: str, *, rising: bool) -> Callable[[Values], Shape]:
    """Return an edge from the first to the second parameter; if they are out of order it is a step between them."""
    return lambda p: (kind, p) if p[0] < p[1] else _step((p[0] + p[1]) / 2, rising=rising)


def _ramp(p: Values) -> Shape:
    return ("ramp", p) if p[0] != p[1] else _step(p[0], rising=True)


def _falling_ramp(p: Values) -> Shape:
    return ("ramp", p[::-1]) if p[0] != p[1] else _step(p[0], rising=False)


def _trapezoid(p: Values) -> Shape:
    """Return a trapezoid; shoulders may have two infinite corners, and tops in reverse order make a low peak."""
    left, left_top, right_top, right = p
    if left <= left_top and right_top <= right and right_top < left_top < math.inf and right_top > -math.inf:
        return _low_peak(p)
    if left == -math.inf and left_top == -math.inf:
        left_top = min(right_top, 0.0) if right_top == math.inf else right_top
    if right == math.inf and right_top == math.inf:
        right_top = left_top
    return "trapezoid", (left, left_top, right_top, right)


def _low_peak(p: Values) -> Shape:
    """Return min((x - a)/(b - a), (d - x)/(d - c)) for c < b: a triangle that ends where its sides cross, below 1."""
    a, b, c, d = p
    if a >= d or math.isinf(a) or math.isinf(d):
        return "trapezoid", p
    rise, fall = b - a, d - c
    peak = (a * fall + d * rise) / (rise + fall)
    degree = (d - a) / (rise + fall)
    return "piecewise", (a, 0.0, peak, degree, d, 0.0)


#: Membership functions by name: those of MATLAB and, from `rampmf` on, those that fuzzylite adds.
MEMBERSHIP_WORDS: Final[dict[str, ShapeWord]] = {
    "trimf": ShapeWord("triangle", "left peak right"),
    "trapmf": ShapeWord("trapezoid", "left left_top right_top right", read=_trapezoid),
    "gaussmf": ShapeWord("gaussian", "sigma mean", (1, 0), magnitudes=(1,)),
    "gauss2mf": ShapeWord("gaussian2", "sigma1 mean1 sigma2 mean2", (1, 0, 3, 2), magnitudes=(1, 3)),
    "gbellmf": ShapeWord("bell", "width slope center", (2, 0, 1), magnitudes=(1,)),
    "sigmf": ShapeWord("sigmoid", "slope center", (1, 0)),
    "dsigmf": ShapeWord("sigmoid_difference", "slope1 center1 slope2 center2", (1, 0, 2, 3)),
    "psigmf": ShapeWord("sigmoid_product", "slope1 center1 slope2 center2", (1, 0, 2, 3)),
    "zmf": ShapeWord("z_shape", "start end", read=_edge("z_shape", rising=False)),
    "smf": ShapeWord("s_shape", "start end", read=_edge("s_shape", rising=True)),
    "pimf": ShapeWord("pi_shape", "left left_top right_top right"),
    "linsmf": ShapeWord("ramp", "start end", read=_ramp),
    "linzmf": ShapeWord("ramp", "start end", read=_falling_ramp),
    "constant": ShapeWord("constant", "value"),
    "rampmf": ShapeWord("ramp", "start end"),
    "rectmf": ShapeWord("rectangle", "left right"),
    "discretemf": ShapeWord("piecewise", "x1 y1 x2 y2 ..."),
    "concavemf": ShapeWord("concave", "inflection end"),
    "cosinemf": ShapeWord("cosine", "center width"),
    "spikemf": ShapeWord("spike", "center width"),
    "binarymf": ShapeWord("rectangle", "start direction", read=lambda p: _step(p[0], rising=p[1] > p[0])),
    "arcmf": ShapeWord("arc", "start end"),
    "semiellipsemf": ShapeWord("semi_ellipse", "start end"),
}

#: All words for terms.
MEMBERSHIPS: Final[dict[str, ShapeWord]] = {
    **MEMBERSHIP_WORDS,
    "linear": ShapeWord("linear", "coefficients constant"),
    "function": ShapeWord("function", "formula"),
}

#: The words as fuzzylite reads them: it reads some with parameters out of order in another way.
MEMBERSHIPS_OF_FUZZYLITE: Final[dict[str, ShapeWord]] = {
    **MEMBERSHIPS,
    "trapmf": TERM_WORDS["Trapezoid"],
    "smf": TERM_WORDS["SShape"],
    "zmf": TERM_WORDS["ZShape"],
}

#: The words that only fuzzylite writes.
OF_FUZZYLITE: Final = frozenset({"function", *list(MEMBERSHIP_WORDS)[list(MEMBERSHIP_WORDS).index("rampmf") :]})

_WORDS: Final = words_by_kind(MEMBERSHIPS)

#: The words of kinds with two sides: whole, without the left side, without the right side.
_SIDES: Final = {"trapezoid": ("trapmf", "linzmf", "linsmf"), "pi_shape": ("pimf", "zmf", "smf")}


def number(value: float, infinite: str = "Inf") -> str:
    """Return a number as MATLAB reads it; fuzzylite has another word for an infinite one."""
    if math.isinf(value):
        return infinite if value > 0 else f"-{infinite}"
    return number_text(value)


#: A function of a `.fis` file with its parameters.
Written = tuple[str, Values]


def written(kind: str, p: Values, height: float = 1.0, *, fuzzylite: bool) -> Written | None:
    """Return a membership function of a file, or None if no `.fis` file has it.

    Args:
        kind: The kind.
        p: Its parameters.
        height: Its height.
        fuzzylite: Whether the file is for fuzzylite, which has words of its own for some kinds.
    """
    if kind == "piecewise" and height == 1.0 and not fuzzylite:
        kind, p, height = _without_points(p)
    if height != 1.0:
        return _low_triangle(kind, p, height)
    if fuzzylite:
        p = tuple(as_written(kind, p))
    if kind == "ramp":
        return _line(p, fuzzylite=fuzzylite)
    if kind == "singleton":
        return "constant", p
    if kind == "triangle" and any(map(math.isinf, (p[0], p[2]))):
        kind, p = "trapezoid", (p[0], p[1], p[1], p[2])
    if kind == "rectangle" and not fuzzylite:
        left, right = p
        inner = (left if math.isfinite(left) else right, right if math.isfinite(right) else left)
        kind, p = "trapezoid", (left, *inner, right)
    if kind in _SIDES and any(map(math.isinf, (p[0], p[3]))):
        return _shoulder(kind, p, fuzzylite=fuzzylite)
    word = _WORDS.get(kind)
    return (word[0], word[1].parameters(p)) if word is not None else None


def _shoulder(kind: str, p: Values, *, fuzzylite: bool) -> Written:
    """Return a function with one side, or with none."""
    left, left_top, right_top, right = p
    _, falling, rising = _SIDES[kind]
    if math.isinf(left) and math.isinf(right):
        return "trapmf", (-math.inf, -math.inf, math.inf, math.inf)
    function, ends = (falling, (right_top, right)) if math.isinf(left) else (rising, (left, left_top))
    if kind == "pi_shape" or not fuzzylite:
        return function, ends
    if ends[0] == ends[1]:  # fuzzylite has no ramp without width
        return "rectmf", ((ends[0], math.inf) if function == rising else (-math.inf, ends[1]))
    return _line(ends if function == rising else ends[::-1], fuzzylite=True)


def _line(p: Values, *, fuzzylite: bool) -> Written:
    """Return a ramp, for which fuzzylite has one word and MATLAB one for each direction."""
    if fuzzylite:
        return "rampmf", p
    return ("linsmf", p) if p[0] < p[1] else ("linzmf", p[::-1])


def _without_points(p: Values) -> tuple[str, Values, float]:
    """Return points as a triangle, a trapezoid or a shoulder with its height if they are one, else unchanged."""
    points, height = list(zip(p[::2], p[1::2], strict=True)), 1.0
    if len(points) == 3 and points[0][1] == points[2][1] == 0.0 < points[1][1]:
        height = points[1][1]  # a low peak
        points[1] = (points[1][0], 1.0)
    shape = simplest(points)
    return (*shape, height) if shape is not None else ("piecewise", p, 1.0)


def _low_triangle(kind: str, p: Values, height: float) -> Written | None:
    """Return a triangle below 1: a trapezoid with its tops in reverse order, so that its sides cross before."""
    if kind != "triangle" or height == 0.0 or not all(map(math.isfinite, p)):
        return None
    left, peak, right = p
    return "trapmf", (left, left + (peak - left) / height, right - (right - peak) / height, right)
