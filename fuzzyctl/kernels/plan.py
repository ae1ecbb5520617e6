"""From the model to a plan: the same system without names to look up, expressions to compute, or places in a text."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Final, Literal

from fuzzyctl.errors import Diagnostic, DiagnosticError, FuzzyctlError, UnknownNameError
from fuzzyctl.expr import (
    CONSTANTS,
    MAX_DEPTH,
    ONE,
    ZERO,
    Binary,
    Call,
    Expr,
    Name,
    Number,
    evaluate,
    names_in,
    replace,
    replace_names,
)
from fuzzyctl.formulas import (
    HEDGES,
    MEMBERSHIP,
    VARIANTS,
    Norm,
    Vertex,
    conjunction,
    disjunction,
    exact_centroid_possible,
    formula_of,
    held,
    inverse_hedge,
    is_monotone,
    one_minus,
)
from fuzzyctl.formulas import hedge as usual_hedge
from fuzzyctl.kernels.program import DEEPEST, clip, depth
from fuzzyctl.model.method import AVERAGES, OVER_RULES, SUMS
from fuzzyctl.model.misfits import misfitting_semantics
from fuzzyctl.model.reads import reads_of
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Membership, Output, Term


@dataclass(frozen=True)
class HeldPlan:
    """What an output is where no rule fires, if that is its previous value: at first `start`."""

    start: float


#: What a planned output is where no rule fires: a number (NaN for `else nan`), its previous value, an exception, or
#: nothing, since it has been promised that some rule always fires.
Otherwise = float | HeldPlan | Literal["error"] | None

#: The name of the variable itself in the expression of a `function` term of an input.
ITSELF: Final = "x"


class OutputCycleError(FuzzyctlError):
    """Raised when outputs read each other in a circle, so that none can be computed first."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(f"outputs depend on each other: {' → '.join(names)}")


@dataclass(frozen=True)
class SetPlan:
    """A fuzzy set, or a consequent of Takagi-Sugeno, with its parameters as numbers.

    Args:
        kind: A key of `formulas.MEMBERSHIP`, `linear` or `function`.
        parameters: Its parameters, none for `linear` and `function`.
        height: The largest degree.
        expression: For `linear` and `function` consequents over the names of the inputs, for a `function` term of an
            input over `ITSELF`.
        changes: What hedges and weights make of its degree, one after the other, each an expression over `ITSELF`.
        reach: For a `linear` consequent of inputs that are clamped the numbers it lies between, up to rounding; kernels
            hold what they compute within. None where nothing is known beforehand.
    """

    kind: str
    parameters: tuple[float, ...]
    height: float = 1.0
    expression: Expr | None = None
    reach: tuple[float, float] | None = None
    changes: tuple[Expr, ...] = ()

    def degree(self, x: Expr) -> Expr:
        """Return the degree of x."""
        if self.expression is not None:
            own = held(replace_names(self.expression, {ITSELF: x}))
        else:
            own = formula_of(self.kind).degree(x, self.parameters)
        whole = own if self.height == 1.0 else Binary("*", Number(self.height), own)
        return reduce(lambda degree, change: replace_names(change, {ITSELF: degree}), self.changes, whole)

    def degree_for_many(self, x: Expr, *, exact: bool) -> Expr:
        """Return the degree of x as vector instructions like it: without choices, for triangles and trapezoids.

        Each side is a line, the smaller of them counts, held within [0, 1].

        Args:
            x: An atom.
            exact: Whether it must be the same number as `degree`; if not, it is 0 or 1 at the same corners and may
                differ by rounding between them, where a product is cheaper than a quotient.
        """
        sides = _sides(self)
        if sides is None:
            return self.degree(x)
        own = clip(reduce(lambda a, b: Call("min", (a, b)), [_line(x, *s, exact=exact) for s in sides]), 0.0, 1.0)
        return own if self.height == 1.0 else Binary("*", Number(self.height), own)

    @property
    def has_sides(self) -> bool:
        """Whether it is a triangle or trapezoid without jumps."""
        return _sides(self) is not None

    @cached_property
    def vertices(self) -> tuple[Vertex, ...]:
        """Corners of a piecewise-linear set, empty for a curved one."""
        if self.expression is not None or not all(map(_is_straight, self.changes)):
            return ()
        corners = [(x, self.height * y) for x, y in formula_of(self.kind).vertices(self.parameters)]
        for change in self.changes:
            corners = [(x, evaluate(change, {ITSELF: y})) for x, y in corners]
        return tuple(corners)

    @property
    def pieces(self) -> tuple[float, ...]:
        """Finite places where the formula changes, such as corners."""
        if self.expression is not None:
            return ()
        formula = formula_of(self.kind)
        places = [*formula.core(self.parameters), *formula.pieces(self.parameters)]
        return tuple(sorted({x for x in places if not math.isinf(x)}))

    @property
    def peak(self) -> float:
        """The middle of the core: what the averages take (Eq. (18) of Goto, Bertol, Martins)."""
        left, right = formula_of(self.kind).core(self.parameters)
        return left if left == right else 0.5 * left + 0.5 * right

    def share(self, activation: Expr, *, limited: bool = True) -> Expr:
        """Return an activation relative to the height; `limited` to at most 1, which it may pass."""
        own = activation if self.height == 1.0 else Binary("/", activation, Number(self.height))
        return Call("min", (ONE, own)) if limited else own

    def inverse(self, share: Expr) -> Expr:
        """Return where a monotone set has a share, which must be a name, of its height."""
        found = formula_of(self.kind).inverse(share, self.parameters)
        assert found is not None, "tsukamoto takes monotone sets only"
        return found


