"""Checks of valid terms: whether they suit the defuzzifier, and where they lie."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Binary, Expr, Keyword, Name, Number, names_in, replace_names, span_of, walk
from fuzzyctl.formulas import MEMBERSHIP, exact_maxima_possible, is_monotone, is_number
from fuzzyctl.formulas.inverse import solved
from fuzzyctl.model.block import Bounds, ParamValues
from fuzzyctl.model.checks.partitions import spoilt_partitions
from fuzzyctl.model.computed_numbers import Numbers
from fuzzyctl.model.controller import EquationBlock, Instance
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.method import DEFUZZIFIERS, MAXIMA, TSUKAMOTO, Defuzzifier
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term
from fuzzyctl.records import record


def misfitting_defuzzifier(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find output terms that the defuzzifier cannot handle."""
    system = numbers.system
    for output in system.outputs:
        if output.value is not None:
            continue
        method = output.defuzzifier or system.method.defuzzifier
        if output.adaptive is not None and not method.averages:
            yield Diagnostic(
                "FZ214",
                f"adaptive output '{output.name}' needs a defuzzifier over rules, not '{method.kind}'",
                output.span,
                help=BY_AVERAGE,
            )
        if output.adaptive is not None:
            continue
        if DEFUZZIFIERS[method.kind].takes == "place":
            yield from _not_monotone(numbers, output, method)
        elif method.kind in TSUKAMOTO:
            yield from _without_names(system, output, method)
            yield from _without_sets(output, method)
        elif method.over_rules:
            yield from _without_peak(numbers, output, method)
        else:
            yield from _without_names(system, output, method)
            yield from _without_centroid(system, output, method)


_SAMPLED: Final = "defuzzifier centroid(resolution=1000)"


