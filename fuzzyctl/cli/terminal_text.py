"""Reports of commands on a terminal: in the colours of diagnostics, at its width."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.diagnostics.diagnostic import paint, wrapped
from fuzzyctl.diagnostics.terminal import printable, spelt

#: Words behind which a claim, its reason or nothing follows, with their styles.
TONES: Final = {
    **dict.fromkeys(("proved", "met"), "green"),
    **dict.fromkeys(("refuted", "not met", "problem", "missing"), "red"),
    **dict.fromkeys(("undecided", "stopped", "not installed"), "yellow"),
}
_WORD: Final = re.compile(rf"(?:(?<=: )|^)({'|'.join(TONES)})(?=:|;|$|  \()")
#: The subject of a line: a name with its value, or the text before a colon.
_SUBJECT: Final = re.compile(r"^(?! )(?:\S+(?= = )|(?!(?:problem|proved|met)\b).+?(?=: ))")
#: Columns by which a wrapped line is farther from the left than its first one.
_FARTHER: Final = 4


def painted(text: str, *, color: bool, width: int | None, encoding: str | None) -> str:
    """Return a report as a terminal shows it; see `fuzzyctl.diagnostics.diagnostic.render`."""
    lines = [spelt(printable(line), encoding) for line in text.split("\n")]
    return "\n".join(_shown(line, color=color, width=width) for line in lines)


def _shown(line: str, *, color: bool, width: int | None) -> str:
    """Return a line as a terminal shows it."""
    indent = len(line) - len(line.lstrip(" ")) + _FARTHER
    head, *others = wrapped(line, width, first=0, indent=indent)
    rows = [head, *(" " * indent + other.lstrip(" ") for other in others)]
    if not color:
        return "\n".join(rows)
    rows[0] = _SUBJECT.sub(lambda match: paint(match[0], "bold"), rows[0])
    return "\n".join(_WORD.sub(lambda match: paint(match[0], TONES[match[0]]), row) for row in rows)
