"""Empty cells of rule tables that leave an output without a firing rule at a point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.kernels.compile import degree_function
from fuzzyctl.model.rule import RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem


def empty_cells(system: FuzzySystem, output: str, point: Mapping[str, float]) -> tuple[Note, ...]:
    """Return a note for each empty cell whose row and column both hold at a point.

    Args:
        system: The system.
        output: Name of the output without a rule there.
        point: Values of the inputs by name.
    """
    notes = []
    for table in _tables(system, output):
        for row, cells in zip(table.row_terms or ("",), table.cells, strict=True):
            if table.rows is not None and not _holds(system, table.rows, row, point):
                continue
            for column, cell in zip(table.column_terms, cells, strict=True):
                if not cell.terms and cell.span is not None and _holds(system, table.columns, column, point):
                    where = f"row '{row}', column '{column}'" if row else f"column '{column}'"
                    notes.append(Note(cell.span, f"the cell of {where} is empty"))
    return tuple(notes)


def _tables(system: FuzzySystem, output: str) -> Iterator[RuleTable]:
    for block in system.blocks:
        parts = block.rules if isinstance(block, RuleBlock) else (block,)
        yield from (p for p in parts if isinstance(p, RuleTable) and output in p.outputs)


def _holds(system: FuzzySystem, variable: str, term: str, point: Mapping[str, float]) -> bool:
    declared = next((i for i in system.inputs if i.name == variable), None)
    found = declared.term(term) if declared is not None else None
    if declared is None or found is None or variable not in point:
        return False
    degree = degree_function(system, declared, found)
    return degree is not None and degree(point[variable]) > 0.0