def _is_straight(change: Expr) -> bool:
    """Return whether a change of degrees is a line: a complement or a factor."""
    match change:
        case Binary(op="-" | "*", left=Number(), right=Name()):
            return True
    return False


def _sides(term: SetPlan) -> list[tuple[float, float]] | None:
    """Return foot and top of the sides of a triangle or trapezoid, None for any other set."""
    if term.expression is not None or term.changes:
        return None
    corners = formula_of(term.kind).vertices(term.parameters)
    tops = [x for x, y in corners if y == 1.0]
    feet = [x for x, y in corners if y == 0.0]
    if not feet or len(tops) + len(feet) < len(corners) or len({x for x, _ in corners}) < len(corners):
        return None
    left, right = [x for x in feet if x < tops[0]], [x for x in feet if x > tops[-1]]
    if len(left) > 1 or len(right) > 1 or len(left) + len(right) < len(feet):  # else there is a valley between tops
        return None
    return [(x, tops[0]) for x in left] + [(x, tops[-1]) for x in right]


def _line(x: Expr, foot: float, top: float, *, exact: bool) -> Expr:
    """Return the line that is 0 at the foot and 1, or by rounding a bit more, at the top."""
    beyond = Binary("-", x, Number(foot)) if top > foot else Binary("-", Number(foot), x)
    if exact:
        return Binary("/", beyond, Number(abs(top - foot)))
    slope = 1.0 / abs(top - foot)
    while slope * abs(top - foot) < 1.0:
        slope = math.nextafter(slope, math.inf)
    return Binary("*", beyond, Number(slope))


@dataclass(frozen=True)
class InputPlan:
    """An input: its position is its place in the plan."""

    name: str
    lower: float
    upper: float
    extrapolate: bool


@dataclass(frozen=True)
class DegreePlan:
    """The degree of one term of one variable; it appears once, however many rules name it.

    Variables are counted through: first the inputs, then the outputs, which count with their crisp values.
    """

    variable: int
    term: str
    set: SetPlan


@dataclass(frozen=True)
class RulePlan:
    """A rule: which firing strength it has, and its weight."""

    strength: int
    weight: float


@dataclass(frozen=True)
class ImpliedPlan:
    """The consequent of a rule in one output, both as positions.

    Args:
        rule: The rule.
        term: The consequent term.
        factor: What the activation is multiplied by in the end: a weight that counts after implication.
        change: What hedges make of the activation, an expression over `ITSELF`; None for none.
    """

    rule: int
    term: int
    factor: float = 1.0
    change: Expr | None = None


@dataclass(frozen=True)
class ChainPlan:
    """How far a term of an output has been activated by the rules before, which later rules read.

    Args:
        output: Position of the output.
        entries: Positions in its `implied`, of the rules before that name the term.
    """

    output: int
    entries: tuple[int, ...]


