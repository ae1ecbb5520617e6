"""Cells of rule tables given as Python values."""

from __future__ import annotations

from fuzzyctl.building import fragments, values
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import ONE
from fuzzyctl.model.rule import Cell
from fuzzyctl.support import arguments


def row(label: str, given: object, outputs: tuple[str, ...], columns: int) -> tuple[Cell, ...]:
    """Return the cells of a row, given as a text or a sequence.

    Args:
        label: The term that leads the row.
        given: What is given for it.
        outputs: The outputs that each cell sets.
        columns: The expected number of cells.

    Raises:
        ArgumentError: For another number of cells, and for what is no cell.
        DiagnosticError: For a text that is none.
    """
    name = f"row {label!r}"
    found = (
        fragments.cells(given) if isinstance(given, str) else arguments.items(name, "cells in a text or a list", given)
    )
    if len(found) != columns:
        raise ArgumentError(f"{name} has {len(found)} cells for {columns} columns")
    return tuple(cell(f"a cell of {name}", c, outputs) for c in found)


def cell(name: str, given: object, outputs: tuple[str, ...]) -> Cell:
    """Return one cell; a cell without a term stands for no rule.

    Args:
        name: What to call it where it is refused.
        given: A text, a number, a membership, a cell, or None for no rule.
        outputs: The outputs that it sets.

    Raises:
        ArgumentError: For another number of terms than of outputs, and for what is no cell.
        DiagnosticError: For a text that is none.
    """
    if given is None:
        return Cell(terms=())
    if isinstance(given, Cell):
        made = given
    elif isinstance(given, str):
        texts = fragments.cells(given)
        if len(texts) != 1:
            raise ArgumentError(f"expected one cell, got {given!r}")
        made = texts[0]
    else:
        made = Cell(terms=(values.membership(name, given),), weight=ONE)
    if made.terms and len(made.terms) != len(outputs):
        raise ArgumentError(f"{name} names {len(made.terms)} terms for {len(outputs)} outputs")
    return made
