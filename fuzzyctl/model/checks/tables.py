"""Cells of rule tables: jumps between neighbours and broken symmetry."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from functools import lru_cache, reduce
from itertools import product
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.model.rule import RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import dataclass

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
    results: set[Place] = set()
    for across, down in product((1, -1), repeat=2):
        bad = [cells for cells, downwards, step in steps if not 0 <= (down if downwards else across) * step <= 1]
        if not bad:
            return None
        if 1 < len(bad) <= max(2, len(steps) // 3):
            results |= set.intersection(*bad)
    return results.pop() if len(results) == 1 else None


def ranks_of(system: FuzzySystem, table: RuleTable) -> list[list[int]] | None:
    """Return the position of each cell's term among the terms of the output; None if a cell is not a term alone."""
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


#: Pairs of cells that must follow a symmetry before one that does not is worth a word; in constant parts all do.
_TELLING: Final = 4

#: Where a cell of a table with some rows and columns has its counterpart.
_Counterpart = Callable[[Place, int, int], Place]

#: Ways to turn a table, in words, and whether it must be square.
_TURNS: Final[tuple[tuple[str, _Counterpart, bool], ...]] = (
    ("turned by 180 degrees", lambda p, n, m: (n - 1 - p[0], m - 1 - p[1]), False),
    ("with rows and columns exchanged", lambda p, n, m: (p[1], p[0]), True),
    ("mirrored at its other diagonal", lambda p, n, m: (m - 1 - p[1], n - 1 - p[0]), True),
    ("read from the last row to the first", lambda p, n, m: (n - 1 - p[0], p[1]), False),
    ("read from the last column to the first", lambda p, n, m: (p[0], m - 1 - p[1]), False),
)


@dataclass(frozen=True)
class _Break:
    """The one pair of cells that breaks a symmetry: a single cell if it is its counterpart."""

    cells: frozenset[Place]
    turn: str
    opposite: bool


def odd_cells(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find the one cell that breaks the symmetry of a table which is otherwise symmetric or antisymmetric."""
    for block in system.tables_and_rules:
        if not isinstance(block, RuleTable) or block.rows is None or len(block.outputs) != 1:
            continue
        ranks = ranks_of(system, block)
        breaks = list(_breaks(ranks, len(system.output(block.outputs[0]).terms))) if ranks is not None else []
        # A cell that jumps has a message already.
        if ranks is not None and breaks and culprit(ranks) is None:
            cells = reduce(frozenset.intersection, (b.cells for b in breaks))
            if cells:
                yield _diagnostic(block, max(cells), breaks[0])


def _breaks(ranks: list[list[int]], terms: int) -> Iterator[_Break]:
    """Yield the symmetries that all cells follow but one pair."""
    rows, columns = len(ranks), len(ranks[0])
    usual = Counter(r for row in ranks for r in row).most_common(1)[0][0]
    for k, (turn, _, square) in enumerate(_TURNS):
        if square and rows != columns:
            continue
        pairs = _pairs(k, rows, columns)
        for opposite in (False, True):
            broken = _broken(ranks, pairs, usual, terms - 1 if opposite else None)
            if broken is not None:
                yield _Break(frozenset(broken), turn, opposite)


@lru_cache(maxsize=64)
def _pairs(turn: int, rows: int, columns: int) -> tuple[tuple[Place, Place], ...]:
    """Return the pairs of cells that a way to turn a table exchanges; a cell that stays is with itself."""
    counterpart = _TURNS[turn][1]
    cells = [(i, j) for i in range(rows) for j in range(columns)]
    return tuple((p, q) for p in cells if p <= (q := counterpart(p, rows, columns)))


def _broken(
    ranks: list[list[int]], pairs: tuple[tuple[Place, Place], ...], usual: int, total: int | None
) -> tuple[Place, Place] | None:
    """Return the one pair whose ranks are not the same, or not of the total that is given; None for none or several."""
    broken, telling = None, 0
    for pair in pairs:
        (i, j), (k, m) = pair
        a, b = ranks[i][j], ranks[k][m]
        if b != (a if total is None else total - a):
            if broken is not None:
                return None
            broken = pair
        elif pair[0] != pair[1] and (a, b) != (usual, usual):
            telling += 1
    return broken if telling >= _TELLING else None


def _diagnostic(table: RuleTable, place: Place, found: _Break) -> Diagnostic:
    cell = table.cells[place[0]][place[1]]
    (i, j) = min(found.cells - {place}, default=place)
    other = table.cells[i][j]
    kind = "its opposite" if found.opposite else "the same"
    facts = [f"all other cells make {kind} table when it is {found.turn}"]
    beside = f"its counterpart in row {table.row_terms[i]}, column {table.column_terms[j]} is '{other.terms[0]}'"
    notes = (Note(other.span, beside),) if other is not cell and other.span is not None else ()
    if other is not cell and not notes:
        facts.append(beside)
    message = f"the cell '{cell.terms[0]}' breaks the symmetry of the table"
    help_text = "check the cell" if other is cell else "check the cell and its counterpart"
    return Diagnostic("FZ311", message, cell.span, "warning", tuple(facts), help_text, notes)
