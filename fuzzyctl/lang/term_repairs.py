"""Repairs of terms and table rows: membership functions in the notation of other tools."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang.edits import Edit, Repair, Surroundings
from fuzzyctl.lang.other_tools import ORDERS, SCIKIT_ORDERS, known_kind
from fuzzyctl.lang.repair_patterns import NUMBER, by_pattern, head
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

_NUMBERS: Final = re.compile(rf"(?:{NUMBER}|[-+]?(?:inf(?:inity)?)\b)", re.IGNORECASE)
_INFINITY: Final = re.compile(r"^([-+]?)inf(?:inity)?$", re.IGNORECASE)
_WITH_COMMA: Final = re.compile(r"[-+]?\d+(?:[.,]\d+)?")
_CALL: Final = re.compile(
    rf"^\s*(?:{NAME}\[\s*\"([^\"]*)\"\s*\]|({NAME}))?\s*(?:=|:=|:|\s)\s*\"?(?:fuzz\.|mf\.|sf\.)?({NAME})\"?\s*,?\s*"
    r"([\[(]?.*)$"
)
_UNIVERSE: Final = re.compile(rf"^[\[(]\s*(?:{NAME}(?:\.{NAME})?)\s*,")


def _call(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Write the membership function of a term line as here, with its numbers in the order of here."""
    found = _CALL.match(text)
    if found is None or (found[1] is None and found[2] is None) or head(code) in ("if", "with", "table", "terms"):
        return
    kind = known_kind(found[3])
    rest = re.sub(r"\s*(?:#.*)?$", "", found[4])
    if kind is None:
        return
    is_scikit = _UNIVERSE.match(rest) is not None and "[" not in rest
    numbers = _arguments(_UNIVERSE.sub("", rest) if _UNIVERSE.match(rest) else rest)
    if numbers is None:
        return
    word = found[3].lower()
    form = SCIKIT_ORDERS.get(word) if is_scikit else ORDERS.get(word)
    parameters = MEMBERSHIP[kind].parameters
    decimals = _with_decimal_commas(rest)
    if len(decimals) == len(parameters) != len(numbers):
        numbers = decimals
    if (
        not MEMBERSHIP[kind].variadic
        and re.fullmatch(r"[(\[]\d+(?:,\d+)+[)\]]\s*", rest)
        and len(numbers) == 2 * len(parameters)
    ):
        # All numbers have a comma, none has a blank.
        numbers = [f"{whole}.{part}" for whole, part in zip(numbers[::2], numbers[1::2], strict=True)]
    numbers = [n if n.lstrip("+-") in around.declared.params else _INFINITY.sub(r"\1inf", n) for n in numbers]
    why = "membership functions have names of their own here"
    if form is not None and len(numbers) == len(form.parameters) and not any("=" in n for n in numbers):
        given = dict(zip(form.parameters, numbers, strict=True))
        numbers = [given[p] for p in parameters]
        if tuple(form.parameters) != tuple(parameters):
            theirs, ours = ", ".join(form.parameters), ", ".join(parameters)
            why = f"{form.tool} writes {found[3]}({theirs}), here it is {kind}({ours}): the order differs"
    elif word == "binary" and numbers[-1].startswith("-"):
        # fuzzylite writes where it begins and to which side it goes.
        numbers.reverse()
    elif word == kind or found[3] == kind:
        why = f"the form is: NAME = {kind}({', '.join(parameters)})"
    new = f"{kind}({', '.join(numbers)})"
    start = found.start(3)
    if found[2] is None or text[found.end(2) : start].strip() != "=":
        start = len(text) - len(text.lstrip())
        new = f"{found[2] or _name_of(found[1])} = {new}"
    if new != text[start : found.start(4) + len(rest)]:
        yield Edit(start, found.start(4) + len(rest), new, why)


def _name_of(label: str) -> str:
    return re.sub(r"\W+", "_", label)


def _arguments(rest: str) -> list[str] | None:
    """Return the parameters of a call, which may lack their parentheses or commas; None for anything else."""
    inner = re.sub(r"^[\[(\s]+|[\])\s]+$", "", rest)
    if re.fullmatch(r"[^\[\](),]+(?:,[^\[\](),]+)+", inner) and not re.search(r"\d\s+[-+]?\.?\d", inner):
        return [part.strip() for part in inner.split(",")]
    # Points of FCL: (0, 1) (5, 0).
    inner = re.sub(r"[\[\](),;]", " ", inner)
    parts = inner.split()
    return parts if parts and all(map(_NUMBERS.fullmatch, parts)) else None


def _with_decimal_commas(rest: str) -> list[str]:
    """Return the parameters of a call whose numbers are separated by blanks and have commas for points."""
    parts = re.sub(r"[\[\]()]", " ", rest).split()
    return [p.replace(",", ".") for p in parts] if all(map(_WITH_COMMA.fullmatch, parts)) else []


def _points(groups: list[str], around: Surroundings) -> str:
    numbers = re.findall(NUMBER, groups[2])
    return f" = piecewise({', '.join(numbers)})"


def _separated(groups: list[str], around: Surroundings) -> str | None:
    items = re.sub(r"[\[\](){},\"]", " ", groups[2]).split()
    return f" {' '.join(items)}" if items else None


def _cell(groups: list[str], around: Surroundings) -> str | None:
    names = re.findall(NAME, groups[1])
    if set(names) & around.declared.variables:
        return f"function({groups[1]})"
    return f"({groups[1]})" if not names or set(names) & around.declared.params else None


