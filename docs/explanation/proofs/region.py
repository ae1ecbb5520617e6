"""Draws the region of attraction of a loop: the starts from which `require stable` is proved.

    python region.py weak_motor.fz -o weak_motor.png

The loop has `for` lines for the starts of two states: they are the map. A rectangle that is not proved is cut into
four, up to a depth; green ones are proved. Red points are starts whose runs end outside of the map, and open ground is
undecided.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import fuzzyctl
from fuzzyctl.expr import Number, evaluate
from fuzzyctl.model.block import Bounds

#: Starts along each side of the map from which runs are made.
RUNS = 16

#: Ends of the ranges of two states.
Box = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Region:
    """The map, its proved rectangles, and the starts whose runs end outside of it, shape (n, 2)."""

    names: tuple[str, str]
    whole: Box
    proved: list[Box]
    lost: np.ndarray

    @property
    def share(self) -> float:
        """The share of the map that is proved."""
        return sum(map(area, self.proved)) / area(self.whole)


def area(box: Box) -> float:
    """Return the area of a rectangle."""
    (left, right), (low, high) = box
    return (right - left) * (high - low)


def quarters(box: Box) -> Iterator[Box]:
    """Yield the four quarters of a rectangle."""
    (left, right), (low, high) = box
    x, y = 0.5 * (left + right), 0.5 * (low + high)
    yield from (((a, b), (c, d)) for a, b in ((left, x), (x, right)) for c, d in ((low, y), (y, high)))


def is_proved(loop: Any, box: Box, timeout: float) -> bool:
    """Return whether every member that starts in a rectangle is proved to converge."""
    ends = (Bounds(lower=Number(value=a), upper=Number(value=b)) for a, b in box)
    starts = tuple(replace(one, bounds=bounds) for one, bounds in zip(loop.varied, ends, strict=True))
    claims = tuple(g for g in loop.guarantees if type(g).__name__ == "Stable")
    (verdict,) = fuzzyctl.prove(replace(loop, varied=starts, guarantees=claims), timeout=timeout)
    return isinstance(verdict, fuzzyctl.Proved)


def lost(loop: Any, names: tuple[str, str], whole: Box) -> np.ndarray:
    """Return the starts of a grid whose runs are outside of the map at their ends, shape (n, 2)."""
    experiment = fuzzyctl.Experiment(loop, free=names)
    starts = [(float(x), float(y)) for x in np.linspace(*whole[0], RUNS) for y in np.linspace(*whole[1], RUNS)]
    ends = []
    for start in starts:
        run = experiment.run(start)
        ends.append([run[name][-1] for name in names])
    low, high = np.transpose(whole)
    is_inside = ((ends >= low) & (ends <= high)).all(axis=1)
    return np.array(starts)[~is_inside]


def region(path: Path, depth: int, timeout: float) -> Region:
    """Return the region of attraction of the only loop in a file.

    Args:
        path: The file.
        depth: How often a rectangle is cut at most.
        timeout: Processor time for each rectangle [s].
    """
    loop = fuzzyctl.load(path, block=fuzzyctl.Loop)
    values, (first, second) = loop.param_values.values, loop.varied
    x, y = ((evaluate(one.bounds.lower, values), evaluate(one.bounds.upper, values)) for one in (first, second))
    proved, boxes = list[Box](), [((x, y), 0)]
    while boxes:
        box, cuts = boxes.pop()
        if is_proved(loop, box, timeout):
            proved.append(box)
        elif cuts < depth:
            boxes += [(one, cuts + 1) for one in quarters(box)]
    names = (first.name, second.name)
    return Region(names, (x, y), proved, lost(loop, names, (x, y)))


def draw(result: Region, path: Path) -> None:
    """Write the picture of a region."""
    figure = Figure(figsize=(6.4, 5.4), layout="constrained")
    axes = figure.subplots()
    for (left, right), (low, high) in result.proved:
        axes.add_patch(Rectangle((left, low), right - left, high - low, fc="#009e73", ec="white", lw=0.4))
    axes.plot(*result.lost.T, ".", color="#d55e00", ms=4, label="starts whose runs leave")
    axes.add_patch(Rectangle((0, 0), 0, 0, fc="#009e73", label="proved to converge"))
    axes.set(xlim=result.whole[0], ylim=result.whole[1], xlabel=result.names[0], ylabel=result.names[1])
    figure.legend(loc="outside upper center", ncols=2)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Draw the region and print its share of the map."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("file", type=Path)
    options.add_argument("-o", "--output", type=Path, default=Path("region.png"))
    options.add_argument("--depth", type=int, default=3, help="how often a rectangle is cut at most")
    options.add_argument("--timeout", type=float, default=1.5, help="processor time for each rectangle [s]")
    arguments = options.parse_args()
    result = region(arguments.file, arguments.depth, arguments.timeout)
    draw(result, arguments.output)
    print(f"proved: {100 * result.share:.1f} % of the map, in {len(result.proved)} rectangles")
    print(f"runs that leave: {len(result.lost)} of {RUNS * RUNS}")


if __name__ == "__main__":
    main()
