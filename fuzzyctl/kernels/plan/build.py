"""Builder of plans: a model with names resolved to indices and expressions to numbers."""

from __future__ import annotations

import math
from typing import cast

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import (
    Call,
    CompareOp,
    Expr,
    Name,
    children,
    rebuilt,
)
from fuzzyctl.formulas import (
    MEMBERSHIP,
    exact_maxima_possible,
    formula_of,
    is_monotone,
)
from fuzzyctl.formulas.formula import is_infinite
from fuzzyctl.formulas.inverse import solved
from fuzzyctl.kernels.plan.clauses import Antecedents, Conclusions, term_of_input, term_of_output
from fuzzyctl.kernels.plan.plan import (
    ActivationPlan,
    CallPlan,
    ChainPlan,
    DegreePlan,
    HeldPlan,
    ImpliedPlan,
    InputPlan,
    LetPlan,
    Otherwise,
    OutputCycleError,
    OutputPlan,
    Plan,
    RulePlan,
    chain_name,
    degree_name,
    step_name,
)
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.plan.traced import guarded, number_of, over_inputs
from fuzzyctl.model.checks.checks import misfitting_semantics
from fuzzyctl.model.method import MAXIMA, OVER_MIDDLES, Activation
from fuzzyctl.model.rule import Rule
from fuzzyctl.model.system import FuzzySystem, comparisons_that_wait, ordered_lets, reads_of
from fuzzyctl.model.variable import Hold, Input, Let, LinguisticVariable, Output, Term


def require_suited(output: Output, planned: OutputPlan) -> None:
    """Refuse consequents that the defuzzifier cannot take.

    Raises:
        DiagnosticError: At the first such consequent.
    """
    if planned.rate is not None and not planned.averages:
        message = f"output '{output.name}' is adaptive, and only averages know adaptive consequents"
        raise DiagnosticError([Diagnostic("FZ214", message, output.span, help="use 'defuzzifier weighted_average'")])
    for i in sorted({entry.term for entry in planned.implied}):
        misfit = _misfit(planned, planned.terms[i])
        if misfit is None:
            continue
        problem, way_out = misfit
        named = i < len(output.terms)
        who = f"term '{output.terms[i].name}'" if named else f"the consequent '{planned.terms[i].kind}'"
        message = f"{who} of output '{output.name}' does not suit the defuzzifier: {problem}"
        span = output.terms[i].span if named else output.span
        raise DiagnosticError([Diagnostic("FZ214", message, span, help=way_out)])


def _misfit(output: OutputPlan, term: SetPlan) -> tuple[str, str] | None:
    """Return the problem of a consequent under the defuzzifier of its output, and its solution."""
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
    """Return the kind of a term; for one that a hedge has changed, its description."""
    return term.kind if not term.changes else "piecewise" if term.vertices else "changed"


__all__ = [
    "ITSELF",
    "ActivationPlan",
    "CallPlan",
    "ChainPlan",
    "DegreePlan",
    "HeldPlan",
    "ImpliedPlan",
    "InputPlan",
    "LetPlan",
    "Otherwise",
    "OutputCycleError",
    "OutputPlan",
    "Plan",
    "RulePlan",
    "SetPlan",
    "chain_name",
    "degree_name",
    "guarded",
    "plan",
    "planned_set",
    "step_name",
]


def plan(system: FuzzySystem) -> Plan:
    """Flatten a well-formed system, which keeps its plan.

    Raises:
        DiagnosticError: For terms that do not suit the defuzzifier, such as an exact centroid of curved terms, and for
            activation methods that compare rules where some rule reads an output of the same evaluation.
        OutputCycleError: For outputs that read each other in a circle.
        UnknownNameError: For an undeclared name in an antecedent or consequent.
        ExprError: For an expression without a value; a loaded system has none such.
    """
    if "plan" not in system.derived:
        system.derived["plan"] = _plan(system)
    cached: Plan = system.derived["plan"]
    return cached


