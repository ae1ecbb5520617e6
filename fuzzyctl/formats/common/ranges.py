"""Ranges of variables: estimated from terms, inputs clamped to them, and formulas that leave [0, 1] within them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, product
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ZERO, Expr, ExprError, Number, evaluate, names_in
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formulas import MEMBERSHIP, is_endless, is_number
from fuzzyctl.formulas.formula import between, union
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Term

Ends = tuple[float, float]

# --- estimates -----------------------------------------------------------------------------------------------------

#: Most points at which a function of the inputs is evaluated.
_MOST_POINTS: Final = 729

#: Steps from end to end of a range at which formulas are evaluated.
_STEPS: Final = 100

#: Rounding may bring a degree so far beyond [0, 1].
_SLACK: Final = 1e-12


def of_terms(supports: Iterable[Ends]) -> Ends | None:
    """Return the smallest range that holds all terms, None without terms; a single place gets some room."""
    finite = [s for s in supports if all(map(math.isfinite, s))]
    if not finite:
        return None
    low, high = union(*finite)
    if low < high:
        return low, high
    room = max(1.0, abs(low) * 0.5)
    return low - room, high + room


def of_function(expression: Expr, inputs: Mapping[str, Ends], values: Mapping[str, float]) -> Ends | None:
    """Return the least and the largest value of a function at the ends and middles of its inputs."""
    places: list[tuple[float, ...]] = [(low, low / 2 + high / 2, high) for low, high in inputs.values()]
    while places and math.prod(map(len, places)) > _MOST_POINTS:
        widest = max(range(len(places)), key=lambda i: len(places[i]))
        places[widest] = places[widest][1:2]
    points = (dict(zip(inputs, point, strict=True)) for point in product(*places))
    results = tuple(y for point in points if (y := _value(expression, {**values, **point})) is not None)
    return between(results) if results else None


def _value(expression: Expr, names: Mapping[str, float]) -> float | None:
    """Return the value of a formula; None if it has none."""
    try:
        return evaluate(expression, names)
    except ExprError:
        return None


def linear_range(parameters: Sequence[float], inputs: Iterable[Ends]) -> Ends:
    """Return the least and largest value of a linear consequent.

    Args:
        parameters: A coefficient for each input, and the constant; a constant consequent has that alone.
        inputs: The ranges of the inputs.
    """
    *coefficients, low = parameters
    high = low
    for factor, (first, last) in zip(coefficients, inputs, strict=False):
        low += min(factor * first, factor * last)
        high += max(factor * first, factor * last)
    return low, high


def finite_range(
    name: str,
    ends: tuple[Number, Number],
    needed: Iterable[float],
    place: Span,
    findings: Findings,
    kind: str = "infinite",
) -> tuple[Number, Number]:
    """Return a finite range: some ends, or the places needed in the direction of an infinite one, with a warning."""
    lower, upper = ends
    if math.isfinite(lower.value) and math.isfinite(upper.value):
        return lower, upper
    finite = [e for e in needed if math.isfinite(e)]
    low = lower.value if math.isfinite(lower.value) else min(finite, default=0.0)
    high = upper.value if math.isfinite(upper.value) else max(finite, default=1.0)
    if low >= high:
        low, high = (low, low + 1.0) if math.isfinite(lower.value) else (high - 1.0, high)
    message = f"the range of '{name}' is {kind}; [{low:.6g}, {high:.6g}] is what its terms need"
    findings.warning("FZ603", message, lower.span or place, help="give it a finite range")
    return Number(low), Number(high)


def corners(memberships: Iterable[Membership]) -> list[float]:
    """Return the numbers of some memberships, which lie about the places that matter."""
    return [a.value for m in memberships for a in m.arguments if isinstance(a, Number)]


def reached(membership: Membership, ranges: Sequence[Ends]) -> Ends:
    """Return the least and largest value of a constant or linear consequent over the ranges of the inputs."""
    parameters = corners([membership])
    if membership.kind not in ("constant", "linear") or not parameters:
        return math.inf, -math.inf
    return linear_range(parameters, ranges)


def warn_of_degrees_beyond(
    terms: Iterable[Term],
    variable: str,
    ends: Ends,
    findings: Findings,
    *,
    below: bool = True,
    params: Mapping[str, float] | None = None,
) -> None:
    """Warn once of each term whose formula of the variable leaves [0, 1] in the range, as other tools allow.

    Args:
        terms: The terms of the variable.
        variable: Its name.
        ends: Its range; without a finite one there is no warning.
        findings: Takes the warnings.
        below: Whether degrees below 0 matter; they do not in the maximum of sets, which begins at 0.
        params: Values of the other names in the formulas.
    """
    low, high = ends
    if not math.isfinite(high - low):
        return
    places = [low + (high - low) * k / _STEPS for k in range(_STEPS + 1)]
    least = -_SLACK if below else -math.inf
    for term in terms:
        if term.membership.kind not in ("function", "formula"):
            continue
        formula = term.membership.arguments[0]
        degrees = ((x, _value(formula, {**(params or {}), variable: x})) for x in places)
        outside = [(max(-y, y - 1.0), x, y) for x, y in degrees if y is not None and not least <= y <= 1.0 + _SLACK]
        if outside:
            _, x, y = max(outside)
            message = f"the degree of '{term.name}' is {y:.6g} at {variable} = {x:.6g}, and held within [0, 1] here"
            help_text = "other tools go on with it as it is; scale the formula, or clip it there, too"
            findings.warning("FZ609", message, term.membership.span or term.span, help=help_text)


#: A corner of a straight function: its place and its degree.
Point = tuple[float, float]


# --- clamped inputs ------------------------------------------------------------------------------------------------


def is_read_by_consequents(variable: Input, system: FuzzySystem) -> bool:
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
    if is_read_by_consequents(variable, system):
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
    vertices = formula.vertices(p)
    if vertices:
        below = {y for x, y in vertices if x < lower} | {vertices[0][1], _degree(vertices, lower)}
        above = {y for x, y in vertices if x > upper} | {vertices[-1][1], _degree(vertices, upper)}
        return len(below) == len(above) == 1
    bends = [x for x in (*formula.pieces(p), *formula.core(p)) if math.isfinite(x)]
    if not bends:
        return False
    # A side without width is a jump; at the end of the range it counts as beyond the range.
    first, last = (p[0] == p[1], p[-1] == p[-2]) if membership.kind == "pi_shape" else (False, False)
    return lower <= min(bends) and max(bends) <= upper and not ((first and lower == p[0]) or (last and upper == p[-1]))


def _degree(vertices: Sequence[Point], x: float) -> float:
    """Return the degree of a straight function at a place; the larger one if it jumps there."""
    at = [y for place, y in vertices if place == x]
    if at or x < vertices[0][0] or x > vertices[-1][0]:
        return max(at) if at else vertices[0][1] if x < vertices[0][0] else vertices[-1][1]
    (a, u), (b, v) = next(pair for pair in pairwise(vertices) if pair[0][0] < x < pair[1][0])
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
    """Return a straight function that is the same within a range, and constant beyond; None if it does not exist."""
    if membership.kind not in MEMBERSHIP or is_number(membership.kind):
        return None
    vertices = MEMBERSHIP[membership.kind].vertices(tuple(system.number(a) for a in membership.arguments))
    if not vertices:
        return None
    inner = [(float(x), float(y)) for x, y in vertices if lower < x < upper]
    line = [(lower, _degree(vertices, lower)), *inner, (upper, _degree(vertices, upper))]
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
    vertices = list(points)
    while len(vertices) > 1 and vertices[0][1] == vertices[1][1]:
        del vertices[0]
    while len(vertices) > 1 and vertices[-1][1] == vertices[-2][1]:
        del vertices[-1]
    places = tuple(x for x, _ in vertices)
    match tuple(y for _, y in vertices):
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
