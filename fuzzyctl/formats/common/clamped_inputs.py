"""Inputs clamped to their ranges, for formats without clamping: shoulders replace it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from fuzzyctl.expr import ZERO, Number, names_in
from fuzzyctl.formulas import MEMBERSHIP, is_endless, is_number
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Term

#: A corner of a straight function: its place and its degree.
Point = tuple[float, float]


def counts(variable: Input, system: FuzzySystem) -> bool:
    """Whether a consequent that is a function of the inputs names an input."""
    place = system.inputs.index(variable)
    memberships = [t.membership for o in system.outputs for t in o.terms]
    memberships += [c.term for r in system.rules for c in r.consequents if isinstance(c.term, Membership)]
    return any(
        (m.kind == "linear" and m.arguments[place] != ZERO)
        or (m.kind == "function" and variable.name in {n.name for n in names_in(m.arguments[0])})
        for m in memberships
    )


def holding_matters(system: FuzzySystem, variable: Input) -> bool:
    """Whether clamping an input to its range changes numbers."""
    if counts(variable, system):
        return True
    used = {i.term for r in system.rules for i in literals(r.antecedent) if i.variable == variable.name}
    ends = system.range_of(variable)
    return any(not _is_constant_beyond(system, t.membership, *ends) for t in variable.terms if t.name in used)


def _is_constant_beyond(system: FuzzySystem, membership: Membership, lower: float, upper: float) -> bool:
    """Whether a term has one degree from the lower end down, and one from the upper end up."""
    if membership.kind == "function":
        return not names_in(membership.arguments[0])
    if membership.kind not in MEMBERSHIP or is_endless(membership.kind):
        return False
    formula = MEMBERSHIP[membership.kind]
    p = tuple(system.number(a) for a in membership.arguments)
    corners = formula.vertices(p)
    if corners:
        below = {y for x, y in corners if x < lower} | {corners[0][1], _degree(corners, lower)}
        above = {y for x, y in corners if x > upper} | {corners[-1][1], _degree(corners, upper)}
        return len(below) == len(above) == 1
    bends = [x for x in (*formula.pieces(p), *formula.core(p)) if math.isfinite(x)]
    # A side without width is a jump; at the end of the range it counts as beyond the range.
    first, last = (p[0] == p[1], p[-1] == p[-2]) if membership.kind == "pi_shape" else (False, False)
    return lower <= min(bends) and max(bends) <= upper and not ((first and lower == p[0]) or (last and upper == p[-1]))


def _degree(corners: Sequence[Point], x: float) -> float:
    """Return the degree of a straight function at a place; the larger one if it jumps there."""
    at = [y for place, y in corners if place == x]
    if at or x < corners[0][0] or x > corners[-1][0]:
        return max(at) if at else corners[0][1] if x < corners[0][0] else corners[-1][1]
    (a, u), (b, v) = next(pair for pair in pairwise(corners) if pair[0][0] < x < pair[1][0])
    return u + (v - u) * ((x - a) / (b - a))


def with_shoulders(system: FuzzySystem, *, points: bool) -> FuzzySystem:
    """Return a system whose clamped inputs have, if straight functions can, the same degrees without clamping.

    Args:
        system: The system.
        points: Whether the format has lists of points, for functions that are neither 0 nor 1 at an end, and heights.
    """
    inputs = tuple(i if i.extrapolate else _with_shoulders(system, i, points) for i in system.inputs)
    return system.model_copy(update={"inputs": inputs})


def _with_shoulders(system: FuzzySystem, variable: Input, points: bool) -> Input:
    ends = system.range_of(variable)

    def cut(term: Term) -> Term:
        if _is_constant_beyond(system, term.membership, *ends):
            return term
        return term.model_copy(update={"membership": _cut(system, term.membership, *ends, points) or term.membership})

    return variable.model_copy(update={"terms": tuple(map(cut, variable.terms))})


def _cut(system: FuzzySystem, membership: Membership, lower: float, upper: float, points: bool) -> Membership | None:
    """Return a straight function that is the same within a range, and constant beyond; None if there is none."""
    if membership.kind not in MEMBERSHIP or is_number(membership.kind):
        return None
    corners = MEMBERSHIP[membership.kind].vertices(tuple(system.number(a) for a in membership.arguments))
    if not corners:
        return None
    inner = [(float(x), float(y)) for x, y in corners if lower < x < upper]
    line = [(lower, _degree(corners, lower)), *inner, (upper, _degree(corners, upper))]
    if not any(y for _, y in line):  # it is 0 within the range, and no kind is 0 everywhere
        return None
    kind, parameters = simplest(line) or ("piecewise", tuple(n for point in line for n in point))
    if not points and (kind == "piecewise" or system.number(membership.height) != 1):
        return None
    arguments = tuple(map(Number, parameters))
    return Membership(kind=kind, arguments=arguments, height=membership.height, span=membership.span)


def simplest(points: Sequence[Point]) -> tuple[str, tuple[float, ...]] | None:
    """Return the kind and the parameters of points that are a triangle, a trapezoid or a shoulder, else None.

    Args:
        points: Corners from left to right, beyond which the degree is constant.
    """
    corners = list(points)
    while len(corners) > 1 and corners[0][1] == corners[1][1]:
        del corners[0]
    while len(corners) > 1 and corners[-1][1] == corners[-2][1]:
        del corners[-1]
    places = tuple(x for x, _ in corners)
    match tuple(y for _, y in corners):
        case (0.0, 1.0, 0.0):
            return "triangle", places
        case (0.0, 1.0, 1.0, 0.0):
            return "trapezoid", places
        case (0.0, 1.0):
            return "triangle", (*places, math.inf)
        case (1.0, 0.0):
            return "triangle", (-math.inf, *places)
        case (1.0,):
            return "trapezoid", (-math.inf, *places, *places, math.inf)
    return None