@dataclass(frozen=True)
class OutputPlan:
    """An output with the consequents of all rules that name it.

    Args:
        name: Its name.
        lower: Lower end of the range.
        upper: Upper end of the range.
        kind: The defuzzifier, one of `model.method.DEFUZZIFIERS`.
        resolution: Sample points of the set, None for what is exact.
        grid: Where the sample points stand.
        implication: One of `formulas.IMPLICATIONS`.
        aggregation: One of `formulas.AGGREGATIONS`.
        terms: The consequents: the terms in order of declaration, then those without a name.
        implied: One entry for each rule that names the output, in order of the rules.
        otherwise: What it is where no rule fires.
        rate: For an adaptive output dC_k/dt divided by ξ_k over the names of the inputs, else None.
        reads: Positions of the outputs it depends on, directly or through others.
        merge: What a sum over rules runs over; see `model.semantics`.
        total: What an average divides by; see there.
        equal: What degrees may differ by that count as equal; see there.
        clamped: Whether its value is held within its range.
        rule: What is made of the samples; see `model.method.Defuzzifier`.
        tolerance: Part of the largest degree by which maxima may fall short of it, None for the usual one.
        by: What smallest and largest of the maxima are measured by.
        places: Whether places that Tsukamoto's method finds are clamped to the range; see `model.semantics`.
        none_active: What the maxima of a set are that is 0 everywhere; see there.
        fallback: Where it is what its `else` says; see there.
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
    reads: tuple[int, ...] = ()
    merge: str = "rules"
    total: str = "activations"
    equal: float = 0.0
    clamped: bool = False
    rule: str | None = None
    tolerance: float | None = None
    by: str = "value"
    places: str = "clamped"
    none_active: str = "otherwise"
    fallback: str = "unfired"

    @property
    def averages(self) -> bool:
        """Whether it is an average over rules of fixed or adaptive numbers."""
        return self.kind in AVERAGES

    @property
    def over_rules(self) -> bool:
        """Whether it sums over rules rather than over a fuzzy set."""
        return self.kind in OVER_RULES

    @property
    def sums(self) -> bool:
        """Whether it is a sum over rules that is not divided by the sum of their activations."""
        return self.kind in SUMS

    @property
    def inverts(self) -> bool:
        """Whether it takes the places where monotone consequents have the activations."""
        return self.kind in ("tsukamoto", "tsukamoto_sum")

    @property
    def takes_degrees(self) -> bool:
        """Whether it takes the degrees that consequents have at the activations."""
        return self.kind in ("inverse_tsukamoto", "inverse_tsukamoto_sum")


@dataclass(frozen=True)
class ActivationPlan:
    """The activation method; see `model.method.Activation`."""

    kind: str = "general"
    count: int = 1
    threshold: float = 0.0
    comparison: str = ">="


@dataclass(frozen=True)
class Plan:
    """A system as numbers: hashable, and equal for systems that compute the same in the same order.

    Args:
        inputs: In order of a kernel's arguments.
        degrees: Each degree that some rule uses, once.
        steps: Parts of firing strengths that are mentioned more than once, each an expression over degrees and earlier
            steps.
        strengths: Each distinct firing strength, an expression over the names of degrees and steps.
        rules: In the order written.
        activation: Which rules act.
        outputs: In order of a kernel's results.
        order: Positions of the outputs, each after those it reads.
        chains: Degrees of outputs that antecedents read while rules are evaluated.
        least: A rule acts only if its activation is above it; None for rules that always act.
    """

    inputs: tuple[InputPlan, ...]
    degrees: tuple[DegreePlan, ...]
    steps: tuple[Expr, ...]
    strengths: tuple[Expr, ...]
    rules: tuple[RulePlan, ...]
    activation: ActivationPlan
    outputs: tuple[OutputPlan, ...]
    order: tuple[int, ...]
    chains: tuple[ChainPlan, ...] = ()
    least: float | None = 0.0

    def variable(self, position: int) -> InputPlan:
        """Return an input, or an output as what antecedents read: its value within its range."""
        if position < len(self.inputs):
            return self.inputs[position]
        output = self.outputs[position - len(self.inputs)]
        return InputPlan(output.name, output.lower, output.upper, extrapolate=False)

    @property
    def held(self) -> tuple[int, ...]:
        """The outputs that hold their previous value where no rule fires, in the order they are computed in.

        Their previous values are the last entries of the state.
        """
        return tuple(o for o in self.order if isinstance(self.outputs[o].otherwise, HeldPlan))

    @property
    def states(self) -> tuple[tuple[int, int], ...]:
        """The adaptive part of the state: (output, position in its `implied`) for each of its entries.

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
        """The peaks of the declared terms, one for each entry of `states`, then what is held at first."""
        held = (self.outputs[o].otherwise for o in self.held)
        return (
            *(self.outputs[o].terms[self.outputs[o].implied[k].term].peak for o, k in self.states),
            *(h.start for h in held if isinstance(h, HeldPlan)),
        )


def degree_name(index: int) -> str:
    """Return the name that a degree has inside firing strengths."""
    return f"d{index}"


def chain_name(index: int) -> str:
    """Return the name that the degree of an output so far has inside firing strengths."""
    return f"c{index}"


def step_name(index: int) -> str:
    """Return the name that a step has inside firing strengths."""
    return f"t{index}"


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
    straight = not term.changes or bool(term.vertices)
    is_exact = straight and exact_centroid_possible(term.kind, output.implication, output.aggregation)
    if output.resolution is not None or (is_exact and output.kind == "centroid"):
        return None
    if not term.vertices:
        problem = f"the exact {output.kind} needs piecewise-linear terms, and '{term.kind}' is curved"
    else:
        problem = f"there is no exact {output.kind} for '{output.implication}' and '{output.aggregation}'"
    return problem, f"sample it, such as 'defuzzifier {output.kind}(resolution=1000)'"
