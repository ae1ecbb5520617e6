"""Hover texts and inlay hints: values, terms, forms and meanings."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final
from xml.sax.saxutils import escape

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.navigation import symbol_at
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.editor.words import called, hedges, keywords
from fuzzyctl.expr import to_text
from fuzzyctl.formulas import MEMBERSHIP, is_number
from fuzzyctl.kernels.compile import degree_function
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.syntax import NAME
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Term

_UNIT: Final = re.compile(r'\s+unit\s*"[^"]*"\s*$')


@dataclass(frozen=True)
class Hint:
    """A text shown after an offset, and its meaning."""

    offset: int
    text: str
    what: str


def hints(document: Document, start: int = 0, end: int | None = None) -> list[Hint]:
    """Return the hints of a range of offsets, by offset.

    They are the peaks of terms that share a range evenly, the values of params that are computed, and the bounds of
    outputs once `Document.bounds` is known. A system with mistakes has none.
    """
    end = len(document.text) if end is None else end
    statements = {
        s.name.span.start: s
        for s in document.tree.statements
        if isinstance(s, sx.Param | sx.Variable) and s.span.source.name == document.source.name
    }
    unordered = set()
    for block in document.examined.blocks:
        unordered |= {*_computed(block, statements)}
    for system in document.examined.systems:
        unordered |= {*_peaks(system, statements), *_bound_hints(document, system, statements)}
    return sorted((h for h in unordered if start <= h.offset <= end), key=lambda h: (h.offset, h.text))


_Statements = dict[int, sx.Param | sx.Variable]


def _at(span: Span | None, statements: _Statements) -> sx.Param | sx.Variable | None:
    return statements.get(span.start) if span is not None else None


def _computed(block: Block, statements: _Statements) -> Iterator[Hint]:
    for param in block.params:
        s = _at(param.span, statements)
        is_written = isinstance(param.expression, ex.Number) or not list(_operations(param.expression))
        if isinstance(s, sx.Param) and not is_written:
            end = s.span.start + len(_UNIT.sub("", s.span.text))
            yield Hint(end, f"= {block.number(param.expression):.6g}", f"value of param '{param.name}'")


def _operations(expression: ex.Expr) -> Iterator[ex.Expr]:
    """Yield the parts of an expression that make it more than a number with its sign."""
    return (n for n in ex.walk(expression) if not isinstance(n, ex.Number | ex.Negate))


def _peaks(system: FuzzySystem, statements: _Statements) -> Iterator[Hint]:
    for variable in system.variables:
        s = _at(variable.span, statements)
        if not isinstance(s, sx.Variable):
            continue
        alone = {
            item.name.text: item.name.span.end
            for line in s.terms
            if isinstance(line, sx.TermsLine)
            for item in line.items
            if item.peak is None and item.value is None
        }
        for term in variable.terms:
            at = peak(system, term.membership)
            if term.name in alone and at is not None:
                yield Hint(alone[term.name], f"@{at:.6g}", f"peak of term '{term.name}'")


def peak(system: FuzzySystem, membership: Membership) -> float | None:
    """Return where a term is highest, in the middle of a flat top; None for a curved one and for functions."""
    formula = MEMBERSHIP.get(membership.kind)
    if formula is None:
        return None
    vertices = formula.vertices(tuple(system.number(a) for a in membership.arguments))
    top = [x for x, y in vertices if y == max(y for _, y in vertices) and abs(x) < float("inf")]
    return (top[0] + top[-1]) / 2 if top else None


def _bound_hints(document: Document, system: FuzzySystem, statements: _Statements) -> Iterator[Hint]:
    for output in system.outputs:
        s, bound = _at(output.span, statements), document.bounds.get((system.name, output.name))
        if isinstance(s, sx.Variable) and bound is not None:
            ends = f"[{bound[0]:.6g}, {bound[1]:.6g}]"
            yield Hint(s.span.end, f"proved {ends}", f"'{output.name}' lies in {ends} for all inputs")


_WIDTH, _HEIGHT, _MARGIN, _POINTS = 260, 80, 14, 131
_STRONG, _PALE, _GREY = "#2b7bba", "#9aa7b0", "#808080"
#: Most other terms that are drawn.
_MOST: Final = 15


def picture(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> str:
    """Return the picture of a term as an SVG; an empty text for a function of the inputs."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    if not high - low > 0.0 or high - low == float("inf"):
        return ""
    xs = [low + (high - low) * k / (_POINTS - 1) for k in range(_POINTS)]
    if not _line(system, variable, term, xs, (low, high)):
        return ""
    lines = []
    for other in (*[t for t in variable.terms if t is not term][:_MOST], term):
        points = _line(system, variable, other, xs, (low, high))
        color, width = (_STRONG, 2.5) if other is term else (_PALE, 1)
        if points:
            lines.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="{width}"/>')
    base = _HEIGHT - _MARGIN
    style = f'font-family="sans-serif" font-size="10" fill="{_GREY}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}">'
        f'<path d="M0 {base}H{_WIDTH}" stroke="{_GREY}" stroke-width="0.5"/>{"".join(lines)}'
        f'<text x="1" y="{_HEIGHT - 3}" {style}>{low:.6g}</text>'
        f'<text x="{_WIDTH / 2}" y="{_HEIGHT - 3}" text-anchor="middle" {style}>{escape(variable.axis_label)}</text>'
        f'<text x="{_WIDTH - 1}" y="{_HEIGHT - 3}" text-anchor="end" {style}>{high:.6g}</text></svg>'
    )


