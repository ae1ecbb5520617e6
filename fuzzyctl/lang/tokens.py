"""Tokens of rule files, blanks and comments among them: one list for all who read a text piece by piece.

The grammar names the tokens of a line by what may stand at their place, see `lang/grammar.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from fuzzyctl.lang.syntax import NAME

#: A number without its sign.
NUMBER: Final = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
#: What may follow a number behind a blank: a unit of time, or a percent sign.
_UNIT: Final = r"[ \t]*(?:%|(?:us|ms|s|min|h)(?!\w))"

#: Kinds of tokens are the names of the groups. A number runs into no letters; what is no token is a character.
TOKEN: Final = re.compile(
    rf'(?P<blank>\n|[ \t\r]+)|(?P<name>{NAME})|(?P<number>{NUMBER}(?:(?![\w.])|(?={_UNIT})))|(?P<text>"[^"\n]*"?)'
    r"|(?P<sign><=|>=|==|!=|[-+*/^()\[\],=<>@|.:×])|(?P<comment>#[^\n]*)|(?P<character>.)",
    re.DOTALL,
)
#: A number with its unit, and two names joined by a point.
QUANTITY: Final = re.compile(NUMBER + _UNIT)
MEMBER: Final = re.compile(rf"{NAME}\.{NAME}")


def is_name(text: str) -> bool:
    """Whether a text is a name."""
    return re.fullmatch(NAME, text) is not None


class Token(NamedTuple):
    """A piece of a text.

    Args:
        kind: "blank", "name", "number", "text" (its second quote may be missing), "sign", "comment" or
            "character", which is no token.
        text: Its characters.
        start: Offset of the first one.
        end: Offset after the last one.
    """

    kind: str
    text: str
    start: int
    end: int


def tokens(text: str, start: int = 0, end: int | None = None) -> Iterator[Token]:
    """Yield the tokens of a part of a text, which together are all of it."""
    for m in TOKEN.finditer(text, start, len(text) if end is None else end):
        yield Token(m.lastgroup or "", m[0], m.start(), m.end())
