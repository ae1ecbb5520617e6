"""Samples of a run that a page holds: each n-th, and between these the peaks that they miss."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

#: Most samples of a run that a page holds, most numbers of all its runs, fewest samples.
SAMPLES: Final = 400
NUMBERS: Final = 15_000
FEWEST: Final = 100
#: Share of the height of a panel below which a peak is not seen: half a pixel.
SEEN: Final = 0.005


class Drawn(NamedTuple):
    """A line before it is thinned: its values at all samples, and the height of its panel in the same unit."""

    values: Sequence[float]
    height: float


class Samples(NamedTuple):
    """The samples that a page holds of a run, all increasing.

    Args:
        every: How far those that the slider of the time reaches are apart.
        shown: These, and the last one.
        peaks: For each line the samples between these that its picture needs.
    """

    every: int
    shown: list[int]
    peaks: list[list[int]]


def samples(count: int, drawn: Sequence[Drawn], followed: int, runs: int) -> Samples:
    """Return which samples a page holds, fewer where lines have many peaks.

    Args:
        count: How many samples the run has.
        drawn: Its lines.
        followed: How many signals are not drawn, but held at the times of the slider; the time is one.
        runs: How many runs the page has.
    """
    most, held = NUMBERS // runs, len(drawn) + followed
    widest = max(1, math.ceil(count / FEWEST))
    every = max(1, min(math.ceil(count / min(SAMPLES, max(1, most // held))), widest))
    while True:
        shown = sorted({*range(0, count, every), *range(count)[-1:]})
        found = [peaks(line, shown) for line in drawn]
        size = len(shown) * held + 2 * sum(map(len, found))
        if size <= most or every == widest:
            return Samples(every, shown, found)
        every = min(math.ceil(every * size / most), widest)


def peaks(line: Drawn, shown: Sequence[int]) -> list[int]:
    """Return the samples of the least and the greatest value of each stretch where they lie beyond its ends.

    So a picture has the band that chattering fills, and lines that are smooth cost nothing.

    Args:
        line: What is drawn.
        shown: The samples at which stretches end, increasing.
    """
    values, seen, found = line.values, SEEN * line.height, set()
    for start, stop in pairwise(shown):
        inside = values[start + 1 : stop]
        if not inside:
            continue
        least, greatest = min(inside), max(inside)
        low, high = sorted((values[start], values[stop]))
        for value, beyond in ((least, low - least), (greatest, greatest - high)):
            if math.isfinite(value) and not beyond <= seen:
                found.add(start + 1 + inside.index(value))
    return sorted(found)
