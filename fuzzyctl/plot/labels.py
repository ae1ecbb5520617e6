"""Names of terms over their curves, above each other where they would overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

#: Mean width of a letter and distance of lines, in points, of the size that pictures are written in.
LETTER: Final = 6.4
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
    """

    text: str
    at: float
    height: float
    color: str


def draw_labels(ax: Any, labels: Sequence[Label], low: float, high: float) -> int:
    """Write names over their curves.

    Args:
        ax: Axes from low to high.
        labels: What to write.
        low: The left end of the axis.
        high: The right end.

    Returns:
        How many lines stand above each other at the highest curves.
    """
    width = AXES * ax.figure.get_size_inches()[0] * 72.0
    lines = lanes(labels, low, high, width)
    for label, line in zip(labels, lines, strict=True):
        side, text = _side(label, low, high), shortened(label.text)
        place = (label.at, label.height)
        ax.annotate(text, place, (0, 3 + LINE * line), textcoords="offset points", ha=side, color=label.color)
    return 1 + max(lines, default=0)


def lanes(labels: Sequence[Label], low: float, high: float, width: float) -> list[int]:
    """Return for each label the lowest line on which it overlaps none to its left.

    Args:
        labels: The labels.
        low: The left end of the axis.
        high: The right end.
        width: Its length in points.
    """
    found = [0] * len(labels)
    placed: list[tuple[float, float, float, int]] = []
    for k in sorted(range(len(labels)), key=lambda k: labels[k].at):
        left, right = _extent(labels[k], low, high, width)
        near = [(a, b, line) for a, b, height, line in placed if abs(height - labels[k].height) < SAME]
        taken = {line for a, b, line in near if a < right and left < b}
        found[k] = next((line for line in range(MOST) if line not in taken), k % MOST)
        placed.append((left, right, labels[k].height, found[k]))
    return found


def shortened(text: str, longest: int = LONGEST) -> str:
    """Return a text, or its beginning where it is too long for a picture."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def _extent(label: Label, low: float, high: float, width: float) -> tuple[float, float]:
    """Return from where to where a label reaches, in points from the left end of the axis."""
    length = LETTER * len(shortened(label.text)) + LETTER / 2
    at = width * (label.at - low) / (high - low)
    match _side(label, low, high):
        case "left":
            return at, at + length
        case "right":
            return at - length, at
    return at - length / 2, at + length / 2


def _side(label: Label, low: float, high: float) -> str:
    """Return how a label is aligned: at the ends of the axis a centred one would stand on tick labels or outside."""
    return "left" if label.at <= low else "right" if label.at >= high else "center"
