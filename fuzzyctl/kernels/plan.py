"""From the model to a plan: the same system without names to look up, expressions to compute, or places in a text."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from typing import Literal

from fuzzyctl.errors import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import CONSTANTS, Expr, Name, Number, names_in, replace_names
from fuzzyctl.formulas import CONJUNCTIONS, DISJUNCTIONS, MEMBERSHIP, Norm, Vertex, one_minus
from fuzzyctl.model.method import AVERAGES, Method
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output

#: What a planned output is where no rule fires: a number (NaN for `else nan`), an exception, or nothing, since it has
#: been promised that some rule always fires.
Otherwise = float | Literal["error"] | None


@dataclass(frozen=True)
class SetPlan:
    """A fuzzy set with its parameters as numbers."""

    kind: str
    parameters: tuple[float, ...]

    def degree(self, x: Expr) -> Expr:
        """Return the degree of x."""
        return MEMBERSHIP[self.kind].degree(x, self.parameters)

    @property
    def vertices(self) -> tuple[Vertex, ...]:
        """Corners of a piecewise-linear set, empty for a curved one."""
        return MEMBERSHIP[self.kind].vertices(self.parameters)

    @property
    def peak(self) -> float:
        """The middle of the core: what the averages take (Eq. (18) of Goto, Bertol, Martins)."""
        left, right = MEMBERSHIP[self.kind].core(self.parameters)
        return left if left == right else 0.5 * left + 0.5 * right


@dataclass(frozen=True)
class InputPlan:
    """An input: its position is its place in the plan."""

    name: str
    lower: float
    upper: float
    extrapolate: bool


@dataclass(frozen=True)
class DegreePlan:
    """The degree of one term of one input; it appears once, however many rules name it."""

    input: int
    term: str
    set: SetPlan


@dataclass(frozen=True)
class RulePlan:
    """A rule: which firing strength it has, and its weight."""

    strength: int
    weight: float


@dataclass(frozen=True)
class ImpliedPlan:
    """The consequent of a rule in one output, both as positions."""

    rule: int
    term: int


@dataclass(frozen=True)
class OutputPlan:
    """An output with the consequents of all rules that name it.

    Args:
        name: Its name.
        lower: Lower end of the range.
        upper: Upper end of the range.
        kind: The defuzzifier, one of `model.method.DEFUZZIFIERS`.
        resolution: Sample points of a centroid, None for the exact one.
        grid: Where the sample points stand.
        implication: One of `formulas.IMPLICATIONS`.
        aggregation: One of `formulas.AGGREGATIONS`.
        terms: The fuzzy sets of the terms, in order of declaration.
        implied: One entry for each rule that names the output, in order of the rules.
        otherwise: What it is where no rule fires.
        rate: For an adaptive output dC_k/dt divided by ξ_k over the names of the inputs, else None.
    """

    name: str
    lower: float
    upper: float
    kind: str
    resolution: int | None
    grid: str
    implication: str
    aggregation: str
    terms: tuple[SetPlan, ...]
    implied: tuple[ImpliedPlan, ...]
    otherwise: Otherwise
    rate: Expr | None

    @property
    def averages(self) -> bool:
        """Whether it sums over rules rather than over a fuzzy set."""
        return self.kind in AVERAGES


@dataclass(frozen=True)
class Plan:
    """A system as numbers: hashable, and equal for systems that compute the same in the same order.

    Args:
        inputs: In order of a kernel's arguments.
        degrees: Each degree that some rule uses, once.
        strengths: Each distinct firing strength, an expression over `d0`, `d1`, ... of the degrees.
        rules: In the order written.
        outputs: In order of a kernel's results.
    """

    inputs: tuple[InputPlan, ...]
    degrees: tuple[DegreePlan, ...]
    strengths: tuple[Expr, ...]
    rules: tuple[RulePlan, ...]
    outputs: tuple[OutputPlan, ...]

    @property
    def states(self) -> tuple[tuple[int, int], ...]:
        """The adaptive state: (output, position in its `implied`) for each of its entries.

        One entry for each rule that names an adaptive output, output by output; with the one adaptive output that most
        systems have, entry k belongs to rule k.
        """
        return tuple(
            (o, k)
            for o, output in enumerate(self.outputs)
            if output.rate is not None
            for k in range(len(output.implied))
        )

    @property
    def initial_state(self) -> tuple[float, ...]:
        """The peaks of the declared terms, one for each entry of `states`."""
        return tuple(self.outputs[o].terms[self.outputs[o].implied[k].term].peak for o, k in self.states)


def degree_name(index: int) -> str:
    """Return the name that a degree has inside firing strengths."""
    return f"d{index}"


def plan(system: FuzzySystem) -> Plan:
    """Flatten a well-formed system.

    Raises:
        DiagnosticError: For an exact centroid of curved terms, which has no closed form, and of terms without area.
        UnknownNameError: For an antecedent or consequent that names what is not declared.
        ExprError: For an expression without a value; a loaded system has none such.
    """
    antecedents = _Antecedents(system)
    rules = tuple(
        RulePlan(antecedents.strength(rule.antecedent), _number(system, rule.weight)) for rule in system.rules
    )
    return Plan(
        inputs=tuple(_input(system, i) for i in system.inputs),
        degrees=tuple(antecedents.degrees.values()),
        strengths=tuple(antecedents.strengths),
        rules=rules,
        outputs=tuple(_output(system, output) for output in system.outputs),
    )


class _Antecedents:
    """Collect the distinct degrees and firing strengths of a system."""

    def __init__(self, system: FuzzySystem) -> None:
        self.system = system
        self.conjunction = CONJUNCTIONS[system.method.conjunction]
        self.disjunction = DISJUNCTIONS[system.method.disjunction]
        self.positions = {v.name: i for i, v in enumerate(system.inputs)}
        self.degrees: dict[tuple[int, str], DegreePlan] = {}
        self.names: dict[tuple[int, str], Name] = {}
        self.strengths: dict[Expr, int] = {}

    def strength(self, antecedent: Antecedent) -> int:
        return self.strengths.setdefault(self.truth(antecedent), len(self.strengths))

    def truth(self, antecedent: Antecedent) -> Expr:
        match antecedent:
            case Is(variable=variable, term=term):
                return self.degree(variable, term)
            case Not(operand=operand):
                return one_minus(self.truth(operand))
            case And(operands=operands):
                return self.join(self.conjunction, operands)
            case Or(operands=operands):
                return self.join(self.disjunction, operands)
        raise TypeError(f"{type(antecedent).__name__} is no antecedent")

    def join(self, norm: Norm, operands: tuple[Antecedent, ...]) -> Expr:
        return reduce(norm, [self.truth(operand) for operand in operands])

    def degree(self, variable: str, term: str) -> Name:
        if variable not in self.positions:
            raise UnknownNameError("input", variable, self.positions)
        key = (self.positions[variable], term)
        if key not in self.degrees:
            declared = self.system.inputs[key[0]]
            found = declared.term(term)
            if found is None:
                raise UnknownNameError("term", term, [t.name for t in declared.terms])
            self.names[key] = Name(degree_name(len(self.degrees)))
            self.degrees[key] = DegreePlan(key[0], term, _set(self.system, found.membership))
        return self.names[key]


def _number(system: FuzzySystem, expr: Expr) -> float:
    # + 0.0 makes -0.0 a plain zero, so that equal systems have equal plans.
    return float(system.number(expr)) + 0.0


def _input(system: FuzzySystem, variable: Input) -> InputPlan:
    return InputPlan(
        variable.name, _number(system, variable.lower), _number(system, variable.upper), variable.extrapolate
    )


def _set(system: FuzzySystem, membership: Membership) -> SetPlan:
    return SetPlan(membership.kind, tuple(_number(system, a) for a in membership.arguments))


def _output(system: FuzzySystem, output: Output) -> OutputPlan:
    method = system.method
    terms = tuple(_set(system, term.membership) for term in output.terms)
    positions = {term.name: i for i, term in enumerate(output.terms)}
    implied: list[ImpliedPlan] = []
    for r, rule in enumerate(system.rules):
        for consequent in rule.consequents:
            if consequent.output == output.name:
                term = consequent.term
                if isinstance(term, Membership):
                    terms = (*terms, _set(system, term))
                    implied.append(ImpliedPlan(r, len(terms) - 1))
                    continue
                if term not in positions:
                    raise UnknownNameError("term", term, positions)
                implied.append(ImpliedPlan(r, positions[term]))
    rate = _rate(system, output)
    _require_area(output, terms, method, {entry.term for entry in implied})
    lower, upper = _number(system, output.lower), _number(system, output.upper)
    return OutputPlan(
        name=output.name,
        lower=lower,
        upper=upper,
        kind=method.defuzzifier.kind,
        resolution=method.defuzzifier.resolution,
        grid=method.defuzzifier.grid,
        implication=method.implication,
        aggregation=method.aggregation,
        terms=terms,
        implied=tuple(implied),
        otherwise=_otherwise(system, output, lower, upper),
        rate=rate,
    )


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
    return _number(system, output.otherwise)


def _rate(system: FuzzySystem, output: Output) -> Expr | None:
    if output.adaptive is None:
        return None
    if not system.method.defuzzifier.averages:
        message = f"output '{output.name}' is adaptive, and only averages know adaptive consequents"
        raise DiagnosticError([Diagnostic("FZ214", message, output.span, help="use 'defuzzifier weighted_average'")])
    inputs = {i.name for i in system.inputs}
    numbers: dict[str, Expr] = {n: Number(v) for n, v in (CONSTANTS | system.values).items() if n not in inputs}
    for name in names_in(output.adaptive):
        if name.name not in inputs and name.name not in numbers:
            raise UnknownNameError("input", name.name, sorted(inputs))
    return replace_names(output.adaptive, numbers)


def _require_area(output: Output, terms: tuple[SetPlan, ...], method: Method, used: set[int]) -> None:
    """Refuse a centroid that has no closed form or no area to take it of."""
    if method.defuzzifier.averages:
        return
    for i in sorted(used):
        name = f"term '{output.terms[i].name}'" if i < len(output.terms) else "a consequent"
        span, vertices = output.terms[i].span if i < len(output.terms) else output.span, terms[i].vertices
        if terms[i].kind == "singleton":
            problem = "a singleton has no area, so it has no centroid"
            way_out = "use 'defuzzifier weighted_average'"
        elif not vertices and method.defuzzifier.resolution is None:
            problem = f"the exact centroid needs piecewise-linear terms, and '{terms[i].kind}' is curved"
            way_out = "sample it, such as 'defuzzifier centroid(resolution=1000)'"
        else:
            continue
        message = f"{name} of output '{output.name}' does not suit the defuzzifier: {problem}"
        raise DiagnosticError([Diagnostic("FZ214", message, span, help=way_out)])
