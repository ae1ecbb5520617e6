"""Values of `.fis` entries: strings, counts, ranges and membership functions."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.report import Findings, ParseError
from tests.oracles.fis.sections import QUOTES, Entry, trimmed
from tests.oracles.fis.vectors import read_vector

_COUNT: Final = re.compile(r"(\d{1,9})(?:\.0*)? *[;,]?$", re.ASCII)


#: What switches of fuzzylite's are where they are on.
_ON: Final = re.compile(r"(?:1(?:\.0*)?|true)$", re.IGNORECASE)


@dataclass(frozen=True)
class Text:
    """A string with its place, quotes left out."""

    text: str
    span: Span


@dataclass(frozen=True)
class RawTerm:
    """A membership function as written: its name, its function, and its parameters or its formula."""

    name: Text
    function: Text
    parameters: tuple[Number, ...]
    span: Span
    formula: Span | None = None


def is_on(entry: Entry) -> bool:
    """Whether a switch of fuzzylite's is on."""
    return _ON.match(string(entry).text) is not None


def string(entry: Entry) -> Text:
    """Return a string value; quotes are optional, and a doubled quote stands for one."""
    found, rest = _leading_string(entry.value, ends="")
    if rest.text.strip(";, "):
        return Text(entry.value.text, entry.value)
    return found


def count(entry: Entry, findings: Findings) -> int | None:
    """Return a whole number of 0 or more."""
    match = _COUNT.match(entry.value.text)
    if match is None:
        findings.error("FZ601", f"'{entry.key}' is a whole number, got '{entry.value.text[:40]}'", entry.value)
        return None
    return int(match.group(1))


def vector(span: Span, findings: Findings) -> tuple[Number, ...] | None:
    """Return the numbers between brackets, which may lack around one number; None where they are no numbers."""
    inner = _inside(span, findings)
    if inner is None:
        return None
    try:
        return read_vector(inner)
    except ParseError as error:
        found = error.diagnostic
        assert found.span is not None
        place = Span(span.source, found.span.start, max(found.span.end, found.span.start + 1))
        help_text = "parameters are numbers, such as [0 2.5 pi/2]" if found.code == "FZ601" else "write Inf"
        findings.error(found.code, found.message, place, help=help_text)
        return None


def _inside(span: Span, findings: Findings) -> Span | None:
    text = span.text.rstrip(";, ")
    if not text.startswith("["):
        return Span(span.source, span.start, span.start + len(text))
    close = text.find("]")
    if close < 0:
        findings.error("FZ103", "the bracket is not closed", Span(span.source, span.start, span.start + 1))
        return None
    if text[close + 1 :].strip():
        rest = trimmed(span.source, span.start + close + 1, span.start + len(text))
        findings.error("FZ601", f"unexpected text behind the bracket: '{rest.text[:40]}'", rest)
        return None
    return Span(span.source, span.start + 1, span.start + close)


def term(entry: Entry, findings: Findings) -> RawTerm | None:
    """Return a membership function `'name':'function',[parameters]`; None for what is none."""
    form = f"a membership function is written: {entry.key}='name':'trimf',[0 1 2]"
    name, rest = _leading_string(entry.value, ends=":")
    if not rest.text.startswith(":"):
        findings.error("FZ601", "expected a colon behind the name of the membership function", entry.value, help=form)
        return None
    function, rest = _leading_string(trimmed(rest.source, rest.start + 1, rest.end), ends=",[;")
    if rest.text[:1] in (",", ";"):
        rest = trimmed(rest.source, rest.start + 1, rest.end)
    if not function.text:
        findings.error("FZ601", "the membership function has no type", entry.value, help=form)
        return None
    if _is_of_type_2(rest.text):
        _refuse_type_2(name, rest, findings)
        return None
    if function.text.lower() == "function":
        inner = _inside(rest, findings)
        return None if inner is None else RawTerm(name, function, (), entry.value, inner)
    parameters = vector(rest, findings)
    if parameters is None:
        return None
    return RawTerm(name, function, parameters, entry.value)


def _is_of_type_2(text: str) -> bool:
    """Whether numbers stand behind the brackets: scale and lag of a lower membership function."""
    close = text.find("]")
    behind = text[close + 1 :].strip() if close >= 0 else ""
    return behind.startswith(",") and any(c.isdigit() for c in behind)


def _refuse_type_2(name: Text, rest: Span, findings: Findings) -> None:
    message = f"'{name.text}' is a type-2 fuzzy set, with scale and lag of a lower membership function"
    help_text = "only type-1 sets are computed; in MATLAB 'convertToType1' makes one"
    findings.error("FZ602", message, rest, help=help_text)


def _leading_string(span: Span, ends: str) -> tuple[Text, Span]:
    """Return the string that a text begins with, and the rest of the text without blanks around it.

    A quote ends it where nothing follows, or one of some characters; so a name may hold an apostrophe.

    Args:
        span: The text.
        ends: What may follow the string.
    """
    text = span.text
    close = QUOTES.get(text[:1])
    if close is None:
        length = min((i for i in (text.find(e) for e in ends) if i >= 0), default=len(text))
        body = trimmed(span.source, span.start, span.start + length)
        return Text(body.text, body), trimmed(span.source, span.start + length, span.end)
    last = _closing(text, close, ends)
    body = Span(span.source, span.start + 1, span.start + last)
    unquoted = body.text.replace(close * 2, close)
    return Text(unquoted.strip(), body), trimmed(span.source, min(span.start + last + 1, span.end), span.end)


def _closing(text: str, close: str, ends: str) -> int:
    """Return the place of the quote that ends the string that a text begins with."""
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
