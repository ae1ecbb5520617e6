"""Checks of a model: a flat list of small ones, each a function from a system to diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Final

from fuzzyctl.errors import Diagnostic, DiagnosticError, Note
from fuzzyctl.expr import Expr, ExprError, evaluate, names_in, span_of
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem, ParamCycleError
from fuzzyctl.model.variable import LinguisticVariable, Term
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
    for expr, may_be_infinite, what in _numbers(system):
        try:
            value = evaluate(expr, values)
        except ExprError as error:
            yield Diagnostic("FZ307", f"{what}: {error.message}", error.span or span_of(expr))
            continue
        if math.isinf(value) and not may_be_infinite:
            yield Diagnostic("FZ302", f"{what} is infinite", span_of(expr), help="only feet may be infinite")


def _numbers(system: FuzzySystem) -> Iterator[tuple[Expr, bool, str]]:
    """Yield every expression of a system with whether it may be infinite and what it is."""
    for variable in (*system.inputs, *system.outputs):
        yield variable.lower, False, f"the lower end of '{variable.name}'"
        yield variable.upper, False, f"the upper end of '{variable.name}'"
        for term in variable.terms:
            formula = MEMBERSHIP[term.membership.kind]
            for name, argument in zip(formula.parameters, term.membership.arguments, strict=True):
                yield argument, name in formula.infinite, f"{name} of '{term.name}'"
    for output in system.outputs:
        if isinstance(output.otherwise, Expr):
            yield output.otherwise, False, f"the 'else' value of '{output.name}'"
    for block in system.blocks:
        cells = [c for row in block.cells for c in row] if isinstance(block, RuleTable) else [block]
        for cell in cells:
            yield cell.weight, False, "the weight"
    for guarantee in system.guarantees:
        if guarantee.within is not None:
            yield guarantee.within, False, "the tolerance"


def empty_ranges(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find ranges whose lower end is not below the upper one."""
    for v in (*system.inputs, *system.outputs):
        low, high = system.number(v.lower), system.number(v.upper)
        if not low < high:
            span = _join(span_of(v.lower), span_of(v.upper)) or v.span
            yield Diagnostic(
                "FZ304", f"the range of '{v.name}' is empty: [{low:.6g}, {high:.6g}]", span, help="swap the ends"
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
        if mistake is None and any(math.isinf(n) for n in MEMBERSHIP[term.membership.kind].core(numbers)):
            mistake = "its peak is infinite"
        if mistake is None:
            continue
        seen.add(line)
        order = "" if formula.name == "gaussian" else f"; the order is {', '.join(formula.parameters)}"
        code = "FZ302" if formula.name == "gaussian" else "FZ301"
        yield Diagnostic(code, f"term '{term.name}' of '{v.name}': {mistake}{order}", term.membership.span or term.span)


def bad_weights(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find weights outside [0, 1]."""
    for rule in system.rules:
        weight = system.number(rule.weight)
        if not 0 <= weight <= 1:
            place = span_of(rule.weight) or rule.span
            yield Diagnostic("FZ302", f"the weight {weight:.6g} lies outside [0, 1]", place)


def misfitting_defuzzifier(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find output terms that the defuzzifier cannot handle."""
    method = system.method.defuzzifier
    for output in system.outputs:
        if output.adaptive is not None and not method.averages:
            yield Diagnostic(
                "FZ214",
                f"adaptive output '{output.name}' needs a defuzzifier over rules, not '{method.kind}'",
                output.span,
                help="write: defuzzifier weighted_average",
            )
        if method.averages or output.adaptive is not None:
            continue
        for term in output.terms:
            kind = term.membership.kind
            if kind == "singleton":
                message = f"term '{term.name}' of '{output.name}' has no area, so it has no centroid"
                help_text = "write: defuzzifier weighted_average"
            elif kind == "gaussian" and method.resolution is None:
                message = f"term '{term.name}' of '{output.name}' is curved; the exact centroid needs straight sides"
                help_text = "write: defuzzifier centroid(resolution=1000), or use triangles and trapezoids"
            else:
                continue
            yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


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
        for term in output.terms:
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
    first: dict[tuple[object, str], tuple[Rule, str]] = {}
    for rule in system.rules:
        key = _canonical(rule.antecedent)
        for c in rule.consequents:
            earlier = first.setdefault((key, c.output), (rule, c.term))
            if earlier[0] is rule:
                continue
            again = "the same" if earlier[1] == c.term else f"'{earlier[1]}' there, '{c.term}' here"
            note = (Note(earlier[0].span, "first given here"),) if earlier[0].span is not None else ()
            yield Diagnostic(
                "FZ209",
                f"a second rule for '{c.output}' has the same antecedent ({again})",
                c.span or rule.span,
                "warning",
                help="both count; remove one unless that is meant",
                notes=note,
            )


def _canonical(antecedent: Antecedent) -> object:
    """Return a key that does not depend on the order of operands."""
    match antecedent:
        case Is(variable=variable, term=term):
            return (variable, term)
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
    written = {(c.output, c.term) for rule in system.rules for c in rule.consequents}
    used = read | written
    touched = {name for name, _ in used}
    for variable, term, _ in _terms(system):
        if variable.name in touched and (variable.name, term.name) not in used:
            message = f"no rule uses term '{term.name}' of '{variable.name}'"
            yield Diagnostic("FZ208", message, term.span, "warning", help="remove it, or use it in a rule")


def unused_params(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find params that nothing uses."""
    used: set[str] = set()
    for expr, _, _ in _numbers(system):
        used.update(n.name for n in names_in(expr))
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


def terms_out_of_order(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find neighbouring terms whose cores are in descending order: mostly a slip in a number."""
    for variable in system.inputs:
        cores = [(t, MEMBERSHIP[t.membership.kind].core(_values(system, t))) for t in variable.terms]
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
        # A peak computed like the end of the range may differ from it by rounding.
        slack = 1e-9 * (high - low)
        for term in output.terms:
            a, b = MEMBERSHIP[term.membership.kind].core(_values(system, term))
            peak = (a + b) / 2
            if not low - slack <= peak <= high + slack:
                bounds = f"[{low:.6g}, {high:.6g}] of '{output.name}'"
                message = f"the peak {peak:.6g} of '{term.name}' lies outside the range {bounds}"
                yield Diagnostic("FZ306", message, term.span, "warning", help="widen the range, or move the peak")


def _terms(system: FuzzySystem) -> Iterator[tuple[LinguisticVariable, Term, tuple[float, ...]]]:
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            yield variable, term, _values(system, term)


def _values(system: FuzzySystem, term: Term) -> tuple[float, ...]:
    return tuple(system.number(a) for a in term.membership.arguments)


def _join(first: Span | None, last: Span | None) -> Span | None:
    return first.to(last) if first is not None and last is not None else first or last


#: Structural errors first, then what is only suspicious.
CHECKS: Final[tuple[Check, ...]] = (
    empty_ranges,
    bad_parameters,
    bad_weights,
    misfitting_defuzzifier,
    several_adaptive_outputs,
    outputs_without_rules,
    contradictory_rules,
    unused_inputs,
    unused_terms,
    unused_params,
    terms_out_of_order,
    peaks_outside_range,
)
