"""Reads what most lines of rule files are: rows of names, and terms whose parameters are numbers and names.

The grammar reads them too, token by token and ten times slower; a test holds the two to each other. Whatever is not as
plain as this is left to the grammar, and with it every mistake.
"""

from __future__ import annotations

import math
import re
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.lines import LineKind, LogicalLine
from fuzzyctl.source import SourceText, Span

_NAME: Final = r"[A-Za-z_][A-Za-z0-9_]{0,50}"
_NUMBER: Final = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_END: Final = r"[ \t\r]*"
_PARAMETER: Final = rf"[ \t]*-?(?:{_NUMBER}|{_NAME})[ \t]*"

_HEADER: Final = re.compile(rf"[ \t]*{_NAME}(?:[ \t]+{_NAME})*{_END}")
_ROW: Final = re.compile(rf"[ \t]*({_NAME})?[ \t]*\|((?:[ \t]+(?:{_NAME}|\.))+){_END}")
_TERM: Final = re.compile(rf"[ \t]*({_NAME})[ \t]*=[ \t]*({_NAME})[ \t]*\(({_PARAMETER}(?:,{_PARAMETER})*)\){_END}")
_WORD: Final = re.compile(rf"{_NAME}|\.")
_VALUE: Final = re.compile(rf"(-?)({_NUMBER}|{_NAME})")


def read(source: SourceText, line: LogicalLine, kind: LineKind) -> Any:
    """Return the node of a plain line, None for any other line."""
    text = source.text[line.start : line.end]
    whole = Span(source, line.start + len(text) - len(text.lstrip()), line.end)
    if kind == "header" and _HEADER.fullmatch(text):
        return sx.HeaderLine(whole, tuple(_word(source, line.start, m) for m in _WORD.finditer(text)))
    if kind == "row" and (row := _ROW.fullmatch(text)):
        label = None if row[1] is None else _word(source, line.start, row, 1)
        cells = tuple(_cell(source, line.start, m) for m in _WORD.finditer(text, *row.span(2)))
        return sx.RowLine(whole, label, cells)
    if kind == "term_line" and (term := _TERM.fullmatch(text)):
        return _term(source, line.start, whole, term)
    return None


def _at(source: SourceText, base: int, found: re.Match[str], group: int = 0) -> Span:
    return Span(source, base + found.start(group), base + found.end(group))


def _word(source: SourceText, base: int, found: re.Match[str], group: int = 0) -> sx.Word:
    return sx.Word(found[group], _at(source, base, found, group))


def _cell(source: SourceText, base: int, found: re.Match[str]) -> sx.CellText:
    place = _at(source, base, found)
    return sx.CellText(() if found[0] == "." else (sx.Word(found[0], place),), None, place)


def _term(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.TermLine | None:
    arguments = []
    for value in _VALUE.finditer(found.string, *found.span(3)):
        place = _at(source, base, value)
        expr = _value(source, base, value, place)
        if expr is None:
            return None
        arguments.append(sx.Argument(expr, None, place))
    name, kind = _word(source, base, found, 1), _word(source, base, found, 2)
    return sx.TermLine(whole, name, kind, tuple(arguments))


def _value(source: SourceText, base: int, found: re.Match[str], place: Span) -> ex.Expr | None:
    """Return a parameter, None for a number that a double cannot hold."""
    sign, text = found[1], found[2]
    if not (text[0].isdigit() or text[0] == "."):
        name = ex.Name(text, _at(source, base, found, 2))
        return ex.Negate(name, place) if sign else name
    value = float(text)
    if math.isinf(value) or (value == 0.0 and any(c in "123456789" for c in text.lower().partition("e")[0])):
        return None
    return ex.Number(-value if sign else value, sign + text, place)
