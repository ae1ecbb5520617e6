"""Words of FML with their names here, both ways; the writer takes the first word of a table for each meaning."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

from fuzzyctl.expr import Call, Expr, Name
from fuzzyctl.model.block import Hedge

#: Methods for AND and for activation; the schema calls two of them as their conorms.
CONJUNCTION_WORDS: Final[dict[str, str]] = {
    "MIN": "min",
    "PROD": "product",
    "BDIF": "bounded_difference",
    "BSUM": "bounded_difference",
    "DRP": "drastic_product",
    "DRS": "drastic_product",
    "EPROD": "einstein_product",
    "HPROD": "hamacher_product",
    "NILMIN": "nilpotent_minimum",
}

#: Methods for OR, and all but one for accumulation.
DISJUNCTION_WORDS: Final[dict[str, str]] = {
    "MAX": "max",
    "PROBOR": "probabilistic_sum",
    "BSUM": "bounded_sum",
    "DRS": "drastic_sum",
    "ESUM": "einstein_sum",
    "HSUM": "hamacher_sum",
    "NILMAX": "nilpotent_maximum",
}


class Norms(NamedTuple):
    """The methods of a connector, the default one, and the attribute of a definition that names one."""

    words: Mapping[str, str]
    default: str
    attribute: str


NORMS: Final = {
    "and": Norms(CONJUNCTION_WORDS, "min", "t-norm"),
    "or": Norms(DISJUNCTION_WORDS, "max", "t-conorm"),
}

#: Methods for accumulation; drafts have the plain sum, too.
ACCUMULATION_WORDS: Final = {**DISJUNCTION_WORDS, "SUM": "sum"}

#: Defuzzifiers; older files have MM, as FCL does.
DEFUZZIFIER_WORDS: Final[dict[str, str]] = {
    "COG": "centroid",
    "COA": "bisector",
    "LM": "som",
    "RM": "lom",
    "MOM": "mom",
    "MM": "mom",
}

#: Modifiers with their hedges. `above` and `below` are sets derived from the term, `norm` changes only sets below 1.
#: The standard's `extremely` is the cube; elsewhere the hedge `extremely` is `intensify`.
MODIFIERS: Final[dict[str, str]] = {
    "above": "above",
    "any": "any",
    "below": "below",
    "extremely": "extremely",
    "intensify": "intensify",
    "more_or_less": "slightly",
    "norm": "norm",
    "not": "not",
    "plus": "plus",
    "seldom": "seldom",
    "slightly": "slightly_1855",
    "somewhat": "somewhat",
    "very": "very",
}

#: Modifiers that are defined by the largest degree of a term, and available only if that is 1.
NEED_ONE: Final = ("norm", "slightly")

#: Of a set that has every degree, the largest degree of `plus` and not `very`: of min(d^(5/4), 1 - d²).
_SLIGHTLY_PEAK: Final = 0.580790459486683


def _contrast(x: Expr) -> Expr:
    """Return 2x² up to 1/2 and 1 - 2(1 - x)² above, as 1/2 + 2u - 2u|u| with u = x - 1/2."""
    u = x - 0.5
    doubled = 2.0 * u
    return 0.5 + doubled - doubled * Call("abs", (u,))


_X: Final = Name("x")
_PLUS: Final = _X**1.25
_SLIGHTLY: Final = _contrast(Call("min", (_PLUS, 1.0 - _X**2.0)) / _SLIGHTLY_PEAK)

#: Hedges that a system with these modifiers defines: x^(5/4); `intensify` beside the standard's `extremely`; and plus
#: and not very, scaled to reach 1 and intensified.
HEDGES: Final[dict[str, Hedge]] = {
    name: Hedge(name=name, parameter="x", expression=expression)
    for name, expression in (("plus", _PLUS), ("intensify", _contrast(_X)), ("slightly_1855", _SLIGHTLY))
}


def word_for(words: Mapping[str, str], meaning: str) -> str:
    """Return the first word with a meaning; by default the first word of the table."""
    return next((word for word, value in words.items() if value == meaning), next(iter(words)))


def modifier_of(name: str, hedge: Hedge | None) -> str:
    """Return the modifier of a hedge, which a system defines or which is built in (None); empty if FML has none."""
    if hedge is not None:
        name = next((n for n, h in HEDGES.items() if h.expression == hedge.expression), "")
    return next((word for word, value in MODIFIERS.items() if value == name), "")