def _without_peak(numbers: Numbers, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find terms that no average can take, since they reach 1 nowhere."""
    for term, parameters in numbers.shapes(output):
        if any(map(math.isinf, MEMBERSHIP[term.membership.kind].core(parameters))):
            message = f"term '{term.name}' of '{output.name}' has no peak that '{method.kind}' could take"
            help_text = "use s_shape or ramp, or write: defuzzifier tsukamoto"
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)
    for term in output.terms:
        if term.membership.kind == "formula":
            message = (
                f"term '{term.name}' of '{output.name}' is a formula, without a peak that '{method.kind}' could take"
            )
            help_text = f"a function of the inputs does not name '{output.name}'; of sets write: {_SAMPLED}"
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


def _without_area(output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Report once the terms of an output that are numbers or functions, which have no area."""
    without = [t for t in output.terms if t.membership.kind in ("linear", "function") or is_number(t.membership.kind)]
    if not without:
        return
    first, *others = without
    what = "a number" if is_number(first.membership.kind) else "a function of the inputs"
    message = f"term '{first.name}' of '{output.name}' is {what} and has no area, so it has no {method.kind}"
    facts = (f"the same holds for {', '.join(repr(t.name) for t in others)}",) if others else ()
    place = first.membership.span or first.span
    yield Diagnostic("FZ214", message, place, facts=facts, help=BY_AVERAGE)


def _without_centroid(system: FuzzySystem, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find terms without an area, and maxima without a closed form."""
    implications = system.implications_of(output)
    aggregation = output.aggregation or system.method.aggregation
    sampled = f"write: defuzzifier {method.kind}(resolution=1000)"
    for term in output.terms:
        kind = term.membership.kind
        if kind in ("linear", "function") or is_number(kind):
            continue
        if kind == "formula" and method.resolution is None:
            message = f"'{method.kind}' of '{term.name}' of '{output.name}', which is a formula, has no closed form"
            help_text = f"sample it: defuzzifier {method.kind}(resolution=1000)"
        else:
            continue
        yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)
    yield from _without_area(output, method)
    kinds = [t.membership.kind for t in output.terms if t.membership.kind in MEMBERSHIP]
    is_known = method.resolution is not None or exact_maxima_possible(kinds, implications, aggregation)
    if method.kind in MAXIMA and not is_known:
        norms = "', '".join(implications)
        message = f"'{method.kind}' of its terms with '{norms}' and '{aggregation}' has no closed form"
        yield Diagnostic("FZ214", f"output '{output.name}': {message}", output.span, help=sampled)


def _without_sets(output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find terms without a degree at the activation."""
    for term in output.terms:
        kind = term.membership.kind
        if kind not in MEMBERSHIP or not MEMBERSHIP[kind].fuzzy:
            what = "is a formula" if kind == "formula" else "is not a set"
            message = f"term '{term.name}' of '{output.name}' {what}, and '{method.kind}' takes its degrees"
            help_text = _BY_POINTS if kind == "formula" else BY_AVERAGE
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


#: The repair of terms without an area.
BY_AVERAGE: Final = "in the line of the defuzzifier write: defuzzifier weighted_average"
_SOLVABLE: Final = (
    "name the output once, with numbers by + - * /, exp, log and sqrt; or approximate the formula: "
    "piecewise(x1, degree1, x2, degree2, ...)"
)
_BY_POINTS: Final = "approximate it by points of its curve: piecewise(x1, degree1, x2, degree2, ...)"


def _not_monotone(numbers: Numbers, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find consequents that Tsukamoto's method cannot invert."""
    shapes = {t.name: p for t, p in numbers.shapes(output)}
    for term in output.terms:
        kind = term.membership.kind
        help_text = "use ramp, sigmoid, s_shape, z_shape, concave, rising or falling points, or one infinite foot"
        if kind == "formula":
            if numbers.system.method.semantics.merge == "rules" and _can_be_solved(numbers, output, term):
                continue
            reason, help_text = f"a formula whose inverse '{method.kind}' does not know", _SOLVABLE
        elif kind not in MEMBERSHIP:
            reason = f"no set, and '{method.kind}' inverts sets"
        # One with bad parameters has another diagnostic.
        elif term.name in shapes and not is_monotone(kind, shapes[term.name]):
            reason = f"not monotone, so '{method.kind}' cannot invert it"
        else:
            continue
        message = f"term '{term.name}' of '{output.name}' is {reason}"
        yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)
    yield from _without_names(numbers.system, output, method)


def _can_be_solved(numbers: Numbers, output: Output, term: Term) -> bool:
    """Return whether the place of a degree of a formula can be written down, which factors of 0 prevent."""
    values = {name: Number(value) for name, value in numbers.params.values.items() if name != output.name}
    expression = replace_names(term.membership.arguments[0], values)
    factors = [part for e in walk(expression) if isinstance(e, Binary) and e.op in "*/" for part in (e.left, e.right)]
    is_flat = any(numbers.value(part) == 0.0 for part in factors if not names_in(part))
    return not is_flat and solved(expression, output.name, Name("w")) is not None


def _without_names(system: FuzzySystem, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find consequents without a name where sets are expected."""
    for r, k in system.conclusions.get(output.name, ()):
        c = system.rules[r].consequents[k]
        if isinstance(c.term, Membership):
            message = f"'{method.kind}' takes terms of '{output.name}', not numbers or functions"
            yield Diagnostic("FZ214", message, c.term.span or c.span, help=BY_AVERAGE)


def initial_consequents_outside(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find adaptive outputs whose consequents do not begin as numbers within the range."""
    for output in numbers.system.outputs:
        ends = numbers.range(output)
        if output.adaptive is None or ends is None:
            continue
        low, high = ends
        for term in output.terms:
            if term.membership.kind not in MEMBERSHIP:
                message = f"term '{term.name}' of adaptive output '{output.name}' must be a number"
                yield Diagnostic("FZ214", message, term.span, help="write, for example: terms NB=0 ZO=0 PB=0")
        for shape in numbers.shapes(output):
            first = numbers.core(shape)
            if not low <= first <= high:
                message = f"the initial consequent {shape[0].name} = {first:.6g} lies outside [{low:.6g}, {high:.6g}]"
                help_text = "adaptation is clipped to the range; start inside it"
                yield Diagnostic("FZ302", message, shape[0].span, help=help_text)


def _is_peaked(term: Term) -> bool:
    """Return whether a term has one top in its middle; of others the order says nothing."""
    return term.membership.kind in MEMBERSHIP and MEMBERSHIP[term.membership.kind].peaked


def terms_out_of_order(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find neighbouring terms whose cores are in descending order: mostly a slip in a number."""
    for variable in numbers.system.inputs:
        planned = [t for t in variable.terms if _is_peaked(t)]
        middles = [(s[0], numbers.core(s)) for s in numbers.shapes(variable) if _is_peaked(s[0])]
        if len(middles) < len(planned):
            continue  # bad parameters have another diagnostic
        rising = sum(b[1] >= a[1] for a, b in pairwise(middles))
        if rising * 2 < len(middles) - 1:
            continue  # listed from high to low on purpose
        for (left, a), (right, b) in pairwise(middles):
            if b < a:
                message = f"term '{right.name}' of '{variable.name}' lies left of '{left.name}' before it"
                facts = (f"peak of '{left.name}': {a:.6g}, of '{right.name}': {b:.6g}",)
                yield Diagnostic("FZ305", message, right.span, "warning", facts, help="check the numbers")


def values_outside_range(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find peaks of outputs and values of `else` outside the range: nothing clips them to it."""
    for output in numbers.system.outputs:
        ends = numbers.range(output)
        if ends is None:
            continue
        low, high = ends
        # A peak computed like the end of the range may differ from it by rounding.
        slack = 1e-9 * (high - low)
        bounds = f"[{low:.6g}, {high:.6g}] of '{output.name}'"
        for what, value, place in _lasting(numbers, output):
            if math.isfinite(value) and not low - slack <= value <= high + slack:
                message = f"the {what.format(f'{value:.6g}')} lies outside the range {bounds}"
                thing = "peak" if what.startswith("peak") else "value"
                yield Diagnostic("FZ306", message, place, "warning", help=f"widen the range, or move the {thing}")


def _lasting(numbers: Numbers, output: Output) -> Iterator[tuple[str, float, Span | None]]:
    """Yield the values that an output can have without being clipped: a description, the value, and its place."""
    for shape in numbers.shapes(output) if output.adaptive is None else ():
        yield f"peak {{}} of '{shape[0].name}'", numbers.core(shape), shape[0].span
    otherwise = output.otherwise.start if isinstance(output.otherwise, Hold) else output.otherwise
    value = numbers.finite(otherwise) if isinstance(otherwise, Expr) else None
    if isinstance(otherwise, Expr) and value is not None:
        yield "'else' value {}", value, span_of(otherwise) or output.span


def uncovered_ranges(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find parts of an input's range where no term has a degree above 0.

    Where some output has no `else`, the proof of coverage reports such a part as the hole it makes.
    """
    if any(o.otherwise is None and o.adaptive is None for o in numbers.system.outputs):
        return
    for variable in numbers.system.inputs:
        for low, high in _gaps(numbers, variable):
            message = f"no term of '{variable.name}' covers its range from {low:.6g} to {high:.6g}"
            yield Diagnostic("FZ309", message, variable.span, "warning", help="widen a term, or shorten the range")


def _gaps(numbers: Numbers, variable: Input) -> list[tuple[float, float]]:
    """Return the parts of the range, wider than a point, that no support reaches."""
    ends, shapes = numbers.range(variable), numbers.shapes(variable)
    if ends is None or not shapes or len(shapes) < len(variable.terms):
        return []  # no antecedent reads an input without terms, and the reach of a term with bad parameters is unknown
    supports: list[tuple[float, float]] = []
    for term, parameters in shapes:
        vertices = MEMBERSHIP[term.membership.kind].vertices(parameters)
        if not vertices:
            return []  # curved terms are above 0 nearly everywhere
        left = vertices[0][0] if vertices[0][1] == 0 else -math.inf
        right = vertices[-1][0] if vertices[-1][1] == 0 else math.inf
        supports.append((left, right))
    reached, upper = ends
    gaps: list[tuple[float, float]] = []
    for left, right in sorted(supports):
        if left > reached:
            gaps.append((reached, min(left, upper)))
        reached = max(reached, right)
        if reached >= upper:
            return gaps
    return [*gaps, (reached, upper)]


#: Each needs whole variables and a known method, so they run where every statement has a meaning.
SHAPE_CHECKS: Final[tuple[Callable[[Numbers], Iterator[Diagnostic]], ...]] = (
    misfitting_defuzzifier,
    initial_consequents_outside,
)

#: Checks of the same kind that give nothing but warnings.
SHAPE_HINTS: Final[tuple[Callable[[Numbers], Iterator[Diagnostic]], ...]] = (
    terms_out_of_order,
    values_outside_range,
    uncovered_ranges,
    spoilt_partitions,
)


@record(frozen=True, slots=True)
class Outside:
    """A number outside of its range: description, value, range, and the range with the numbers of its ends."""

    what: str
    value: float
    bounds: Bounds
    text: str


def outside_ranges(block: EquationBlock, given: Mapping[str, float], path: str = "") -> Iterator[Outside]:
    """Yield the params and starts of states that leave their ranges, those of blocks inside too.

    Params that follow from these are not reported.

    Args:
        block: A well-formed block.
        given: Values of its params in place of those that it has.
        path: Prefix of the names, such as `law.`.
    """
    changed = [replace(p, expression=Number(given[p.name])) if p.name in given else p for p in block.params]
    params = ParamValues(changed, partial=True)
    disturbances = block.disturbances if isinstance(block, Loop) else ()
    chosen = [(f"param '{path}{p.name}'", p.expression, p.bounds) for p in changed if p.name in given]
    others = [(f"param '{path}{p.name}'", p.expression, p.bounds) for p in changed if p.name not in given]
    others += [(f"the start of state '{path}{s.name}'", s.start, s.bounds) for s in block.states]
    others += [(f"disturbance '{path}{d.name}'", d.nominal, d.bounds) for d in disturbances]
    results = [*_outside(chosen, params)] or [*_outside(others, params)]
    yield from results
    if results:
        return
    for instance, inner, values in inside(block, params):
        yield from outside_ranges(inner, values, f"{path}{instance.name}.")


def _outside(ranged: Sequence[tuple[str, Expr, Bounds | None]], params: ParamValues) -> Iterator[Outside]:
    for what, number, bounds in ranged:
        if bounds is None:
            continue
        value, low, high = (params.of(e) for e in (number, bounds.lower, bounds.upper))
        if value is not None and low is not None and high is not None and not bounds.holds(value, low, high):
            yield Outside(what, value, bounds, bounds.text(low, high))


def has_computed_params(block: EquationBlock) -> bool:
    """Whether a param, or the end of its range, follows from others, in the block or in one inside it."""
    ranges = [(p.expression, p.bounds.lower, p.bounds.upper) for p in block.params if p.bounds is not None]
    if any(names_in(e) for pair in ranges for e in pair):
        return True
    for instance in block.instances:
        inner = block.callee(instance)
        arguments, ranged = _given(instance, inner), {p.name for p in inner.params if p.bounds is not None}
        if any(names_in(e) for name, e in arguments.items() if name in ranged) or has_computed_params(inner):
            return True
    return False


def inside(block: EquationBlock, params: ParamValues) -> Iterator[tuple[Instance, EquationBlock, dict[str, float]]]:
    """Yield the instances of a block, their blocks, and the values that they give its params, as far as known."""
    for instance in block.instances:
        inner = block.callee(instance)
        numbers = {name: params.of(e) for name, e in _given(instance, inner).items()}
        yield instance, inner, {name: value for name, value in numbers.items() if value is not None}


def _given(instance: Instance, inner: EquationBlock) -> dict[str, Expr]:
    """Return the values that an instance gives the params of its block."""
    names = {p.name for p in inner.params}
    return {a.name: a.value for a in instance.arguments if isinstance(a, Keyword) and a.name in names}
