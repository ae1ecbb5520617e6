"""Checks of a model: a flat list of small ones, each a function from a system to diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Final

from fuzzyctl.errors import Diagnostic, DiagnosticError, Note
from fuzzyctl.expr import Expr, ExprError, Number, evaluate, names_in, span_of
from fuzzyctl.formulas import MEMBERSHIP, exact_centroid_possible, is_monotone
from fuzzyctl.model.claims import bad_claims, uncomputable_claims
from fuzzyctl.model.hints import jumping_tables, uncovered_ranges
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, literals
from fuzzyctl.model.system import FuzzySystem, ParamCycleError
from fuzzyctl.model.variable import Hold, LinguisticVariable, Membership, Output, Term
from fuzzyctl.source import Span

Check = Callable[[FuzzySystem], Iterator[Diagnostic]]


def check_model(system: FuzzySystem) -> list[Diagnostic]:
    """Return all diagnostics of a system, in the order of their places.

    Checks that need numbers run only when every number can be computed, so that one mistake gives one diagnostic.
    """
    found = list(uncomputable_numbers(system))
    if not found:
        found = [d for check in CHECKS for d in check(system)]
    return sorted(found, key=lambda d: d.span.start if d.span is not None else -1)


def require_well_formed(system: FuzzySystem) -> None:
    """Raise `DiagnosticError` when a system has errors; warnings pass."""
    errors = [d for d in check_model(system) if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)


def uncomputable_numbers(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find params that depend on themselves, divisions by zero, and values that are not finite."""
    try:
        values = system.values
    except ParamCycleError as error:
        yield Diagnostic("FZ308", error.message, error.span, help="break the cycle: give one of them a number")
        return
    except ExprError as error:
        yield Diagnostic("FZ307", error.message, error.span)
        return
    infinite = list(_infinite_ranges(system, values))
    yield from infinite
    seen: set[Span] = set()
    for expr, may_be_infinite, what in _numbers(system):
        # The ends of a range are also peaks of an even partition; one place gives one diagnostic.
        place = span_of(expr)
        if place in seen or (place is None and infinite and not isinstance(expr, Number)):
            continue
        if place is not None:
            seen.add(place)
        try:
            value = evaluate(expr, values)
        except ExprError as error:
            yield Diagnostic("FZ307", f"{what}: {error.message}", error.span or span_of(expr))
            continue
        if math.isinf(value) and not may_be_infinite:
            yield Diagnostic("FZ302", f"{what} is infinite", span_of(expr), help="only feet may be infinite")
    yield from uncomputable_claims(system)


def _infinite_ranges(system: FuzzySystem, values: Mapping[str, float]) -> Iterator[Diagnostic]:
    for v in (*system.inputs, *system.outputs):
        try:
            infinite = any(math.isinf(evaluate(e, values)) for e in (v.lower, v.upper))
        except ExprError:
            continue  # this has a diagnostic of its own
        if infinite:
            span = _join(span_of(v.lower), span_of(v.upper)) or v.span
            yield Diagnostic("FZ302", f"the range of '{v.name}' is infinite", span, help="only feet may be infinite")


def _numbers(system: FuzzySystem) -> Iterator[tuple[Expr, bool, str]]:
    """Yield every expression of a system with whether it may be infinite and what it is."""
    for variable in (*system.inputs, *system.outputs):
        yield variable.lower, True, f"the lower end of '{variable.name}'"
        yield variable.upper, True, f"the upper end of '{variable.name}'"
        for term in variable.terms:
            yield from _parameters(term.membership, term.name)
            yield term.membership.height, False, f"the height of '{term.name}'"
    for output in system.outputs:
        if isinstance(output.otherwise, Expr):
            yield output.otherwise, False, f"the 'else' value of '{output.name}'"
        elif isinstance(output.otherwise, Hold) and output.otherwise.start is not None:
            yield output.otherwise.start, False, f"the value that '{output.name}' holds at first"
    for rule in system.rules:
        yield rule.weight, False, "the weight"
        for c in rule.consequents:
            if isinstance(c.term, Membership):
                yield from _parameters(c.term, c.output)
    if system.method.activation.threshold is not None:
        yield system.method.activation.threshold, False, "the threshold"
    for guarantee in system.guarantees:
        if guarantee.within is not None:
            yield guarantee.within, False, "the tolerance"


