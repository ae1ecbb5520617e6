"""Vocabulary of FCL and its dialects, with the names used here."""

from __future__ import annotations

from typing import Final

from fuzzyctl.formats.common.words import DUAL_OF, ShapeWord
from fuzzyctl.formats.fll.shapes import TERM_WORDS

#: Words of jFuzzyLogic, in capitals; it takes them in small letters too.
JFUZZYLOGIC_SHAPES: Final[dict[str, ShapeWord]] = {
    "TRIAN": ShapeWord("triangle", "left peak right"),
    "TRAPE": ShapeWord("trapezoid", "left left_top right_top right"),
    "GAUSS": ShapeWord("gaussian", "mean deviation"),
    "GAUSS2": ShapeWord("gaussian2", "mean deviation mean deviation"),
    "GBELL": ShapeWord("bell", "a b mean", (2, 0, 1)),
    "SIGM": ShapeWord("sigmoid", "gain center", (1, 0)),
    "DSIGM": ShapeWord("sigmoid_difference", "a1 c1 a2 c2", (1, 0, 2, 3)),
    "COSINE": ShapeWord("cosine", "half_width center", (1, 0), doubled=(1,)),
}

#: The words of fuzzylite that messages name first.
_USUAL: Final = ("Triangle", "Trapezoid", "Rectangle", "Ramp", "Gaussian", "GaussianProduct", "Bell", "Sigmoid")

#: Words of fuzzylite, as it writes them.
FUZZYLITE_SHAPES: Final = {n: TERM_WORDS[n] for n in dict.fromkeys((*_USUAL, *TERM_WORDS)) if n != "Binary"}

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
