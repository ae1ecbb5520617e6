"""Completion, and the signature of the call that is being typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Scope, Symbol
from fuzzyctl.editor.words import (
    LanguageWord,
    called,
    functions,
    hedges,
    keywords,
    measures,
    memberships,
    plants,
    snippet,
)
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.edits import masked
from fuzzyctl.lang.syntax import NAME
from fuzzyctl.model.method import ACTIVATIONS
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.resolve.settings import SETTINGS

_WORD: Final = rf"(?:{NAME})?"
#: Statements in which an expression follows `=`.
_EXPRESSIONS: Final = "param|let|next|der|output|state|function|hedge|require"


@dataclass(frozen=True)
class Item:
    """One proposal.

    Args:
        label: The text to insert, and to show.
        kind: Kind of the symbol or word.
        detail: Its form, or its owner.
        what: Its meaning; may be empty.
        snippet: The text to insert for editors that know placeholders, such as `${1:name}`; empty for the label.
    """

    label: str
    kind: str
    detail: str = ""
    what: str = ""
    snippet: str = ""


@dataclass(frozen=True)
class Completion:
    """Proposals and the text that they replace.

    Args:
        items: Most likely first.
        span: The characters of the word that has been begun; empty without one.
    """

    items: tuple[Item, ...]
    span: Span


@dataclass(frozen=True)
class _Place:
    """Where the cursor is: document, offset, the line before it, the scope of its block."""

    document: Document
    offset: int
    before: str
    scope: Scope
    block: str
    found: re.Match[str]


def complete(document: Document, offset: int) -> Completion:
    """Return the proposals at an offset; none inside of comments and texts."""
    before = document.text_before(offset)
    begun = re.search(rf"{_WORD}$", before)
    word = begun[0] if begun is not None else ""
    span = Span(document.source, offset - len(word), offset)
    code = masked(before)
    if "#" in code or code.count('"') % 2:
        return Completion((), span)
    scope, head = document.symbols.scope_at(offset)
    block = head.kind if head is not None and head.kind != "system" else ""
    for pattern, proposals in _PLACES:
        match = pattern.search(code)
        if match is not None:
            items = proposals(_Place(document, offset, before, scope, block, match))
            if items is not None:
                unique: dict[str, Item] = {}
                for item in items:
                    unique.setdefault(item.label, item)
                return Completion(tuple(unique.values()), span)
    return Completion((), span)


# -- proposals; None where the place is another one after all

_Proposals = Callable[[_Place], "Iterable[Item] | None"]


def _words(words: Iterable[LanguageWord]) -> Iterator[Item]:
    return (Item(w.name, w.kind, w.form, w.what, snippet(w)) for w in words)


def _names(place: _Place, *kinds: str) -> Iterator[Item]:
    for symbol in (*place.scope.own.values(), *place.scope.outer.values()):
        if not kinds or symbol.kind in kinds:
            yield _item(symbol)


def _item(symbol: Symbol) -> Item:
    return Item(symbol.name, symbol.kind, symbol.whole.text.split("\n")[0].split("#")[0].strip(), symbol.label)


def _terms_of(place: _Place, variable: str) -> Iterator[Item]:
    return (_item(term) for term in place.scope.terms.get(variable, {}).values())


def _terms_after_is(place: _Place) -> Iterator[Item]:
    yield from _terms_of(place, place.found[1])
    yield Item("not", "keyword", "VARIABLE is not TERM")
    if place.found[1] in place.scope.own and place.scope.own[place.found[1]].kind != "output":
        yield Item("any", "keyword", "VARIABLE is any", "true everywhere")
    yield from _words(hedges())
    yield from _names(place, "hedge")


def _values(place: _Place) -> Iterator[Item]:
    for value in SETTINGS[place.found[1]]:
        yield Item(value, "value", f"{place.found[1]} {value}")


def _activations(place: _Place) -> Iterator[Item]:
    return (Item(name, "value", f"activation {name}") for name in ACTIVATIONS)


def _profiles(place: _Place) -> Iterator[Item]:
    return (Item(name, "value", f"semantics {name}") for name in PROFILES)


def _in_cells(place: _Place) -> Iterator[Item] | None:
    """Propose the terms of a table's outputs."""
    table = _table_above(place)
    if table is None:
        return None
    return (item for output in table.outputs for item in _terms_of(place, output.text))


