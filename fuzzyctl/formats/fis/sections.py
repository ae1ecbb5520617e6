"""Sections of a `.fis` file: lines `key=value` with strings, counts, vectors and membership functions as values."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of
from fuzzyctl.formats.common.report import Findings, ParseError
from fuzzyctl.support.files import TOO_LARGE

#: Closing quotes by their opening ones; word processors make the curly ones.
_QUOTES: Final = {"'": "'", '"': '"', "\u2018": "\u2019", "\u201c": "\u201d"}

_HEADER: Final = re.compile(r"\[ *([A-Za-z_]+?) *([0-9]*) *\]")

#: Names of sections in small letters.
_KINDS: Final = ("system", "input", "output", "rules")

#: A string, the quote of one that is never closed, or a mark that begins a comment.
_PIECE: Final = re.compile(
    rf"(?<![^\W_])(?:{'|'.join(f'{a}[^{b}]*{b}' for a, b in _QUOTES.items())}|(?P<open>[{''.join(_QUOTES)}]))"
    r"|(?P<mark>[%#])"
)

#: The mark of a comment behind a quote that is never closed.
_MARK: Final = re.compile(r"[ \t]%| #")

#: The key of a membership function: its number, and U or L of interval type-2 sets.
NUMBERED: Final = re.compile(r"mf *([0-9]{1,6}) *([ul]?)$", re.IGNORECASE)

_COUNT: Final = re.compile(r"(\d{1,9})(?:\.0*)? *[;,]?$", re.ASCII)

#: The values with which a switch of fuzzylite is on.
_ON: Final = re.compile(r"(?:1(?:\.0*)?|true)$", re.IGNORECASE)


@dataclass(frozen=True)
class Text:
    """A string with its place, quotes left out."""

    text: str
    span: Span


@dataclass(frozen=True)
class Entry:
    """A line `key = value`; in the section of rules a whole line, with an empty key."""

    key: str
    value: Span
    span: Span

    @property
    def key_span(self) -> Span:
        """The place of the key."""
        return Span(self.span.source, self.span.start, self.span.start + len(self.key))

    @property
    def string(self) -> Text:
        """The value without its quotes, which are optional; a doubled quote stands for one."""
        string, rest = _leading_string(self.value, ends="")
        return Text(self.value.text, self.value) if rest.text.strip(";, ") else string

    @property
    def is_on(self) -> bool:
        """Whether a switch of fuzzylite is on."""
        return _ON.match(self.string.text) is not None

    def count(self, findings: Findings) -> int | None:
        """Return a whole number of 0 or more; report anything else."""
        match = _COUNT.match(self.value.text)
        if match is None:
            message = f"'{self.key}' is a whole number of at most 9 digits, got '{self.value.text[:40]}'"
            findings.error("FZ601", message, self.value)
        return int(match.group(1)) if match is not None else None


@dataclass(frozen=True)
class Section:
    """A section with its header.

    Args:
        kind: `system`, `input`, `output` or `rules`.
        number: The number of an input or output, else 0.
        header: The place of its header.
        entries: Its lines.
    """

    kind: str
    number: int
    header: Span
    entries: list[Entry] = field(default_factory=list)

    def entry(self, key: str) -> Entry | None:
        """Return the last entry of a key in capital or small letters."""
        return next((e for e in reversed(self.entries) if e.key.lower() == key.lower()), None)

    def string(self, key: str) -> str:
        """Return the last value of a key without quotes, empty if the key is missing."""
        entry = self.entry(key)
        return entry.string.text if entry is not None else ""


@dataclass(frozen=True)
class Sections:
    """A file in sections, with its comments, which tell who wrote it."""

    sections: tuple[Section, ...]
    comments: tuple[str, ...]

    def of(self, kind: str) -> list[Section]:
        """Return the sections of a kind in the order of their numbers."""
        return sorted((s for s in self.sections if s.kind == kind), key=lambda s: s.number)


def split(source: SourceText, findings: Findings) -> Sections:
    """Split a file; report unknown sections and lines that belong to no section."""
    sections: list[Section] = []
    comments: list[str] = []
    unknown = False
    for number, line in enumerate(_lines(source), 1):
        if findings.too_many(number, line):
            break
        text = line.text
        if text.startswith(("%", "#", "//")):
            comments.append(text)
        elif text.startswith("[") and (header := _HEADER.match(text)) is not None:
            kind, digits = header.group(1).lower(), header.group(2)
            unknown = kind not in _KINDS
            if unknown:
                known = "[System], [Input1], [Output1] and [Rules] are"
                message = f"there is no section '{header.group()}'"
                findings.error("FZ601", message, line, help=f"{known} sections")
            else:
                sections.append(Section(kind, int(digits[:6] or 0), line))
        elif sections and not unknown:
            _add(sections[-1], line, findings)
        elif not unknown:
            message = "unexpected line before the first section"
            findings.error("FZ601", message, line, help="a file begins with [System]")
            unknown = True  # one message is enough
    return Sections(tuple(sections), tuple(comments))


def _add(section: Section, line: Span, findings: Findings) -> None:
    if section.kind == "rules":
        section.entries.append(Entry("", line, line))
        return
    key, equals, _ = line.text.partition("=")
    if not equals or not key.strip():
        findings.error("FZ601", "the line is not of the form key=value", line, help="comments begin with % or #")
        return
    section.entries.append(Entry(key.strip(), _trimmed(line, len(key) + 1), line))


def _lines(source: SourceText) -> Iterator[Span]:
    """Yield the lines that are not blank, without blanks around them and without comments behind them."""
    at = 0
    for raw in source.text.split("\n"):
        line = _trimmed(Span(source, at, at + len(raw)))
        at += len(raw) + 1
        if line.text and not line.text.startswith(("%", "#")):
            line = _trimmed(line, 0, _length_without_comment(line.text))
        if line.text:
            yield line


def _length_without_comment(text: str) -> int:
    """Return the place of the first mark of a comment that is not within quotes, else the length of the line."""
    for piece in _PIECE.finditer(text):
        if piece["open"]:  # it hides no comment
            mark = _MARK.search(text)
            return mark.start() if mark is not None else len(text)
        if piece["mark"]:
            return piece.start()
    return len(text)


def _trimmed(span: Span, start: int = 0, end: int | None = None) -> Span:
    """Return a part of a text without the blanks around it; the places of its ends are counted within the text."""
    text = span.text[start:end]
    left = len(text) - len(text.lstrip())
    first = span.start + min(start, len(span.text))
    return Span(span.source, first + left, first + max(left, len(text.rstrip())))


# --- membership functions ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TermText:
    """A membership function of a file: its name, its function, and its parameters or its formula."""

    name: Text
    function: Text
    parameters: tuple[Number, ...]
    span: Span
    formula: Span | None = None


def term_text(entry: Entry, findings: Findings) -> TermText | None:
    """Return a membership function `'name':'function',[parameters]`; report a mistake and return None."""
    form = f"a membership function is written: {entry.key}='name':'trimf',[0 1 2]"
    name, rest = _leading_string(entry.value, ends=":")
    if not rest.text.startswith(":"):
        findings.error("FZ601", "expected a colon behind the name of the membership function", entry.value, help=form)
        return None
    function, rest = _leading_string(_trimmed(rest, 1), ends=",[;")
    if rest.text[:1] in (",", ";"):
        rest = _trimmed(rest, 1)
    if not function.text:
        findings.error("FZ601", "the membership function has no type", entry.value, help=form)
        return None
    _, bracket, behind = rest.text.partition("]")
    if bracket and behind.strip().startswith(",") and any(c.isdigit() for c in behind):
        message = f"'{name.text}' is a type-2 fuzzy set, with scale and lag of a lower membership function"
        help_text = "only type-1 sets are computed; in MATLAB 'convertToType1' makes one"
        findings.error("FZ602", message, rest, help=help_text)
        return None
    if function.text.lower() == "function":
        formula = _inside_brackets(rest, findings)
        return TermText(name, function, (), entry.value, formula) if formula is not None else None
    parameters = vector(rest, findings)
    return TermText(name, function, parameters, entry.value) if parameters is not None else None


def _leading_string(span: Span, ends: str) -> tuple[Text, Span]:
    """Return the string at the beginning of a text, and the rest of the text without blanks around it.

    A quote ends the string if it is the last character or one of `ends` follows; so a name may have an apostrophe.
    """
    text = span.text
    close = _QUOTES.get(text[:1])
    if close is None:
        length = min((i for i in map(text.find, ends) if i >= 0), default=len(text))
        body = _trimmed(span, 0, length)
        return Text(body.text, body), _trimmed(span, length)
    last = _closing(text, close, ends)
    body = Span(span.source, span.start + 1, span.start + last)
    return Text(body.text.replace(close * 2, close).strip(), body), _trimmed(span, last + 1)


def _closing(text: str, close: str, ends: str) -> int:
    """Return the place of the quote that ends the string at the beginning of a text."""
    at = text.find(close, 1)
    while at >= 0:
        if text[at + 1 : at + 2] == close and text[at + 2 : at + 3]:
            at = text.find(close, at + 2)
            continue
        following = text[at + 1 : at + 200].lstrip()
        if not following or following[0] in ends or following[0] == ";":
            return at
        at = text.find(close, at + 1)
    return len(text)


# --- vectors -------------------------------------------------------------------------------------------------------

#: Largest number of numbers, signs and separators.
_LONGEST: Final = 20_000

_TOKEN: Final = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|[A-Za-z_]\w*|[-+*/^(),;]", re.ASCII)

_NAMES: Final = {"pi": math.pi, "inf": math.inf, "infinity": math.inf, "eps": 2.0**-52}

_OPERATIONS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "^": operator.pow,
}

_POWER: Final = 3


def _inside_brackets(span: Span, findings: Findings) -> Span | None:
    """Return the text between brackets, which are optional; report a mistake and return None."""
    text = span.text.rstrip(";, ")
    if not text.startswith("["):
        return Span(span.source, span.start, span.start + len(text))
    close = text.find("]")
    if close < 0:
        findings.error("FZ103", "the bracket is not closed", Span(span.source, span.start, span.start + 1))
        return None
    rest = _trimmed(span, close + 1, len(text))
    if rest.text:
        findings.error("FZ601", f"unexpected text behind the bracket: '{rest.text[:40]}'", rest)
        return None
    return Span(span.source, span.start + 1, span.start + close)


def vector(span: Span, findings: Findings) -> tuple[Number, ...] | None:
    """Return the numbers of a vector with their places; report a mistake and return None.

    Elements are separated by blanks, commas or semicolons. As in MATLAB, a sign with a blank before it and none behind
    it begins an element: `[1 -2]` has two, `[1 - 2]` one.
    """
    inner = _inside_brackets(span, findings)
    if inner is None:
        return None
    try:
        return tuple(_Vector(inner).numbers())
    except ParseError as error:
        findings.refuse(error)
        return None


class _Vector(SpanParser[float]):
    infix: Mapping[str, Operator] = {
        **dict.fromkeys(("+", "-"), Operator(1)),
        **dict.fromkeys(("*", "/"), Operator(2)),
        "^": Operator(_POWER),
    }
    deepest = 20

    def __init__(self, span: Span) -> None:
        self.end = Span(span.source, span.end, span.end + 1)
        self.tokens = list(_tokens(span))

    def numbers(self) -> Iterator[Number]:
        while self.next < len(self.tokens):
            if self._text() in (",", ";"):
                self.next += 1
                continue
            first = self.tokens[self.next]
            value = self.parse()
            yield Number(value, span=first.to(self.tokens[self.next - 1]))

    def _peek(self) -> str:
        """Return the operator that comes next, and nothing for a sign that begins an element."""
        return "" if not self.depth and self._begins_element() else self._text()

    def _begins_element(self) -> bool:
        """Whether the next token is a sign with a blank before it and none behind it."""
        if self._text() not in ("+", "-") or self.next + 1 >= len(self.tokens):
            return False
        before, sign, follower = self.tokens[self.next - 1 : self.next + 2]
        return before.end < sign.start and sign.end == follower.start

    def _operand(self, least: int) -> float:
        """Take an atom with its signs, which bind less than a power, but belong to the exponent that they begin."""
        negative = False
        while (sign := self._text()) in ("+", "-"):
            negative ^= sign == "-"
            self.next += 1
        value = self.parse(_POWER) if least < _POWER else self._atom()
        return -value if negative else value

    def _atom(self) -> float:
        if self.next >= len(self.tokens):
            raise _mistake("expected a number", self.end)
        place = self._take()
        text = place.text.lower()
        if text[0] in ".0123456789":
            return _finite(float(text.replace("d", "e")), place)
        if text in _NAMES:
            return _NAMES[text]
        if text != "(":
            raise _mistake(f"'{place.text[:40]}' is not a number", place)
        value = self._nested(0, place)
        if self._text() != ")":
            raise _mistake("a parenthesis is not closed", place)
        self.next += 1
        return value

    def _too_deep(self, place: Span) -> ParseError:
        return _mistake("parentheses are nested too deeply", place)

    def _binary(self, sign: str, left: float, right: float, place: Span) -> float:
        last = self.tokens[self.next - 1]
        try:
            value = _OPERATIONS[sign](left, right)
        except (ZeroDivisionError, OverflowError):
            raise _mistake("the value cannot be computed", last) from None
        if isinstance(value, complex) or math.isnan(value):
            raise _mistake("the value is not a real number", last)
        return value if math.isinf(left) or math.isinf(right) else _finite(value, last)


def _mistake(message: str, place: Span) -> ParseError:
    return ParseError(message, place, help="parameters are numbers, such as [0 2.5 pi/2]")


def _finite(value: float, place: Span) -> float:
    if math.isinf(value):
        raise ParseError(TOO_LARGE, place, "FZ108", help="write Inf")
    return value


def _tokens(span: Span) -> Iterator[Span]:
    for count, (place, matches) in enumerate(tokens_of(span, _TOKEN), 1):
        if not matches:
            raise _mistake(f"'{place.text}' has no place among numbers", place)
        if count > _LONGEST:
            raise _mistake("there are too many numbers", place)
        yield place
