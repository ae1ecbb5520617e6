"""Recognition of a line below an output that says what it is where no rule fires, as FCL and others have it."""

from __future__ import annotations

import re
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.syntax import FallbackClause, Variable

_LINE: Final = re.compile(
    r"\s*(else|default|otherwise)\b\s*(?::=|=|:)?\s*([-+]?(?:\d+[.,]?\d*|\.\d+)|hold|midpoint|nan|error|nc)[\s;.]*(?:(?://|%).*)?",
    re.IGNORECASE,
)


def misplaced_else(source: SourceText, line: LogicalLine, above: Any) -> Diagnostic | None:
    """Return the mistake of a line such as `default 5`, with a fix of both lines; None for any other line.

    Args:
        source: The text.
        line: The line.
        above: The statement above it.
    """
    found = _LINE.fullmatch(source.text, line.start, line.end)
    if found is None or not isinstance(above, Variable) or above.keyword.text != "output" or above.value is not None:
        return None
    if any(isinstance(clause, FallbackClause) for clause in above.clauses):
        return None
    value = found[2].lower().replace(",", ".")
    value = "hold" if value == "nc" else value  # FCL: no change
    after = source.text.find("\n", line.end) + 1
    whole = Span(source, line.start, line.end if line.comment or not after else after)
    end = Span(source, above.span.end, above.span.end)
    return Diagnostic(
        "FZ101",
        f"'{found[1]}' begins no statement: what an output is where no rule fires stands in its own line",
        Span(source, *found.span(1)),
        help=f"write: {above.span.text.strip()} else {value}",
        fix=Fix((Replacement(end, f" else {value}"), Replacement(whole, "")), "sure"),
    )
