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
    """Whether a consequent that is a function of the inputs names one."""
    place = system.inputs.index(variable)
    named = [t.membership for o in system.outputs for t in o.terms]
    named += [c.term for r in system.rules for c in r.consequents if isinstance(c.term, Membership)]
    for membership in named:
        if membership.kind == "linear" and membership.arguments[place] != ZERO:
            return True
        if membership.kind == "function" and variable.name in {n.name for n in names_in(membership.arguments[0])}:
            return True
    return False


def holding_matters(system: FuzzySystem, variable: Input) -> bool:
    """Whether an input that is not held at the ends of its range gives other numbers beyond them."""
    if counts(variable, system):
        return True
    used = {i.term for r in system.rules for i in literals(r.antecedent) if i.variable == variable.name}
    ends = system.number(variable.lower), system.number(variable.upper)
    return any(not _is_constant_beyond(system, t.membership, *ends) for t in variable.terms if t.name in used)


def _is_constant_beyond(system: FuzzySystem, membership: Membership, lower: float, upper: float) -> bool:
    """Whether a degree stays below the lower end what it is there, and above the upper end."""
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
    # A side of no width is a jump, which counts as what lies beyond the range where it stands at its end.
    first, last = (p[0] == p[1], p[-1] == p[-2]) if membership.kind == "pi_shape" else (False, False)
    return lower <= min(bends) and max(bends) <= upper and not ((first and lower == p[0]) or (last and upper == p[-1]))


def _degree(corners: Sequence[Point], x: float) -> float:
    """Return the degree of a straight function at a place; where it jumps the larger one."""
    at = [y for place, y in corners if place == x]
    if at or x < corners[0][0] or x > corners[-1][0]:
        return max(at) if at else corners[0][1] if x < corners[0][0] else corners[-1][1]
    (a, u), (b, v) = next(pair for pair in pairwise(corners) if pair[0][0] < x < pair[1][0])
    return u + (v - u) * ((x - a) / (b - a))


def with_shoulders(system: FuzzySystem, *, points: bool) -> FuzzySystem:
    """Return a system whose held inputs have, where straight functions can, the same degrees without being held.

    Args:
        system: The system.
        points: Whether the format has lists of points, for functions that are neither 0 nor 1 at an end, and heights.
    """
    inputs = tuple(i if i.extrapolate else _with_shoulders(system, i, points) for i in system.inputs)
    return system.model_copy(update={"inputs": inputs})


def _with_shoulders(system: FuzzySystem, variable: Input, points: bool) -> Input:
    lower, upper = system.number(variable.lower), system.number(variable.upper)
    terms: list[Term] = []
    for term in variable.terms:
        if not _is_constant_beyond(system, term.membership, lower, upper):
            found = _cut(system, term.membership, lower, upper, points)
            term = term.model_copy(update={"membership": found}) if found is not None else term
        terms.append(term)
    return variable.model_copy(update={"terms": tuple(terms)})


def _cut(system: FuzzySystem, own: Membership, lower: float, upper: float, points: bool) -> Membership | None:
    """Return a straight function that is the same within a range, and constant beyond; None where there is none."""
    if own.kind not in MEMBERSHIP or is_number(own.kind):
        return None
    corners = MEMBERSHIP[own.kind].vertices(tuple(system.number(a) for a in own.arguments))
    if not corners:
        return None
    ends = [(x, _degree(corners, x)) for x in (lower, upper)]
    inner = [(float(x), float(y)) for x, y in corners if lower < x < upper]
    found = [ends[0], *inner, ends[1]]
    if not any(y for _, y in found):  # nothing in the range belongs to it, and there is no set that nothing belongs to
        return None
    kind, parameters = simplest(found) or ("piecewise", tuple(n for point in found for n in point))
    if not points and (kind == "piecewise" or system.number(own.height) != 1):
        return None
    return Membership(kind=kind, arguments=tuple(map(Number, parameters)), height=own.height, span=own.span)


def simplest(points: Sequence[Point]) -> tuple[str, tuple[float, ...]] | None:
    """Return the kind and the parameters of a set of points that is a triangle, a trapezoid or a shoulder, else None.

    Args:
        points: Corners from left to right, beyond which the degree stays.
    """
    kept = list(points)
    while len(kept) > 1 and kept[0][1] == kept[1][1]:
        del kept[0]
    while len(kept) > 1 and kept[-1][1] == kept[-2][1]:
        del kept[-1]
    places = tuple(x for x, _ in kept)
    match tuple(y for _, y in kept):
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
