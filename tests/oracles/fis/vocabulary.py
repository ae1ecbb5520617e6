"""Vocabulary of `.fis` files: membership functions, methods, and the settings of each dialect."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, Literal

from fuzzyctl.formats.common.words import Shape, ShapeWord, Values

Dialect = Literal["matlab", "octave", "fuzzylite"]


def _step(at: float, *, rising: bool) -> Shape:
    return "rectangle", ((at, math.inf) if rising else (-math.inf, at))


def _edge(kind: str, *, rising: bool) -> Callable[[Values], Shape]:
    """Return an edge from the first to the second parameter; where they are out of order it is a step between them."""
    return lambda p: (kind, p) if p[0] < p[1] else _step((p[0] + p[1]) / 2, rising=rising)


def _ramp(p: Values) -> Shape:
    return ("ramp", p) if p[0] != p[1] else _step(p[0], rising=True)


def _falling_ramp(p: Values) -> Shape:
    return ("ramp", (p[1], p[0])) if p[0] != p[1] else _step(p[0], rising=False)


def _trapezoid(p: Values) -> Shape:
    """Return a trapezoid; shoulders may be written with two infinite corners, and tops in reverse make a low peak."""
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

#: Those that only fuzzylite writes.
OF_FUZZYLITE: Final = frozenset({"function", *list(MEMBERSHIP_WORDS)[list(MEMBERSHIP_WORDS).index("rampmf") :]})

#: Triangular norms for `and` and implication.
CONJUNCTION_WORDS: Final[dict[str, str]] = {
    "min": "min",
    "prod": "product",
    "product": "product",
    "bounded_difference": "bounded_difference",
    "drastic_product": "drastic_product",
    "einstein_product": "einstein_product",
    "hamacher_product": "hamacher_product",
    "nilpotent_minimum": "nilpotent_minimum",
}

#: Triangular conorms for `or`.
DISJUNCTION_WORDS: Final[dict[str, str]] = {
    "max": "max",
    "probor": "probabilistic_sum",
    "algebraic_sum": "probabilistic_sum",
    "bounded_sum": "bounded_sum",
    "normalized_sum": "bounded_sum",  # (a + b) / max(1, a + b) is min(1, a + b)
    "drastic_sum": "drastic_sum",
    "einstein_sum": "einstein_sum",
    "hamacher_sum": "hamacher_sum",
    "nilpotent_maximum": "nilpotent_maximum",
}

AGGREGATION_WORDS: Final[dict[str, str]] = {**DISJUNCTION_WORDS, "sum": "sum"}

#: Words that only Octave's toolkit and fuzzylite have, each in its own way.
BEYOND_MATLAB: Final = frozenset({*CONJUNCTION_WORDS, *DISJUNCTION_WORDS} - {"min", "prod", "max", "probor"})

DEFUZZIFIER_WORDS: Final[dict[str, str]] = {
    "centroid": "centroid",
    "centroid_integral": "centroid",
    "bisector": "bisector",
    "mom": "mom",
    "som": "som",
    "lom": "lom",
    "wtaver": "weighted_average",
    "wtsum": "weighted_sum",
}
