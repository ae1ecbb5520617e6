"""Compatibility of consequents and defuzzifiers."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Name
from fuzzyctl.formulas import exact_maxima_possible, formula_of, is_monotone
from fuzzyctl.formulas.inverse import solved
from fuzzyctl.formulas.shared import is_infinite
from fuzzyctl.kernels.plan.plan import OutputPlan
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.variable import Output


def require_suited(output: Output, planned: OutputPlan) -> None:
    """Refuse consequents that the defuzzifier cannot take.

    Raises:
        DiagnosticError: At the first such consequent.
    """
    if planned.rate is not None and not planned.averages:
        message = f"output '{output.name}' is adaptive, and only averages know adaptive consequents"
        raise DiagnosticError([Diagnostic("FZ214", message, output.span, help="use 'defuzzifier weighted_average'")])
    for i in sorted({entry.term for entry in planned.implied}):
        found = _misfit(planned, planned.terms[i])
        if found is None:
            continue
        problem, way_out = found
        named = i < len(output.terms)
        who = f"term '{output.terms[i].name}'" if named else f"the consequent '{planned.terms[i].kind}'"
        message = f"{who} of output '{output.name}' does not suit the defuzzifier: {problem}"
        span = output.terms[i].span if named else output.span
        raise DiagnosticError([Diagnostic("FZ214", message, span, help=way_out)])


def _misfit(output: OutputPlan, term: SetPlan) -> tuple[str, str] | None:
    """Return what is wrong with a consequent under the defuzzifier of its output, and the way out."""
    average = "use 'defuzzifier weighted_average'"
    if term.kind == "formula" and output.inverts and output.merge == "rules":
        if term.expression is not None and solved(term.expression, ITSELF, Name("w")) is not None:
            return None
        return "a formula whose inverse is not known", "approximate it by piecewise(x1, degree1, x2, degree2, ...)"
    if term.kind == "formula":
        if not output.over_rules and output.resolution is not None:
            return None
        lacks = "known peak" if output.over_rules else "closed form"
        return f"a formula of the output has no {lacks}", "sample it, such as 'defuzzifier centroid(resolution=1000)'"
    if output.inverts:
        if is_monotone(term.kind, term.parameters):
            return None
        return f"'{term.kind}' is not monotone with these parameters", "use a ramp, or an infinite foot on one side"
    if output.takes_degrees:
        if term.expression is None and formula_of(term.kind).fuzzy:
            return None
        return f"a '{term.kind}' is no set", average
    if output.over_rules:
        if term.expression is not None:
            return (f"a '{term.kind}' cannot adapt", "use constants") if output.rate is not None else None
        if is_infinite(term.peak):
            return f"a '{term.kind}' has no finite peak", "use 'defuzzifier tsukamoto'"
        return None
    if term.expression is not None or not formula_of(term.kind).fuzzy:
        return f"a {term.kind} has no area, so it has no {output.kind}", average
    if output.resolution is not None or output.kind not in MAXIMA:
        return None
    used = [output.terms[e.term] for e in output.implied]
    crossed = term.kind == "gaussian2" and term.parameters[0] > term.parameters[2]
    implications = list(dict.fromkeys(map(output.implication_of, used)))
    if exact_maxima_possible(map(_shape, used), implications, output.aggregation) and not crossed:
        return None
    norms = " and ".join(f"'{n}'" for n in (*implications, output.aggregation))
    problem = f"'{output.kind}' of these terms with {norms} has no closed form"
    return problem, f"sample it, such as 'defuzzifier {output.kind}(resolution=1000)'"


def _shape(term: SetPlan) -> str:
    """Return the kind of a term, of one that a hedge has changed what it is like."""
    return term.kind if not term.changes else "piecewise" if term.vertices else "changed"
