"""From the model to a plan: the same system without names to look up, expressions to compute, or places in a text."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from typing import Final, cast

from fuzzyctl.errors import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import (
    MAX_DEPTH,
    ZERO,
    CompareOp,
    Expr,
    Name,
    Number,
    replace_names,
)
from fuzzyctl.formulas import (
    HEDGES,
    MEMBERSHIP,
    Norm,
    conjunction,
    disjunction,
    exact_maxima_possible,
    formula_of,
    held,
    is_monotone,
    one_minus,
)
from fuzzyctl.formulas import hedge as usual_hedge
from fuzzyctl.kernels.conclusions import Conclusions, set_of
from fuzzyctl.kernels.flat import (
    ITSELF,
    ActivationPlan,
    ChainPlan,
    DegreePlan,
    HeldPlan,
    ImpliedPlan,
    InputPlan,
    Otherwise,
    OutputCycleError,
    OutputPlan,
    Plan,
    RulePlan,
    SetPlan,
    chain_name,
    degree_name,
    step_name,
)
from fuzzyctl.kernels.numbers import constants_of, guarded, number_of, over_inputs, require_known
from fuzzyctl.kernels.program import DEEPEST, depth
from fuzzyctl.model.method import AVERAGES, MAXIMA, Activation
from fuzzyctl.model.misfits import misfitting_semantics
from fuzzyctl.model.reads import comparisons_that_wait
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Output, Term

__all__ = [
    "ITSELF",
    "ActivationPlan",
    "ChainPlan",
    "DegreePlan",
    "HeldPlan",
    "ImpliedPlan",
    "InputPlan",
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
    """Flatten a well-formed system.

    Raises:
        DiagnosticError: For terms that do not suit the defuzzifier, such as an exact centroid of curved terms, and for
            activation methods that compare rules of which some read an output of the same evaluation.
        OutputCycleError: For outputs that read each other in a circle.
        UnknownNameError: For an antecedent or consequent that names what is not declared.
        ExprError: For an expression without a value; a loaded system has none such.
    """
    mistakes = list(misfitting_semantics(system))
    if mistakes:
        raise DiagnosticError(mistakes)
    antecedents = _Antecedents(system)
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
    )


def _first_weight(system: FuzzySystem, rule: Rule) -> float:
    """Return the weight that counts before implication; a rule of weight 0 never acts."""
    weight = number_of(system, rule.weight)
    return 1.0 if system.method.semantics.weight == "after" and weight != 0.0 else weight


#: Norms whose formulas mention each operand once, so that operands need no name of their own.
_ONCE: Final = ("min", "product", "bounded_difference", "max", "bounded_sum")


class _Antecedents:
    """Collect the distinct degrees and firing strengths of a system."""

    def __init__(self, system: FuzzySystem) -> None:
        self.system = system
        self.variables = (*system.inputs, *system.outputs)
        self.positions = {v.name: i for i, v in enumerate(self.variables)}
        self.hedges = {h.name: h for h in system.hedges}
        self.degrees: list[DegreePlan] = []
        self.names: dict[tuple[int, str], Name] = {}
        self.steps: dict[Expr, Name] = {}
        self.strengths: dict[Expr, int] = {}
        self.chains: list[ChainPlan] = []
        self.rule = 0

    def strength(self, antecedent: Antecedent, rule: int) -> int:
        self.rule = rule
        if not isinstance(antecedent, Is) and _nesting(antecedent) > MAX_DEPTH:
            message = f"an antecedent is nested more than {MAX_DEPTH} deep"
            raise DiagnosticError([Diagnostic("FZ106", message, help="join the parts with one 'and' or 'or'")])
        return self.strengths.setdefault(self.truth(antecedent), len(self.strengths))

    def truth(self, antecedent: Antecedent) -> Expr:
        if type(antecedent) is Is:  # more than half of all parts are
            degree = self.degree(antecedent.variable, antecedent.term)
            return reduce(self.hedged, reversed(antecedent.hedges), degree) if antecedent.hedges else degree
        match antecedent:
            case Not(operand=operand):
                return one_minus(self.shallow(self.truth(operand)))
            case And(operands=operands):
                return self.join(conjunction, self.system.rule_methods[self.rule].conjunction, operands)
            case Or(operands=operands):
                return self.join(disjunction, self.system.rule_methods[self.rule].disjunction, operands)
        raise TypeError(f"{type(antecedent).__name__} is no antecedent")

    def join(self, norms: Callable[[str, float], Norm], name: str, operands: tuple[Antecedent, ...]) -> Expr:
        norm, truths = norms(name, self.system.method.semantics.equal), [self.truth(operand) for operand in operands]
        if name in _ONCE:
            return reduce(lambda a, b: norm(self.shallow(a), self.shallow(b)), truths)
        return reduce(lambda a, b: norm(self.named(a), self.named(b)), truths)

    def hedged(self, truth: Expr, hedge: str) -> Expr:
        if hedge in self.hedges:
            own = self.hedges[hedge]
            numbers = constants_of(self.system, {own.parameter})
            require_known(own.expression, {own.parameter}, numbers)
            inside: dict[str, Expr] = {**numbers, own.parameter: self.named(truth)}
            return held(guarded(replace_names(own.expression, inside)))
        if hedge not in HEDGES:
            raise UnknownNameError("hedge", hedge, [*HEDGES, *self.hedges])
        return usual_hedge(hedge, cube=self.system.method.semantics.extremely == "cube")(self.named(truth))

    def shallow(self, truth: Expr) -> Expr:
        """Return a truth, or a name for it where it is nested deeply."""
        return self.named(truth) if not isinstance(truth, Name | Number) and depth(truth) >= DEEPEST else truth

    def named(self, truth: Expr) -> Expr:
        """Return a name for what a formula mentions several times."""
        if isinstance(truth, Name | Number):
            return truth
        return self.steps.setdefault(truth, Name(step_name(len(self.steps))))

    def so_far(self, output: int, term: str) -> Expr:
        """Return how far the rules before have activated a term of an output."""
        name = self.system.outputs[output].name
        terms = [t.name for t in self.system.outputs[output].terms]
        if term not in terms:
            raise UnknownNameError("term", term, terms)
        concluded = [
            (r, c.term) for r, rule in enumerate(self.system.rules) for c in rule.consequents if c.output == name
        ]
        entries = tuple(k for k, (r, own) in enumerate(concluded) if r < self.rule and own == term)
        if not entries:
            return ZERO
        chain = ChainPlan(output, entries)
        if chain not in self.chains:
            self.chains.append(chain)
        return Name(chain_name(self.chains.index(chain)))

    def degree(self, variable: str, term: str) -> Expr:
        if variable not in self.positions:
            raise UnknownNameError("input", variable, self.positions)
        position = self.positions[variable]
        known = self.names.get((position, term))
        if known is not None:
            return known
        if self.system.method.semantics.chained == "degree" and position >= len(self.system.inputs):
            return self.so_far(position - len(self.system.inputs), term)
        declared = self.variables[position]
        found = declared.term(term)
        if found is None:
            raise UnknownNameError("term", term, [t.name for t in declared.terms])
        degrees = _term_of_input if isinstance(declared, Input) else _term_of_output
        name = self.names[position, term] = Name(degree_name(len(self.degrees)))
        self.degrees.append(DegreePlan(position, term, degrees(self.system, declared.name, found)))
        return name


def _nesting(antecedent: Antecedent) -> int:
    level: list[Antecedent] = [antecedent]
    deepest = -1
    while level:
        deepest += 1
        inner: list[Antecedent] = []
        for part in level:
            match part:
                case Not(operand=operand):
                    inner.append(operand)
                case And(operands=operands) | Or(operands=operands):
                    inner.extend(operands)
        level = inner
    return deepest


def _input(system: FuzzySystem, variable: Input) -> InputPlan:
    return InputPlan(
        variable.name, number_of(system, variable.lower), number_of(system, variable.upper), variable.extrapolate
    )


def planned_set(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> SetPlan | None:
    """Return a term as a fuzzy set with numbers, None for a consequent that is a function of the inputs."""
    if isinstance(variable, Input):
        return _term_of_input(system, variable.name, term)
    return set_of(system, term.membership) if term.membership.kind in MEMBERSHIP else None


def _term_of_input(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    membership = term.membership
    if membership.kind != "function":
        return set_of(system, membership)
    numbers = constants_of(system, {variable})
    require_known(membership.arguments[0], {variable}, numbers)
    inside: dict[str, Expr] = {**numbers, variable: Name(ITSELF)}
    expression = guarded(replace_names(membership.arguments[0], inside))
    return SetPlan("function", (), number_of(system, membership.height), expression)


def _term_of_output(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    if term.membership.kind not in MEMBERSHIP:
        message = f"term '{term.name}' of output '{variable}' is a function of the inputs, so nothing can be it"
        raise DiagnosticError([Diagnostic("FZ214", message, term.span, help="give the output fuzzy sets as terms")])
    return set_of(system, term.membership)


def _order(system: FuzzySystem) -> tuple[tuple[int, ...], list[tuple[int, ...]]]:
    """Return the outputs each after those it reads, and for each all it depends on."""
    names = [o.name for o in system.outputs]
    direct: dict[str, set[str]] = {name: set() for name in names}
    for output, read in system.reads:
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
    found: dict[tuple[ActivationPlan, int], int] = {}
    groups: dict[int, int] = {}
    for method in {m.block: m for m in system.rule_methods}.values():
        mistake = next(comparisons_that_wait(system, method.block), None) if method.activation.compares else None
        if mistake is not None:
            raise DiagnosticError([mistake])
        own = _activation(system, method.activation)
        groups[method.block] = found.setdefault((own, method.block if own.compares else -1), len(found))
    return tuple(activation for activation, _ in found), [groups[m.block] for m in system.rule_methods]


def _activation(system: FuzzySystem, method: Activation) -> ActivationPlan:
    return ActivationPlan(
        kind=method.kind,
        count=1 if method.count is None else method.count,
        threshold=0.0 if method.threshold is None else number_of(system, method.threshold),
        comparison=cast("CompareOp", method.comparison or ">="),  # what reads an activation lets nothing else pass
    )


def _output(system: FuzzySystem, output: Output, reads: tuple[int, ...]) -> OutputPlan:
    method = system.method
    defuzzifier = output.defuzzifier or method.defuzzifier
    conclusions = Conclusions(system, output)
    for r, rule in enumerate(system.rules):
        for k, consequent in enumerate(rule.consequents):
            if consequent.output == output.name:
                conclusions.add(r, rule, k)
    semantics = method.semantics
    aggregation = output.aggregation or method.aggregation
    # Of constants it does not matter whether those of one term are added up first.
    joins = defuzzifier.over_rules and (aggregation != "sum" or defuzzifier.kind not in (*AVERAGES, "weighted_sum"))
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
        otherwise=_otherwise(system, output, lower, upper),
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
    )
    _require_suited(output, planned)
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


def _require_suited(output: Output, planned: OutputPlan) -> None:
    """Refuse consequents that the defuzzifier cannot take."""
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
        if math.isinf(term.peak):
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