def _line(
    system: FuzzySystem, variable: LinguisticVariable, term: Term, xs: Sequence[float], ends: tuple[float, float]
) -> str:
    """Return the points of a term's line in the picture."""
    scale = (_WIDTH - 2) / (ends[1] - ends[0])
    base, height = _HEIGHT - _MARGIN, _HEIGHT - _MARGIN - 4
    if is_number(term.membership.kind):
        at = 1 + (system.number(term.membership.arguments[0]) - ends[0]) * scale
        return f"{at:.1f},{base} {at:.1f},{base - height * system.number(term.membership.height):.1f}"
    degree = degree_function(system, variable, term)
    if degree is None:
        return ""
    return " ".join(f"{1 + (x - ends[0]) * scale:.1f},{base - height * degree(x):.1f}" for x in xs)


def as_markdown(svg: str, name: str) -> str:
    """Return a picture as part of a Markdown text."""
    return f"![{name}](data:image/svg+xml;base64,{b64encode(svg.encode()).decode()})"


@dataclass(frozen=True)
class Hover:
    """A text in Markdown and the location that it is about."""

    markdown: str
    span: Span


def hover(document: Document, offset: int) -> Hover | None:
    """Return the facts of the word at an offset, or None."""
    name = symbol_at(document, offset)
    if name is not None:
        return Hover("\n\n".join(_of_symbol(document, name[1])), name[0])
    span = word_at(document, offset)
    if span is None:
        return None
    _, head = document.symbols.scope_at(offset)
    block = head.kind if head is not None and head.kind != "system" else ""
    behind = document.text[span.end :].lstrip(" \t")
    words = {w.name: w for w in (*hedges(), *keywords(block))}
    if behind.startswith("("):
        words = words | called(block)
    word = words.get(span.text)
    if word is None:
        return None
    return Hover("\n\n".join(filter(None, [f"```fz\n{word.form}\n```", word.what])), span)


def word_at(document: Document, offset: int) -> Span | None:
    """Return the location of the word at an offset; None between words."""
    start = document.text.rfind("\n", 0, offset) + 1
    for m in re.finditer(NAME, document.text_before(offset) + document.text[offset:].split("\n", 1)[0]):
        if m.start() <= offset - start <= m.end():
            return Span(document.source, start + m.start(), start + m.end())
    return None


def _of_symbol(document: Document, symbol: Symbol) -> list[str]:
    first = symbol.whole.text.split("\n")[0].split("#")[0].strip()
    parts = [f"```fz\n{first}\n```"]
    if symbol.label:
        parts.append(symbol.label)
    if symbol.owner is not None:
        parts.append(f"{symbol.kind} of '{symbol.owner.name}'")
    system = _system_of(document, symbol)
    if system is not None:
        parts += _values(system, symbol)
        bound = document.bounds.get((system.name, symbol.name))
        if symbol.kind == "output" and bound is not None:
            parts.append(f"proved: lies in [{bound[0]:.6g}, {bound[1]:.6g}]")
    return parts


def _system_of(document: Document, symbol: Symbol) -> FuzzySystem | None:
    block = symbol.block or symbol
    systems = document.examined.systems
    if block.kind in ("system", "controller", "plant", "loop"):
        is_own = block.span.source.name == document.source.name
        return next((s for s in systems if is_own and s.name == block.name), None)
    return systems[0] if len(systems) == 1 else None


def _values(system: FuzzySystem, symbol: Symbol) -> list[str]:
    """Return the numbers behind a param or a term."""
    values = system.values
    if symbol.kind == "param" and symbol.name in values:
        return [f"value: {values[symbol.name]:g}"]
    if symbol.kind == "term" and symbol.owner is not None:
        for variable in system.variables:
            term = variable.term(symbol.name) if variable.name == symbol.owner.name else None
            if term is not None:
                return _of_term(system, variable, term)
    return []


def _of_term(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> list[str]:
    """Return the function of a term, its peak and its picture."""
    numbers = ", ".join(to_text(p) for p in term.membership.arguments)
    parts = [f"`{term.membership.kind}({numbers})`"]
    at = peak(system, term.membership)
    if at is not None:
        parts[0] += f", peak at {at:.6g}"
    svg = picture(system, variable, term)
    return [*parts, as_markdown(svg, term.name)] if svg else parts
