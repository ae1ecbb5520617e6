"""Decimal text of bounds, rounded to the safe side."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, Context


def at_most(bound: float, digits: int = 3) -> str:
    """Return a proved bound in a few digits, rounded up where it has more: read back, it is never below the bound.

    Args:
        bound: Not negative.
        digits: Significant ones; at most 15, so that what is printed is what was rounded.
    """
    text = f"{bound:.{digits}g}"
    if not math.isfinite(bound) or float(text) >= bound:
        return text
    return f"{float(Context(prec=digits, rounding=ROUND_CEILING).create_decimal_from_float(bound)):.{digits}g}"
