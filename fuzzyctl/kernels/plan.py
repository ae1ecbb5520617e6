"""From the model to a plan: the same system without names to look up, expressions to compute, or places in a text."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Final

from fuzzyctl.errors import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import (
    CONSTANTS,
    MAX_DEPTH,
    ZERO,
    Binary,
    Call,
    Expr,
    Name,
    Number,
    names_in,
    replace,
    replace_names,
)
from fuzzyctl.formulas import (
    HEDGES,
    MEMBERSHIP,
    VARIANTS,
    Norm,
    conjunction,
    disjunction,
    exact_maxima_possible,
    formula_of,
    held,
    inverse_hedge,
    is_monotone,
    one_minus,
)
from fuzzyctl.formulas import hedge as usual_hedge
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
from fuzzyctl.kernels.program import DEEPEST, depth
from fuzzyctl.model.method import AVERAGES, MAXIMA
from fuzzyctl.model.misfits import misfitting_semantics
from fuzzyctl.model.reads import reads_of
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Membership, Output, Term

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
    rules = tuple(
        RulePlan(antecedents.strength(rule.antecedent, r), _first_weight(system, rule))
        for r, rule in enumerate(system.rules)
    )
    order, reads = _order(system)
    if system.method.semantics.total == "all_rules" and any(reads):
        message = "'total=all_rules' divides by the activations of all rules, and some of them read an output"
        raise DiagnosticError([Diagnostic("FZ214", message, system.method.semantics.span)])
    return Plan(
        inputs=tuple(_input(system, i) for i in system.inputs),
        degrees=tuple(antecedents.degrees.values()),
        steps=tuple(antecedents.steps),
        strengths=tuple(antecedents.strengths),
        rules=rules,
        activation=_activation(system, chained=any(reads) or bool(antecedents.chains)),
        outputs=tuple(_output(system, output, r) for output, r in zip(system.outputs, reads, strict=True)),
        order=order,
        chains=tuple(antecedents.chains),
        least=system.method.semantics.least,
    )


def _first_weight(system: FuzzySystem, rule: Rule) -> float:
    """Return the weight that counts before implication; a rule of weight 0 never acts."""
    weight = _number(system, rule.weight)
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
        self.degrees: dict[tuple[int, str], DegreePlan] = {}
        self.names: dict[tuple[int, str], Name] = {}
        self.steps: dict[Expr, Name] = {}
        self.strengths: dict[Expr, int] = {}
        self.chains: list[ChainPlan] = []
        self.rule = 0

    def strength(self, antecedent: Antecedent, rule: int) -> int:
        self.rule = rule
        if _nesting(antecedent) > MAX_DEPTH:
            message = f"an antecedent is nested more than {MAX_DEPTH} deep"
            raise DiagnosticError([Diagnostic("FZ106", message, help="join the parts with one 'and' or 'or'")])
        return self.strengths.setdefault(self.truth(antecedent), len(self.strengths))

    def truth(self, antecedent: Antecedent) -> Expr:
        match antecedent:
            case Is(variable=variable, term=term, hedges=hedges):
                return reduce(self.hedged, reversed(hedges), self.degree(variable, term))
            case Not(operand=operand):
                return one_minus(self.shallow(self.truth(operand)))
            case And(operands=operands):
                return self.join(conjunction, self.system.method.conjunction, operands)
            case Or(operands=operands):
                return self.join(disjunction, self.system.method.disjunction, operands)
        raise TypeError(f"{type(antecedent).__name__} is no antecedent")

    def join(self, norms: Callable[[str, float], Norm], name: str, operands: tuple[Antecedent, ...]) -> Expr:
        norm, truths = norms(name, self.system.method.semantics.equal), [self.truth(operand) for operand in operands]
        if name in _ONCE:
            return reduce(lambda a, b: norm(self.shallow(a), self.shallow(b)), truths)
        return reduce(lambda a, b: norm(self.named(a), self.named(b)), truths)

    def hedged(self, truth: Expr, hedge: str) -> Expr:
        if hedge in self.hedges:
            own = self.hedges[hedge]
            numbers = _constants(self.system, {own.parameter})
            _require_known(own.expression, {own.parameter}, numbers)
            inside: dict[str, Expr] = {**numbers, own.parameter: self.named(truth)}
            return held(guarded(replace_names(own.expression, inside)))
        if hedge not in HEDGES:
            raise UnknownNameError("hedge", hedge, [*HEDGES, *self.hedges])
        return usual_hedge(hedge, cube=self.system.method.semantics.extremely == "cube")(self.named(truth))

    def shallow(self, truth: Expr) -> Expr:
        """Return a truth, or a name for it where it is nested deeply."""
        return self.named(truth) if depth(truth) >= DEEPEST else truth

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
        if self.system.method.semantics.chained == "degree" and self.positions[variable] >= len(self.system.inputs):
            return self.so_far(self.positions[variable] - len(self.system.inputs), term)
        key = (self.positions[variable], term)
        if key not in self.degrees:
            declared = self.variables[key[0]]
            found = declared.term(term)
            if found is None:
                raise UnknownNameError("term", term, [t.name for t in declared.terms])
            degrees = _term_of_input if isinstance(declared, Input) else _term_of_output
            self.names[key] = Name(degree_name(len(self.degrees)))
            self.degrees[key] = DegreePlan(key[0], term, degrees(self.system, declared.name, found))
        return self.names[key]


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


def guarded(expr: Expr) -> Expr:
    """Return an expression that a user wrote so that every target computes the same, and none raises.

    Quotients follow IEEE 754, and `min` and `max` compare, so that all targets agree where an operand has no value.
    """

    def change(node: Expr) -> Expr:
        match node:
            case Binary(op="/", left=left, right=right):
                return Call("divide", (left, right))
            case Call(function="min" | "max" as function, arguments=arguments):
                pair = "smaller" if function == "min" else "larger"
                return reduce(lambda a, b: Call(pair, (a, b)), arguments)
        return node

    return replace(expr, change)


def _number(system: FuzzySystem, expr: Expr) -> float:
    # + 0.0 makes -0.0 a plain zero, so that equal systems have equal plans.
    return float(system.number(expr)) + 0.0


def _constants(system: FuzzySystem, hidden: set[str]) -> dict[str, Expr]:
    """Return params and named constants as numbers, without those that a variable of the same name hides."""
    return {n: Number(v) for n, v in (CONSTANTS | system.values).items() if n not in hidden}


def _require_known(expr: Expr, variables: set[str], numbers: dict[str, Expr]) -> None:
    for name in names_in(expr):
        if name.name not in variables and name.name not in numbers:
            raise UnknownNameError("input", name.name, sorted(variables))


def _of_inputs(system: FuzzySystem, expr: Expr, *, outputs: bool = False) -> Expr:
    """Return an expression over the names of the inputs, and perhaps of the outputs, params replaced by numbers."""
    inputs = {v.name for v in (*system.inputs, *(system.outputs if outputs else ()))}
    numbers = _constants(system, inputs)
    _require_known(expr, inputs, numbers)
    return replace_names(expr, numbers)


def _input(system: FuzzySystem, variable: Input) -> InputPlan:
    return InputPlan(
        variable.name, _number(system, variable.lower), _number(system, variable.upper), variable.extrapolate
    )


def planned_set(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> SetPlan | None:
    """Return a term as a fuzzy set with numbers, None for a consequent that is a function of the inputs."""
    if isinstance(variable, Input):
        return _term_of_input(system, variable.name, term)
    return _set(system, term.membership) if term.membership.kind in MEMBERSHIP else None


def _term_of_input(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    membership = term.membership
    if membership.kind != "function":
        return _set(system, membership)
    numbers = _constants(system, {variable})
    _require_known(membership.arguments[0], {variable}, numbers)
    inside: dict[str, Expr] = {**numbers, variable: Name(ITSELF)}
    expression = guarded(replace_names(membership.arguments[0], inside))
    return SetPlan("function", (), _number(system, membership.height), expression)


def _term_of_output(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    if term.membership.kind not in MEMBERSHIP:
        message = f"term '{term.name}' of output '{variable}' is a function of the inputs, so nothing can be it"
        raise DiagnosticError([Diagnostic("FZ214", message, term.span, help="give the output fuzzy sets as terms")])
    return _set(system, term.membership)


def _set(system: FuzzySystem, membership: Membership) -> SetPlan:
    height = _number(system, membership.height)
    variant = f"{membership.kind} {getattr(system.method.semantics, membership.kind, '')}"
    kind = variant if variant in VARIANTS else membership.kind
    return SetPlan(kind, tuple(_number(system, a) for a in membership.arguments), height)


def _consequent(system: FuzzySystem, membership: Membership) -> SetPlan:
    match membership.kind:
        case "linear":
            *factors, constant = (_number(system, a) for a in membership.arguments)
            names = [i.name for i in system.inputs]
            parts = [Binary("*", Number(c), Name(n)) for c, n in zip(factors, names, strict=True) if c != 0.0]
            reach = _reach(system, factors, constant)
            return SetPlan("linear", (), expression=_sum([*parts, Number(constant)]), reach=reach)
        case "function":
            return SetPlan(
                "function", (), expression=guarded(_of_inputs(system, membership.arguments[0], outputs=True))
            )
    return _set(system, membership)


def _reach(system: FuzzySystem, factors: Sequence[float], constant: float) -> tuple[float, float] | None:
    """Return what a linear consequent lies between while the inputs are in their ranges; None if they need not be."""
    low = high = constant
    for factor, variable in zip(factors, system.inputs, strict=True):
        if factor == 0.0:
            continue
        if variable.extrapolate:
            return None
        ends = sorted(factor * _number(system, end) for end in (variable.lower, variable.upper))
        low, high = low + ends[0], high + ends[1]
    return (low, high) if math.isfinite(high - low) else None


def _sum(parts: list[Expr]) -> Expr:
    return reduce(lambda a, b: Binary("+", a, b), [p for p in parts if p != ZERO] or [ZERO])


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


def _activation(system: FuzzySystem, *, chained: bool) -> ActivationPlan:
    method = system.method.activation
    if chained and method.kind not in ("general", "threshold"):
        message = f"activation '{method.kind}' compares all rules, and some of them read an output of the system"
        raise DiagnosticError([Diagnostic("FZ214", message, method.span, help="use 'activation general'")])
    return ActivationPlan(
        kind=method.kind,
        count=1 if method.count is None else method.count,
        threshold=0.0 if method.threshold is None else _number(system, method.threshold),
        comparison=method.comparison or ">=",
    )


def _output(system: FuzzySystem, output: Output, reads: tuple[int, ...]) -> OutputPlan:
    method = system.method
    defuzzifier = output.defuzzifier or method.defuzzifier
    conclusions = _Conclusions(system, output)
    for r, rule in enumerate(system.rules):
        for k, consequent in enumerate(rule.consequents):
            if consequent.output == output.name:
                conclusions.add(r, rule, k)
    semantics = method.semantics
    aggregation = output.aggregation or method.aggregation
    # Of constants it does not matter whether those of one term are added up first.
    joins = defuzzifier.over_rules and (aggregation != "sum" or defuzzifier.kind not in (*AVERAGES, "weighted_sum"))
    lower, upper = _number(system, output.lower), _number(system, output.upper)
    planned = OutputPlan(
        name=output.name,
        lower=lower,
        upper=upper,
        kind=defuzzifier.kind,
        resolution=defuzzifier.resolution,
        grid=defuzzifier.grid,
        implication=output.implication or method.implication,
        aggregation=aggregation,
        terms=tuple(conclusions.terms),
        implied=tuple(conclusions.implied),
        otherwise=_otherwise(system, output, lower, upper),
        rate=None if output.adaptive is None else _of_inputs(system, output.adaptive),
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


class _Conclusions:
    """Collect the consequents of the rules in one output."""

    def __init__(self, system: FuzzySystem, output: Output) -> None:
        self.system, self.output = system, output
        self.semantics = system.method.semantics
        self.over_rules = (output.defuzzifier or system.method.defuzzifier).over_rules
        self.implication = output.implication or system.method.implication
        self.terms = [_consequent(system, term.membership) for term in output.terms]
        self.positions = {term.name: i for i, term in enumerate(output.terms)}
        self.implied: list[ImpliedPlan] = []

    def add(self, position: int, rule: Rule, place: int) -> None:
        """Add a consequent of a rule, the one at a place among all of its consequents."""
        consequent = rule.consequents[place]
        factor = _number(self.system, rule.weight) if self.semantics.weight == "after" else 1.0
        term = self._term(consequent)
        changes: list[Expr] = []
        if not self.over_rules and self.semantics.consequent_hedges in ("set", "undone"):
            changes += self._hedges(consequent)
        if factor != 1.0 and not self.over_rules and self.implication == "min":
            changes.append(Binary("*", Number(factor), Name(ITSELF)))
        if changes:
            term = self._own(dataclasses.replace(self.terms[term], changes=tuple(changes)))
        self.implied.append(ImpliedPlan(position, term, factor, self._change(rule, place)))

    def _term(self, consequent: Consequent) -> int:
        term = consequent.term
        if isinstance(term, Membership):
            return self._own(_consequent(self.system, term))
        if term not in self.positions:
            raise UnknownNameError("term", term, self.positions)
        return self.positions[term]

    def _own(self, term: SetPlan) -> int:
        """Return the position of a consequent without a name."""
        if term not in self.terms[len(self.output.terms) :]:
            self.terms.append(term)
        return self.terms.index(term, len(self.output.terms))

    def _hedges(self, consequent: Consequent, *, undone: bool = False) -> list[Expr]:
        """Return what hedges do one after the other, the nearest to the term first, or what undoes them."""
        return [_change(self.system, hedge, undone=undone) for hedge in reversed(consequent.hedges)]

    def _change(self, rule: Rule, place: int) -> Expr | None:
        """Return what hedges make of the activation of a rule in one of its consequents."""
        how = self.semantics.consequent_hedges
        if how == "set" or (how == "undone" and not self.over_rules):
            return None
        before = rule.consequents[:place] if how == "carried" else ()
        changes = [c for own in (*before, rule.consequents[place]) for c in self._hedges(own, undone=how == "undone")]
        if not changes:
            return None
        return reduce(lambda whole, change: replace_names(change, {ITSELF: whole}), changes)


def _change(system: FuzzySystem, hedge: str, *, undone: bool) -> Expr:
    """Return what a hedge, or its inverse, makes of a degree, an expression over `ITSELF`."""
    x, cube = Name(ITSELF), system.method.semantics.extremely == "cube"
    own = next((h for h in system.hedges if h.name == hedge), None)
    if own is not None:
        numbers = _constants(system, {own.parameter})
        _require_known(own.expression, {own.parameter}, numbers)
        return held(guarded(replace_names(own.expression, {**numbers, own.parameter: x})))
    if hedge not in HEDGES:
        raise UnknownNameError("hedge", hedge, [*HEDGES, *(h.name for h in system.hedges)])
    found = inverse_hedge(hedge, cube=cube) if undone else usual_hedge(hedge, cube=cube)
    assert found is not None, "hedges without an inverse are refused"
    return found(x)


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
            return HeldPlan(0.5 * lower + 0.5 * upper if start is None else _number(system, start))
    return _number(system, output.otherwise)


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
    kinds = [_shape(output.terms[e.term]) for e in output.implied]
    crossed = term.kind == "gaussian2" and term.parameters[0] > term.parameters[2]
    if exact_maxima_possible(kinds, output.implication, output.aggregation) and not crossed:
        return None
    norms = f"'{output.implication}' and '{output.aggregation}'"
    problem = f"'{output.kind}' of these terms with {norms} has no closed form"
    return problem, f"sample it, such as 'defuzzifier {output.kind}(resolution=1000)'"


def _shape(term: SetPlan) -> str:
    """Return the kind of a term, of one that a hedge has changed what it is like."""
    return term.kind if not term.changes else "piecewise" if term.vertices else "changed"
