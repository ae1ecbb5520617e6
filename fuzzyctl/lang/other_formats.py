"""Files of other tools under the name of a rule file, known by how they begin."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span

#: Each format with the suffix of its files and how they begin. No rule file begins in one of these ways.
_BEGINNINGS: Final[tuple[tuple[str, str, str], ...]] = (
    ("a file of MATLAB or Octave", ".fis", r"\[System\]"),
    ("a fuzzylite file", ".fll", r"Engine[ \t]*:"),
    ("an FCL file", ".fcl", r"FUNCTION_BLOCK\b"),
    ("an FML file", ".fml", r"<\?xml\b|<(?:\w+:)?Fuzzy(?:Controller|System)\b"),
)

#: Empty lines and comments of any of these formats, without a second look at what has been passed.
_BEFORE: Final = re.compile(r"(?:\s|(?:[#%]|//)[^\n]*|\(\*.*?\*\))*+", flags=re.DOTALL)


def other_format(source: SourceText) -> Diagnostic | None:
    """Return the one mistake of a file that is written in the format of another tool; None for any other file."""
    before = _BEFORE.match(source.text)
    at = before.end() if before else 0
    for what, suffix, beginning in _BEGINNINGS:
        first = re.compile(beginning, flags=re.IGNORECASE).match(source.text, at)
        if first is not None:
            span = Span(source, at, first.end())
            repair = f"save it under a name that ends with '{suffix}', by which it is known"
            return Diagnostic("FZ101", f"this is {what}, not a rule file", span, help=repair)
    return None
