"""Identifiers of FCL: letters, digits and underscores, none of them reserved."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.diagnostics.transliterate import in_ascii
from fuzzyctl.formats.fcl.names import (
    ACCUMULATION_WORDS,
    CONJUNCTION_WORDS,
    METHOD_WORDS,
    SHAPE_WORDS,
)
from fuzzyctl.formulas import HEDGES

#: Words that are no names in FCL; jFuzzyLogic takes none of them for one, wherever it stands.
RESERVED: Final = frozenset(
    {
        *("AND", "OR", "NOT", "IF", "THEN", "IS", "WITH", "RULE", "TERM", "RANGE", "METHOD", "ACCU", "ACT", "DEFAULT"),
        *("NC", "NAN", "INF", "INFINITY", "REAL", "LOCK", "ENABLED", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK", "OPTIONS"),
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "FUNCTION_BLOCK", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ABS", "NONE"),
        *("END_VAR", "END_FUZZIFY", "END_DEFUZZIFY", "END_RULEBLOCK", "END_FUNCTION_BLOCK", "END_OPTIONS", "PI"),
        *CONJUNCTION_WORDS,
        *ACCUMULATION_WORDS,
        *METHOD_WORDS,
        *SHAPE_WORDS,
        *(h.upper() for h in HEDGES),
    }
)

_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def spelt(name: str, where: str = "") -> str:
    """Return a name that FCL can hold."""
    if _NAME.fullmatch(name) and name.upper() not in RESERVED:
        return name
    found = re.sub(r"_+", "_", in_ascii(name)).strip("_") or "unnamed"
    if not found[0].isalpha():
        found = f"n_{found}"
    return f"{found}_" if found.upper() in RESERVED else found
