"""Common errors of lines that cannot be repaired as a whole, each with its correct form."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.syntax import NAME

#: Characters that have a spelling of their own here.
SPELLINGS: Final = {"≤": "<=", "≥": ">=", "≠": "!=", "−": "-", "–": "-", "—": "-", "·": "*", "⋅": "*", "∞": "inf"}

_DASH: Final = re.compile(r"(?:^|[\s|])[-–—]\s*$")
_CORNER: Final = re.compile(rf"\s*({NAME}\s*[\\/]\s*{NAME})(?:\s*\|)?(?=\s)")

#: What stands in a cell where there is to be no rule.
NO_RULE: Final = "write '.' where there is to be no rule"


def repair(source: SourceText, line: LogicalLine, at: int) -> str:
    """Say what to write where the parser stopped; an empty string where it is no known slip.

    Args:
        source: The text.
        line: The line that cannot be read.
        at: The offset of what was not expected, or the end of the line.
    """
    text = source.text
    if line.kind == "row" and (at == line.end or text[at - 1].isspace()) and _DASH.search(text[line.start : at]):
        return NO_RULE
    if text[at - 1 : at + 1] == "**":
        return "write '^' for a power"
    if line.word == "table" and re.match(r"[x×]\s", text[at : at + 2]):
        return "for a third variable put 'with VARIABLE is TERM' above a table for each of its terms"
    if line.word == "require" and text.startswith("within", at):
        return "write 'within' once, and before 'when'"
    return ""


def corner(source: SourceText, line: LogicalLine) -> tuple[int, int] | None:
    r"""Return where the corner of a table stands that papers print, such as e\de; None where there is none."""
    found = _CORNER.match(source.text, line.start, line.end) if line.kind in ("header", "row") else None
    return found.span(1) if found is not None else None
