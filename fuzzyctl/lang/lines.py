"""Logical lines of a file: the unit of parsing, of error recovery, and of formatting.

A logical line is one line of text, longer while a parenthesis or bracket is open. Since each is parsed on its own,
a broken line costs nothing but itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final, Literal, NamedTuple

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang.syntax import BLOCKS, HEADS, NAME, STATEMENT_KEYWORDS
from fuzzyctl.records import dataclass, record

#: A number without its sign.
NUMBER: Final = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
#: The text that may follow a number after a blank: a unit of time, or a percent sign.
_UNIT: Final = r"[ \t]*(?:%|(?:us|ms|s|min|h)(?!\w))"

#: Kinds of tokens are the names of the groups. A number runs into no letters; any other character is a token.
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
            "character", which is not a token.
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


#: Which start symbol of the grammar a line is parsed with; "unknown" is a mistake, "blank" has no code.
#: "block_statement" is a line of a controller, plant or loop; "label" and "cell" are fields of a CSV file.
LineKind = Literal[
    "statement", "block_statement", "term_line", "header", "row", "label", "cell", "unknown", "blank"
]  # fmt: skip

#: Deepest nesting of parentheses.
MAX_NESTING: Final = 100

# A whole line whose strings are closed and whose parentheses nest no more than once, which nearly all are: its code,
# whether a bar stands outside of parentheses, and its comment.
_CODE = r'[^"#()\[\]|\n]'
_INNER = rf"\({_CODE}*\)"
_SIMPLE = re.compile(rf'((?:{_CODE}+|"[^"\n]*"|\((?:{_CODE}++|{_INNER})*+\)|\[{_CODE}*\]|(\|))*+)(#[^\n]*)?(\n|\Z)')
_WORD = re.compile(rf"\s*({NAME})")
_NAMES = re.compile(rf"\s*{NAME}(?:\s+{NAME})*\s*")
# No row has two bars, so `require |` with a second one is a guarantee.
# `let` is a statement only with a name and what may follow that; variables and terms may be called so. What names a
# number is a param, for which other languages have the word.
_LET = rf"let[ \t]+{NAME}[ \t]*(?:=(?!=)(?=[^#\n]*(?<![\d.])[^\W\d])|\"|(?:in|unit)\b)"
_KEYWORD_LINE = re.compile(rf"\s*(?:(?:{'|'.join(STATEMENT_KEYWORDS)})\b(?!\s*[=|])|require\s*\|[^|]*\||{_LET})")

_BLOCK_LINES = {head: rf"\s*(?:{'|'.join(words)})\b(?!\s*[=|])" for head, words in BLOCKS.items()}

# Patterns of lines that are rare are texts: they are compiled for the first such line.
#: Beginnings of lines whose ranges may be half open: the range of a param, and conditions.
_HALF_OPEN: Final = r"[ \t]*(?:param[ \t]+\w+[ \t]+in\b|(?:let|function|require|measure)\b[^#\n]*\bin\b)"
# Words that inputs and terms are named by as well: a head goes on with a name, and ends or goes on with '=' or a text.
_LIKE_HEAD = rf"\s*({NAME})[ \t]*(?:(?!is\b){NAME}[ \t]*)?(?:$|[\"#]|=[ \t]*(?:tf|zpk|ss|python)\b)"
# The first word of a block behind another one, or behind characters, that do not belong there.
_BEHIND = (
    rf"\s*(?:{NAME}\s+|[^\w\s\"#]+\s*)"
    rf"(?:(table)(?:\s+{NAME})?\s*=|(input|output)\s+(?!(?:in|unit|is)\b){NAME}"
    rf"|({'|'.join(HEADS)})\b(?!\s+is\b)(?:\s+{NAME}\s*)?\s*(?:$|[\"#=]))"
)
_HEADS = rf"(?:plant|loop)\b(?=[ \t]+(?!is\b){NAME}[ \t]*(?:$|[=\"#\n]))"
_FIRST = "|".join(_HEADS if word == "plant" else rf"{word}\b" for word in STATEMENT_KEYWORDS if word != "loop")
# Lines that cannot be the rest of an open parenthesis. A rule may be broken before `and` and `or`. Each part looks at
# one line only: blank lines below an open parenthesis would be read again from each of them.
_NEW_LINE = (
    rf"[^\S\n]*(?:(?!(?:and|or)\b)(?:(?:{_FIRST})(?!\s*[=|])|{_LET})"
    rf"|{NAME}\s*=\s*(?:{'|'.join(MEMBERSHIP)})\s*\(|(?:{NAME}\s*)?\|)"
)
_NEW_BLOCK_LINES = {
    head: rf"[^\S\n]*(?:{_HEADS}|(?:{'|'.join(w for w in words if w not in ('plant', 'loop'))})\b(?!\s*[=|(]))"
    for head, words in BLOCKS.items()
}


@record(frozen=True, slots=True)
class LogicalLine:
    """One logical line.

    Args:
        start: Offset of its first character in the source.
        end: Offset after its code, the trailing comment excluded.
        comment: The trailing comment with its `#`, or an empty string.
        kind: How to parse it.
        word: Its first word, or an empty string.
        mistake: The mistake in its parentheses or strings, from splitting.
        closed: Whether it is a statement that ends with a string, such as a table from a file: no header follows.
        in_block: The first word of the controller, plant or loop that it belongs to; empty for none.
    """

    start: int
    end: int
    comment: str
    kind: LineKind
    word: str
    mistake: Diagnostic | None = None
    closed: bool = False
    in_block: str = ""

    def code(self, source: SourceText) -> str:
        """Return its code, with its indentation and without its comment."""
        return source.text[self.start : self.end]

    def place(self, source: SourceText) -> Span:
        """Return the location of its code without its indentation."""
        return Span(source, self.end - len(self.code(source).lstrip()), self.end)

    def word_place(self, source: SourceText) -> Span:
        """Return the location of its first word."""
        start = self.place(source).start
        return Span(source, start, start + len(self.word))


@dataclass
class _Open:
    """The line being collected."""

    start: int
    end: int
    opened: list[int]
    comment: str = ""
    bar: bool = False
    mistake: Diagnostic | None = None


def split(source: SourceText) -> Iterator[LogicalLine]:
    """Yield the logical lines of a source, blank and comment-only ones included."""
    above: LogicalLine | None = None
    text = source.text
    at: int | None = 0
    while at is not None:
        simple = _SIMPLE.match(text, at)
        if simple is not None:
            end = at + len(simple[1].rstrip())
            comment = "" if simple[3] is None else simple[3].rstrip()
            current = _Open(at, end, [], comment, simple[2] is not None)
            at = simple.end() if simple[4] else None
        else:
            current, at = _collect(source, at, in_block=above.in_block if above is not None else "")
        line = _close(source, current, above)
        above = above if line.kind == "blank" else line
        yield line


def _collect(source: SourceText, start: int, *, in_block: str) -> tuple[_Open, int | None]:
    """Return the line that begins at an offset, piece by piece, and where the next one begins, None for the last."""
    current, text = _Open(start, start, []), source.text
    for token in tokens(text, start):
        if token.text != "\n":
            _take(source, current, token.text, token.start, in_block=in_block)
        elif not current.opened or _resumes(text, token.end, in_block=in_block):
            return current, token.end
    return current, None


def _resumes(text: str, at: int, *, in_block: str) -> bool:
    """Whether the line that begins here cannot be the rest of an open parenthesis."""
    pattern = _NEW_BLOCK_LINES[in_block] if in_block else _NEW_LINE
    return re.compile(pattern).match(text, at) is not None


def _take(source: SourceText, current: _Open, piece: str, at: int, *, in_block: str) -> None:
    if piece.startswith("#"):
        # A comment inside parentheses is part of the code's extent; only one at the end stands apart.
        if current.opened:
            current.end = at + len(piece.rstrip())
        else:
            current.comment = piece.rstrip()
        return
    if not piece.isspace():
        current.end = at + len(piece.rstrip())
    if piece in "([":
        current.opened.append(at)
        if len(current.opened) > MAX_NESTING and current.mistake is None:
            current.mistake = Diagnostic(
                "FZ106",
                f"parentheses nest deeper than {MAX_NESTING} levels",
                Span(source, at, at + 1),
                help="give parts a name with 'let', or with 'param' where no input is read",
            )
    elif piece in ")]":
        half_open = bool(in_block) or re.compile(_HALF_OPEN).match(source.text, current.start) is not None
        _shut(source, current, piece, at, half_open=half_open)
    elif piece == "|":
        current.bar = True
    elif piece.startswith('"') and (len(piece) == 1 or not piece.endswith('"')):
        current.mistake = current.mistake or Diagnostic(
            "FZ104",
            "the string is not closed",
            Span(source, at, current.end),
            help='end it with a double quote (") on the same line',
        )


def _shut(source: SourceText, current: _Open, piece: str, at: int, *, half_open: bool) -> None:
    place = Span(source, at, at + 1)
    if not current.opened:
        current.mistake = current.mistake or Diagnostic(
            "FZ103", f"'{piece}' has no opening bracket", place, help="remove it"
        )
        return
    opening = source.text[current.opened.pop()]
    if (opening, piece) not in {("(", ")"), ("[", "]")} and not half_open:
        right = ")" if opening == "(" else "]"
        current.mistake = current.mistake or Diagnostic(
            "FZ103", f"'{opening}' is closed by '{piece}'", place, help=f"write '{right}'"
        )


def _close(source: SourceText, current: _Open, above: LogicalLine | None) -> LogicalLine:
    mistake = current.mistake
    if current.opened and mistake is None:
        at = current.opened[-1]
        mistake = Diagnostic(
            "FZ103", f"'{source.text[at]}' is not closed", Span(source, at, at + 1), help="close it on this line"
        )
    code = source.text[current.start : current.end]
    word = _WORD.match(code)
    first = word[1] if word else ""
    begins = word is not None and bool(_KEYWORD_LINE.match(code)) and not _is_header(code, above)
    in_block = above.in_block if above is not None else ""
    if begins and first in ("system", *HEADS):
        in_block = "" if first == "system" else first
    kind = _block_kind(code, in_block) if in_block else _kind(code, current.bar, above)
    if kind == "unknown":
        in_block = meant_head(code, in_block) or in_block
    return LogicalLine(current.start, current.end, current.comment, kind, first, mistake, code.endswith('"'), in_block)


def meant_head(code: str, in_block: str) -> str | None:
    """Return which head of a block a line that begins no statement most likely is: half typed, misspelt, behind a slip.

    In a system, where short names begin lines of tables, a word of two letters does not begin a statement.
    """
    behind = re.match(_BEHIND, code)
    if behind is not None and behind[3]:
        return behind[3]
    match = re.match(_LIKE_HEAD, code)
    if match is None or len(match[1]) < (2 if in_block else 4):
        return None
    meant = half_typed(match[1], (*HEADS, *BLOCKS.get(in_block, STATEMENT_KEYWORDS)))
    return meant if meant in HEADS else None


def keyword_behind(code: str) -> str | None:
    """Return the first word of a block behind another word, or behind characters, at the beginning of a line."""
    match = re.match(_BEHIND, code)
    return None if match is None else match[match.lastindex or 1]


def half_typed(word: str, keywords: Sequence[str]) -> str | None:
    """Return the keyword that a word most likely is the beginning of, or means."""
    typed = next((keyword for keyword in keywords if keyword.startswith(word)), None)
    return typed or (closest(word, keywords) if len(word) > 3 else None)


def _block_kind(code: str, head: str) -> LineKind:
    if not code or code.isspace():
        return "blank"
    return "block_statement" if re.match(_BLOCK_LINES[head], code) else "unknown"


def _follows_table(above: LogicalLine | None) -> bool:
    return above is not None and above.kind == "statement" and above.word == "table" and not above.closed


def _is_header(code: str, above: LogicalLine | None) -> bool:
    """Whether a line is the header of the table above: terms may be named like keywords."""
    return _follows_table(above) and _NAMES.fullmatch(code) is not None


def _kind(code: str, bar: bool, above: LogicalLine | None) -> LineKind:
    if not code or code.isspace():
        return "blank"
    if _is_header(code, above):
        return "header"
    if _KEYWORD_LINE.match(code):
        return "statement"
    if bar:
        return "row"
    if re.match(rf"\s*{NAME}\s*=", code):
        return "term_line"
    return "header" if _follows_table(above) else "unknown"
