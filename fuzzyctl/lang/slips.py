"""Slips that other notations suggest, each with what to write instead: `=` for `==`, `**` for `^`, `|x|` for `abs`."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.syntax import NAME
from fuzzyctl.source import SourceText

#: Characters that have a spelling of their own here.
SPELLINGS: Final = {"≤": "<=", "≥": ">=", "≠": "!=", "−": "-", "–": "-", "—": "-", "·": "*", "⋅": "*", "∞": "inf"}

_OPERATORS: Final = {"=": "==", "=>": ">=", "=<": "<=", "===": "==", "<>": "!=", "!==": "!="}
_OPERATOR: Final = re.compile(r"[=<>!]+")
_ABSOLUTE: Final = re.compile(r"\|([^|]+)\|")
_CHAIN: Final = re.compile(
    r"\s*require\s+([^<>=!]+?)\s*([<>]=?)\s*([^<>=!]+?)\s*([<>]=?)\s*([^<>=!]+?)(?:\s+w(?:hen|ithin)\b.*)?"
)
_CONSEQUENT: Final = re.compile(rf"(?:\bthen|,)\s*({NAME})\s+(?:is\b\s*((?:{NAME}\s*)?)|)$")
_NUMBER: Final = re.compile(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?")
_WEIGHT: Final = re.compile(r"\sweight\b")
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
    if line.word == "require" and line.kind == "statement":
        return _in_a_claim(text, line, at)
    return _in_a_rule(text, line, at) if line.word == "if" and at < line.end else ""


def corner(source: SourceText, line: LogicalLine) -> tuple[int, int] | None:
    r"""Return where the corner of a table stands that papers print, such as e\de; None where there is none."""
    found = _CORNER.match(source.text, line.start, line.end) if line.kind in ("header", "row") else None
    return found.span(1) if found is not None else None


def _in_a_claim(text: str, line: LogicalLine, at: int) -> str:
    absolute = _ABSOLUTE.match(text, at, line.end)
    if absolute is not None:
        return f"write abs({absolute[1].strip()})"
    start = at
    while text[start - 1] in "=<>!":
        start -= 1
    operator = _OPERATOR.match(text, start, line.end)
    if operator is not None and operator[0] in _OPERATORS:
        return f"write '{_OPERATORS[operator[0]]}'"
    if text.startswith("within", at):
        return "write 'within' once, and before 'when'"
    chain = _CHAIN.fullmatch(text, line.start, line.end) if text[at : at + 1] in ("<", ">", "=", "!") else None
    if chain is None:
        return ""
    low, first, middle, second, high = chain.groups()
    if (first, second) == ("<=", "<=") and re.fullmatch(NAME, middle):
        return f"write: require bounded({middle}, {low}, {high})"
    return f"compare two things at a time: {low} {first} {middle} and {middle} {second} {high}"


def _in_a_rule(text: str, line: LogicalLine, at: int) -> str:
    """Repair `=` for `is`, and formulas where a term is due."""
    found = _CONSEQUENT.search(text, line.start, at)
    if found is None:
        return "write 'is' for '='" if text[at] == "=" else ""
    start = at + 1 if text[at] == "=" else found.start(2)
    value = _first_part(text[start : line.end])
    if re.fullmatch(NAME, value):
        return f"write: {found[1]} is {value}"
    if _NUMBER.fullmatch(value):
        return f"for a number write: {found[1]} is constant({value})"
    return f"for a formula write: {found[1]} is function({value})" if re.search(r"[-+*/^(]", value) else ""


def _first_part(text: str) -> str:
    """Return a text up to the comma, outside parentheses, or the weight that ends it."""
    depth = 0
    for i, char in enumerate(text):
        depth += (char == "(") - (char == ")")
        if (char == "," and depth == 0) or _WEIGHT.match(text, i):
            return text[:i].strip()
    return text.strip()