def _in_header(place: _Place) -> Iterator[Item] | None:
    """Propose the terms of a table's columns that its header lacks."""
    table = _table_above(place)
    if table is None or (table.rows and table.rows[0].span.start < place.offset):
        return None
    if table.header is not None and table.header.span.line != place.document.source.line_of(place.offset):
        return None
    given = {w.text for w in table.header.terms} if table.header is not None else set()
    columns = table.second if table.second is not None else table.first
    return (item for item in _terms_of(place, columns.text) if item.label not in given)


def _at_row(place: _Place) -> Iterator[Item] | None:
    """Propose the terms of rows that a table lacks, and statements that may follow it."""
    table = _table_above(place)
    if table is None or table.second is None:
        return None
    labels = {row.label.text for row in table.rows if row.label is not None}
    cells = "  ".join(f"${{{k}:.}}" for k, _ in enumerate(table.header.terms if table.header is not None else (), 1))
    missing = [
        replace(item, snippet=f"{item.label} |  {cells}" if cells else "")
        for item in _terms_of(place, table.first.text)
        if item.label not in labels
    ]
    return iter([*missing, *_words(keywords(place.block))])


def _table_above(place: _Place) -> sx.Table | None:
    """Return the table whose lines hold the place; None where another statement begins in between."""
    table = None
    for s in place.document.tree.statements:
        if s.span.source.name == place.document.source.name and s.span.start < place.offset:
            table = s
    if not isinstance(table, sx.Table) or place.document.source.line_of(place.offset) == table.span.line:
        return None
    return table


def _at_start(place: _Place) -> Iterator[Item]:
    return _words(keywords(place.block))


def _kinds_of_terms(place: _Place) -> Iterator[Item] | None:
    if place.block:
        return None
    return _words(memberships())


def _expression(place: _Place) -> Iterator[Item]:
    yield from _names(place, "param", "input", "output", "let", "state", "block", "disturbance")
    yield from _words(functions(place.block))
    yield from _names(place, "function", "system")


def _members(place: _Place, kinds: Collection[str] = ("output",)) -> Iterator[Item] | None:
    callee = place.scope.callees.get(place.found[1])
    if callee is None or place.found[1].isdigit():
        return iter(())
    scopes = [scope for scope, head in place.document.symbols.blocks() if head.name == callee]
    return (_item(symbol) for scope in scopes for symbol in scope.own.values() if symbol.kind in kinds)


def _members_of_kinds(*kinds: str) -> _Proposals:
    return lambda place: _members(place, kinds)


def _of_kinds(*kinds: str) -> _Proposals:
    return lambda place: _names(place, *kinds)


def _claims(place: _Place) -> Iterator[Item] | None:
    """Propose the beginnings of a claim of a loop: a word about every member, a measure or a param."""
    if place.block != "loop":
        return None
    always = Item("always", "keyword", "require always CONDITION from 20 s", "a claim about every instant")
    stable = Item("stable", "keyword", "require stable", "a claim that every member converges")
    return iter((*_names(place, "measure", "param"), always, stable))


def _plants(place: _Place) -> Iterator[Item]:
    return _words(plants())


def _measures(place: _Place) -> Iterator[Item] | None:
    return _words(measures()) if place.block == "loop" else None


