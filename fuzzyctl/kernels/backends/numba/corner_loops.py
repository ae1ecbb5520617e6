"""Batches of programs that loop over the corners of a cell: loops over points inside of those, not around them.

Compilers make vector instructions of innermost loops only. So a block of points is gone through once for what all
corners need, which is kept, once for each turn of the loops over corners, and once for what follows from the results.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.program.printer import INDENT, Dialect, block, text
from fuzzyctl.kernels.program.program import Assign, Between, Offset, Program, Refuse, Statement
from fuzzyctl.records import record

#: Points of a block: what is kept of them stays in the nearest cache.
LANES: Final = 128
#: Names in the generated text: what is kept of the points of a block, and of their cells.
_KEPT, _CELLS = "kept", "cells"


@record(frozen=True)
class _Nest:
    """Loops over corners, one inside the other, as one.

    Args:
        name: Name of the result.
        cell: Name of the position where the cell's corners begin; empty if there is but one cell.
        sides: Name of each counter, how far the point lies to that side, and the stride.
        body: What the innermost loop does, from the place where it begins.
        place: Name of that place.
        value: What it computes.
    """

    name: str
    cell: str
    sides: tuple[tuple[str, Expr, int], ...]
    body: tuple[Assign, ...]
    place: str
    value: Expr


def is_in_passes(program: Program) -> bool:
    """Return whether a program has loops over corners, and nothing that stops a batch."""
    return any(isinstance(s, Between) for s in program.body) and not any(isinstance(s, Refuse) for s in program.body)


def pass_lines(program: Program, dialect: Dialect) -> list[str]:
    """Return the lines of a loop over points `i` below `count`, which read `points` and write `results`."""
    nests = [_nest(s) for s in program.body if isinstance(s, Between)]
    before, after = _split(program)
    columns = {n: k for k, n in enumerate(dict.fromkeys(_shares(nests)))}
    cells = {n: k for k, n in enumerate(dict.fromkeys(n.cell for n in nests if n.cell))}
    sums = {n.name: len(columns) + k for k, n in enumerate(nests)}
    raw = [f"{x} = points[{len(program.arguments)} * i + {k}]" for k, x in enumerate(program.arguments)]
    first = [
        *raw,
        *_block(before, dialect),
        *(f"{_KEPT}[{k}, lane] = {n}" for n, k in columns.items()),
        *(f"{_CELLS}[{k}, lane] = {n}" for n, k in cells.items()),
        *(f"{_KEPT}[{k}, lane] = 0.0" for k in sums.values()),
    ]
    last = [
        *raw,
        *_block(before, dialect),
        *(f"{n} = {_KEPT}[{k}, lane]" for n, k in sums.items()),
        *_block(after, dialect),
        *(f"results[{len(program.results)} * i + {k}] = {text(r, dialect)}" for k, r in enumerate(program.results)),
    ]
    turns = [line for n in nests for line in _turns(n, columns, cells, sums[n.name], dialect)]
    return [
        f"{_KEPT} = np.empty(({len(columns) + len(sums)}, {LANES}))",
        *([f"{_CELLS} = np.empty(({len(cells)}, {LANES}), np.int64)"] if cells else []),
        f"for start in range(0, count, {LANES}):",
        *_indented([f"here = min({LANES}, count - start)", *_lanes(first), *turns, *_lanes(last)]),
    ]


def _lanes(lines: Sequence[str]) -> list[str]:
    return ["for lane in range(here):", *_indented(["i = start + lane", *lines])]


def _indented(lines: Sequence[str]) -> list[str]:
    return [INDENT + line for line in lines]


def _block(statements: tuple[Statement, ...], dialect: Dialect) -> Iterator[str]:
    return block(statements, dialect, lambda condition, output: [], 0)


def _turns(nest: _Nest, columns: dict[str, int], cells: dict[str, int], total: int, dialect: Dialect) -> list[str]:
    """Return the lines that add up over the sides, each with its weight: the product of how far points lie there.

    A share counts as 0 + 1 · share or as 1 - 1 · share, which rounds no more than a choice between the two would; for a
    choice compilers write the whole loop twice.
    """
    lines = []
    weights = []
    for k, (side, share, _) in enumerate(reversed(nest.sides)):
        lines += [f"{side} = turn // {1 << k} % 2", f"{side}_from = 1.0 - {side}", f"{side}_by = 2.0 * {side} - 1.0"]
        weights.append(f"({side}_from + {side}_by * {text(share, dialect)})")
    steps = " + ".join(f"{stride} * {side}" for side, _, stride in nest.sides)
    read = [f"{n} = {_KEPT}[{k}, lane]" for n, k in columns.items()]
    place = f"{nest.place} = {f'{_CELLS}[{cells[nest.cell]}, lane] + ' if nest.cell else ''}step"
    added = f"{_KEPT}[{total}, lane] += {' * '.join(weights)} * {text(nest.value, dialect)}"
    own = [*read, place, *_block(nest.body, dialect), added]
    return [
        f"for turn in range({1 << len(nest.sides)}):",
        *_indented([*lines, f"step = {steps}", *_lanes(own)]),
    ]


def _shares(nests: Sequence[_Nest]) -> Iterator[str]:
    """Yield the names that the loops read."""
    for nest in nests:
        given = {s.name for s in nest.body}
        values = [share for _, share, _ in nest.sides] + [s.value for s in nest.body] + [nest.value]
        yield from (n.name for v in values for n in names_in(v) if n.name not in given)


def _nest(loop: Between) -> _Nest:
    name, cell = loop.name, ""
    sides: list[tuple[str, Expr, int]] = []
    while True:
        offset, *rest = loop.body
        assert isinstance(offset, Offset), "a loop over corners begins with the place where its side begins"
        *whence, (_, stride) = offset.parts
        if not sides and whence:
            cell = whence[0][0]
        sides.append((loop.side, loop.share, stride))
        if not rest or not isinstance(rest[0], Between):
            body = tuple(s for s in rest if isinstance(s, Assign))
            return _Nest(name, cell, tuple(sides), body, offset.name, loop.value)
        loop = rest[0]


def _split(program: Program) -> tuple[tuple[Statement, ...], tuple[Statement, ...]]:
    """Return the statements that need no result of the loops, and those that do."""
    needs_loops = {s.name for s in program.body if isinstance(s, Between)}
    before: list[Statement] = []
    after: list[Statement] = []
    for statement in program.body:
        if isinstance(statement, Assign) and any(n.name in needs_loops for n in names_in(statement.value)):
            needs_loops.add(statement.name)
            after.append(statement)
        elif not isinstance(statement, Between):
            before.append(statement)
    return tuple(before), tuple(after)
