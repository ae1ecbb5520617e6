"""Programs of multilinear interpolation: find the cell, take its coefficients, and multiply out.

Two forms of the same function. `cells` looks up one polynomial for each cell: least work. `corners` looks up the values
at the cell's corners, if a polynomial for each cell would take too much memory.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise, product
from typing import Final

from fuzzyctl.expr import Expr, Name, Number, Where, minus, names_in, plus, times
from fuzzyctl.kernels.algorithms.grid import Grid, Table
from fuzzyctl.kernels.inference.inference import raw_names
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, Between, Item, Locate, Offset, Place, Program
from fuzzyctl.kernels.program.traversal import parts, statements, writes

#: Most coefficients of one sum over all cells: 1 MiB.
MOST_COEFFICIENTS: Final = 1 << 17
#: Least number of inputs looked up in loops: written out, 2^n corners take a compiler seconds, then minutes.
LOOPED: Final = 7
#: Inputs whose corners are written out within the loops: as fast as without loops.
WRITTEN_OUT: Final = 6
#: Corners of a cell per rule from which on evaluating the rules is faster than looking corners up in loops.
MOST_CORNERS: Final = 2

#: How far each input lies from its knot to the next one, and how far the values at these stand apart.
_Along = Sequence[tuple[Expr, int]]


def lookup(plan: Plan, grid: Grid, most: int = MOST_COEFFICIENTS) -> Program:
    """Write the program that evaluates the polynomial of the cell, or interpolates between its corners.

    Args:
        plan: The plan.
        grid: Its values at the knots.
        most: Coefficients of all cells together, beyond which the values at the corners are stored.
    """
    if _changing(grid) >= LOOPED:
        return _corners(plan, grid, WRITTEN_OUT)
    return written_out(plan, grid, most)


def written_out(plan: Plan, grid: Grid, most: int = MOST_COEFFICIENTS) -> Program:
    """Write the same without loops, for other languages."""
    return _cells(plan, grid) if _has_cells(grid, most) else _corners(plan, grid, _changing(grid))


def interpreted(plan: Plan, grid: Grid) -> Program:
    """Write the same for generated Python, where rows of coefficients cost less than corners."""
    return _cells(plan, grid) if _has_cells(grid) else lookup(plan, grid)


def arrays(plan: Plan, grid: Grid) -> Program:
    """Write the same for arrays: in loops over all corners, where each name is an array and a turn costs nothing."""
    return _corners(plan, grid, 0) if _changing(grid) >= LOOPED else written_out(plan, grid)


def is_sparse(plan: Plan, grid: Grid) -> bool:
    """Return whether there are few rules for the number of inputs, so that evaluating them beats look-up."""
    inputs = _changing(grid)
    return inputs >= LOOPED and 1 << inputs >= MOST_CORNERS * len(plan.rules)


def _changing(grid: Grid) -> int:
    """Return how many inputs change something: an input with one knot does not."""
    return sum(len(k) > 1 for k in grid.knots)


def _has_cells(grid: Grid, most: int = MOST_COEFFICIENTS) -> bool:
    return grid.size << len(grid.inputs) <= most


def _cells(plan: Plan, grid: Grid) -> Program:
    builder = Builder()
    raw = raw_names(plan)
    width = 1 << len(grid.inputs)
    strides = [width * s for s in _strides(grid)]
    rests, places = _located(builder, grid, raw, grid.knots, strides)
    cell = _sum(builder, [(p, 1) for p in places])
    parts: dict[tuple[float, ...], str] = {}

    def value(at_knots: tuple[float, ...]) -> Expr:
        if at_knots not in parts:
            parts[at_knots] = builder.table(coefficients(grid, at_knots))
        items: list[Expr] = [Item(parts[at_knots], Place(cell, k)) for k in range(width)]
        for rest in reversed(rests):
            items = [plus(a, times(rest, b)) for a, b in zip(items[::2], items[1::2], strict=True)]
        return builder.let(items[0])

    return _finished(plan, builder, [_average(builder, t, value) for t in grid.outputs])


def _corners(plan: Plan, grid: Grid, longest: int) -> Program:
    builder = Builder()
    raw = raw_names(plan)
    # The last knot begins no cell; an input with one knot changes nothing.
    inner = [i for i, k in enumerate(grid.knots) if len(k) > 1]
    along: list[tuple[Expr, int]] = []
    places: list[tuple[str, int]] = []
    for i in inner:
        knots, stride = grid.knots[i], _strides(grid)[i]
        x = builder.let(clip(raw[grid.inputs[i]], knots[0], knots[-1]))
        share, place = _share(builder, x, knots)
        along.append((share, stride))
        places += [(place, stride)] if place else []
    cell = _sum(builder, places) if places else ""

    def value(at_knots: tuple[float, ...]) -> Expr:
        return _contracted(builder, builder.table(at_knots), cell, along, longest)

    return _finished(plan, builder, [_average(builder, t, value) for t in grid.outputs])


def _share(builder: Builder, x: Expr, knots: tuple[float, ...]) -> tuple[Expr, str]:
    """Return how far a value lies from its knot to the next one, and the name of the knot's position, if it has one."""
    if len(knots) == 2:
        beyond = builder.let(minus(x, Number(knots[0])))
        return builder.let(times(beyond, Number(1.0 / (knots[1] - knots[0])))), ""
    name, rest, begins = builder.fresh(), builder.fresh(), knots[:-1]
    builder.statements.append(Locate(name, rest, x, builder.table(begins), begins, 1))
    beyond = builder.let(minus(x, Item(builder.table(begins), Place(name))))
    widths = builder.table(1.0 / (b - a) for a, b in pairwise(knots))
    return builder.let(times(beyond, Item(widths, Place(name)))), name