#: Patterns of the line before the cursor; the first one whose proposals apply counts.
_PLACES: Final[tuple[tuple[re.Pattern[str], _Proposals], ...]] = tuple(
    (re.compile(pattern), proposals)
    for pattern, proposals in (
        (rf"^\s*for\s+({NAME})\.{_WORD}$", _members_of_kinds("state", "param")),
        (rf"^\s*require\s+always\b.*\b({NAME})\.{_WORD}$", _members_of_kinds("input", "state", "output")),
        (rf"\b({NAME})\.{_WORD}$", _members),
        (rf"^\s*(?:{NAME}\s*)?\|", _in_cells),
        (rf"^\s*(?:{NAME}\s+)*{_WORD}$", _in_header),
        (rf"^\s*{_WORD}$", _at_row),
        (rf"^\s*{_WORD}$", _at_start),
        (rf"\bterms\s+of\s+{_WORD}$", _of_kinds("input", "output", "let")),
        (rf"\b({NAME})\s+is\s+(?:(?!(?:and|or|then|weight|unless)\b){NAME}\s+)*{_WORD}$", _terms_after_is),
        (rf"^\s*(?:if|otherwise)\b.*\bthen\s+(?:.*,\s*)?\(?{_WORD}$|^\s*otherwise\s+{_WORD}$", _of_kinds("output")),
        (rf"^\s*(?:if|with)\s+(?:.*\b(?:and|or|not|unless)\s+)?\(*{_WORD}$", _of_kinds("input", "let", "output")),
        (rf"(?:^|\s)(and|or|implication|aggregation|defuzzifier)\s+{_WORD}$", _values),
        (rf"^\s*activation\s+{_WORD}$", _activations),
        (rf"^\s*semantics\s+{_WORD}$", _profiles),
        (rf"^\s*table\s+(?:{NAME}\s*,\s*)*{_WORD}$", _of_kinds("output")),
        (rf"^\s*table\s+[^=]*=\s*(?:{NAME}\s+x\s+)?{_WORD}$", _of_kinds("input", "let", "output")),
        (rf"^\s*(?:next|der)\s+{_WORD}$", _of_kinds("state")),
        (rf"^\s*plant\s+{NAME}\s*=\s*{_WORD}$", _plants),
        (rf"^\s*block\s+{NAME}\s*=\s*{_WORD}$", _of_kinds("controller", "plant")),
        (rf"^\s*for\s+{_WORD}$", _of_kinds("block", "param")),
        (rf"^\s*require\s+{_WORD}$", _claims),
        (rf"^\s*measure\b.*=\s*{_WORD}$", _measures),
        (
            rf"^\s*(?!(?:{_EXPRESSIONS})\b){NAME}\s*=\s*{_WORD}$",
            _kinds_of_terms,
        ),
        (
            rf"[-+*/^(,:=<>\[]\s*{_WORD}$|^\s*(?:require(?:\s+always)?|every|run)\s+{_WORD}$|"
            rf"\b(?:when|within|from|until)\s+{_WORD}$",
            _expression,
        ),
    )
)


@dataclass(frozen=True)
class Signature:
    """A form such as `triangle(left, peak, right)`, its parameters, and which of them is being typed, from 0."""

    form: str
    what: str
    parameters: tuple[str, ...]
    active: int


def signature(document: Document, offset: int) -> Signature | None:
    """Return the innermost open call before an offset; None without a known one."""
    code = masked(document.text_before(offset))
    depth = commas = 0
    for at in range(len(code) - 1, -1, -1):
        char = code[at]
        if char in ")]":
            depth += 1
        elif char in "([" and depth:
            depth -= 1
        elif char == "," and not depth:
            commas += 1
        elif char == "(":
            name = re.search(rf"({NAME})\s*$", code[:at])
            return _of(document, offset, name[1], commas) if name is not None else None
    return None


def _of(document: Document, offset: int, name: str, commas: int) -> Signature | None:
    _, head = document.symbols.scope_at(offset)
    word = called(head.kind if head is not None and head.kind != "system" else "").get(name)
    if word is not None:
        inner = word.form[word.form.index("(") + 1 : word.form.rindex(")")]
        parameters = tuple(p.strip() for p in re.split(r",(?![^\[]*\])", inner))
        return Signature(word.form, word.what, parameters, min(commas, len(parameters) - 1))
    for scope, block in document.symbols.blocks():
        if block.name == name:
            inputs = tuple(s.name for s in scope.own.values() if s.kind == "input")
            if inputs:
                return Signature(f"{name}({', '.join(inputs)})", block.label, inputs, min(commas, len(inputs) - 1))
    return None
