"""Pictures beside the text: the surface and the terms of the system at the cursor, and the rules at a point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError, FuzzyctlError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.region import Region, region
from fuzzyctl.model.system import FuzzySystem

#: Draws one picture after the other: matplotlib's settings are those of the process.
DRAWER: Final = ThreadPoolExecutor(1, thread_name_prefix="pictures")
#: Points along an axis of the surface: what is drawn at every key is coarser than what `plot-surface` writes.
_RESOLUTION: Final = 31
#: Width and height of a surface beside its map [inch]: in a pane, half a window, texts of a wider picture are small.
_SIZE: Final = (8.0, 3.8)
#: Most rules that the picture of a point has.
_RULES: Final = 8


@dataclass(frozen=True)
class Axis:
    """An input of the system: its name, its label with the unit, its range, and its value in the pictures."""

    name: str
    label: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class Frame:
    """Where the map of the surface is in its picture, as fractions from the top left; `axes` names its inputs."""

    left: float
    top: float
    width: float
    height: float
    axes: tuple[str, ...]


@dataclass(frozen=True)
class Preview:
    """What a pane beside the text shows.

    Args:
        message: Why there are no pictures, or no surface; empty where there is one.
        title: Name of the system and of the output.
        surface: SVG of the output over the first two inputs, the others at the point; the region of the rule at the
            cursor is marked.
        terms: SVG of the terms of all variables.
        rules: SVG of the rules that act at the point; empty without a point.
        frame: Where clicks in the surface are points.
        inputs: The inputs with their ranges.
        rule: Where the strongest rule at the point is written; None without a point, or where no rule acts.
        strength: How strong it is, in [0, 1].
        region: Region of the rule at the cursor; None where the cursor is in none.
    """

    message: str = ""
    title: str = ""
    surface: str = ""
    terms: str = ""
    rules: str = ""
    frame: Frame | None = None
    inputs: tuple[Axis, ...] = ()
    rule: Span | None = field(default=None, compare=False)
    strength: float = 0.0
    region: Region | None = None


def preview(
    document: Document,
    offset: int,
    point: Mapping[str, float] | None = None,
    *,
    pictures: bool = True,
    dark: bool = False,
) -> Preview:
    """Return the pictures of the system at an offset, or of the first one where no system is there.

    Args:
        document: The text.
        offset: The cursor: its block is the system; its output, if it is in one or in a rule of one, the output.
        point: Values of inputs; those that are missing or no inputs are mid-range. None for no point.
        pictures: Whether pictures are drawn.
        dark: Whether the surface is shown on a dark background.
    """
    try:
        system, output, rule = chosen(document, offset)
    except LookupError as error:
        return Preview(str(error.args[0]))
    inputs = inputs_at(system, point or {})
    values = tuple((i.name, i.value) for i in inputs)
    found = Preview("", f"{system.name}: {output}", inputs=inputs)
    if pictures:
        found = replace(found, terms=_terms(system))
    try:
        if rule is not None:
            found = replace(found, region=region(system, rule))
        if point is not None:
            place, strength = strongest(system, output, values)
            own = place if place is not None and place.source.name == document.source.name else None
            found = replace(found, rule=own, strength=strength)
        if not pictures:
            return found
        surface, frame = _surface(system, output, rule, values[2:], dark)
    except FuzzyctlError as error:
        # A table that is not finished has gaps, and terms that can be seen.
        return replace(found, message=str(error))
    return replace(found, surface=surface, frame=frame, rules="" if point is None else _rules(system, values))


def chosen(document: Document, offset: int) -> tuple[FuzzySystem, str, int | None]:
    """Return the system at an offset, its output there, and the position of the rule there, None for none.

    Raises:
        LookupError: Where there is no system without mistakes; the message is for the user.
    """
    try:
        system = document.system_at(offset)
    except DiagnosticError as error:
        raise LookupError(error.diagnostics[0].message) from None
    if system is None:
        head = document.symbols.scope_at(offset)[1]
        is_system = head is not None and head.kind == "system"
        name = f"system '{head.name}' has" if head is not None and is_system else ""
        raise LookupError(f"{name or 'the text has no system, or its system has'} mistakes")
    rule = _rule_at(system, document, offset)
    return system, _output_at(system, document, offset, rule), rule


def inputs_at(system: FuzzySystem, point: Mapping[str, float]) -> tuple[Axis, ...]:
    """Return the inputs with their values at a point, brought into their ranges; mid-range where it has none."""
    found = []
    for v in system.inputs:
        low, high = system.number(v.lower), system.number(v.upper)
        middle = (low + high) / 2
        value = point.get(v.name, middle)
        value = middle if value != value else min(max(value, low), high)
        found.append(Axis(v.name, v.axis_label, low, high, value))
    return tuple(found)


def _rule_at(system: FuzzySystem, document: Document, offset: int) -> int | None:
    """Return the position of the rule at an offset; in a table, that of the cell."""
    for position, rule in enumerate(system.rules):
        s = rule.span
        if s is not None and s.source.name == document.source.name and s.start <= offset <= s.end:
            return position
    return None


def _output_at(system: FuzzySystem, document: Document, offset: int, rule: int | None) -> str:
    names = [o.name for o in system.outputs]
    if rule is not None:
        return system.rules[rule].consequents[0].output
    for symbol in document.symbols.all:
        if symbol.kind == "output" and symbol.whole.source.name == document.source.name:
            in_system = symbol.owner is not None and symbol.owner.name == system.name
            if in_system and symbol.name in names and symbol.whole.start <= offset <= symbol.whole.end:
                return symbol.name
    return names[0]


def strongest(system: FuzzySystem, output: str, values: Sequence[tuple[str, float]]) -> tuple[Span | None, float]:
    """Return where the rule of an output is written that is most active at a point, and how strong it is.

    Returns:
        None and 0 where no rule is active.
    """
    import numpy as np

    from fuzzyctl.plot.rule_regions import rule_strengths

    strengths = rule_strengths(system, np.array([value for _, value in values]))
    rules = [r for r, _ in system.conclusions.get(output, ()) if strengths[r] > 0]
    found = max(rules, key=lambda r: float(strengths[r]), default=None)
    return (system.rules[found].span, float(strengths[found])) if found is not None else (None, 0.0)


# A change of a comment, of another system or of the cursor leaves most pictures as they are; systems compare by value.


@lru_cache(maxsize=16)
def _surface(
    system: FuzzySystem, output: str, rule: int | None, others: tuple[tuple[str, float], ...], dark: bool
) -> tuple[str, Frame]:
    from fuzzyctl.plot.rule_regions import grid, lead, mark_rule
    from fuzzyctl.plot.style import svg
    from fuzzyctl.plot.surfaces import draw_surface

    axes = [v.name for v in system.inputs[:2]]
    fixed = dict(others)
    found: list[Any] = []

    def draw(figure: Any) -> None:
        draw_surface(figure, system, axes, fixed, output, _RESOLUTION, _SIZE)
        found.append(figure.axes[1 if len(axes) == 2 else 0])
        if rule is not None:
            grids, points = grid(system, axes, fixed, 4 * _RESOLUTION)
            mark_rule(found[0], grids, lead(system, output, rule, points))

    text = svg(draw, dark=dark)
    left, bottom, width, height = (float(x) for x in found[0].get_position().bounds)
    return text, Frame(left, 1 - bottom - height, width, height, tuple(axes))


@lru_cache(maxsize=8)
def _terms(system: FuzzySystem) -> str:
    from fuzzyctl.plot.memberships import draw_terms
    from fuzzyctl.plot.style import svg

    return svg(lambda figure: draw_terms(figure, system))


@lru_cache(maxsize=8)
def _rules(system: FuzzySystem, values: tuple[tuple[str, float], ...]) -> str:
    from fuzzyctl.explain.trace import trace
    from fuzzyctl.plot.rule_viewer import draw_rules
    from fuzzyctl.plot.style import svg

    found = trace(system, dict(values))
    return svg(lambda figure: draw_rules(figure, system, found, _RULES))
