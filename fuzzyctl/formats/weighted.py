"""What fuzzylite's weighted defuzzifiers do with an output: that depends on its terms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal

from fuzzyctl.expr import Number
from fuzzyctl.formulas import is_monotone
from fuzzyctl.model.variable import Membership

WeightedType = Literal["Automatic", "TakagiSugeno", "Tsukamoto"]

#: Consequents that are functions of the inputs.
_FUNCTIONS: Final = ("constant", "linear", "function")

#: Terms that may be monotone, but never are to fuzzylite.
_INVERTED_HERE_ONLY: Final = ("piecewise", "gaussian2")

#: The defuzzifiers here for an average and for a sum, by what is taken of each rule.
KINDS: Final[dict[str, tuple[str, str]]] = {
    "function": ("weighted_average", "weighted_sum"),
    "inverse": ("tsukamoto", "tsukamoto_sum"),
    "degree": ("inverse_tsukamoto", "inverse_tsukamoto_sum"),
}


def weighted_kinds(memberships: Iterable[Membership], given: WeightedType) -> set[str]:
    """Return the keys of `KINDS` that some terms stand for; more than one for a mix, which nothing defuzzifies."""
    return {_taken(m, given) for m in memberships}


def _taken(membership: Membership, given: WeightedType) -> str:
    if membership.kind in _FUNCTIONS:
        return "function"
    if given == "TakagiSugeno":
        return "degree"
    if given == "Tsukamoto":
        return "inverse"
    if membership.kind in _INVERTED_HERE_ONLY:
        return "degree"
    parameters = tuple(a.value for a in membership.arguments if isinstance(a, Number))
    return "inverse" if is_monotone(membership.kind, parameters) else "degree"
