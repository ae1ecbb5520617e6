"""Writer of terms as `Triangle 0 1 2`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from fuzzyctl.expr import number_text
from fuzzyctl.formats.common.shape_words import words_by_kind
from fuzzyctl.formats.fll.vocabulary import TERM_WORDS
from fuzzyctl.formats.fuzzylite.discontinuities import as_written

#: Terms by kind of the model; a rectangle that never ends is fuzzylite's Binary.
_NAMES: Final[dict[str, str]] = {
    **{kind: name for kind, (name, _) in words_by_kind(TERM_WORDS).items()},
    "rectangle": "Rectangle",
    "piecewise": "Discrete",
    "singleton": "Constant",
    "constant": "Constant",
    "linear": "Linear",
}


def written(kind: str, parameters: Sequence[float], height: float, *, python: bool = False) -> str | None:
    """Return a term as a file for fuzzylite, or pyfuzzylite, has it; None for a kind that it does not have."""
    name = _NAMES.get(kind)
    if name is None:
        return None
    shown = list(as_written(kind, parameters, python=python))
    if kind == "rectangle" and any(map(math.isinf, shown)):
        left, right = shown
        name, shown = "Binary", ([left, math.inf] if math.isfinite(left) else [right, -math.inf])
    if height != 1:
        shown.append(height)
    return " ".join([name, *map(number_text, shown)])
