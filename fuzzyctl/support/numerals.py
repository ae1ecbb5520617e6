"""Strict decimal numbers: ASCII digits, no underscores, and no overflow to infinity."""

from __future__ import annotations

import math
import re
from typing import Final

#: Pattern of a number; Python's `float` also takes underscores and the digits of all scripts.
_NUMBER: Final = re.compile(
    r"[ \t\r\n]*[+-]?((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|inf|infinity|nan)[ \t\r\n]*", re.ASCII | re.IGNORECASE
)

#: The message on a number that no double can hold.
TOO_LARGE: Final = "a double cannot hold this number"


def to_number(text: str) -> float:
    """Read a number; `inf` and `nan` are numbers, a literal that overflows is not.

    Raises:
        OverflowError: For a number that a double cannot hold.
        ValueError: For a text that is not a number.
    """
    if _NUMBER.fullmatch(text) is None:
        raise ValueError(text)
    value = float(text)
    if math.isinf(value) and any(c in "0123456789" for c in text):
        raise OverflowError(TOO_LARGE)
    return value
