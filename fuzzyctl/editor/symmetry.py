"""Symmetry of rule tables: the cell that lies opposite each cell, and what it should be."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Name
from fuzzyctl.formulas import MEMBERSHIP, is_number
from fuzzyctl.kernels.plan.build import planned_set
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Term

#: Terms by their mirror images.
Mirror = Mapping[str, str]
#: Degrees, and parts of a range, that differ by less are the same.
_ROUNDING: Final = 1e-9
#: A cell: characters that are no blanks, and blanks within brackets, which may be nested once.
_CELL: Final = re.compile(r"(?:\[[^\]]*\]|\((?:[^()]|\([^()]*\))*\)|[^\s\[(])+")


def mirror_of(system: FuzzySystem, variable: LinguisticVariable) -> Mirror | None:
    """Return the term that each term becomes where the range is turned about its middle; None where one has none."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    if not (math.isfinite(low) and math.isfinite(high)):
        return None
    shapes = {t.name: _shape(system, variable, t, low, high) for t in variable.terms}
    found = {}
    for name, shape in shapes.items():
        opposite = _turned(shape, low, high) if shape is not None else None
        images = [n for n, s in shapes.items() if opposite is not None and s is not None and _equal(s, opposite)]
        if len(images) != 1:
            return None
        found[name] = images[0]
    return found


#: Places within the range, as parts of it from 0 to 1, each with the degree there.
_Shape = list[tuple[float, float]]


def _shape(system: FuzzySystem, variable: LinguisticVariable, term: Term, low: float, high: float) -> _Shape | None:
    """Return what tells a term from others: its degrees at the places where it bends, and halfway between them."""
    own = term.membership
    if is_number(own.kind):
        return [((system.number(own.arguments[0]) - low) / (high - low), system.number(own.height))]
    planned = planned_set(system, variable, term) if own.kind in MEMBERSHIP else None
    if planned is None:
        return None
    bends = planned.vertices or [(x, 0.0) for x in planned.pieces]
    places = sorted({low, high, *(x for x, _ in bends if low < x < high)})
    places = sorted([*places, *(0.5 * a + 0.5 * b for a, b in pairwise(places))])
    degree = scalar_function(planned.degree(Name("x")))
    return [((x - low) / (high - low), degree(x)) for x in places]


def _turned(shape: _Shape, low: float, high: float) -> _Shape:
    return [(1.0 - x, y) for x, y in reversed(shape)]


def _equal(one: _Shape, other: _Shape) -> bool:
    pairs = zip(one, other, strict=False)
    return len(one) == len(other) and all(
        math.isclose(a, b, rel_tol=0.0, abs_tol=_ROUNDING) for p, q in pairs for a, b in zip(p, q, strict=True)
    )


@dataclass(frozen=True)
class Opposites:
    """The cells of a table, each with the one that lies opposite.

    Args:
        cells: Cells by the terms of row and column, the row empty in a table of one input.
        rows, columns: Mirror images of the labels.
        outputs: Mirror images of the terms of each output; None for a table of equal opposite cells.
    """

    cells: Mapping[tuple[str, str], sx.CellText]
    rows: Mirror
    columns: Mirror
    outputs: tuple[Mirror, ...] | None

    def opposite(self, place: tuple[str, str]) -> tuple[str, str]:
        """Return the place opposite another one."""
        return self.rows[place[0]], self.columns[place[1]]

    def mirrored(self, cell: sx.CellText) -> str | None:
        """Return the text of the cell opposite another one; None for numbers and functions of the inputs."""
        text, start = cell.span.text, cell.span.start
        if self.outputs is None:
            return text
        for term, mirror in reversed(list(zip(cell.terms, self.outputs, strict=False))):
            word = term.term if isinstance(term, sx.HedgedTerm) else term
            if not isinstance(word, sx.Word) or word.text not in mirror:
                return None
            text = text[: word.span.start - start] + mirror[word.text] + text[word.span.end - start :]
        return text

    def wanted(self, place: tuple[str, str]) -> str | None:
        """Return what a cell should be; None where the opposite cell does not say it."""
        other = self.opposite(place)
        cell = self.cells.get(other)
        if other != place:
            return self.mirrored(cell) if cell is not None and cell.terms else None
        if self.outputs is None or (cell is not None and self.mirrored(cell) == cell.span.text and cell.terms):
            return None
        middle = [next((t for t, u in mirror.items() if t == u), None) for mirror in self.outputs]
        return "/".join(m for m in middle if m is not None) if None not in middle else None


