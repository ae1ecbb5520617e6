"""Pictures beside the text: the surface and the terms of the system at the cursor, and the rules at a point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError, FuzzyctlError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.formats.fz import rule_text
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.kernels.plan.build import planned_set
from fuzzyctl.model.rule import And, Antecedent, Is
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Term

Ends = tuple[float, float]
#: Degrees that differ by less are the same height.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Side:
    """Extent of a region along one input: ends of the support and of the core, within the range of the input."""

    name: str
    support: Ends
    core: Ends


@dataclass(frozen=True)
class Value:
    """A value of an input."""

    name: str
    value: float


@dataclass(frozen=True)
class Region:
    """Region of a rule.

    Args:
        rule: Where the rule, or the cell of a table, is written.
        text: The rule as a line.
        inputs: Its side along each input, in the order of the system; None where it is not a box.
        point: The middle of each core; None where it is not a box.
    """

    rule: Span | None = field(compare=False)
    text: str
    inputs: tuple[Side, ...] | None
    point: tuple[Value, ...] | None


def region(system: FuzzySystem, position: int) -> Region:
    """Return the region of the rule at a position of `FuzzySystem.rules`."""
    rule = system.rules[position]
    conditions = _conditions(rule.antecedent)
    found: list[Side] | None = []
    for variable in system.inputs:
        asked = [c for c in conditions or () if c.variable == variable.name]
        side = _side(system, variable, asked)
        found = [*found, side] if side is not None and found is not None else None
    names = {v.name for v in system.inputs}
    if conditions is None or found is None or any(c.variable not in names for c in conditions):
        return Region(rule.span, rule_text(rule), None, None)
    point = tuple(Value(s.name, 0.5 * s.core[0] + 0.5 * s.core[1]) for s in found)
    return Region(rule.span, rule_text(rule), tuple(found), point)


def _conditions(antecedent: Antecedent) -> tuple[Is, ...] | None:
    """Return the conditions of a conjunction of plain terms, those that always hold left out; None for others."""
    match antecedent:
        case Is(hedges=()):
            return (antecedent,)
        case Is(hedges=("any",)):
            return ()
        case And(operands=operands):
            parts = [_conditions(o) for o in operands]
            return None if None in parts else tuple(c for part in parts if part is not None for c in part)
    return None


def _side(system: FuzzySystem, variable: Input, conditions: list[Is]) -> Side | None:
    """Return the side of a region along an input; None where terms have no ends or have nothing in common."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    supports, cores = [(low, high)], [(low, high)]
    for condition in conditions:
        term = variable.term(condition.term)
        ends = ends_of(system, variable, term) if term is not None else None
        if ends is None:
            return None
        supports.append(ends[0])
        cores.append(ends[1])
    support, core = _common(supports), _common(cores)
    return Side(variable.name, support, core) if support is not None and core is not None else None


def _common(ends: list[Ends]) -> Ends | None:
    low, high = max(a for a, _ in ends), min(b for _, b in ends)
    return (low, high) if low <= high else None


def ends_of(system: FuzzySystem, variable: Input, term: Term) -> tuple[Ends, Ends] | None:
    """Return the ends of a term's support and core within the range of its input.

    A support or core in several parts counts from its first to its last end.

    Returns:
        The ends; None for a function of the input, and for a term that is 0 in the range.
    """
    planned = planned_set(system, variable, term)
    if planned is None or term.membership.kind not in MEMBERSHIP:
        return None
    low, high = system.number(variable.lower), system.number(variable.upper)
    corners = [x for x, _ in planned.vertices]
    places = sorted({low, high, *(x for x in (*corners, *planned.pieces) if low < x < high)})
    middles = [0.5 * a + 0.5 * b for a, b in pairwise(places)]
    heights = degrees(system, variable, term, [*places, *middles])
    if heights is None:
        return None
    at, between = heights[: len(places)].tolist(), heights[len(places) :].tolist()
    inside = [*_above(places, at, between, curved=not corners), *(x for x, y in zip(places, at, strict=True) if y > 0)]
    if not inside:
        return None
    top = max(at)
    core = [x for x, y in zip(places, at, strict=True) if y >= top - _ROUNDING]
    return (min(inside), max(inside)), (core[0], core[-1])


def _above(places: list[float], at: list[float], between: list[float], *, curved: bool) -> Iterator[float]:
    """Yield the ends of the stretches between places over which a degree is above 0.

    That of a curve may be 0 by rounding in the middle of a stretch, far from where it is highest.
    """
    for (a, b), (left, right), middle in zip(pairwise(places), pairwise(at), between, strict=True):
        if middle > 0 or (curved and max(left, right) > 0):
            yield from (a, b)


#: Draws one picture after the other: matplotlib's settings are those of the process.
DRAWER: Final = ThreadPoolExecutor(1, thread_name_prefix="pictures")
#: Points along an axis of the surface, which is coarser than that of `plot-surface`, as it is drawn at every key.
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
    """The contents of a pane beside the text.

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
        region: Region of the rule at the cursor; None without a rule at the cursor.
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
    inputs = []
    for v in system.inputs:
        low, high = system.number(v.lower), system.number(v.upper)
        middle = (low + high) / 2
        value = point.get(v.name, middle)
        value = middle if value != value else min(max(value, low), high)
        inputs.append(Axis(v.name, v.axis_label, low, high, value))
    return tuple(inputs)


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

    from fuzzyctl.plot.surfaces import rule_strengths

    strengths = rule_strengths(system, np.array([value for _, value in values]))
    rules = [r for r, _ in system.conclusions.get(output, ()) if strengths[r] > 0]
    rule = max(rules, key=lambda r: float(strengths[r]), default=None)
    return (system.rules[rule].span, float(strengths[rule])) if rule is not None else (None, 0.0)


# A change of a comment, of another system or of the cursor leaves most pictures as they are; systems compare by value.


@lru_cache(maxsize=16)
def _surface(
    system: FuzzySystem, output: str, rule: int | None, others: tuple[tuple[str, float], ...], dark: bool
) -> tuple[str, Frame]:
    from fuzzyctl.plot.style import svg
    from fuzzyctl.plot.surfaces import draw_surface, grid, lead, mark_rule

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
