"""Repairs of terms and rows of tables: membership functions and cells in the notation of other tools."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang.edits import NUMBER, VALUE, Edit, Repair, Surroundings, depth, head, row
from fuzzyctl.lang.foreign import ORDERS, SCIKIT_ORDERS, known_kind
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

_KEYWORD: Final = "|".join(STATEMENT_KEYWORDS)
_NUMBERS: Final = re.compile(rf"(?:{NUMBER}|[-+]?(?:inf(?:inity)?)\b)", re.IGNORECASE)
_CALL: Final = re.compile(
    rf"^\s*(?:{NAME}\[\s*\"([^\"]*)\"\s*\]|({NAME}))?\s*(?:=|:=|:|\s)\s*\"?(?:fuzz\.|mf\.|sf\.)?({NAME})\"?\s*,?\s*"
    r"([\[(]?.*)$"
)
_UNIVERSE: Final = re.compile(rf"^[\[(]\s*(?:{NAME}(?:\.{NAME})?)\s*,")
_POINTS: Final = re.compile(rf"^\s*{NAME}(\s*[:=]+\s*(?:\(\s*+{NUMBER}\s*+,\s*+{NUMBER}\s*+\)\s*+,?\s*+){{2,}}+)$")


def _call(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Write the membership function of a term line as here, with its numbers in the order of here."""
    if (points := _POINTS.match(text)) is not None:
        new = f" = piecewise({', '.join(re.findall(NUMBER, points[1]))})"
        yield Edit(*points.span(1), new, "points of a term are written piecewise(x1, y1, x2, y2, ...)")
    match = _CALL.match(text)
    if match is None or (match[1] is None and match[2] is None) or head(code) in ("if", "with", "table", "terms"):
        return
    kind = known_kind(match[3])
    rest = re.sub(r"\s*(?:#.*)?$", "", match[4])
    if kind is None:
        return
    is_universe = _UNIVERSE.match(rest) is not None
    numbers = _arguments(_UNIVERSE.sub("", rest), len(MEMBERSHIP[kind].parameters), variadic=MEMBERSHIP[kind].variadic)
    if numbers is None:
        return
    word, parameters = match[3].lower(), MEMBERSHIP[kind].parameters
    form = SCIKIT_ORDERS.get(word) if is_universe and "[" not in rest else ORDERS.get(word)
    infinity = re.compile(r"^([-+]?)inf(?:inity)?$", re.IGNORECASE)
    numbers = [n if n.lstrip("+-") in around.declared.params else infinity.sub(r"\1inf", n) for n in numbers]
    why = "membership functions have names of their own here"
    if form is not None and len(numbers) == len(form.parameters) and not any("=" in n for n in numbers):
        values = dict(zip(form.parameters, numbers, strict=True))
        numbers = [values[p] for p in parameters]
        if tuple(form.parameters) != tuple(parameters):
            theirs, ours = ", ".join(form.parameters), ", ".join(parameters)
            why = f"{form.tool} writes {match[3]}({theirs}), here it is {kind}({ours}): the order differs"
    elif word == "binary" and numbers[-1].startswith("-"):
        # fuzzylite writes where it begins and to which side it goes.
        numbers.reverse()
    elif match[3] == kind:
        why = f"the form is: NAME = {kind}({', '.join(parameters)})"
    new, start = f"{kind}({', '.join(numbers)})", match.start(3)
    if match[2] is None or text[match.end(2) : start].strip() != "=":
        start = len(text) - len(text.lstrip())
        name = match[2] or re.sub(r"\W+", "_", match[1])
        new = f"{name} = {new}"
    if new != text[start : match.start(4) + len(rest)]:
        yield Edit(start, match.start(4) + len(rest), new, why)


def _arguments(rest: str, due: int, *, variadic: bool) -> list[str] | None:
    """Return the parameters of a call, which may lack their parentheses or commas; None for anything else."""
    inner = re.sub(r"^[\[(\s]+|[\])\s]+$", "", rest)
    if re.fullmatch(r"[^\[\](),]+(?:,[^\[\](),]+)+", inner) and not re.search(r"\d\s+[-+]?\.?\d", inner):
        parts = [part.strip() for part in inner.split(",")]
    else:
        # Points of FCL: (0, 1) (5, 0).
        parts = re.sub(r"[\[\](),;]", " ", inner).split()
        if not parts or not all(map(_NUMBERS.fullmatch, parts)):
            return None
    decimals = re.sub(r"[\[\]()]", " ", rest).split()
    if all(re.fullmatch(r"[-+]?\d+(?:[.,]\d+)?", p) for p in decimals) and len(decimals) == due != len(parts):
        return [p.replace(",", ".") for p in decimals]
    if not variadic and re.fullmatch(r"[(\[]\d+(?:,\d+)+[)\]]\s*", rest) and len(parts) == 2 * due:
        # All numbers have a comma, none has a blank.
        return [f"{whole}.{part}" for whole, part in zip(parts[::2], parts[1::2], strict=True)]
    return parts


