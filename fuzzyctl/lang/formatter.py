"""Formatter of rule files: spacing, indentation and columns; tokens stay.

The layout is made of the tokens as typed, so that numbers, parentheses and comments stay as they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.lines import LogicalLine, is_name, split, tokens
from fuzzyctl.records import dataclass

#: Words with a blank before an opening parenthesis.
_APART: Final = frozenset(
    {"in", "and", "or", "not", "if", "is", "unless", "else", "then", "otherwise", "when", "within", "rate", "weight"}
    | {"require", "always", "from", "until"}
)
#: Those that follow an operand: in place of one they are names.
_CLAUSES: Final = frozenset({"from", "rate", "until", "weight", "when", "within"})
_BINARY: Final = frozenset({"+", "-", "*", "/", "<=", ">=", "==", "!=", "<", ">", "="})
_SETTINGS: Final = frozenset({"and", "or", "implication", "aggregation", "activation", "defuzzifier", "semantics"})
_INDENT: Final = "  "


@dataclass(frozen=True)
class _Laid:
    """A line laid out: its code, its comment, and the run of neighbours it is aligned with."""

    code: str
    comment: str
    run: str


def format_source(source: SourceText) -> str:
    """Return the canonical layout of a rule file.

    Args:
        source: A text; lines that cannot be parsed are left as they are.

    Returns:
        The text, ending with one line feed; formatting it again changes nothing.
    """
    lines = list(split(source))
    laid: list[_Laid] = []
    for block in _blocks(lines):
        laid.extend(_lay_out(source, block))
    return _joined(laid)


def _blocks(lines: Sequence[LogicalLine]) -> Iterator[list[LogicalLine]]:
    """Yield runs of lines that share columns: settings, params, the terms of a variable, a table; others alone."""
    for _, group in groupby(_with_kinds(lines), key=lambda pair: pair[0]):
        yield [line for _, line in group]


def _with_kinds(lines: Sequence[LogicalLine]) -> Iterator[tuple[object, LogicalLine]]:
    number = 0
    for i, line in enumerate(lines):
        kind = _column_kind(line)
        previous = _column_kind(lines[i - 1]) if i else ""
        if not kind or kind != previous:
            number += 1
        yield (number, kind), line


def _column_kind(line: LogicalLine) -> str:
    if line.kind in ("header", "row"):
        return "table"
    if line.kind == "term_line":
        return "terms"
    if line.kind == "statement" and line.word in _SETTINGS:
        return "settings"
    aligned = ("param", "let", "next", "der", "measure") if line.in_block else ("param",)
    return line.word if line.kind in ("statement", "block_statement") and line.word in aligned else ""


def _lay_out(source: SourceText, block: list[LogicalLine]) -> Iterator[_Laid]:
    kind = _column_kind(block[0])
    texts = [line.code(source) for line in block]
    if kind == "table":
        codes = _table(block, texts)
    elif kind == "settings":
        width = max(len(line.word) for line in block)
        codes = [_setting(text, width) for text in texts]
    elif kind in ("terms", "param", "let", "next", "der", "measure"):
        codes = _equal_signs([_code(line, text) for line, text in zip(block, texts, strict=True)])
    else:
        codes = [_code(line, text) for line, text in zip(block, texts, strict=True)]
    for line, text, code in zip(block, texts, codes, strict=True):
        layout = _as_typed(text) if "\n" in text else code
        yield _Laid(layout, line.comment, kind or line.word)


def _as_typed(text: str) -> str:
    """Keep the layout of a line that goes on inside parentheses: its author broke it with care."""
    return "\n".join(part.rstrip() for part in text.strip("\n").split("\n"))


def _pieces(text: str) -> list[str]:
    return [t.text for t in tokens(text) if t.kind != "blank"]


def _code(line: LogicalLine, text: str) -> str:
    pieces = _pieces(text)
    if line.kind == "statement" and line.word == "terms":
        return _INDENT + _items(pieces)
    if line.kind == "statement" and line.word in ("if", "otherwise"):
        return _spaced(pieces, tight="=")
    if line.kind == "statement" and line.word in ("rules", "output"):
        at = _outer_equal(pieces)
        before = _spaced(pieces[:at], tight="=")
        return before if at == len(pieces) else f"{before} = {_spaced(pieces[at + 1 :], tight='')}"
    if line.kind == "term_line":
        head, rest = pieces[:2], pieces[2:]
        return f"{_INDENT}{head[0]} = {_spaced(rest, tight='=')}"
    if line.in_block and "=" in pieces:
        # Only the first equals sign has blanks around it; the others name arguments of calls.
        at = pieces.index("=")
        return f"{_spaced(pieces[:at], tight='')} = {_spaced(pieces[at + 1 :], tight='=')}"
    if re.match(r"require\s+always\s+[-+]\s", text):
        # A subtraction from a measure with the name "always".
        return f"{pieces[0]} {pieces[1]} {pieces[2]} {_spaced(pieces[3:], tight='')}"
    return _spaced(pieces, tight="")


def _items(pieces: Sequence[str]) -> str:
    """Join the tokens of a `terms` line: blanks separate its items, and operators only inside parentheses."""
    joined, depth = "", 0
    for part in re.split(r"( [*/] |[()])", _spaced(pieces, tight="=@")):
        depth += (part == "(") - (part == ")")
        joined += part.strip() if part in (" * ", " / ") and depth == 0 else part
    return joined


def _setting(text: str, width: int) -> str:
    keyword, *rest = _pieces(text)
    return f"{keyword:<{width}} {_spaced(rest, tight='=')}"


def _equal_signs(codes: list[str]) -> list[str]:
    """Align the first equals sign of each line, labels aside."""
    places = [next((t.start for t in tokens(code) if t.text == "="), None) for code in codes]
    width = max((at for code, at in zip(codes, places, strict=True) if at is not None and "\n" not in code), default=0)
    pairs = zip(codes, places, strict=True)
    return [code if at is None else f"{code[:at]:<{width}}{code[at:]}" for code, at in pairs]


def _outer_equal(pieces: Sequence[str]) -> int:
    """Return the position of the equals sign outside of parentheses, or the number of tokens."""
    depth = 0
    for position, piece in enumerate(pieces):
        depth += (piece in "([") - (piece in ")]")
        if piece == "=" and depth == 0:
            return position
    return len(pieces)


def _table(block: list[LogicalLine], texts: list[str]) -> list[str]:
    rows: list[tuple[str, list[str]]] = []
    for line, text in zip(block, texts, strict=True):
        before, _, after = text.rpartition("|") if line.kind == "row" else ("", "", text)
        rows.append((before.strip(), _cells(after)))
    label_width = max(len(label) for label, _ in rows)
    count = max(len(cells) for _, cells in rows)
    widths = [max((len(cells[k]) for _, cells in rows if k < len(cells)), default=0) for k in range(count)]
    laid = []
    for line, (label, cells) in zip(block, rows, strict=True):
        bar = "|" if line.kind == "row" else " "
        lead = f"{label:<{label_width}} {bar}" if label_width else bar
        body = "  ".join(f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=False))
        laid.append(f"{_INDENT}{lead}  {body}".rstrip())
    return laid


def _cells(text: str) -> list[str]:
    """Split a row into cells: blanks separate them, except inside parentheses and around `/`, `*` and signs."""
    cells: list[str] = []
    depth, before = 0, ""
    for token in _pieces(text):
        is_call = token == "(" and before in ("linear", "function", "constant")
        inside = depth > 0 or token in ("/", "*") or before in ("/", "*", "+", "-")
        if cells and (is_call or inside):
            are_words = (before[-1:].isalnum() or before[-1:] == "_") and re.match(r"[\w.]", token)
            cells[-1] += f" {token}" if are_words else token
        else:
            cells.append(token)
        depth += (token in "([") - (token in ")]")
        before = token
    return cells


def _spaced(pieces: Sequence[str], *, tight: str) -> str:
    """Join tokens with canonical spacing; operators in `tight` have none around them inside this line."""
    out: list[str] = []
    before = ""
    unary = False
    for token in pieces:
        glue = "" if not out or unary else _glue(before, token, tight)
        unary = token in "+-" and _begins_operand(before, tight)
        out.append(glue + token)
        is_operand = token in _CLAUSES and (before == "." or _begins_operand(before, tight))
        before = "x" if is_operand else token
    return "".join(out)


def _begins_operand(before: str, tight: str) -> bool:
    """Whether a sign after this token belongs to a number rather than standing between two."""
    return before == "" or before in _BINARY or before in "([,^@:" or before in _APART or before in tight


def _glue(before: str, token: str, tight: str) -> str:
    if before in "([^." or token in ")],^:." or before in tight or token in tight:
        return ""
    if token == "(":
        return "" if is_name(before) and before not in _APART else " "
    return " "


def _joined(laid: Sequence[_Laid]) -> str:
    """Join the lines: comments of neighbours in one column, blank lines at most one at a time."""
    out: list[str] = []
    columns = _comment_columns(laid)
    indents = _comment_indents(laid)
    for line, column, indent in zip(laid, columns, indents, strict=True):
        if not line.code:
            if line.comment:
                out.append(indent + line.comment)
            elif out and out[-1]:
                out.append("")
        elif line.comment:
            out.append(f"{line.code}{' ' * (column - _last_width(line.code))}  {line.comment}")
        else:
            out.append(line.code)
    text = "\n".join(out).strip("\n")
    return text + "\n" if text else ""


def _comment_columns(laid: Sequence[_Laid]) -> list[int]:
    """Return for each line the width of code before its comment: the same for neighbours of one run with comments."""
    columns: list[int] = []
    # The last part of a line that its author broke is not a neighbour of anything.
    keys = [(bool(line.code and line.comment), line.run, i if "\n" in line.code else -1) for i, line in enumerate(laid)]
    for _, group in groupby(zip(keys, laid, strict=True), key=lambda pair: pair[0]):
        run = [line for _, line in group]
        columns.extend([max(_last_width(line.code) for line in run)] * len(run))
    return columns


def _comment_indents(laid: Sequence[_Laid]) -> list[str]:
    """Return for each line how a comment in its place is indented: like the code that follows without a blank line."""
    indents: list[str] = []
    indent = ""
    for line in reversed(laid):
        if line.code:
            indent = _INDENT if line.code.startswith(_INDENT) else ""
        elif not line.comment:
            indent = ""
        indents.append(indent)
    return indents[::-1]


def _last_width(code: str) -> int:
    return len(code.rsplit("\n", 1)[-1])
