"""Recognition of block heads whose keyword is missing, by their form and by the next line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.mistakes import FORMS
from fuzzyctl.lang.syntax import NAME, Table

#: What a line without a keyword is: the head of a variable or a table, or a header whose table is missing.
Headless = Literal["variable", "table", "header", ""]

_VARIABLE: Final = re.compile(rf'\s*{NAME}\s+(?:"[^"\n]*"\s*)?in\s*\[')
_CROSS: Final = rf'(?:\s+(?:x|×)\s+{NAME})(?:\s+from\s+"[^"\n]*")?|\s+from\s+"[^"\n]*"'
_TABLE: Final = re.compile(rf"\s*{NAME}(?:\s*,\s*{NAME})*\s*=\s*{NAME}({_CROSS})?\s*")
_BARRED_TERM: Final = re.compile(rf"\s*{NAME}\s*\|\s*(?:{'|'.join(MEMBERSHIP)})\s*\(")
_DECLARES: Final = "input|output|hedge|param|function|let|state|next|der|block|measure|controller|plant|loop"
_NAMELESS: Final = re.compile(rf"\s*(?:input|output)\s+in\s*\[|\s*(?:{_DECLARES})\b(?!\s*{NAME})")
_RANGE: Final = re.compile(r"\bin\s*\[")
_NAMELESS_PARAM: Final = re.compile(rf"\s*param\s*=(?!\s*{NAME}\s*\()")
_CELL: Final = re.compile(r"[^\s=|\"<>:;]+")
_NAMES: Final = re.compile(rf"\s*{NAME}(?:\s+{NAME})*\s*")


def headless(source: SourceText, line: LogicalLine, below: LogicalLine | None) -> Headless:
    """Say which head a line without a keyword is; nothing where it is none.

    Args:
        source: The text.
        line: A line that begins with no keyword.
        below: The next line with code, None at the end.
    """
    text = source.text[line.start : line.end]
    # Settings and other statements of names only are no header.
    following = source.text[below.start : below.end] if below is not None and below.kind != "statement" else ""
    if _VARIABLE.match(text):
        return "variable"
    table = _TABLE.fullmatch(text)
    # `a = b` alone may be a param or a term; above a line of names it is a one-way table.
    if table is not None and (table[1] or _NAMES.fullmatch(following)):
        return "table"
    if _NAMES.fullmatch(text) and below is not None and below.kind == "row":
        return "header"
    return ""


def is_nameless(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line that could not be read, or that looks like a term line, is a declaration without its name."""
    text = source.text[line.start : line.end]
    if line.kind == "term_line":
        # A term may be called `param`, but then a membership function follows.
        return _NAMELESS_PARAM.match(text) is not None
    return _NAMELESS.match(text) is not None


def looks_like_variable(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line that begins with no keyword has a range, as only the head of a variable has."""
    return _RANGE.search(source.text, line.start, line.end) is not None


def looks_like_term(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line with a bar is a term line rather than the row of a table."""
    text = source.text[line.start : line.end]
    return "=" in text or _BARRED_TERM.match(text) is not None


def is_barless_row(source: SourceText, line: LogicalLine, columns: int, labelled: bool) -> bool:
    """Whether a line below the header of a table is a row but for its bar: as many cells as there are columns."""
    words = source.text[line.start : line.end].split()
    if len(words) != columns + labelled or not all(map(_CELL.fullmatch, words)):
        return False
    return "is" not in words and "then" not in words


def describe_barless(source: SourceText, rows: Sequence[LogicalLine], table: object) -> Diagnostic:
    """Return the diagnostic for all rows of a table that lack their bar."""
    first = rows[0]
    text = source.text[first.start : first.end].strip()
    place = Span(source, first.end - len(text), first.end)
    labelled = isinstance(table, Table) and table.second is not None
    first_word, *others = re.split(r"\s+" if "(" in text else r"[\s,;]+", text.rstrip(",;"))
    label, cells = (first_word, " ".join(others)) if labelled and others else ("", " ".join([first_word, *others]))
    more = len(rows) - 1
    facts = (f"and so {'does' if more == 1 else 'do'} {counted(more, 'other row')}",) if more else ()
    return Diagnostic(
        "FZ102", "the row lacks its bar", place, facts=facts, help=f"write '{f'{label} | {cells}'.strip()}'"
    )


def describe_headless(source: SourceText, line: LogicalLine, what: Headless) -> Diagnostic:
    """Return the diagnostic for such a line: the one for its whole block."""
    text = source.text[line.start : line.end]
    start = line.start + len(text) - len(text.lstrip())
    place = Span(source, start, start + len(line.word))
    if what == "header":
        message = "unexpected table header outside of a table"
        return Diagnostic("FZ110", message, Span(source, start, line.end), help=f"the form is: {FORMS['table']}")
    keyword = "input' or 'output" if what == "variable" else "table"
    message = f"a line that declares a {what} begins with '{keyword}', not with '{line.word}'"
    form = FORMS["output" if what == "variable" else "table"]
    return Diagnostic("FZ101", message, place, help=f"put the keyword before it; the form is: {form}")
