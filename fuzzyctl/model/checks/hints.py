"""Hints for rule tables: probable slips in a number or a cell."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.computed_numbers import Numbers
from fuzzyctl.model.rule import RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input

#: Row and column of a cell.
Place = tuple[int, int]


def uncovered_ranges(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find parts of an input's range where no term has a degree above 0.

    Where some output has no `else`, the proof of coverage reports such a part as the hole it makes.
    """
    if any(o.otherwise is None and o.adaptive is None for o in numbers.system.outputs):
        return
    for variable in numbers.system.inputs:
        for low, high in _gaps(numbers, variable):
            message = f"no term of '{variable.name}' covers its range from {low:.6g} to {high:.6g}"
            yield Diagnostic("FZ309", message, variable.span, "warning", help="widen a term, or shorten the range")


def _gaps(numbers: Numbers, variable: Input) -> list[tuple[float, float]]:
    """Return the parts of the range, wider than a point, that no support reaches."""
    ends, shapes = numbers.range(variable), numbers.shapes(variable)
    if ends is None or not shapes or len(shapes) < len(variable.terms):
        return []  # no antecedent reads an input without terms, and the reach of a term with bad parameters is unknown
    supports: list[tuple[float, float]] = []
    for term, parameters in shapes:
        vertices = MEMBERSHIP[term.membership.kind].vertices(parameters)
        if not vertices:
            return []  # curved terms are above 0 nearly everywhere
        left = vertices[0][0] if vertices[0][1] == 0 else -math.inf
        right = vertices[-1][0] if vertices[-1][1] == 0 else math.inf
        supports.append((left, right))
    reached, upper = ends
    gaps: list[tuple[float, float]] = []
    for left, right in sorted(supports):
        if left > reached:
            gaps.append((reached, min(left, upper)))
        reached = max(reached, right)
        if reached >= upper:
            return gaps
    return [*gaps, (reached, upper)]


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