def _plan(system: FuzzySystem) -> Plan:
    mistakes = list(misfitting_semantics(system))
    if mistakes:
        raise DiagnosticError(mistakes)
    antecedents = Antecedents(system)
    activations, groups = _activations(system)
    rules = tuple(
        RulePlan(antecedents.strength(rule.antecedent, r), _first_weight(system, rule), group)
        for r, (rule, group) in enumerate(zip(system.rules, groups, strict=True))
    )
    order, reads = _order(system)
    if system.method.semantics.total == "all_rules" and any(reads):
        message = "'total=all_rules' divides by the activations of all rules, and some of them read an output"
        raise DiagnosticError([Diagnostic("FZ214", message, system.method.semantics.span)])
    return Plan(
        inputs=tuple(_input(system, i) for i in system.inputs),
        degrees=tuple(antecedents.degrees),
        steps=tuple(antecedents.steps),
        strengths=tuple(antecedents.strengths),
        rules=rules,
        activations=activations,
        outputs=tuple(_output(system, output, r) for output, r in zip(system.outputs, reads, strict=True)),
        order=order,
        chains=tuple(antecedents.chains),
        least=system.method.semantics.least,
        lets=tuple(_let(system, v) for v in ordered_lets(system)),
    )


def _first_weight(system: FuzzySystem, rule: Rule) -> float:
    """Return the weight that counts before implication; a rule of weight 0 never acts."""
    weight = number_of(system, rule.weight)
    return 1.0 if system.method.semantics.weight == "after" and weight != 0.0 else weight


def _input(system: FuzzySystem, variable: Input) -> InputPlan:
    return InputPlan(
        variable.name, number_of(system, variable.lower), number_of(system, variable.upper), variable.extrapolate
    )


def _let(system: FuzzySystem, let: Let) -> LetPlan:
    calls: list[CallPlan] = []
    value = over_inputs(system, _with_calls(system, let.name, let.value, calls), more={c.name for c in calls})
    return LetPlan(let.name, number_of(system, let.lower), number_of(system, let.upper), guarded(value), tuple(calls))


def _with_calls(system: FuzzySystem, name: str, expr: Expr, calls: list[CallPlan]) -> Expr:
    """Return an expression with names for its calls of other systems, and collect these, inner ones first."""
    parts = [_with_calls(system, name, part, calls) for part in children(expr)]
    if not (isinstance(expr, Call) and "." in expr.function):
        return rebuilt(expr, parts) if parts else expr
    other, _, output = expr.function.partition(".")
    called = next(c for c in system.called if c.name == other)
    names = {c.name for c in calls}
    arguments = tuple(guarded(over_inputs(system, part, more=names)) for part in parts)
    position = [o.name for o in called.outputs].index(output)
    calls.append(CallPlan(f"{name}.{len(calls) + 1}", plan(called), position, arguments))
    return Name(calls[-1].name)


