"""Region of a rule in the space of inputs: where its terms are above 0, and where they are highest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

from fuzzyctl.diagnostics.source import Span
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
        inputs: Its side along each input, in the order of the system; None where it is no box.
        point: The middle of each core; None where it is no box.
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
    found = degrees(system, variable, term, [*places, *middles])
    if found is None:
        return None
    at, between = found[: len(places)].tolist(), found[len(places) :].tolist()
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
