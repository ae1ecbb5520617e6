"""Words of rules: norms that belong together, tables read the other way round, and what `any` makes of a condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

#: The norms that belong together by De Morgan's laws: `not (a and b)` is `not a or not b`.
_PAIRS: Final = (
    ("min", "max"),
    ("product", "probabilistic_sum"),
    ("bounded_difference", "bounded_sum"),
    ("drastic_product", "drastic_sum"),
    ("nilpotent_minimum", "nilpotent_maximum"),
    ("einstein_product", "einstein_sum"),
    ("hamacher_product", "hamacher_sum"),
)
DUAL_OF: Final[dict[str, str]] = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}


def first_words(words: Mapping[str, str]) -> dict[str, str]:
    """Return the first word of a file for each name of the model."""
    return {name: word for word, name in reversed(list(words.items()))}


def up_to_any(hedges: Sequence[str], term: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what follows `is` in a condition of fuzzylite, as its hedges and its term, if any.

    `any` is 1 whatever follows it. fuzzylite takes nothing behind it, so that what follows is left out.
    """
    if "any" in hedges:
        return tuple(hedges[: hedges.index("any") + 1]), ()
    return tuple(hedges), (term,)