def _leading_bar(groups: list[str], around: Surroundings) -> str | None:
    """Drop the bar before the term of a row where the table has rows with terms."""
    return "" if _two_way(around) else None


def _two_way(around: Surroundings) -> bool:
    return re.search(r"\s[x×]\s", around.statement) is not None


def _bars(groups: list[str], around: Surroundings) -> str:
    # Commas without a blank are those of decimals where others have one.
    separator = r"(?:[|&]|,(?!\d))" if re.search(r",\s", groups[1]) else "[|,&]"
    filled = re.sub(rf"^\s*(?={separator})|(?<=[|,&])\s*(?={separator})", " . ", groups[1])
    return " ".join(re.sub(separator, " ", filled).split())


def _hyphen_name(groups: list[str], around: Surroundings) -> str:
    return groups[1].replace("-", "_")


_ROW_WEIGHT: Final = rf"(?<=\s)(?P<x>({NUMBER})\s*\*\s*({NAME}))(?=\s|$)"


def _weight(groups: list[str], around: Surroundings) -> str | None:
    # A param or an input times a number is a value, a term times a number is a rule with a weight.
    return None if groups[3] in around.declared.params | around.declared.variables else f"{groups[3]}*{groups[2]}"


def _in_rows(repair: Repair) -> Repair:
    def only(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
        if re.match(rf"\s*{NAME}\s*\|", code) or (code.lstrip().startswith("|") and not _two_way(around)):
            yield from repair(code, text, around)

    return only


_SPACED: Final = "cells are separated by blanks"
#: A formula; signs with a blank only before them begin a cell of their own.
_VALUE: Final = rf"[-+]?[\w.]+(?:(?:\s*[*/^]\s*|[-+]|\s+[-+]\s+)[\w.(]+\)*)+|[-+]{NAME}"

#: What follows the name of a term.
_FUNCTION: Final = rf"\s*=\s*(?:{'|'.join(MEMBERSHIP)})\s*\("

TERMS: Final[tuple[Repair, ...]] = (
    by_pattern(
        rf"^\s*(?!(?:{'|'.join(STATEMENT_KEYWORDS)})\b)(?P<x>{NAME}(?:[ \t]+{NAME})+)(?={_FUNCTION})",
        lambda g, _: "_".join(dict.fromkeys(g[1].split())),
        "a name has no blanks",
    ),
    by_pattern(rf"^\s*({NAME}(?:-{NAME})+)(?=\s*=|\s*\|)", _hyphen_name, "a name has no hyphen, which is a minus sign"),
    by_pattern(
        rf"^\s*terms(?P<x>\s*[:=]?\s*([\[({{]?\s*\"?{NAME}\"?(?:[\s,]+\"?{NAME}\"?)+\s*[\])}}]?))\s*$",
        _separated,
        "terms are separated by blanks",
        heads="terms",
    ),
    by_pattern(rf"(?<=\w)(?P<x>\s*,\s*)(?={NAME}\s*[=@])", " ", "terms are separated by blanks", heads="terms"),
    by_pattern(rf"(?<=\s){NAME}(?P<x>\s*:\s*|\s+at\s+)(?=[-+.\d(])", "@", "a peak is written TERM@PEAK", heads="terms"),
    by_pattern(rf"(?<=\s){NAME}(?P<x>\(([^()]*)\))", "@{2}", "a peak is written TERM@PEAK", heads="terms"),
    by_pattern(
        rf"(?<=[=@])(?P<x>({_VALUE}|{NAME}))(?=\s|$)",
        "({2})",
        "an expression of several parts is written in parentheses",
        heads="terms",
    ),
    by_pattern(
        rf"^\s*{NAME}(?P<x>\s*[:=]+\s*((?:\(\s*+{NUMBER}\s*+,\s*+{NUMBER}\s*+\)\s*+,?\s*+){{2,}}+))$",
        _points,
        "points of a term are written piecewise(x1, y1, x2, y2, ...)",
    ),
    _call,
    by_pattern(
        rf"^\s*{NAME}(?P<x>\s*[:&]\s*)(?={NAME})",
        lambda _, around: " | " if around.block == "table" else None,
        "a row begins with its term and '|'",
    ),
    _in_rows(by_pattern(r"(?P<x>\s*\\\\)\s*$", "", _SPACED)),
    _in_rows(by_pattern(r"(?<=\s)(?P<x>-+)(?=\s|$)", ".", "a cell without a rule is '.'")),
    by_pattern(rf"^\s*(?P<x>\|\s*)(?={NAME}\s*\|)", _leading_bar, "a row begins with its term"),
    _in_rows(by_pattern(r"\|\s*(?P<x>[^\n]*\w\s*[|,&][^\n]*)$", _bars, _SPACED)),
    _in_rows(
        by_pattern(
            rf"(?<=\s)({NAME})\*(?P<x>({NAME}))(?=\s|$)",
            lambda g, a: f"({g[3]})" if g[3] in a.declared.params and g[1] not in a.declared.variables else None,
            "a weight other than a number is written in parentheses",
        )
    ),
    _in_rows(by_pattern(_ROW_WEIGHT, _weight, "the weight of a cell is written TERM*WEIGHT")),
    _in_rows(
        by_pattern(
            rf"(?<=\s)({_VALUE})(?=\s|$)", _cell, "a cell holds a term, a number, or an expression in parentheses"
        )
    ),
)