def opposites(system: FuzzySystem, table: sx.Table, *, odd: bool) -> Opposites | None:
    """Return the opposite cells of a table; None where labels, or terms of the outputs for `odd`, have no mirror image.

    Args:
        system: The system of the table.
        table: A table with its header.
        odd: Whether opposite cells have opposite terms; otherwise they have the same.
    """
    variables = {v.name: v for v in system.variables}
    names = [*((table.first, table.second) if table.second is not None else (table.first,)), *table.outputs]
    if table.header is None or table.incomplete or any(n.text not in variables for n in names):
        return None
    columns = [w.text for w in table.header.terms]
    cells = {
        (row.label.text if row.label is not None else "", column): cell
        for row in table.rows
        for column, cell in zip(columns, _whole_cells(row), strict=False)
    }
    if len(cells) < len(table.rows) * len(columns):
        return None
    across = mirror_of(system, variables[(table.second or table.first).text])
    down = mirror_of(system, variables[table.first.text]) if table.second is not None else {"": ""}
    outputs = [mirror_of(system, variables[o.text]) for o in table.outputs] if odd else []
    if across is None or down is None or not all(column in across and row in down for row, column in cells):
        return None
    known = tuple(m for m in outputs if m is not None)
    return Opposites(cells, down, across, known if odd else None) if len(known) == len(outputs) else None


def _whole_cells(row: sx.RowLine) -> Iterator[sx.CellText]:
    """Yield the cells with spans that hold brackets and weights, too; none where cells have blanks elsewhere."""
    bar = row.span.start + row.span.text.index("|") + 1
    whole = [
        Span(row.span.source, bar + m.start(), bar + m.end()) for m in _CELL.finditer(row.span.text.partition("|")[2])
    ]
    if len(whole) == len(row.cells):
        for cell, span in zip(row.cells, whole, strict=True):
            yield sx.CellText(cell.terms, cell.weight, span)


def symmetric(system: FuzzySystem, table: sx.Table, offset: int) -> Iterator[tuple[str, list[Replacement]]]:
    """Yield the changes that make a table symmetric about its middle, each with a title.

    What is empty is completed where no two cells contradict each other. Otherwise the rows on the side of the offset
    count, the upper ones where it is in neither; within a middle row the left columns.
    """
    for odd, word in ((True, "antisymmetry"), (False, "symmetry")):
        found = opposites(system, table, odd=odd)
        if found is None:
            continue
        wanted = {place: found.wanted(place) for place in found.cells}
        given = {p: c for p, c in found.cells.items() if c.terms and wanted[p] is not None}
        wrong = {p for p, c in given.items() if not _same(c.span, wanted[p] or "")}
        empty = {p: text for p, text in wanted.items() if text is not None and not found.cells[p].terms}
        if empty and not wrong:
            yield f"complete the table by {word}", _changes(found, empty)
        elif wrong and (odd or 2 * len(wrong) < len(given)):
            lower = _is_below(table, offset)
            last = _later(found, lower)
            changed = {p: text for p, text in wanted.items() if text is not None and (p in last or p not in given)}
            title = f"make the table {'anti' if odd else ''}symmetric"
            side = "" if table.second is None else f", {'upper rows from lower' if lower else 'lower rows from upper'}"
            if any(p in wrong for p in changed):
                yield f"{title}{side}", _changes(found, changed)


def _same(span: Span, text: str) -> bool:
    return span.text.split() == text.split()


def _changes(found: Opposites, texts: Mapping[tuple[str, str], str]) -> list[Replacement]:
    return [Replacement(found.cells[p].span, text) for p, text in texts.items() if found.cells[p].span.text != text]


def _is_below(table: sx.Table, offset: int) -> bool:
    """Whether an offset is in the lower half of the rows."""
    lines = [row.span.line for row in table.rows]
    return table.second is not None and table.span.source.line_of(offset) > (lines[0] + lines[-1]) / 2


def _later(found: Opposites, lower: bool) -> set[tuple[str, str]]:
    """Return the cells that follow from their opposite ones: the later of each two, or the earlier; and the middle."""
    order = {place: k for k, place in enumerate(found.cells)}
    pairs = ((p, found.opposite(p)) for p in order)
    return {p for p, other in pairs if p == other or (other in order and (order[p] > order[other]) != lower)}
