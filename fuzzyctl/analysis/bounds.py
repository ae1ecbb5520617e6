"""Bounds of outputs, proved for the numbers that kernels return."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any, Final

from fuzzyctl.analysis.coverage import Hole, Verdict, breakpoints, cells, uncovered_of
from fuzzyctl.analysis.intervals import Interval, enclose, hull
from fuzzyctl.errors import NoRuleFiresError
from fuzzyctl.expr import Expr, Name, span_of
from fuzzyctl.kernels import inference, python_backend
from fuzzyctl.kernels.defuzzify import consequent_hull, support_hull
from fuzzyctl.kernels.plan import OutputPlan, Plan, degree_name, plan
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output
from fuzzyctl.source import Span

#: Points tried when looking for one where a bound is attained.
TRIES: Final = 20_000


@dataclass(frozen=True)
class OutputBound:
    """What an output can be.

    Args:
        name: The output.
        lo: No number a kernel returns is smaller.
        hi: No number a kernel returns is larger.
        exact: Whether both are attained, for an adaptive output by some state within its range.
        lo_span: The consequent term, or the `else` value, that gives `lo`, if it came from a text.
        hi_span: The same for `hi`.
        lo_at: A point where `lo` is attained, if one is known.
        hi_at: The same for `hi`.
    """

    name: str
    lo: float
    hi: float
    exact: bool
    lo_span: Span | None = None
    hi_span: Span | None = None
    lo_at: dict[str, float] | None = None
    hi_at: dict[str, float] | None = None


def output_bounds(system: FuzzySystem) -> dict[str, OutputBound]:
    """Bound every output over all inputs.

    An average lies between the consequents of the rules that can fire, a centroid between the ends of their supports,
    an adaptive output within its range. Where it is not proved that some rule always fires, `else` counts
    too. NaN, for `else nan` and for inputs that are NaN, is not bounded.

    Returns:
        A bound for each output by name.
    """
    flat = plan(system)
    verdicts = uncovered_of(flat)
    return {o.name: _bound(system, flat, o, verdicts[o.name]) for o in flat.outputs}


@dataclass(frozen=True)
class _End:
    """One end of a bound: its value, where it comes from, and where it is attained."""

    value: float
    span: Span | None = None
    at: dict[str, float] | None = None


def _bound(system: FuzzySystem, flat: Plan, output: OutputPlan, verdict: Verdict) -> OutputBound:
    declared = system.output(output.name)
    terms = _terms_that_fire(flat, output)
    ends = _ends(declared, flat, output, terms, covered=verdict is None)
    attained = output.rate is not None and bool(terms)
    if output.averages and output.rate is None:
        ends = _locate(flat, output, ends)
    if verdict is not None and isinstance(output.otherwise, float) and not math.isnan(output.otherwise):
        ends = _with_otherwise(declared, output.otherwise, verdict, ends, only=not terms)
        attained = attained and ends[0].value >= output.lower and ends[1].value <= output.upper
    low, high = ends
    exact = attained or (low.at is not None and high.at is not None)
    return OutputBound(output.name, low.value, high.value, exact, low.span, high.span, low.at, high.at)


def _terms_that_fire(flat: Plan, output: OutputPlan) -> list[int]:
    """Return the consequent terms of the rules whose firing strength is above 0 somewhere."""
    reach: dict[str, Interval] = {}
    for i, degree in enumerate(flat.degrees):
        own = cells(flat.variable(degree.variable), [degree.set])
        formula = degree.set.degree(Name("x"))
        reach[degree_name(i)] = hull(enclose(formula, {"x": cell.floats}) for cell in own)
    possible = [enclose(strength, reach)[1] > 0.0 for strength in flat.strengths]
    rules = [flat.rules[entry.rule] for entry in output.implied]
    return [e.term for e, r in zip(output.implied, rules, strict=True) if r.weight > 0.0 and possible[r.strength]]


def _ends(
    declared: Output, flat: Plan, output: OutputPlan, terms: Sequence[int], *, covered: bool
) -> tuple[_End, _End]:
    """Bound the output where some rule fires."""
    planned = [e.term for e in output.implied if flat.rules[e.rule].weight > 0.0]
    hull_of = consequent_hull if output.averages else support_hull
    # Kernels hold their results within the hull of all rules.
    held = hull_of(output, planned)
    wanted = hull_of(output, terms) if terms else held
    margin = _rounding(output, terms)
    ends: list[_End] = []
    for k, sign in enumerate((-1.0, 1.0)):
        value = wanted[k]
        if value != held[k]:
            # Within the hull of the rules that can fire the quotient is only held by rounding errors, which are small
            # where activations are not tiny, that is where coverage is proved.
            value = sign * min(sign * value + margin, sign * held[k]) if covered else held[k]
        ends.append(_End(value, _span_of_end(declared, output, terms, wanted[k])))
    return ends[0], ends[1]


def _rounding(output: OutputPlan, terms: Sequence[int]) -> float:
    """Bound the rounding error of a quotient of two sums, relative to the largest value in them.

    A sum of n products of numbers that are not negative is off by n ulp at most; the centroid has as many summands as
    sample points, or as pieces of the range, which are fewer than (2 corners + 1) · terms squared.
    """
    if output.averages:
        count, values = len(output.implied), [abs(output.terms[t].peak) for t in terms]
    else:
        count = output.resolution or 64 * (len(output.terms) + 1) ** 2
        values = [abs(output.lower), abs(output.upper)]
    return 4.0 * (count + 4) * 2.0**-53 * max(values, default=0.0)


def _span_of_end(declared: Output, output: OutputPlan, terms: Sequence[int], value: float) -> Span | None:
    if output.rate is not None:
        return None
    for t in terms:
        at = (output.terms[t].peak,) * 2 if output.averages else support_hull(output, [t])
        if value in at:
            return declared.terms[t].span
    return None


def _locate(flat: Plan, output: OutputPlan, ends: tuple[_End, _End]) -> tuple[_End, _End]:
    """Look for the ends among the corners of the input terms, where on a partition of unity one rule fires alone."""
    program = inference.evaluation(flat)
    if program.state:
        return ends
    names = [i.name for i in flat.inputs]
    kernel = python_backend.compile_source(python_backend.evaluation_source(program), program, names)
    position = flat.outputs.index(output)
    axes = [
        breakpoints(variable, [d.set for d in flat.degrees if d.variable == i])
        for i, variable in enumerate(flat.inputs)
    ]
    found: list[dict[str, float] | None] = [None, None]
    for point in islice(product(*axes), TRIES):
        value = _value(kernel, point, position, len(flat.outputs))
        for k, end in enumerate(ends):
            if found[k] is None and value == end.value:
                found[k] = dict(zip(names, point, strict=True))
        if None not in found:
            break
    return _End(ends[0].value, ends[0].span, found[0]), _End(ends[1].value, ends[1].span, found[1])


def _value(kernel: Callable[..., Any], point: Sequence[float], position: int, outputs: int) -> float:
    try:
        result = kernel(*point)
    except NoRuleFiresError:
        return math.nan
    return float(result if outputs == 1 else result[position])


def _with_otherwise(
    declared: Output, value: float, verdict: Verdict, ends: tuple[_End, _End], *, only: bool
) -> tuple[_End, _End]:
    """Add the value of `else`; it is attained where the hole is."""
    span = span_of(declared.otherwise) if isinstance(declared.otherwise, Expr) else declared.span
    end = _End(value, span, verdict.witness if isinstance(verdict, Hole) else None)
    if only:
        return end, end
    low, high = ends
    return (end if value < low.value else low), (end if value > high.value else high)
