"""Words of FCL and its dialects, with their meanings: the reader and the writer use the same tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

from fuzzyctl.formats.common.words import DUAL_OF, ShapeWord, first_words
from fuzzyctl.formats.fll.methods import OF_SETS, S_NORMS, T_NORMS, WEIGHTED
from fuzzyctl.formats.fll.shapes import TERMS

DialectName = Literal["standard", "jfuzzylogic", "fuzzylite"]

#: The numerics of a dialect, unless a comment names others.
USUAL_NUMERICS: Final[dict[DialectName, str]] = {
    "standard": "exact",
    "jfuzzylogic": "jfuzzylogic",
    "fuzzylite": "fuzzylite",
}

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
_USUAL: Final = ("TRIANGLE", "TRAPEZOID", "RECTANGLE", "RAMP", "GAUSSIAN", "GAUSSIANPRODUCT", "BELL", "SIGMOID")

#: All words behind `TERM name :=`, in capitals.
SHAPE_WORDS: Final = tuple(
    dict.fromkeys((*JFUZZYLOGIC_SHAPES, "SINGLETONS", "FUNCTION", *_USUAL, *map(str.upper, TERMS)))
)


def fuzzylite_word(text: str) -> str | None:
    """Return a word of fuzzylite in its spelling, None for another word.

    A word that jFuzzyLogic has, too, is fuzzylite's only in its spelling: `Cosine`, but not `COSINE`.
    """
    if text in TERMS:
        return text
    if text.upper() in JFUZZYLOGIC_SHAPES or text.upper() == "FUNCTION":
        return None
    return next((word for word in TERMS if word.upper() == text.upper()), None)


#: Words for norms by keyword and norm: first the written one, then that of fuzzylite, then others that are read.
_CONJUNCTIONS: Final = {
    "min": "MIN MIN",
    "product": "PROD PROD",
    "bounded_difference": "BDIF BDIF",
    "drastic_product": "DMIN DPROD",
    "nilpotent_minimum": "NIPMIN NMIN",
    "hamacher_product": "HAMACHER HPROD",
    "einstein_product": "EPROD EPROD",
}
_DISJUNCTIONS: Final = {
    "max": "MAX MAX",
    "probabilistic_sum": "ASUM ASUM PROBOR",
    "bounded_sum": "BSUM BSUM NSUM",  # (a + b) / max(1, a + b) is min(1, a + b)
    "drastic_sum": "DMAX DSUM",
    "nilpotent_maximum": "NIPMAX NMAX",
    "hamacher_sum": "HSUM HSUM",
    "einstein_sum": "EINSTEIN ESUM",
}
_ACCUMULATIONS: Final = _DISJUNCTIONS | {
    "probabilistic_sum": "PROBOR ASUM",
    "einstein_sum": "ESUM ESUM EINSTEIN",
    "sum": "SUM UnboundedSum USUM",
}
_NORMS: Final = {"AND": _CONJUNCTIONS, "OR": _DISJUNCTIONS, "ACT": _CONJUNCTIONS, "ACCU": _ACCUMULATIONS}

_METHODS: Final = {
    "centroid": "COG",
    "bisector": "COA BIS",
    "som": "LM SOM",
    "lom": "RM LOM",
    "mom": "MM MOM",
    "weighted_average": "COGS COGF",
    "weighted_sum": "COGSS",
}


def _by_word(rows: Mapping[str, str], long: Mapping[str, str]) -> dict[str, str]:
    """Return the meanings of words in capitals, with the long words of fuzzylite."""
    words = {word.upper(): meaning for meaning, row in rows.items() for word in row.split()}
    return words | {word.upper(): meaning for word, meaning in long.items() if meaning in rows}


#: The meanings of the values of a setting.
MEANINGS: Final[dict[str, dict[str, str]]] = {
    **{word: _by_word(rows, T_NORMS if rows is _CONJUNCTIONS else S_NORMS) for word, rows in _NORMS.items()},
    "METHOD": _by_word(_METHODS, OF_SETS | {w: f"weighted_{'sum' if s else 'average'}" for w, s in WEIGHTED.items()}),
}

#: The written word for a defuzzifier; averages and sums over rules have one for all quantities of a rule.
METHOD_WORDS: Final = {
    **first_words(MEANINGS["METHOD"]),
    **dict.fromkeys(("center_average", "tsukamoto", "inverse_tsukamoto"), "COGS"),
    **dict.fromkeys(("tsukamoto_sum", "inverse_tsukamoto_sum"), "COGSS"),
}


def norm_word(keyword: str, norm: str, dialect: DialectName) -> str:
    """Return the written word for a norm; the first one of its keyword for a norm that FCL does not have."""
    rows = _NORMS[keyword]
    return rows.get(norm, next(iter(rows.values()))).split()[dialect == "fuzzylite"]


#: The norms that jFuzzyLogic pairs: Hamacher's product with Einstein's sum, by no law.
JFUZZYLOGIC_DUAL_OF: Final = DUAL_OF | {"hamacher_product": "einstein_sum", "einstein_sum": "hamacher_product"}

#: Words that only fuzzylite writes, and words that only jFuzzyLogic has.
FUZZYLITE_ONLY: Final = frozenset(
    ("EPROD", "HPROD", "DPROD", "NMIN", "ESUM", "HSUM", "DSUM", "NMAX", "USUM", "COGSS", "BIS", "SOM", "LOM", "MOM")
)
JFUZZYLOGIC_ONLY: Final = frozenset(
    ("DMIN", "DMAX", "NIPMIN", "NIPMAX", "HAMACHER", "EINSTEIN", "PROBOR", "SUM", "COGF")
)