def _contracted(builder: Builder, table: str, cell: str, along: _Along, longest: int) -> Expr:
    """Interpolate between the corners of a cell, input by input from the last one.

    The last `longest` inputs are written out, the others are loops around these. Inputs with two knots have no
    position, and `cell` is empty where there are no others.
    """
    if len(along) <= longest:
        return _written_out(builder, table, cell, along)
    (share, stride), *others = along
    inner, side, place, name = builder.inner(), builder.fresh(), builder.fresh(), builder.fresh()
    inner.statements.append(Offset(place, (*([(cell, 1)] if cell else []), (side, stride))))
    value = _contracted(inner, table, place, others, longest)
    builder.statements.append(Between(name, side, share, tuple(inner.statements), value))
    return Name(name)


def _written_out(builder: Builder, table: str, cell: str, along: _Along) -> Expr:
    steps = [sum(s) for s in product(*((0, stride) for _, stride in along))]
    items: list[Expr] = [Item(table, Place(cell, s) if cell else s) for s in steps]
    for share, _ in reversed(along):
        named = [builder.let(i) for i in items]
        items = [plus(a, times(share, minus(b, a))) for a, b in zip(named[::2], named[1::2], strict=True)]
    return builder.let(items[0])


def _located(
    builder: Builder, grid: Grid, raw: Sequence[Expr], knots: Sequence[tuple[float, ...]], strides: Sequence[int]
) -> tuple[list[Expr], list[str]]:
    """Find the cell of each input; return how far the inputs lie beyond its beginning, and the positions."""
    rests: list[Expr] = []
    places: list[str] = []
    for position, row, stride in zip(grid.inputs, knots, strides, strict=True):
        name, rest = builder.fresh(), builder.fresh()
        builder.statements.append(Locate(name, rest, raw[position], builder.table(row), row, stride))
        rests.append(Name(rest))
        places.append(name)
    return rests, places


def _strides(grid: Grid) -> list[int]:
    return [math.prod(len(k) for k in grid.knots[i + 1 :]) for i in range(len(grid.knots))]


def _sum(builder: Builder, parts: list[tuple[str, int]]) -> str:
    if len(parts) == 1 and parts[0][1] == 1:
        return parts[0][0]
    name = builder.fresh()
    builder.statements.append(Offset(name, tuple(parts)))
    return name


def coefficients(grid: Grid, at_knots: Sequence[float]) -> list[float]:
    """Return for each cell the coefficients of its polynomial in the distances from its first knot.

    The last input's powers vary fastest. Beyond the last knot nothing changes, so there the slopes are 0.
    """
    row_values = list(at_knots)
    strides = _strides(grid)
    for d, knots in enumerate(grid.knots):
        # For each knot: a row of coefficients of the inputs before.
        row = 1 << d
        stride = strides[d] * row
        wider = [0.0] * (2 * len(row_values))
        for k, value in enumerate(row_values):
            cell, place = divmod(k, row)
            i = cell // strides[d] % len(knots)
            slope = (row_values[k + stride] - value) / (knots[i + 1] - knots[i]) if i + 1 < len(knots) else 0.0
            wider[2 * row * cell + 2 * place] = value
            wider[2 * row * cell + 2 * place + 1] = slope
        row_values = wider
    return row_values


def _average(builder: Builder, table: Table, value: object) -> Expr:
    """Return an output as an atom, clipped to the hull of its average."""
    assert callable(value)
    average = value(table.value)
    if table.weight:
        average = builder.let(average / value(table.weight))
    return builder.let(clip(average, table.low, table.high))


def _finished(plan: Plan, builder: Builder, outputs: Sequence[Expr]) -> Program:
    """Return the program; NaN of an input that does not change an output makes it NaN all the same."""
    raw = raw_names(plan)
    results: list[Expr] = []
    for output in outputs:
        read = _read(builder, output)
        unread = [x for x in raw if x.name not in read]
        results.append(Where(any_nan(unread), NAN, output) if unread else output)
    return builder.program(raw, results)


def _read(builder: Builder, value: Expr) -> set[str]:
    """Return the names that a value is computed from; positions are not among them, since they hide that one is NaN."""
    names = {n.name for n in names_in(value)}
    for statement in reversed(builder.statements):
        targets = {statement.rest} if isinstance(statement, Locate) else writes(statement)
        if targets & names:
            names |= {n.name for part in statements([statement]) for e in parts(part).values for n in names_in(e)}
    return names
