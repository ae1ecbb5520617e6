"""Plot of the terms of linguistic variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.textpath import TextPath

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.formats.fz import membership_text
from fuzzyctl.formulas import MEMBERSHIP, is_number
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable
from fuzzyctl.plot.figures import Panels, finish, one, panels, place, sized, styled
from fuzzyctl.plot.style import COLORS
from fuzzyctl.support import arguments

#: Room for one more line of names above the curves, in degrees.
LANE: Final = 0.16

#: Most functions that a panel has room for.
FUNCTIONS: Final = 7


@overload
def terms(system: Block, variable: None = None, *, ax: Axes | None = None) -> Panels: ...
@overload
def terms(system: FuzzySystem, variable: str, *, ax: Axes | None = None) -> Axes: ...
def terms(system: Block, variable: str | None = None, *, ax: Axes | None = None) -> Axes | Panels:
    """Draw the terms of one variable, or of all of them below each other.

    Args:
        system: A well-formed system, or a controller, whose systems are drawn.
        variable: Name of an input, an output or a let, of several systems `SYSTEM.VARIABLE`; None for all with terms.
        ax: Axes to draw in, whose place several panels take; None for new ones.

    Returns:
        The axes; of several panels a tuple of them, which a notebook shows as the picture.

    Raises:
        UnknownNameError: For a name of no variable.
        ArgumentError: For arguments of another type, a controller that calls no systems, and axes that have no
            place in a grid.
    """
    block = arguments.instance("the system", Block, "a FuzzySystem or a Controller", system)
    if not block.all_systems:
        raise ArgumentError(f"{block.kind} '{block.name}' calls no systems, whose terms could be drawn")
    with styled(ax):
        if variable is None:
            figure = place(ax)
            draw_terms(figure, block)
            return panels(figure)
        several = len(block.all_systems) > 1
        by_name = {
            f"{s.name}.{v.name}" if several else v.name: (s, v)
            for s in block.all_systems
            for v in s.variables
            if v.terms
        }
        if variable not in by_name:
            raise UnknownNameError("variable with terms", str(variable), list(by_name))
        axes: Axes = draw_variable(one(ax, (7.5, 2.6)), *by_name[variable])
        finish(axes)
        return axes


def draw_terms(figure: Any, block: Block) -> None:
    """Draw one panel for each variable of each system: degrees of its terms over its universe.

    Args:
        figure: An empty matplotlib figure, or a part of one.
        block: A system, or a block that calls systems.
    """
    systems = block.all_systems
    variables = [_drawn(system) for system in systems]
    heights = [2.2 * len(group) + 0.4 for group in variables]
    sized(figure, 7.5, sum(heights))
    parts = figure.subfigures(len(systems), 1, height_ratios=heights, squeeze=False)[:, 0] if systems[1:] else [figure]
    for part, system, group in zip(parts, systems, variables, strict=True):
        _draw_system(part, system, group)


def _drawn(system: FuzzySystem) -> list[LinguisticVariable]:
    return [*system.inputs, *(v for v in system.lets if v.terms), *system.outputs]


def _draw_system(figure: Any, system: FuzzySystem, variables: Sequence[LinguisticVariable]) -> None:
    axes = figure.subplots(len(variables), 1, squeeze=False)[:, 0]
    for ax, variable in zip(axes, variables, strict=True):
        draw_variable(ax, system, variable)
    figure.suptitle(system.title or system.name)


def draw_variable(ax: Any, system: FuzzySystem, variable: LinguisticVariable) -> Any:
    """Draw the terms of one variable into axes and return the axes."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    x = _grid(system, variable, low, high)
    labels: list[Label] = []
    functions: list[tuple[str, str]] = []
    for i, term in enumerate(variable.terms):
        color = COLORS[i % len(COLORS)]
        y = degrees(system, variable, term, x)
        if y is None:
            functions.append((f"{term.name} = {membership_text(term.membership)}", color))
        elif is_number(term.membership.kind):
            at, height = system.number(term.membership.arguments[0]), system.number(term.membership.height)
            ax.vlines(at, 0, height, color=color, lw=2)
            labels.append(Label(term.name, at, height, color, upright=True))
        else:
            ax.plot(x, y, color=color)
            ax.fill_between(x, y, color=color, alpha=0.08, lw=0)
            labels.append(Label(term.name, _top(x, y), float(np.max(y)), color))
    lines = draw_labels(ax, labels, low, high)
    ax.set(xlim=(low, high), ylim=(0, 1.18 + LANE * (lines - 1)), xlabel=variable.axis_label)
    if labels or not functions:
        ax.set(ylabel="degree", yticks=[0, 0.5, 1])
    else:
        ax.set(yticks=[])
    _write_functions(ax, functions)
    return ax


def _write_functions(ax: Any, functions: Sequence[tuple[str, str]]) -> None:
    """Write functions of the inputs, which have no picture over the range of the output, as texts."""
    rows = functions if len(functions) <= FUNCTIONS else functions[: FUNCTIONS - 1]
    texts = [(shortened(text, 70), color) for text, color in rows]
    if len(rows) < len(functions):
        texts.append((f"and {len(functions) - len(rows)} more", "#444444"))
    box = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8}
    for k, (text, color) in enumerate(texts):
        place = (0.02, 0.86 - k * 0.9 / FUNCTIONS)
        ax.annotate(text, place, xycoords="axes fraction", fontsize="small", va="center", color=color, bbox=box)


def _top(x: Any, y: Any) -> float:
    """Return the middle of where a term is highest."""
    highest = x[y >= np.max(y) - 1e-12]
    return float((highest[0] + highest[-1]) / 2)


def _grid(system: FuzzySystem, variable: LinguisticVariable, low: float, high: float) -> Any:
    """Return points that include every corner, so that peaks are drawn at their full height."""
    corners = [low, high]
    for term in variable.terms:
        if term.membership.kind not in MEMBERSHIP:
            continue
        numbers = tuple(system.number(a) for a in term.membership.arguments)
        corners.extend(x for x, _ in MEMBERSHIP[term.membership.kind].vertices(numbers) if low <= x <= high)
    beside = [np.nextafter(c, d) for c in corners for d in (-np.inf, np.inf)]
    points = np.unique(np.concatenate([np.linspace(low, high, 401), corners, beside]))
    return points[(points >= low) & (points <= high)]


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
    moved = []
    for label in labels:
        left, right = _extent(label, low, high, width)
        crossed = [u.height for u in labels if u.upright and left <= _at(u, low, high, width) <= right]
        moved.append(replace(label, height=max([label.height, *crossed])))
    return moved


def lanes(labels: Sequence[Label], low: float, high: float, width: float) -> list[int | None]:
    """Return for each label the lowest line on which it overlaps none to its left, or None.

    Args:
        labels: The labels.
        low: The left end of the axis.
        high: The right end.
        width: Its length in points.
    """
    lines: list[int | None] = [None] * len(labels)
    placed: list[tuple[float, float, float, int]] = []
    for k in sorted(range(len(labels)), key=lambda k: labels[k].at):
        left, right = _extent(labels[k], low, high, width)
        near = [(a, b, line) for a, b, height, line in placed if abs(height - labels[k].height) < SAME]
        busy = {line for a, b, line in near if a < right and left < b}
        free = next((line for line in range(MOST) if line not in busy), None)
        if free is not None:
            lines[k] = free
            placed.append((left, right, labels[k].height, free))
    return lines


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