def _parameters(membership: Membership, name: str) -> Iterator[tuple[Expr, bool, str]]:
    if membership.kind == "function":
        return  # an expression over variables has no value of its own
    formula = MEMBERSHIP.get(membership.kind)
    for i, argument in enumerate(membership.arguments):
        named = formula is not None and i < len(formula.parameters)
        parameter = formula.parameters[i] if formula is not None and named else f"parameter {i + 1}"
        yield argument, formula is not None and parameter in formula.infinite, f"{parameter} of '{name}'"


def empty_ranges(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find ranges whose lower end is not below the upper one."""
    for v in (*system.inputs, *system.outputs):
        low, high = system.number(v.lower), system.number(v.upper)
        if math.isinf(high - low):
            message = f"the range of '{v.name}' is wider than a number can be: [{low:.6g}, {high:.6g}]"
            yield Diagnostic("FZ304", message, v.span, help="take another unit")
        elif not low < high:
            span = _join(span_of(v.lower), span_of(v.upper)) or v.span
            yield Diagnostic(
                "FZ304",
                f"the range of '{v.name}' is empty: [{low:.6g}, {high:.6g}]",
                span,
                help="swap the ends" if low > high else "give it an upper end above the lower one",
            )


def bad_parameters(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find feet out of order, infinite feet of the wrong sign and widths that are not positive."""
    seen: set[tuple[str, int]] = set()
    for v, term, numbers in _terms(system):
        # The peaks of one `terms` line share their mistakes: one of them is enough. Those of a bare `terms` line come
        # from the range, which has its own check.
        line = (v.name, term.span.line if term.span is not None else id(term))
        if line in seen or system.number(v.lower) >= system.number(v.upper):
            continue
        formula = MEMBERSHIP[term.membership.kind]
        mistake = formula.mistake(numbers)
        if mistake is None:
            continue
        seen.add(line)
        if term.span is not None and term.span == term.membership.span:
            # A term of a partition: its feet are the peaks beside it, which are all that was written.
            message = (
                f"the peaks of '{v.name}' are out of order: {numbers[1]:.6g} of '{term.name}', then {numbers[2]:.6g}"
            )
            yield Diagnostic("FZ301", message, term.span, help="list the terms from left to right")
            continue
        unordered = "greater than" in mistake
        order = f"; the order is {', '.join(formula.parameters)}" if unordered else ""
        code = "FZ301" if unordered else "FZ302"
        yield Diagnostic(code, f"term '{term.name}' of '{v.name}': {mistake}{order}", term.membership.span or term.span)


def bad_heights(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find heights outside (0, 1]."""
    for variable, term, _ in _terms(system):
        height = system.number(term.membership.height)
        if not 0 < height <= 1:
            message = f"the height {height:.6g} of '{term.name}' of '{variable.name}' lies outside (0, 1]"
            yield Diagnostic("FZ302", message, span_of(term.membership.height) or term.span)


def bad_tolerances(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find tolerances below 0."""
    for guarantee in system.guarantees:
        if guarantee.within is not None and system.number(guarantee.within) < 0:
            value = system.number(guarantee.within)
            place = span_of(guarantee.within) or guarantee.span
            yield Diagnostic("FZ302", f"the tolerance {value:.6g} is below 0", place, help="write a small number >= 0")


def bad_weights(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find weights outside [0, 1]."""
    for rule in system.rules:
        weight = system.number(rule.weight)
        if not 0 <= weight <= 1:
            place = span_of(rule.weight) or rule.span
            yield Diagnostic("FZ302", f"the weight {weight:.6g} lies outside [0, 1]", place)


def misfitting_defuzzifier(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find output terms that the defuzzifier cannot handle."""
    for output in system.outputs:
        method = output.defuzzifier or system.method.defuzzifier
        if output.adaptive is not None and not method.averages:
            yield Diagnostic(
                "FZ214",
                f"adaptive output '{output.name}' needs a defuzzifier over rules, not '{method.kind}'",
                output.span,
                help="write: defuzzifier weighted_average",
            )
        if output.adaptive is not None:
            continue
        if method.kind == "tsukamoto":
            yield from _not_monotone(system, output)
        elif method.over_rules:
            yield from _without_peak(system, output, method)
        else:
            yield from _without_names(system, output, method)
            yield from _without_centroid(system, output, method)


def _without_peak(system: FuzzySystem, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find terms that no average can take, since they reach 1 nowhere."""
    for term in output.terms:
        kind = term.membership.kind
        if kind in MEMBERSHIP and any(map(math.isinf, MEMBERSHIP[kind].core(_values(system, term)))):
            message = f"term '{term.name}' of '{output.name}' has no peak that '{method.kind}' could take"
            help_text = "use s_shape or ramp, or write: defuzzifier tsukamoto"
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


def _without_centroid(system: FuzzySystem, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find terms of which no centroid, or no exact one, can be taken."""
    implication = output.implication or system.method.implication
    aggregation = output.aggregation or system.method.aggregation
    for term in output.terms:
        kind = term.membership.kind
        average = "write: defuzzifier weighted_average"
        sampled = "write: defuzzifier centroid(resolution=1000)"
        if kind in ("linear", "function", "constant"):
            message, help_text = (
                f"term '{term.name}' of '{output.name}' is no set but a function of the inputs",
                average,
            )
        elif kind == "singleton":
            message, help_text = f"term '{term.name}' of '{output.name}' has no area, so it has no centroid", average
        elif method.resolution is not None or exact_centroid_possible(kind, implication, aggregation):
            continue
        elif not exact_centroid_possible(kind, "min", "max"):
            message = f"term '{term.name}' of '{output.name}' is curved; the exact centroid needs straight sides"
            help_text = f"{sampled}, or use triangles and trapezoids"
        else:
            message = f"there is no exact centroid for implication '{implication}' and aggregation '{aggregation}'"
            yield Diagnostic("FZ214", f"output '{output.name}': {message}", output.span, help=sampled)
            return
        yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


def _not_monotone(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """Find consequents that Tsukamoto's method cannot invert."""
    for term in output.terms:
        kind = term.membership.kind
        if kind not in MEMBERSHIP or not is_monotone(kind, _values(system, term)):
            message = f"term '{term.name}' of '{output.name}' is not monotone, so 'tsukamoto' cannot invert it"
            help_text = "use ramp, sigmoid, s_shape, z_shape, concave, or a triangle with one infinite foot"
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)
    yield from _without_names(system, output, Defuzzifier(kind="tsukamoto"))


def _without_names(system: FuzzySystem, output: Output, method: Defuzzifier) -> Iterator[Diagnostic]:
    """Find consequents without a name where sets are due."""
    for rule in system.rules:
        for c in rule.consequents:
            if c.output == output.name and isinstance(c.term, Membership):
                message = f"'{method.kind}' takes terms of '{output.name}', not numbers or functions"
                yield Diagnostic("FZ214", message, c.term.span or c.span, help="write: defuzzifier weighted_average")


def circular_outputs(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find outputs whose values depend on themselves through antecedents."""
    names = {o.name for o in system.outputs}
    needs: dict[str, dict[str, Span | None]] = {name: {} for name in names}
    for rule in system.rules:
        read = {i.variable: i.span for i in literals(rule.antecedent) if i.variable in names}
        for c in rule.consequents:
            needs[c.output].update(read)
    for output in system.outputs:
        path = _circle(output.name, needs)
        if path and output.name == min(path):
            span = needs[path[0]][path[1]] or output.span
            message = f"outputs depend on each other in a circle: {' → '.join(path)}"
            yield Diagnostic("FZ217", message, span, help="let one of these rules read inputs only")


def _circle(start: str, needs: dict[str, dict[str, Span | None]]) -> list[str]:
    """Return a way from an output back to itself, or nothing."""
    ways = [[start]]
    seen: set[str] = set()
    while ways:
        way = ways.pop()
        for name in needs[way[-1]]:
            if name == start:
                return [*way, name]
            if name not in seen:
                seen.add(name)
                ways.append([*way, name])
    return []


def misfitting_activation(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find activation methods that compare all rules where some rules wait for an output."""
    method = system.method.activation
    if method.kind in ("general", "threshold"):
        return
    outputs = {o.name for o in system.outputs}
    reader = next((i for r in system.rules for i in literals(r.antecedent) if i.variable in outputs), None)
    if reader is not None:
        message = f"activation '{method.kind}' compares all rules at once, and some of them read an output"
        note = (Note(reader.span, f"'{reader.variable}' is read here"),) if reader.span is not None else ()
        help_text = "use 'activation general', or put the rules that read it into a system of their own"
        yield Diagnostic("FZ214", message, method.span, help=help_text, notes=note)


def functions_read(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find antecedents that name a term of an output that is no fuzzy set."""
    outputs = {o.name: o for o in system.outputs}
    seen: set[tuple[str, str]] = set()
    for rule in system.rules:
        for i in literals(rule.antecedent):
            output = outputs.get(i.variable)
            term = output.term(i.term) if output is not None else None
            if term is None or term.membership.kind in MEMBERSHIP or (i.variable, i.term) in seen:
                continue
            seen.add((i.variable, i.term))
            message = f"term '{i.term}' of output '{i.variable}' is a function of the inputs, so nothing can be it"
            note = (Note(term.span, "declared here"),) if term.span is not None else ()
            yield Diagnostic("FZ214", message, i.span, help="give the output fuzzy sets as terms", notes=note)


def unused_hedges(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find hedges of the system's own that no rule uses."""
    used = {h for rule in system.rules for i in literals(rule.antecedent) for h in i.hedges}
    for hedge in system.hedges:
        if hedge.name not in used:
            message = f"no rule uses hedge '{hedge.name}'"
            yield Diagnostic("FZ219", message, hedge.span, "warning", help="remove it, or use it in a rule")


def several_adaptive_outputs(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find systems that mix an adaptive output with other outputs: a state belongs to one output."""
    adaptive = [o for o in system.outputs if o.adaptive is not None]
    if adaptive and len(system.outputs) > 1:
        yield Diagnostic(
            "FZ214",
            f"'{adaptive[0].name}' is adaptive, so it must be the only output",
            adaptive[0].span,
            help="put the other outputs into a system of their own",
        )
    for output in adaptive:
        low, high = system.number(output.lower), system.number(output.upper)
        for term in output.terms if low < high else ():
            if term.membership.kind not in MEMBERSHIP:
                message = f"term '{term.name}' of adaptive output '{output.name}' must be a number"
                yield Diagnostic("FZ214", message, term.span, help="write, for example: terms NB=0 ZO=0 PB=0")
                continue
            a, b = MEMBERSHIP[term.membership.kind].core(_values(system, term))
            if not low <= (a + b) / 2 <= high:
                message = f"the initial consequent {term.name} = {(a + b) / 2:.6g} lies outside [{low:.6g}, {high:.6g}]"
                yield Diagnostic(
                    "FZ302", message, term.span, help="adaptation is clipped to the range; start inside it"
                )


def outputs_without_rules(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find outputs that no rule sets."""
    set_by_rules = {c.output for rule in system.rules for c in rule.consequents}
    for output in system.outputs:
        if output.name not in set_by_rules:
            yield Diagnostic("FZ210", f"no rule sets output '{output.name}'", output.span, help="add a table or rules")


def contradictory_rules(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find rules with the same antecedent for the same output."""
    first: dict[tuple[object, str], tuple[Rule, str | Membership]] = {}
    for rule in system.rules:
        key = _canonical(rule.antecedent)
        for c in rule.consequents:
            earlier = first.setdefault((key, c.output), (rule, c.term))
            if earlier[0] is rule:
                continue
            again = "the same" if earlier[1] == c.term else f"{_named(earlier[1])} there, {_named(c.term)} here"
            note = (Note(earlier[0].span, "first given here"),) if earlier[0].span is not None else ()
            yield Diagnostic(
                "FZ209",
                f"a second rule for '{c.output}' has the same antecedent ({again})",
                c.span or rule.span,
                "warning",
                help="both count; remove one unless that is meant",
                notes=note,
            )


def _named(term: str | Membership) -> str:
    return f"'{term}'" if isinstance(term, str) else f"a '{term.kind}' consequent"


def _canonical(antecedent: Antecedent) -> object:
    """Return a key that does not depend on the order of operands."""
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return (variable, hedges, term)
        case Not(operand=operand):
            return ("not", _canonical(operand))
        case And(operands=operands) | Or(operands=operands):
            return (type(antecedent).__name__, frozenset(_canonical(o) for o in operands))
    raise TypeError(type(antecedent).__name__)


def unused_inputs(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find inputs that no rule reads."""
    used = {i.variable for rule in system.rules for i in literals(rule.antecedent)}
    used |= {n.name for o in system.outputs if o.adaptive is not None for n in names_in(o.adaptive)}
    for variable in system.inputs:
        if variable.name not in used:
            message = f"no rule reads input '{variable.name}'"
            yield Diagnostic("FZ211", message, variable.span, "warning", help="remove it, or use it in a rule")


def unused_terms(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find terms that no rule names, of variables that some rule names."""
    read = {(i.variable, i.term) for rule in system.rules for i in literals(rule.antecedent)}
    written = {(c.output, c.term) for rule in system.rules for c in rule.consequents if isinstance(c.term, str)}
    used = read | written
    touched = {name for name, _ in used}
    everything = [(v, t) for v in (*system.inputs, *system.outputs) for t in v.terms]
    for variable, term in everything:
        if variable.name in touched and (variable.name, term.name) not in used:
            message = f"no rule uses term '{term.name}' of '{variable.name}'"
            yield Diagnostic("FZ208", message, term.span, "warning", help="remove it, or use it in a rule")


def unused_params(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find params that nothing uses."""
    used: set[str] = set()
    for expr, _, _ in _numbers(system):
        used.update(n.name for n in names_in(expr))
    for function in _functions(system):
        used.update(n.name for n in names_in(function))
    for p in system.params:
        used.update(n.name for n in names_in(p.expression))
    for g in system.guarantees:
        for claim in (g.claim, g.when):
            if claim is not None:
                used.update(n.name for n in names_in(claim))
    for o in system.outputs:
        if o.adaptive is not None:
            used.update(n.name for n in names_in(o.adaptive))
    for p in system.params:
        if p.name not in used:
            yield Diagnostic("FZ216", f"nothing uses param '{p.name}'", p.span, "warning", help="remove it, or use it")


def _functions(system: FuzzySystem) -> Iterator[Expr]:
    """Yield the expressions over variables: of hedges, and of terms and consequents that are functions."""
    yield from (h.expression for h in system.hedges)
    memberships = [t.membership for v in (*system.inputs, *system.outputs) for t in v.terms]
    memberships += [c.term for r in system.rules for c in r.consequents if isinstance(c.term, Membership)]
    yield from (m.arguments[0] for m in memberships if m.kind == "function")


#: Kinds with one top in their middle; of the others the order says nothing.
_PEAKED: Final = frozenset({"triangle", "trapezoid", "gaussian", "bell", "pi_shape", "cosine", "spike"})


def terms_out_of_order(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find neighbouring terms whose cores are in descending order: mostly a slip in a number."""
    for variable in system.inputs:
        planned = [t for t in variable.terms if t.membership.kind in _PEAKED]
        if any(MEMBERSHIP[t.membership.kind].mistake(_values(system, t)) for t in planned):
            continue  # bad parameters have a diagnostic of their own
        cores = [(t, MEMBERSHIP[t.membership.kind].core(_values(system, t))) for t in planned]
        middles = [(t, (a + b) / 2) for t, (a, b) in cores]
        rising = sum(b[1] >= a[1] for a, b in pairwise(middles))
        if rising * 2 < len(middles) - 1:
            continue  # listed from high to low on purpose
        for (left, a), (right, b) in pairwise(middles):
            if b < a:
                message = f"term '{right.name}' of '{variable.name}' lies left of '{left.name}' before it"
                facts = (f"peak of '{left.name}': {a:.6g}, of '{right.name}': {b:.6g}",)
                yield Diagnostic("FZ305", message, right.span, "warning", facts, help="check the numbers")


def peaks_outside_range(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find output peaks outside the range: a centre average is not clipped to it."""
    for output in system.outputs:
        if output.adaptive is not None:
            continue
        low, high = system.number(output.lower), system.number(output.upper)
        if low >= high:
            continue  # an empty range has a diagnostic of its own
        # A peak computed like the end of the range may differ from it by rounding.
        slack = 1e-9 * (high - low)
        for term in output.terms:
            if term.membership.kind not in MEMBERSHIP:
                continue
            a, b = MEMBERSHIP[term.membership.kind].core(_values(system, term))
            peak = (a + b) / 2
            if math.isfinite(peak) and not low - slack <= peak <= high + slack:
                bounds = f"[{low:.6g}, {high:.6g}] of '{output.name}'"
                message = f"the peak {peak:.6g} of '{term.name}' lies outside the range {bounds}"
                yield Diagnostic("FZ306", message, term.span, "warning", help="widen the range, or move the peak")


def _terms(system: FuzzySystem) -> Iterator[tuple[LinguisticVariable, Term, tuple[float, ...]]]:
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            if term.membership.kind in MEMBERSHIP:
                yield variable, term, _values(system, term)


def _values(system: FuzzySystem, term: Term) -> tuple[float, ...]:
    return tuple(system.number(a) for a in term.membership.arguments)


def _join(first: Span | None, last: Span | None) -> Span | None:
    return first.to(last) if first is not None and last is not None else first or last


#: Structural errors first, then what is only suspicious.
CHECKS: Final[tuple[Check, ...]] = (
    empty_ranges,
    bad_parameters,
    bad_heights,
    bad_weights,
    bad_tolerances,
    bad_claims,
    circular_outputs,
    misfitting_activation,
    functions_read,
    misfitting_defuzzifier,
    several_adaptive_outputs,
    outputs_without_rules,
    contradictory_rules,
    unused_inputs,
    unused_terms,
    unused_params,
    unused_hedges,
    terms_out_of_order,
    peaks_outside_range,
    uncovered_ranges,
    jumping_tables,
)
