"""Labels of terms above their curves, stacked where they would overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

from matplotlib.textpath import TextPath

#: Size of letters, least distance of names beside each other, and distance of lines [points].
SIZE: Final = 10.0
GAP: Final = 3.2
LINE: Final = 12.0

#: Part of a figure's width that its axes take.
AXES: Final = 0.86

#: Most lines above each other, and most letters of a name.
MOST: Final = 6
LONGEST: Final = 28

#: Heights that differ by less share lines.
SAME: Final = 0.15


@dataclass(frozen=True)
class Label:
    """A name over a curve.

    Args:
        text: The name.
        at: Where the curve is highest, in the units of the axis.
        height: How high it is there.
        color: Its colour.
        upright: Whether the curve is a vertical line, as that of a singleton is, through which no name may run.
    """

    text: str
    at: float
    height: float
    color: str
    upright: bool = False


def draw_labels(ax: Any, labels: Sequence[Label], low: float, high: float) -> int:
    """Write names over their curves; names that find no line are counted in a corner.

    Args:
        ax: Axes from low to high.
        labels: What to write.
        low: The left end of the axis.
        high: The right end.

    Returns:
        How many lines stand above each other at the highest curves.
    """
    spec = ax.get_subplotspec()
    columns = 1 if spec is None else spec.get_gridspec().ncols
    width = AXES * ax.figure.bbox.width / ax.figure.dpi * 72.0 / columns
    labels = _above_uprights(labels, low, high, width)
    lines = lanes(labels, low, high, width)
    for label, line in zip(labels, lines, strict=True):
        if line is not None:
            offset = _extent(label, low, high, width)[0] - _at(label, low, high, width) + GAP / 2
            place = (label.at, label.height)
            ax.annotate(
                shortened(label.text), place, (offset, 3 + LINE * line), textcoords="offset points", color=label.color
            )
    if None in lines:
        text = f"and {lines.count(None)} more"
        ax.annotate(text, (1, 1), (0, 2), "axes fraction", "offset points", ha="right", color="#444444")
    return 1 + max((line for line in lines if line is not None), default=0)


def _above_uprights(labels: Sequence[Label], low: float, high: float, width: float) -> list[Label]:
    """Return labels that stand above the vertical lines which would run through them."""
    found = []
    for label in labels:
        left, right = _extent(label, low, high, width)
        crossed = [u.height for u in labels if u.upright and left <= _at(u, low, high, width) <= right]
        found.append(replace(label, height=max([label.height, *crossed])))
    return found


def lanes(labels: Sequence[Label], low: float, high: float, width: float) -> list[int | None]:
    """Return for each label the lowest line on which it overlaps none to its left, None where there is none.

    Args:
        labels: The labels.
        low: The left end of the axis.
        high: The right end.
        width: Its length in points.
    """
    found: list[int | None] = [None] * len(labels)
    placed: list[tuple[float, float, float, int]] = []
    for k in sorted(range(len(labels)), key=lambda k: labels[k].at):
        left, right = _extent(labels[k], low, high, width)
        near = [(a, b, line) for a, b, height, line in placed if abs(height - labels[k].height) < SAME]
        taken = {line for a, b, line in near if a < right and left < b}
        free = next((line for line in range(MOST) if line not in taken), None)
        if free is not None:
            found[k] = free
            placed.append((left, right, labels[k].height, free))
    return found


def shortened(text: str, longest: int = LONGEST) -> str:
    """Return a text, or its beginning where it is too long for a picture."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def _extent(label: Label, low: float, high: float, width: float) -> tuple[float, float]:
    """Return from where to where a label reaches, in points from the left end of the axis.

    It is centred, but for the ends of the axis, which it does not cross.
    """
    length = _length(shortened(label.text))
    left = min(max(_at(label, low, high, width) - length / 2, 0.0), max(width - length, 0.0))
    return left, left + length


def _at(label: Label, low: float, high: float, width: float) -> float:
    """Return where a curve is highest, in points from the left end of the axis, within the axis."""
    return width * min(max((label.at - low) / (high - low), 0.0), 1.0)


@cache
def _length(text: str) -> float:
    """Return the width of a name with the gap behind it [points]."""
    return float(TextPath((0, 0), text, size=SIZE).get_extents().width) + GAP
