"""Vocabulary of `.fll` files: terms, norms, activation methods and defuzzifiers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

Values = tuple[float, ...]
Shape = tuple[str, Values]


@dataclass(frozen=True)
class TermWord:
    """A term of fuzzylite whose parameters are numbers, with or without a height behind them.

    Args:
        kind: Its kind in the model.
        form: Names of the parameters in the order of the file.
        shape: Its kind and parameters in the model, for those of the file.
    """

    kind: str
    form: str
    shape: Callable[[Values], Shape]

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.form.split())


def _same(kind: str, form: str) -> TermWord:
    return TermWord(kind, form, lambda p: (kind, p))


def _binary(p: Values) -> Shape:
    """Return a step; the direction may be any number on the side of its 1."""
    start, direction = p
    return "rectangle", ((start, math.inf) if direction > start else (-math.inf, start))


def _trapezoid(p: Values) -> Shape:
    """Return a trapezoid, whose shoulders fuzzylite also writes with two infinite corners."""
    left, left_top, right_top, right = p
    if left == left_top == -math.inf:
        left_top = right_top if math.isfinite(right_top) else 0.0
    if right == right_top == math.inf:
        right_top = left_top
    return "trapezoid", (left, left_top, right_top, right)


#: Terms by name, besides Constant, Linear, Discrete and Function.
TERM_WORDS: Final[dict[str, TermWord]] = {
    "Arc": _same("arc", "start end"),
    "Bell": TermWord("bell", "center width slope", lambda p: ("bell", (p[0], abs(p[1]), p[2]))),
    "Binary": TermWord("rectangle", "start direction", _binary),
    "Concave": _same("concave", "inflection end"),
    "Cosine": _same("cosine", "center width"),
    "Gaussian": TermWord("gaussian", "mean sigma", lambda p: ("gaussian", (p[0], abs(p[1])))),
    "GaussianProduct": TermWord(
        "gaussian2", "mean_a sigma_a mean_b sigma_b", lambda p: ("gaussian2", (p[0], abs(p[1]), p[2], abs(p[3])))
    ),
    "PiShape": _same("pi_shape", "left left_top right_top right"),
    "Ramp": _same("ramp", "start end"),
    "Rectangle": _same("rectangle", "start end"),
    "SemiEllipse": _same("semi_ellipse", "start end"),
    "Sigmoid": _same("sigmoid", "inflection slope"),
    "SigmoidDifference": _same("sigmoid_difference", "left rising falling right"),
    "SigmoidProduct": _same("sigmoid_product", "left rising falling right"),
    "Spike": TermWord("spike", "center width", lambda p: ("spike", (p[0], abs(p[1])))),
    "SShape": _same("s_shape", "start end"),
    "Trapezoid": TermWord("trapezoid", "left left_top right_top right", _trapezoid),
    "Triangle": _same("triangle", "left top right"),
    "ZShape": _same("z_shape", "start end"),
}

#: All names of terms.
TERMS: Final = (*TERM_WORDS, "Constant", "Discrete", "Function", "Linear")

T_NORMS: Final[dict[str, str]] = {
    "Minimum": "min",
    "AlgebraicProduct": "product",
    "BoundedDifference": "bounded_difference",
    "DrasticProduct": "drastic_product",
    "EinsteinProduct": "einstein_product",
    "HamacherProduct": "hamacher_product",
    "NilpotentMinimum": "nilpotent_minimum",
}

S_NORMS: Final[dict[str, str]] = {
    "Maximum": "max",
    "AlgebraicSum": "probabilistic_sum",
    "BoundedSum": "bounded_sum",
    "NormalizedSum": "bounded_sum",  # (a + b) / max(1, a + b) is min(1, a + b)
    "DrasticSum": "drastic_sum",
    "EinsteinSum": "einstein_sum",
    "HamacherSum": "hamacher_sum",
    "NilpotentMaximum": "nilpotent_maximum",
    "UnboundedSum": "sum",
}

#: Defuzzifiers that look at a set, by name.
OF_SETS: Final[dict[str, str]] = {
    "Centroid": "centroid",
    "Bisector": "bisector",
    "SmallestOfMaximum": "som",
    "LargestOfMaximum": "lom",
    "MeanOfMaximum": "mom",
}

#: Defuzzifiers that sum over rules: whether they do not divide.
WEIGHTED: Final[dict[str, bool]] = {"WeightedAverage": False, "WeightedSum": True}

ACTIVATION_WORDS: Final[dict[str, str]] = {
    "General": "general",
    "First": "first",
    "Last": "last",
    "Highest": "highest",
    "Lowest": "lowest",
    "Proportional": "proportional",
    "Threshold": "threshold",
}

#: Words of rules that no variable and no term may be called, besides those that are none in rule files either.
RULE_WORDS: Final = frozenset({"if", "with"})

#: Functions of formulas, which fuzzylite sees in rules too, so that no variable may be called so.
FUNCTION_WORDS: Final = frozenset(
    {
        *("acos", "acosh", "asin", "asinh", "atan", "atanh", "ceil", "cosh", "eq", "fabs", "floor", "fmod", "ge", "gt"),
        *("le", "log10", "log1p", "lt", "neq", "pow", "round", "sinh", "tanh"),
    }
)

#: Hedges, which have the same names here.
HEDGE_WORDS: Final = ("any", "extremely", "not", "seldom", "somewhat", "very")
