"""Words for norms: those that belong together, and tables read the other way round."""

from __future__ import annotations

from collections.abc import Mapping
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
