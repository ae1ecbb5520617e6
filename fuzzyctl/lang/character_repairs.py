"""Repairs of characters that no valid line holds: signs of comments, quotes, semicolons, operators."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from typing import Final

from fuzzyctl.lang.common_errors import SPELLINGS
from fuzzyctl.lang.edits import Edit, Repair, Surroundings
from fuzzyctl.lang.repair_patterns import by_pattern, head
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

COMMENT: Final = "a comment begins with '#'"
ENDS: Final = "a statement ends with its line"
DECIMAL: Final = "decimals are written with a point"
_QUOTES: Final = "texts are written in straight double quotes"


def _block_comment(groups: list[str], around: Surroundings) -> str:
    inner = (groups[2] or groups[3]).strip()
    return f"# {inner}" if not groups[4] else ""


#: Statements in which `%` and `//` may be operators: those that hold expressions outside of parentheses.
_EXPRESSIONS: Final = re.compile(
    rf"\s*(?:(?:param|hedge|function|require|let|next|der|state|every|block|measure|run)\b|output\b[^=]*=\s*(?![\[(])|"
    rf"{NAME}\s*:?=\s*(?!{NAME}\s*\())",
    re.IGNORECASE,
)
#: What goes on with an expression behind `//`, and behind `%`, which may be a percent sign too.
_OPERAND: Final = re.compile(r"\s*[-+]?[\d(]")
_OPERATION: Final = re.compile(r"\s*(?:[-+*/^%<>=!,#\d()\]]|(?:unit|within|when|and|or)\b)")
#: What begins with a number and is a text, such as `3 points` and `1st`.
_NUMBERED: Final = re.compile(r"\s*\d+(?:(?:st|nd|rd|th)\b|\s+(?!(?:unit|within|when|and|or)\b)[^\W\d])")


def _comment_behind(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace the sign of a comment behind code; in an expression it may be an operator or a percent sign."""
    computes = _EXPRESSIONS.match(code) is not None
    for m in re.finditer(r"(?<=[\s;)\]}\"])(?<!unit )(//+|%+(?!\s*(?://|#)))(?!\s*(?:;*\s*$|else\b|unit\b))", code):
        before, behind = code[: m.start()], code[m.end() :]
        inside = len(re.findall(r"[(\[]", before)) > len(re.findall(r"[)\]]", before))
        goes_on = (_OPERATION if m[0] == "%" else _OPERAND).match(behind) and not _NUMBERED.match(behind)
        if not (goes_on and (computes or inside)):
            yield Edit(m.start(), m.end(), "#", COMMENT)
            return


def _semicolons(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Drop semicolons at the end of a line; inside parentheses they are commas, between cells blanks."""
    depth, opened = 0, 0
    for i, char in enumerate(code):
        if char in "([":
            depth, opened = depth + 1, i
        depth -= char in ")]"
        if char != ";":
            continue
        if depth > 0:
            yield Edit(i, i + 1, ",", "parameters are separated by commas")
            yield from _commas_of_decimals(code, opened, i)
        elif re.match(r"[\s;]*(#|$)", code[i + 1 :]):
            yield Edit(i, i + 1, "", ENDS)
        elif around.block == "table" and head(code) not in STATEMENT_KEYWORDS:
            yield Edit(i, i + 1, " ", "cells are separated by blanks")


def _commas_of_decimals(code: str, opened: int, semicolon: int) -> Iterator[Edit]:
    """Where semicolons separate parameters, commas are those of decimals."""
    rest = re.compile(r"[^()\[\];]*").match(code, semicolon + 1)
    is_last = rest is not None and code[rest.end() : rest.end() + 1] != ";"
    previous = max(code.rfind(";", opened, semicolon), opened)
    for m in re.finditer(r"(?<=\d),(?=\d)", code[previous : rest.end() if rest and is_last else semicolon]):
        yield Edit(previous + m.start(), previous + m.end(), ".", DECIMAL)


def _end_of_rule(groups: list[str], around: Surroundings) -> str | None:
    return None if groups[2] in around.declared.names else ""


_WORDS_OF_SIGNS: Final = {"∧": " and ", "∨": " or ", "¬": "not ", "→": " then ", "⇒": " then ", "∈": " in "}


def _signs(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace characters that have a spelling of their own here, and those that look like ASCII ones."""
    dash_is_cell = "|" in code
    for m in re.finditer(r"[^\x00-\x7f]", code):
        char = m[0]
        if re.match(r"\w", char) or unicodedata.combining(char) or (char == "×" and head(code) == "table"):
            continue
        new = SPELLINGS.get(char) or _WORDS_OF_SIGNS.get(char) or {"×": "*"}.get(char)
        new = new or unicodedata.normalize("NFKC", char)
        if unicodedata.category(char) == "Pd" and dash_is_cell:
            new = "."
        if new.isascii():
            name = unicodedata.name(char, "a control character")
            start, end = m.span()
            if new.startswith(" "):
                start, end = len(code[:start].rstrip()), len(code) - len(code[end:].lstrip())
            yield Edit(start, end, new, f"U+{ord(char):04X}, {name}, is not a character of the language")


def _bare_term(groups: list[str], around: Surroundings) -> str | None:
    return None if groups[2] in around.declared.params | around.declared.variables else groups[2]


CHARACTERS: Final[tuple[Repair, ...]] = (
    by_pattern(r"(?P<x>\(\*(.*?)\*\)|/\*(.*?)\*/)[ \t]*(?=(\S)?)", _block_comment, COMMENT),
    by_pattern(r"^[ \t]*(?P<x>;+|--+|//+|%+|'+(?=[^'\n]*$))", "#", COMMENT),
    _comment_behind,
    by_pattern(r"[“”„‟«»″]", '"', _QUOTES),
    by_pattern(r"(?<![\w'])'([^'\n]*)'", '"{1}"', _QUOTES),
    by_pattern(r"(?<!\w)[‘’‚‛]([^‘’\n]*)[‘’](?!\w)", '"{1}"', _QUOTES),
    by_pattern(r"\bthen\b.*(?<!\bis)(?P<x>[\s;]+(end(?:_?if)?))(?=[\s;]*(?:#|$))", _end_of_rule, ENDS, heads="if"),
    _semicolons,
    by_pattern(r"\s*&&\s*|\s*&\s*(?=\(|\w+\s*(?:\bis\b|[=~!])|~|!)", " and ", "the conjunction is written 'and'"),
    by_pattern(r"\s*\|\|\s*", " or ", "the disjunction is written 'or'"),
    by_pattern(r"(?<!\w)[!~](?!=)\s*(?=[\w(])", "not ", "the negation is written 'not'"),
    by_pattern(r"~=", "!=", "inequality is written '!='"),
    _signs,
    # No character, but a line that holds it may be valid otherwise: a consequent in parentheses is a number.
    by_pattern(
        rf"\bis\s+(?:not\s+)?(?P<x>\(\s*({NAME})\s*\))", _bare_term, "a term has no parentheses", heads="if with"
    ),
)
