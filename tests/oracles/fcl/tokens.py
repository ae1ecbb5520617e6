"""Tokens of FCL: names, numbers and symbols, without comments."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span

Kind = Literal["name", "number", "symbol", "end"]

#: What one token is. A number stops before `..`, and a name may have dots inside, as those of fuzzylite do.
_TOKEN: Final = re.compile(
    r"""(?P<blank>[\s\ufeff\u200b]+)
    | (?P<number>(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
    | (?P<name>[^\W\d]\w*(?:\.(?!\.)\w+)*)
    | (?P<symbol>:=|\.\.+|[:;,()+\-*/^%|=])
    """,
    re.VERBOSE,
)

#: How comments begin and end; None for the end of the line. `{...}` is a pragma.
_COMMENTS: Final[tuple[tuple[str, str | None], ...]] = (
    ("(*", "*)"),
    ("/*", "*/"),
    ("//", None),
    ("#", None),
    ("{", "}"),
)

#: Most runs of meaningless characters reported one by one.
_MOST_BAD: Final = 100

_OPENINGS: Final = frozenset(opening[0] for opening, _ in _COMMENTS)


@dataclass(frozen=True, slots=True)
class Token:
    """A token with its place.

    Args:
        kind: What it is; `end` stands after the last one.
        text: Its characters.
        start: Offset of the first character.
        end: Offset behind the last one.
        first: Whether it is the first on its line.
    """

    kind: Kind
    text: str
    start: int
    end: int
    first: bool = False

    @property
    def word(self) -> str:
        """A name in capitals, for keywords; an empty text for any other token."""
        return self.text.upper() if self.kind == "name" else ""


@dataclass(frozen=True)
class Tokens:
    """The tokens of a source.

    Args:
        tokens: In order, an `end` last.
        comments: The texts of all comments, their marks included.
        diagnostics: Comments that do not end, and characters that FCL does not have.
    """

    tokens: tuple[Token, ...]
    comments: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


def tokenize(source: SourceText) -> Tokens:
    """Return the tokens of a source."""
    text, at, first = source.text, 0, True
    tokens: list[Token] = []
    comments: list[str] = []
    diagnostics: list[Diagnostic] = []
    while at < len(text):
        comment = _comment_at(source, at, diagnostics) if text[at] in _OPENINGS else None
        if comment is not None:
            comments.append(text[at:comment])
            first, at = first or "\n" in text[at:comment], comment
            continue
        match = _TOKEN.match(text, at)
        if match is None:
            at = _bad(source, at, diagnostics)
        elif match.lastgroup == "blank":
            first, at = first or "\n" in match.group(), match.end()
        else:
            tokens.append(Token(_kind(match.lastgroup), match.group(), at, match.end(), first))
            first, at = False, match.end()
    tokens.append(Token("end", "", len(text), len(text), True))
    return Tokens(tuple(tokens), tuple(comments), tuple(diagnostics))


def _kind(group: str | None) -> Kind:
    return "name" if group == "name" else "number" if group == "number" else "symbol"


def _comment_at(source: SourceText, at: int, diagnostics: list[Diagnostic]) -> int | None:
    """Return where a comment that begins here ends, None where none begins."""
    text = source.text
    for opening, closing in _COMMENTS:
        if not text.startswith(opening, at):
            continue
        end = text.find(closing if closing is not None else "\n", at + len(opening))
        if end >= 0:
            return end + (len(closing) if closing is not None else 0)
        if closing is not None:
            message = f"the comment that begins here with '{opening}' does not end"
            span = Span(source, at, at + len(opening))
            diagnostics.append(Diagnostic("FZ601", message, span, help=f"write '{closing}' where it ends"))
        return len(text)
    return None


def _bad(source: SourceText, at: int, diagnostics: list[Diagnostic]) -> int:
    """Report characters that FCL does not have, a run of them once, and return where they end."""
    end = at + 1
    while end < len(source.text) and source.text[end] == source.text[at]:
        end += 1
    if len(diagnostics) > _MOST_BAD:
        return end
    if len(diagnostics) == _MOST_BAD:
        message = "there are more characters that have no meaning in FCL"
        diagnostics.append(Diagnostic("FZ601", message, Span(source, at, end), help="is this an FCL file?"))
        return end
    char = source.text[at]
    shown = f"'{char}' (U+{ord(char):04X})" if char.isprintable() else f"U+{ord(char):04X}"
    message = f"the character {shown} has no meaning in FCL"
    diagnostics.append(Diagnostic("FZ601", message, Span(source, at, end), help="remove it"))
    return end