def planned_set(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> SetPlan | None:
    """Return a term as a fuzzy set with numbers, None for a consequent that is a function of the inputs."""
    if isinstance(variable, Input | Let):
        return term_of_input(system, variable.name, term)
    if term.membership.kind not in (*MEMBERSHIP, "formula"):
        return None
    return term_of_output(system, variable.name, term.membership)


def _order(system: FuzzySystem) -> tuple[tuple[int, ...], list[tuple[int, ...]]]:
    """Return the outputs each after those it reads, and for each all it depends on."""
    names = [o.name for o in system.outputs]
    direct: dict[str, set[str]] = {name: set() for name in names}
    for output, read in reads_of(system):
        direct.get(output, set()).update(read)
    reads: dict[str, set[str]] = {}
    order: list[str] = []
    while len(order) < len(names):
        ready = [n for n in names if n not in reads and direct[n] <= set(order)]
        if not ready:
            raise OutputCycleError(_cycle(direct, [n for n in names if n not in reads]))
        for name in ready:
            reads[name] = direct[name].union(*(reads[n] for n in direct[name]))
            order.append(name)
    return tuple(names.index(n) for n in order), [tuple(sorted(names.index(r) for r in reads[n])) for n in names]


def _cycle(direct: dict[str, set[str]], left: list[str]) -> list[str]:
    """Return outputs that read each other in a circle, the first one again at the end."""
    path = [left[0]]
    while path[-1] not in path[:-1]:
        path.append(min(direct[path[-1]] & set(left)))
    return path[path.index(path[-1]) :]


def _activations(system: FuzzySystem) -> tuple[tuple[ActivationPlan, ...], list[int]]:
    """Return the activation methods, and for each rule which of them it has.

    Methods that look at each rule by itself are one for all rule blocks that have them; others have each its block.
    """
    mistake = next(comparisons_that_wait(system), None)
    if mistake is not None:
        raise DiagnosticError([mistake])
    positions: dict[tuple[ActivationPlan, int], int] = {}
    groups: dict[int, int] = {}
    for method in {m.block: m for m in system.rule_methods}.values():
        own = _activation(system, method.activation)
        groups[method.block] = positions.setdefault((own, method.block if own.compares else -1), len(positions))
    return tuple(activation for activation, _ in positions), [groups[m.block] for m in system.rule_methods]


def _activation(system: FuzzySystem, method: Activation) -> ActivationPlan:
    return ActivationPlan(
        kind=method.kind,
        count=1 if method.count is None else method.count,
        threshold=0.0 if method.threshold is None else number_of(system, method.threshold),
        comparison=cast("CompareOp", method.comparison or ">="),  # a reader of an activation accepts only atoms
    )


def _output(system: FuzzySystem, output: Output, reads: tuple[int, ...]) -> OutputPlan:
    method = system.method
    defuzzifier = output.defuzzifier or method.defuzzifier
    conclusions = Conclusions(system, output)
    for r, k in system.conclusions.get(output.name, ()) if output.value is None else ():
        conclusions.add(r, system.rules[r], k)
    semantics = method.semantics
    aggregation = output.aggregation or method.aggregation
    # Of constants it does not matter whether those of one term are added up first.
    joins = defuzzifier.over_rules and (aggregation != "sum" or defuzzifier.kind not in OVER_MIDDLES)
    lower, upper = number_of(system, output.lower), number_of(system, output.upper)
    planned = OutputPlan(
        name=output.name,
        lower=lower,
        upper=upper,
        kind=defuzzifier.kind,
        resolution=defuzzifier.resolution,
        grid=defuzzifier.grid,
        implication=conclusions.implication,
        aggregation=aggregation,
        terms=tuple(conclusions.terms),
        implied=tuple(conclusions.implied),
        otherwise=_otherwise(system, output, lower, upper) if output.value is None else math.nan,
        rate=None if output.adaptive is None else over_inputs(system, output.adaptive),
        reads=reads,
        rule=defuzzifier.rule,
        tolerance=defuzzifier.tolerance,
        by=defuzzifier.by,
        places=semantics.places,
        none_active=semantics.none_active,
        fallback=semantics.fallback,
        merge=semantics.merge if joins else "rules",
        total=semantics.total if defuzzifier.averages else "activations",
        equal=semantics.equal,
        clamped=output.clamped,
        value=None if output.value is None else guarded(over_inputs(system, output.value, outputs=True)),
    )
    require_suited(output, planned)
    return planned


def _otherwise(system: FuzzySystem, output: Output, lower: float, upper: float) -> Otherwise:
    match output.otherwise:
        case None:
            return None
        case "midpoint":
            return 0.5 * lower + 0.5 * upper
        case "nan":
            return math.nan
        case "error":
            return "error"
        case Hold(start=start):
            if start == "nan":
                return HeldPlan(math.nan)
            return HeldPlan(0.5 * lower + 0.5 * upper if start is None else number_of(system, start))
    return number_of(system, output.otherwise)
