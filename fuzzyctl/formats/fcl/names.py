"""Vocabulary of FCL and its dialects, with the names used here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common.words import DUAL_OF

Arguments = tuple[Expr, ...]


@dataclass(frozen=True)
class ShapeWord:
    """What a word behind `TERM name :=` stands for.

    Args:
        kind: The membership function.
        parameters: What its parameters are called in the order of the file.
        ordered: Brings them into the order of `formulas.MEMBERSHIP`.
        height: Whether a further parameter may give the height, as in fuzzylite.
    """

    kind: str
    parameters: tuple[str, ...]
    ordered: Callable[[Arguments], Arguments] = lambda a: a
    height: bool = False


def doubled(expr: Expr) -> Expr:
    """Return twice a number."""
    return Number(2.0 * expr.value, "", expr.span) if isinstance(expr, Number) else 2.0 * expr


#: Words of jFuzzyLogic, in capitals; it takes them in small letters too.
JFUZZYLOGIC_SHAPES: Final[dict[str, ShapeWord]] = {
    "TRIAN": ShapeWord("triangle", ("left", "peak", "right")),
    "TRAPE": ShapeWord("trapezoid", ("left", "left top", "right top", "right")),
    "GAUSS": ShapeWord("gaussian", ("mean", "deviation")),
    "GAUSS2": ShapeWord("gaussian2", ("mean", "deviation", "mean", "deviation")),
    "GBELL": ShapeWord("bell", ("a", "b", "mean"), lambda a: (a[2], a[0], a[1])),
    "SIGM": ShapeWord("sigmoid", ("gain", "center"), lambda a: (a[1], a[0])),
    "DSIGM": ShapeWord("sigmoid_difference", ("a1", "c1", "a2", "c2"), lambda a: (a[1], a[0], a[2], a[3])),
    "COSINE": ShapeWord("cosine", ("half the width", "center"), lambda a: (a[1], doubled(a[0]))),
}


def _fuzzylite(kind: str, *parameters: str) -> ShapeWord:
    return ShapeWord(kind, parameters, height=True)


_FEET: Final = ("left", "left top", "right top", "right")

#: Words of fuzzylite, as it writes them.
FUZZYLITE_SHAPES: Final[dict[str, ShapeWord]] = {
    "Triangle": _fuzzylite("triangle", "left", "peak", "right"),
    "Trapezoid": _fuzzylite("trapezoid", *_FEET),
    "Rectangle": _fuzzylite("rectangle", "start", "end"),
    "Ramp": _fuzzylite("ramp", "start", "end"),
    "Gaussian": _fuzzylite("gaussian", "mean", "deviation"),
    "GaussianProduct": _fuzzylite("gaussian2", "mean", "deviation", "mean", "deviation"),
    "Bell": _fuzzylite("bell", "center", "width", "slope"),
    "Sigmoid": _fuzzylite("sigmoid", "inflection", "slope"),
    "SigmoidDifference": _fuzzylite("sigmoid_difference", "left", "rising", "falling", "right"),
    "SigmoidProduct": _fuzzylite("sigmoid_product", "left", "rising", "falling", "right"),
    "SShape": _fuzzylite("s_shape", "start", "end"),
    "ZShape": _fuzzylite("z_shape", "start", "end"),
    "PiShape": _fuzzylite("pi_shape", *_FEET),
    "Cosine": _fuzzylite("cosine", "center", "width"),
    "Spike": _fuzzylite("spike", "center", "width"),
    "Concave": _fuzzylite("concave", "inflection", "end"),
    "Arc": _fuzzylite("arc", "start", "end"),
    "SemiEllipse": _fuzzylite("semi_ellipse", "start", "end"),
}

#: Words of fuzzylite with a meaning of their own.
_SPECIAL: Final = ("Binary", "Discrete", "Constant", "Linear", "Function")

#: All words that may stand behind `TERM name :=`, in capitals.
SHAPE_WORDS: Final[tuple[str, ...]] = tuple(
    dict.fromkeys((*JFUZZYLOGIC_SHAPES, "SINGLETONS", "FUNCTION", *(w.upper() for w in (*FUZZYLITE_SHAPES, *_SPECIAL))))
)


def fuzzylite_word(text: str) -> str | None:
    """Return a word of fuzzylite as it is spelt there, None for another word.

    What jFuzzyLogic has too is fuzzylite's only if it is spelt so: `Cosine`, but not `COSINE`.
    """
    known = (*FUZZYLITE_SHAPES, *_SPECIAL)
    if text in known:
        return text
    if text.upper() in JFUZZYLOGIC_SHAPES or text.upper() == "FUNCTION":
        return None
    return next((w for w in known if w.upper() == text.upper()), None)


#: What AND and ACT may be.
CONJUNCTION_WORDS: Final[dict[str, str]] = {
    "MIN": "min",
    "PROD": "product",
    "BDIF": "bounded_difference",
    "DMIN": "drastic_product",
    "DPROD": "drastic_product",
    "NIPMIN": "nilpotent_minimum",
    "NMIN": "nilpotent_minimum",
    "HAMACHER": "hamacher_product",
    "HPROD": "hamacher_product",
    "EPROD": "einstein_product",
    "MINIMUM": "min",
    "ALGEBRAICPRODUCT": "product",
    "BOUNDEDDIFFERENCE": "bounded_difference",
    "DRASTICPRODUCT": "drastic_product",
    "EINSTEINPRODUCT": "einstein_product",
    "HAMACHERPRODUCT": "hamacher_product",
    "NILPOTENTMINIMUM": "nilpotent_minimum",
}

#: What OR may be.
DISJUNCTION_WORDS: Final[dict[str, str]] = {
    "MAX": "max",
    "ASUM": "probabilistic_sum",
    "PROBOR": "probabilistic_sum",
    "BSUM": "bounded_sum",
    "DMAX": "drastic_sum",
    "DSUM": "drastic_sum",
    "NIPMAX": "nilpotent_maximum",
    "NMAX": "nilpotent_maximum",
    "HSUM": "hamacher_sum",
    "ESUM": "einstein_sum",
    "EINSTEIN": "einstein_sum",
    "MAXIMUM": "max",
    "ALGEBRAICSUM": "probabilistic_sum",
    "BOUNDEDSUM": "bounded_sum",
    "NSUM": "bounded_sum",  # (a + b) / max(1, a + b) is min(1, a + b)
    "NORMALIZEDSUM": "bounded_sum",
    "DRASTICSUM": "drastic_sum",
    "EINSTEINSUM": "einstein_sum",
    "HAMACHERSUM": "hamacher_sum",
    "NILPOTENTMAXIMUM": "nilpotent_maximum",
}

#: What ACCU may be.
ACCUMULATION_WORDS: Final[dict[str, str]] = {
    **DISJUNCTION_WORDS,
    "SUM": "sum",
    "USUM": "sum",
    "UNBOUNDEDSUM": "sum",
}

#: What METHOD may be.
METHOD_WORDS: Final[dict[str, str]] = {
    "COG": "centroid",
    "CENTROID": "centroid",
    "COA": "bisector",
    "BIS": "bisector",
    "BISECTOR": "bisector",
    "LM": "som",
    "SOM": "som",
    "SMALLESTOFMAXIMUM": "som",
    "RM": "lom",
    "LOM": "lom",
    "LARGESTOFMAXIMUM": "lom",
    "MM": "mom",
    "MOM": "mom",
    "MEANOFMAXIMUM": "mom",
    "COGS": "weighted_average",
    "COGF": "weighted_average",
    "WEIGHTEDAVERAGE": "weighted_average",
    "COGSS": "weighted_sum",
    "WEIGHTEDSUM": "weighted_sum",
}

#: The norms that belong together as jFuzzyLogic has them: Hamacher's product with Einstein's sum, by no law.
JFUZZYLOGIC_DUAL_OF: Final = DUAL_OF | {"hamacher_product": "einstein_sum", "einstein_sum": "hamacher_product"}

#: Words that only fuzzylite writes.
FUZZYLITE_ONLY: Final = frozenset(
    {"EPROD", "HPROD", "DPROD", "NMIN", "ESUM", "HSUM", "DSUM", "NMAX", "USUM", "COGSS", "BIS", "SOM", "LOM", "MOM"}
)

#: Words that only jFuzzyLogic has.
JFUZZYLOGIC_ONLY: Final = frozenset(
    {"DMIN", "DMAX", "NIPMIN", "NIPMAX", "HAMACHER", "EINSTEIN", "PROBOR", "SUM", "COGF"}
)
