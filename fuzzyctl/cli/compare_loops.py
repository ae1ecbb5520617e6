"""`fuzzyctl compare --loops`: the measures of the loops of two files, with their differences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from fuzzyctl.cli.common import plain, show
from fuzzyctl.cli.loops import chosen_loops, settings_of
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.simulation.run import Run

#: Name, first value, second value and difference of a measure; NaN where one has none.
Row = tuple[str, float, float, float]


def compare_loops(
    first: str, second: str, name: str | None, settings: Sequence[str], within: float | None, form: str
) -> bool:
    """Run the loops of two files in pairs, and print their measures side by side.

    Args:
        first: A file.
        second: Another one.
        name: The loop of both; None for all.
        settings: `NAME=VALUE` for params of either.
        within: Largest difference of a measure that passes; None for any.
        form: "text" or "json".

    Returns:
        Whether all runs reach their end, and the measures that both have agree up to `within`.
    """
    from fuzzyctl.simulation.simulate import simulate

    sides = [[loop for _, loop in chosen_loops(file, name)] for file in (first, second)]
    changed = settings_of(settings, [loop for side in sides for loop in side])
    ones, others = changed[: len(sides[0])], changed[len(sides[0]) :]
    pairs = [(simulate(a), simulate(b)) for a, b in _pairs(ones, others)]
    for run in (run for pair in pairs for run in pair):
        show([run.stopped] if run.stopped is not None else [])
    if form == "json":
        write_json({"pairs": [_data(first, second, a, b) for a, b in pairs]})
    else:
        say("\n\n".join("\n".join(_text(first, second, a, b)) for a, b in pairs))
    ended = all(run.stopped is None for pair in pairs for run in pair)
    return ended and (within is None or all(_agree(row, within) for a, b in pairs for row in _rows(a, b)))


def _pairs(ones: Sequence[Loop], others: Sequence[Loop]) -> Iterator[tuple[Loop, Loop]]:
    """Yield loops of the same name, then those of other names in order; what has no partner is left out."""
    names = {loop.name: loop for loop in others}
    yield from ((loop, names[loop.name]) for loop in ones if loop.name in names)
    known = {loop.name for loop in ones}
    rest = [loop for loop in ones if loop.name not in names]
    yield from zip(rest, [loop for loop in others if loop.name not in known], strict=False)


def _rows(a: Run, b: Run) -> list[Row]:
    names = dict.fromkeys([*a.measures, *b.measures])
    values = [(n, a.measures.get(n, math.nan), b.measures.get(n, math.nan)) for n in names]
    return [(n, x, y, 0.0 if x == y else y - x) for n, x, y in values]


def _agree(row: Row, within: float) -> bool:
    _, first, second, difference = row
    return abs(difference) <= within or (math.isnan(first) and math.isnan(second))


def _data(first: str, second: str, a: Run, b: Run) -> dict[str, Any]:
    measures = {n: {"first": x, "second": y, "difference": d} for n, x, y, d in _rows(a, b)}
    return {"first": f"{first}: {a.loop.name}", "second": f"{second}: {b.loop.name}", "measures": plain(measures)}


def _text(first: str, second: str, a: Run, b: Run) -> Iterator[str]:
    yield f"{first}: {a.loop.name}  and  {second}: {b.loop.name}"
    rows = [("measure", "first", "second", "difference")]
    rows += [(n, _shown(x), _shown(y), _shown(d)) for n, x, y, d in _rows(a, b)]
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    for row in rows:
        yield "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


def _shown(value: float) -> str:
    return "none" if math.isnan(value) else f"{value:.5g}"
