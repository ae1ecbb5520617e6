"""Vocabulary of `.fis` files: membership functions, methods, and the settings of each dialect."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

Dialect = Literal["matlab", "octave", "fuzzylite"]

Values = tuple[float, ...]

#: A kind of the model with its parameters.
Shape = tuple[str, Values]


@dataclass(frozen=True)
class MembershipWord:
    """A membership function of `.fis` files.

    Args:
        count: Number of its parameters; None for pairs without end.
        shape: Its kind and parameters here, for the parameters in the order of the file.
        places: Where each parameter of the file goes in the model's order, for places in diagnostics.
        form: Names of the parameters in the order of the file.
    """

    count: int | None
    shape: Callable[[Values], Shape]
    form: str


def _plain(kind: str, *order: int) -> Callable[[Values], Shape]:
    """Return a shape whose parameters are those of the file in another order."""
    return lambda p: (kind, tuple(p[i] for i in order))


def _gaussian(p: Values) -> Shape:
    """Return a Gaussian; tuning makes widths negative, and the formula squares them."""
    return "gaussian", (p[1], abs(p[0]))


def _gaussian2(p: Values) -> Shape:
    return "gaussian2", (p[1], abs(p[0]), p[3], abs(p[2]))


def _bell(p: Values) -> Shape:
    """Return a bell; the formula squares (x - center) / width."""
    return "bell", (p[2], abs(p[0]), p[1])


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


def _as_it_is(kind: str) -> Callable[[Values], Shape]:
    return lambda p: (kind, p)


#: Membership functions by name: those of MATLAB and, from `rampmf` on, those that fuzzylite adds.
MEMBERSHIP_WORDS: Final[dict[str, MembershipWord]] = {
    "trimf": MembershipWord(3, _as_it_is("triangle"), "left peak right"),
    "trapmf": MembershipWord(4, _trapezoid, "left left_top right_top right"),
    "gaussmf": MembershipWord(2, _gaussian, "sigma mean"),
    "gauss2mf": MembershipWord(4, _gaussian2, "sigma1 mean1 sigma2 mean2"),
    "gbellmf": MembershipWord(3, _bell, "width slope center"),
    "sigmf": MembershipWord(2, _plain("sigmoid", 1, 0), "slope center"),
    "dsigmf": MembershipWord(4, _plain("sigmoid_difference", 1, 0, 2, 3), "slope1 center1 slope2 center2"),
    "psigmf": MembershipWord(4, _plain("sigmoid_product", 1, 0, 2, 3), "slope1 center1 slope2 center2"),
    "zmf": MembershipWord(2, _edge("z_shape", rising=False), "start end"),
    "smf": MembershipWord(2, _edge("s_shape", rising=True), "start end"),
    "pimf": MembershipWord(4, _as_it_is("pi_shape"), "left left_top right_top right"),
    "linsmf": MembershipWord(2, _ramp, "start end"),
    "linzmf": MembershipWord(2, _falling_ramp, "start end"),
    "constant": MembershipWord(1, _as_it_is("constant"), "value"),
    "rampmf": MembershipWord(2, _as_it_is("ramp"), "start end"),
    "rectmf": MembershipWord(2, _as_it_is("rectangle"), "left right"),
    "discretemf": MembershipWord(None, _as_it_is("piecewise"), "x1 y1 x2 y2 ..."),
    "concavemf": MembershipWord(2, _as_it_is("concave"), "inflection end"),
    "cosinemf": MembershipWord(2, _as_it_is("cosine"), "center width"),
    "spikemf": MembershipWord(2, _as_it_is("spike"), "center width"),
    "binarymf": MembershipWord(2, lambda p: _step(p[0], rising=p[1] > p[0]), "start direction"),
    "arcmf": MembershipWord(2, _as_it_is("arc"), "start end"),
    "semiellipsemf": MembershipWord(2, _as_it_is("semi_ellipse"), "start end"),
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
