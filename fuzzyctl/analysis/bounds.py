"""Bounds of outputs, proved for the numbers that kernels return."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from itertools import islice, product
from typing import Any, Final

from fuzzyctl.analysis.coverage.box_search import Hole, Verdict
from fuzzyctl.analysis.coverage.coverage import kept_of
from fuzzyctl.analysis.coverage.silence import Silence
from fuzzyctl.analysis.degrees import (
    CERTAIN,
    Cell,
    Truths,
    activation_in,
    breakpoints,
    cells,
    degree_in,
    effect_in,
    enclosed,
)
from fuzzyctl.analysis.work import SpentError, Work, clock, compiling
from fuzzyctl.diagnostics.diagnostic import Diagnostic, NoRuleFiresError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, Name, span_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.defuzzify.defuzzify import closed_form, consequent_hull, support_hull
from fuzzyctl.kernels.interval.scalar import ANYTHING, Interval, enclose, hull
from fuzzyctl.kernels.plan.build import HeldPlan, OutputPlan, Plan, SetPlan, degree_name, plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.quadrature import MOST
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Output
from fuzzyctl.records import dataclass
from fuzzyctl.support import arguments

#: Note on a bound whose search ended for lack of time.
SPENT: Final = "the time is spent; with more of it the bound may be tighter"
#: Points tried in the search for one that attains a bound.
TRIES: Final = 20_000


@dataclass(frozen=True)
class OutputBound:
    """The values that an output can have.

    Args:
        name: The output.
        lo: No number a kernel returns is smaller.
        hi: No number a kernel returns is larger.
        exact: Whether both are attained, for an adaptive output by some state within its range.
        lo_span: The consequent term, or the `else` value, that gives `lo`, if it came from a text.
        hi_span: The same for `hi`.
        lo_at: A point where `lo` is attained, if one is known.
        hi_at: The same for `hi`.
        note: Why an end is open, and for which inputs the bound is proved if not for all.
    """

    name: str
    lo: float
    hi: float
    exact: bool
    lo_span: Span | None = field(default=None, repr=False)
    hi_span: Span | None = field(default=None, repr=False)
    lo_at: dict[str, float] | None = None
    hi_at: dict[str, float] | None = None
    note: str = field(default="", repr=False)


def output_bounds(system: FuzzySystem) -> dict[str, OutputBound]:
    """Bound every output over all inputs; a system keeps its bounds.

    An average lies between the consequents of the rules that can fire, a weighted sum within the sum of what each rule
    can add, a centroid between the ends of their supports, an adaptive output within its range. Where it is not proved
    that some rule always fires, `else` counts too; an output that holds its previous value holds one that lies within
    these bounds, or its value at the start. NaN, for `else nan` and for inputs that are NaN, is not bounded.

    Returns:
        A bound for each output by name.

    Raises:
        ArgumentError: For an object that is not a system.
    """
    arguments.instance("the system", FuzzySystem, "a FuzzySystem", system)
    if "bounds" not in system.derived:
        system.derived["bounds"] = _bounds(system)
    return dict(system.derived["bounds"])


def _bounds(system: FuzzySystem) -> dict[str, OutputBound]:
    flat = plan(system)
    verdicts = kept_of(system)
    activations = _activations(flat)
    results: dict[str, OutputBound] = {}
    for o in (flat.outputs[k] for k in flat.order):
        if o.value is None:
            results[o.name] = _bound(system, flat, o, activations, verdicts[o.name])
        else:
            results[o.name] = _of_formula(flat, o, o.value, results)
    return {o.name: results[o.name] for o in flat.outputs}


def _of_formula(flat: Plan, output: OutputPlan, value: Expr, known: Mapping[str, OutputBound]) -> OutputBound:
    """Bound an output that is a formula, those that it reads known."""
    box = _box(flat) | {name: (b.lo, b.hi) for name, b in known.items()}
    low, high = (_End(end) for end in enclose(value, box))
    if output.clamped:
        low, high = _clamped(output, low), _clamped(output, high)
    return OutputBound(output.name, low.value, high.value, exact=False)


def diagnostics(system: FuzzySystem, flat: Plan, verdicts: Mapping[str, Verdict]) -> list[Diagnostic]:
    """Report outputs whose functions or sums may leave the declared range; single peaks outside it are warnings.

    Args:
        system: The system.
        flat: Its plan.
        verdicts: On the coverage of the outputs.
    """
    results: list[Diagnostic] = []
    if not any(_is_computed(o) for o in flat.outputs):
        return results
    activations = _activations(flat)
    for declared, output in zip(system.outputs, flat.outputs, strict=True):
        if output.value is not None:
            results.extend(_beyond_range(declared, output, enclose(output.value, _box(flat))))
            continue
        terms = _terms_that_fire(flat, output, activations)
        reaches_out = output.sums or any(output.terms[t].reads_inputs for t in terms)
        if not (_is_computed(output) and reaches_out):
            continue
        ends = _ends(declared, flat, output, terms, activations, covered=verdicts[output.name] is None)
        results.extend(_beyond_range(declared, output, (ends[0].value, ends[1].value)))
    return results


def _beyond_range(declared: Output, output: OutputPlan, ends: Interval) -> Iterator[Diagnostic]:
    low, high = ends
    slack = 1e-9 * (output.upper - output.lower)
    is_known = math.isfinite(low) and math.isfinite(high)  # where inputs extrapolate little is
    if is_known and not output.clamped and (low < output.lower - slack or high > output.upper + slack):
        yield _beyond(declared, output, low, high)


def _is_computed(output: OutputPlan) -> bool:
    """Return whether an output that is not clamped sums over its rules, or has functions of the inputs as terms."""
    if output.rate is not None or output.clamped:
        return False
    return output.value is not None or output.sums or any(t.reads_inputs for t in output.terms)


def _beyond(declared: Output, output: OutputPlan, low: float, high: float) -> Diagnostic:
    width = output.upper - output.lower
    ends = ", ".join(f"{0.0 if abs(e) < 1e-9 * width else e:.6g}" for e in (low, high))  # without margins of rounding
    limits = f"its range [{output.lower:.6g}, {output.upper:.6g}]"
    message = f"output '{output.name}' is proved to lie within [{ends}], and may leave {limits}"
    help_text = f"write 'output {output.name} ... clamp', or widen the range; where it is meant, write 'allow FZ408'"
    return Diagnostic("FZ408", message, declared.span, "hint", (), help_text)


@dataclass(frozen=True)
class _End:
    """One end of a bound: its value, where it comes from, and where it is attained."""

    value: float
    span: Span | None = None
    at: dict[str, float] | None = None


def _bound(
    system: FuzzySystem, flat: Plan, output: OutputPlan, activations: Sequence[Interval], verdict: Verdict
) -> OutputBound:
    declared = system.output(output.name)
    terms = _terms_that_fire(flat, output, activations)
    ends = _ends(declared, flat, output, terms, activations, covered=verdict is None)
    attained = output.rate is not None and bool(terms)
    if output.clamped:
        ends = _clamped(output, ends[0]), _clamped(output, ends[1])
    if output.averages and output.rate is None:
        ends = _locate(flat, output, ends)
    other = output.otherwise.start if isinstance(output.otherwise, HeldPlan) else output.otherwise
    if output.clamped and isinstance(other, float):
        other = _clamped(output, _End(other)).value
    if verdict is not None and isinstance(other, float) and not math.isnan(other):
        ends = _with_otherwise(flat, declared, other, verdict, ends, only=not terms)
        attained = attained and ends[0].value >= output.lower and ends[1].value <= output.upper
    low, high = ends
    exact = attained or (low.at is not None and high.at is not None)
    return OutputBound(output.name, low.value, high.value, exact, low.span, high.span, low.at, high.at)


def _clamped(output: OutputPlan, end: _End) -> _End:
    """Return an end held within the range of the output; where it is attained, so is the end of the range."""
    return replace(end, value=min(max(end.value, output.lower), output.upper))


def _activations(flat: Plan) -> list[Interval]:
    """Enclose the activation of each rule over all inputs."""
    reach: dict[str, Interval] = {}
    for i, degree in enumerate(flat.degrees):
        reach[degree_name(i)] = _reach(degree.set, cells(flat.variable(degree.variable), [degree.set]))
    truths = Truths(flat, reach)
    fired = [truths.strength(strength) for strength in flat.strengths]
    return [activation_in(flat, rule, fired[rule.strength]) for rule in flat.rules]


def _reach(term: SetPlan, parts: Sequence[Cell]) -> Interval:
    """Enclose a degree over the cells of a variable: each of them, or all at once if there is no time."""
    results: list[Interval] = []
    for part in parts:
        if clock.is_over():
            return degree_in(term, (parts[0].floats[0], parts[-1].floats[1]))
        results.append(degree_in(term, part.floats))
    return hull(results)


def _terms_that_fire(flat: Plan, output: OutputPlan, activations: Sequence[Interval]) -> list[int]:
    """Return the consequent terms of the rules whose activation is above 0 somewhere."""
    return [e.term for e in output.implied if effect_in(flat, e, activations[e.rule])[1] > 0.0]


def _hull(output: OutputPlan, terms: Sequence[int], box: Mapping[str, Interval]) -> Interval:
    """Enclose an output while the rules of some terms act; `box` encloses the names that they may read."""
    if not output.over_rules:
        return (output.lower, output.upper) if clock.is_over() else support_hull(output, [*dict.fromkeys(terms)])
    functions = [t for t in terms if output.terms[t].reads_inputs and output.terms[t].reach is None]
    others = [t for t in terms if t not in functions]
    values = [_values(output.terms[t], box) for t in functions]
    return hull([*values, *([consequent_hull(output, others)] if others or not values else [])])


def _values(term: SetPlan, box: Mapping[str, Interval]) -> Interval:
    """Enclose a consequent that is a function of the inputs."""
    assert term.expression is not None
    return enclose(term.expression, box)


def _box(flat: Plan) -> dict[str, Interval]:
    """Enclose the names that a formula may read."""
    return enclosed(flat) | {o.name: ANYTHING for o in flat.outputs}


def _sum_ends(flat: Plan, output: OutputPlan, activations: Sequence[Interval]) -> tuple[_End, _End]:
    """Bound a weighted sum rule by rule."""
    names, box = {"w": ANYTHING, "z": ANYTHING}, _box(flat)
    low = high = size = 0.0
    for entry in output.implied:
        acts = effect_in(flat, entry, activations[entry.rule])
        if output.merge != "rules":  # it may count instead of rules that it is joined with, or they instead of it
            acts = 0.0, 1.0 if acts[1] > 0.0 else 0.0
        names |= {"w": acts, "z": _hull(output, [entry.term], box)}
        least, most = (0.0, 0.0) if names["w"] == (0.0, 0.0) else enclose(_PRODUCT, names)
        low, high, size = low + least, high + most, size + max(abs(least), abs(most))
    margin = 4.0 * (len(output.implied) + 4) * 2.0**-53 * size
    return _End(low - margin if margin else low), _End(high + margin if margin else high)


_PRODUCT: Final = Name("w") * Name("z")


def _ends(
    declared: Output,
    flat: Plan,
    output: OutputPlan,
    terms: Sequence[int],
    activations: Sequence[Interval],
    *,
    covered: bool,
) -> tuple[_End, _End]:
    """Bound the output where some rule fires."""
    if output.sums:
        return _sum_ends(flat, output, activations)
    planned, box = [e.term for e in output.implied if flat.rules[e.rule].weight > 0.0], _box(flat)
    # Kernels hold their results within the hull of all rules; with functions of the inputs, of the rules that fire.
    envelope = _hull(output, planned, box)
    wanted = _hull(output, terms, box) if terms and terms != planned else envelope
    if any(output.terms[t].reads_inputs and output.terms[t].reach is None for t in planned):
        envelope = wanted
    if output.total != "activations":
        wanted = envelope = hull([envelope, (0.0, 0.0)])
    margin = _rounding(output, terms)
    ends: list[_End] = []
    for k, sign in enumerate((-1.0, 1.0)):
        value = wanted[k]
        if value != envelope[k]:
            # Within the hull of the rules that can fire the quotient is only held by rounding errors, which are small
            # where activations are not tiny, that is where coverage is proved.
            sure = covered and not _may_choose_tiny(flat)
            value = sign * min(sign * value + margin, sign * envelope[k]) if sure else envelope[k]
        ends.append(_End(value, _span_of_end(declared, output, terms, wanted[k])))
    return ends[0], ends[1]


def _may_choose_tiny(flat: Plan) -> bool:
    """Return whether the activation method may choose a rule of tiny activation where another fires."""
    return any(m.kind == "lowest" or (m.kind in ("first", "last") and m.threshold < CERTAIN) for m in flat.activations)


def _rounding(output: OutputPlan, terms: Sequence[int]) -> float:
    """Bound the rounding error of a quotient of two sums, relative to the largest value in them.

    A sum of n products of numbers that are not negative is off by n ulp at most; the centroid has as many summands as
    sample points, or as pieces of the range, which are fewer than (2 corners + 1) · terms squared.
    """
    if output.over_rules:
        count, values = len(output.implied), [abs(end) for end in consequent_hull(output, terms)]
    else:
        sets = [output.terms[e.term] for e in output.implied]
        pieces = 64 * (len(output.terms) + 1) ** 2 if closed_form(output, sets) else 15 * MOST
        count = (output.resolution or pieces) * (len(sets) + 1 if output.rule == "polygon" else 1)
        values = [abs(output.lower), abs(output.upper)]
    return 4.0 * (count + 4) * 2.0**-53 * max(values, default=0.0)


def _span_of_end(declared: Output, output: OutputPlan, terms: Sequence[int], value: float) -> Span | None:
    if output.rate is not None:
        return None
    for t in terms:
        if clock.is_over():
            return None
        at = consequent_hull(output, [t]) if output.over_rules else support_hull(output, [t])
        if value in at and t < len(declared.terms):
            return declared.terms[t].span
    return None


def _locate(flat: Plan, output: OutputPlan, ends: tuple[_End, _End]) -> tuple[_End, _End]:
    """Look for the ends among the corners of the input terms, where on a partition of unity one rule fires alone."""
    if clock.is_over(compiling(flat)):
        return ends
    program = inference.evaluation(flat)
    if program.state:
        return ends
    names = [i.name for i in flat.inputs]
    kernel = scalar.compile_source(scalar.evaluation_source(program), program, names)
    position = flat.outputs.index(output)
    axes = [
        breakpoints(variable, [d.set for d in flat.degrees if d.variable == i])
        for i, variable in enumerate(flat.inputs)
    ]
    results: list[dict[str, float] | None] = [None, None]
    for point in islice(product(*axes), TRIES):
        if clock.is_over():
            break
        value = _value(kernel, point, position, len(flat.outputs))
        for k, end in enumerate(ends):
            if results[k] is None and value == end.value:
                results[k] = dict(zip(names, point, strict=True))
        if None not in results:
            break
    return _End(ends[0].value, ends[0].span, results[0]), _End(ends[1].value, ends[1].span, results[1])


def _value(kernel: Callable[..., Any], point: Sequence[float], position: int, outputs: int) -> float:
    try:
        result = kernel(*point)
    except NoRuleFiresError:
        return math.nan
    return float(result if outputs == 1 else result[position])


def _with_otherwise(
    flat: Plan, declared: Output, value: float, verdict: Verdict, ends: tuple[_End, _End], *, only: bool
) -> tuple[_End, _End]:
    """Add the value of `else`; it is attained in the hole."""
    otherwise = declared.otherwise.start if isinstance(declared.otherwise, Hold) else declared.otherwise
    span = span_of(otherwise) if isinstance(otherwise, Expr) else declared.span
    low, high = ends
    if not only and low.value <= value <= high.value:
        return ends
    end = _End(value, span, _confirmed(flat, declared.name, verdict))
    if only:
        return end, end
    return (end if value < low.value else low), (end if value > high.value else high)


def _confirmed(flat: Plan, name: str, verdict: Verdict) -> dict[str, float] | None:
    """Return a point where no rule moves an output, if an evaluation there confirms it."""
    with suppress(SpentError):
        if isinstance(verdict, Hole) and Silence(flat, name, Work(math.inf)).confirms(verdict):
            return verdict.witness
    return None
