"""Checks of rule tables: one cell that breaks what is monotone but for it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.model.rule import RuleTable
from fuzzyctl.model.system import FuzzySystem

#: Row and column of a cell.
Place = tuple[int, int]


def jumping_tables(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find the one cell that breaks an otherwise monotone table whose neighbours differ by one term at most."""
    for block in system.tables_and_rules:
        if not isinstance(block, RuleTable) or len(block.outputs) != 1:
            continue
        ranks = ranks_of(system, block)
        # In a small table one odd cell is as likely to be meant.
        if ranks is None or len(block.column_terms) < (5 if block.rows is None else 3):
            continue
        odd = culprit(ranks)
        if odd is not None:
            cell = block.cells[odd[0]][odd[1]]
            message = f"the cell '{cell.terms[0]}' jumps in a table that is monotone but for it"
            yield Diagnostic("FZ310", message, cell.span, "warning", help="check the cell")


def culprit(ranks: list[list[int]]) -> Place | None:
    """Return the one cell that is part of all breaks, None where there is no break or no such cell."""
    steps = [({a, b}, downwards, _at(ranks, b) - _at(ranks, a)) for a, b, downwards in _neighbours(ranks)]
    found: set[Place] = set()
    for across, down in product((1, -1), repeat=2):
        bad = [cells for cells, downwards, step in steps if not 0 <= (down if downwards else across) * step <= 1]
        if not bad:
            return None
        if 1 < len(bad) <= max(2, len(steps) // 3):
            found |= set.intersection(*bad)
    return found.pop() if len(found) == 1 else None


def ranks_of(system: FuzzySystem, table: RuleTable) -> list[list[int]] | None:
    """Return the position of each cell's term among the terms of the output; None where a cell is no term alone."""
    order = {t.name: i for i, t in enumerate(system.output(table.outputs[0]).terms)}
    ranks: list[list[int]] = []
    if any(c.hedges for row in table.cells for c in row):
        return None
    for row in table.cells:
        named = [c.terms[0] if c.terms else "" for c in row]
        if not all(isinstance(n, str) and n in order for n in named):
            return None
        ranks.append([order[str(n)] for n in named])
    return ranks


def _neighbours(ranks: list[list[int]]) -> Iterator[tuple[Place, Place, bool]]:
    for i, row in enumerate(ranks):
        for j in range(len(row)):
            if j + 1 < len(row):
                yield (i, j), (i, j + 1), False
            if i + 1 < len(ranks):
                yield (i, j), (i + 1, j), True


def _at(ranks: list[list[int]], place: Place) -> int:
    return ranks[place[0]][place[1]]
