"""Inlay hints: numbers that a rule file means and does not write."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership

_UNIT: Final = re.compile(r'\s+unit\s*"[^"]*"\s*$')


@dataclass(frozen=True)
class Hint:
    """A text shown behind an offset, and what it means."""

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
    found = set()
    for block in document.examined.blocks:
        found |= {*_values(block, statements)}
    for system in document.examined.systems:
        found |= {*_peaks(system, statements), *_bounds(document, system, statements)}
    return sorted((h for h in found if start <= h.offset <= end), key=lambda h: (h.offset, h.text))


_Statements = dict[int, sx.Param | sx.Variable]


def _at(span: Span | None, statements: _Statements) -> sx.Param | sx.Variable | None:
    return statements.get(span.start) if span is not None else None


def _values(block: Block, statements: _Statements) -> Iterator[Hint]:
    for param in block.params:
        s = _at(param.span, statements)
        is_written = isinstance(param.expression, ex.Number) or not list(_operations(param.expression))
        if isinstance(s, sx.Param) and not is_written:
            end = s.span.start + len(_UNIT.sub("", s.span.text))
            yield Hint(end, f"= {block.number(param.expression):.6g}", f"value of param '{param.name}'")


def _operations(expression: ex.Expr) -> Iterator[ex.Expr]:
    """Yield what makes an expression more than a number with its sign."""
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


def _bounds(document: Document, system: FuzzySystem, statements: _Statements) -> Iterator[Hint]:
    for output in system.outputs:
        s, bound = _at(output.span, statements), document.bounds.get((system.name, output.name))
        if isinstance(s, sx.Variable) and bound is not None:
            ends = f"[{bound[0]:.6g}, {bound[1]:.6g}]"
            yield Hint(s.span.end, f"proved {ends}", f"'{output.name}' lies in {ends} for all inputs")