def _items(groups: list[str], around: Surroundings) -> str | None:
    """Return the items of a `terms` line, separated by blanks, each peak behind '@'."""
    inner = (
        re.sub(r"^\s*[:=]?\s*[\[({]?|(?<=[\w\"])\s*[\])}]\s*$", "", groups[1])
        if "(" not in groups[1][3:]
        else groups[1]
    )
    inner = re.sub(rf"(?<=\s)({NAME})(?:\(([^()]*)\)|\s*:\s*(?=[-+.\d(])|\s+at\s+(?=[-+.\d(]))", r"\1@\2", f" {inner}")
    inner = re.sub(rf"\s*,\s*(?={NAME})", " ", inner)
    return f" {inner.strip()}" if inner.strip() else None


def _joined_name(groups: list[str], around: Surroundings) -> str | None:
    """Return a name with underscores for blanks and hyphens; in a rule a hyphen may be a minus sign."""
    name = groups[1] or groups[2] or groups[3]
    numbers = around.declared.variables | around.declared.params
    if groups[3] and numbers.issuperset(name.split("-")):
        return None
    return "_".join(dict.fromkeys(name.split())) if groups[1] else name.replace("-", "_")


def _is_two_way(around: Surroundings) -> bool:
    return re.search(r"\s[x×]\s", around.statement) is not None


def _cells(groups: list[str], around: Surroundings) -> str | None:
    """Return a header without bars, or a row with one bar and blanks between its cells."""
    line, first = groups[1].strip(), head(groups[1])
    if around.block != "table" or first in STATEMENT_KEYWORDS:
        return None
    if around.is_first and line.count("|") > 1 and (header := _header(line.strip("|").split("|"), around)) is not None:
        return header
    if _is_two_way(around):
        line = re.sub(rf"^\|\s*(?={NAME}\s*\|)", "", line)
    match = re.match(rf"({NAME})?\s*([|:&])\s*(.*?)[\s|]*(?:\\\\)?$", line)
    if match is None or not match[3] or (match[1] is None and _is_two_way(around)):
        return None
    body = match[3]
    # Commas without a blank are those of decimals where others have one.
    separator = r"(?:[|&]|,(?!\d))" if re.search(r",\s", body) else "[|,&]"
    if depth(body) == 0 and re.search(separator, re.sub(r"\([^()]*\)", "", body)) and "(" not in body:
        body = re.sub(rf"^\s*(?={separator})|(?<=[|,&])\s*(?={separator})", " . ", body)
        body = " ".join(re.sub(separator, " ", body).split())
    body = re.sub(r"(?<!\S)-+(?!\S)", ".", body)
    cell = rf"(?:\s|^)(?:({NUMBER})\s*\*\s*({NAME})|({NAME})\*({NAME})|({VALUE}))(?=\s|$)"
    body = re.sub(cell, lambda m: m[0][: m[0] != m[0].lstrip()] + _cell(m, around), body)
    return (
        f"{match[1] or ''} | {body}".strip()
        if match[2] != "|" or body != match[3] or line != groups[1].strip()
        else None
    )


def _cell(m: re.Match[str], around: Surroundings) -> str:
    params, variables = around.declared.params, around.declared.variables
    if m[1] and m[2] not in params | variables:
        return f"{m[2]}*{m[1]}"
    if m[3] and m[3] not in params | variables:
        return f"{m[3]}*({m[4]})" if m[4] in params else m[0].strip()
    names = set(re.findall(NAME, m[0]))
    if names & variables:
        return f"function({m[0].strip()})"
    return f"({m[0].strip()})" if not names or names & params else m[0].strip()


def _header(parts: list[str], around: Surroundings) -> str | None:
    """Return the terms of the columns if all between the bars are, but for a corner."""
    corner, *cells = (cell.strip() for cell in parts)
    column = re.findall(NAME, around.statement)[-1:]
    terms = around.declared.words.get(column[0], set()) if column else set()
    is_corner = around.declared.variables.issuperset(re.split(r"\s*[\\/]\s*", corner)) or not corner
    names = cells if is_corner else [corner, *cells]
    return " ".join(names) if len(set(names)) == len(names) > 0 and terms.issuperset(names) else None


_FUNCTION: Final = rf"\s*=\s*(?:{'|'.join(MEMBERSHIP)})\s*\("

TERMS: Final[tuple[Repair, ...]] = (
    row(
        rf"^\s*(?!(?:{_KEYWORD})\b)(?P<x>{NAME}(?:[ \t]+{NAME})+)(?={_FUNCTION})"
        rf"|^\s*(?P<y>{NAME}(?:-{NAME})+)(?=\s*=|\s*\|)"
        rf"|\bis\s+(?:not\s+)?(?P<z>{NAME}(?:-{NAME})+)(?=\s*(?:$|,|\)|\b(?:and|or|then|weight)\b))",
        _joined_name,
        "a name has no blanks and no hyphens",
    ),
    row(r"^\s*terms\b(?P<x>[^#\n]*?)\s*$", _items, "terms are separated by blanks, a peak is written TERM@PEAK"),
    _call,
    row(r"^(?P<x>[^#\n]*?)\s*$", _cells, "a row is written TERM | CELLS, with blanks between them and '.' for no rule"),
)
