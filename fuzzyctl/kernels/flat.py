"""What a plan is made of: a system without names to look up, expressions to compute, or places in a text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, reduce
from typing import Final, Literal

from fuzzyctl.errors import FuzzyctlError
from fuzzyctl.expr import (
    COMPARISONS,
    ONE,
    Binary,
    Call,
    CompareOp,
    Expr,
    ExprError,
    Name,
    Number,
    evaluate,
    names_in,
    replace,
    replace_names,
    walk,
)
from fuzzyctl.formulas import (
    Vertex,
    formula_of,
    held,
)
from fuzzyctl.kernels.program import clip
from fuzzyctl.model.method import AVERAGES, OVER_RULES, SUMS
from fuzzyctl.records import record


@record(frozen=True)
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


@record(frozen=True)
class SetPlan:
    """A fuzzy set, or a consequent of Takagi-Sugeno, with its parameters as numbers.

    Args:
        kind: A key of `formulas.MEMBERSHIP`, `linear` or `function`.
        parameters: Its parameters, none for `linear` and `function`.
        height: The largest degree.
        expression: For `linear` and `function` consequents over the names of the inputs, for a `function` term of an
            input over `ITSELF`.
        changes: What hedges and weights make of its degree, one after the other, each an expression over `ITSELF`.
        implication: How rules imply it, where that is not the implication of the output; None where it is.
        reach: For a `linear` consequent of inputs that are clamped the numbers it lies between, up to rounding; kernels
            hold what they compute within. None where nothing is known beforehand.
    """

    kind: str
    parameters: tuple[float, ...]
    height: float = 1.0
    expression: Expr | None = None
    reach: tuple[float, float] | None = None
    changes: tuple[Expr, ...] = ()
    implication: str | None = None

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
        """Finite places where the formula changes, such as corners; of an expression those it compares x with."""
        if self.expression is not None:
            return tuple(sorted(set(_compared(self.expression))))
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


def _compared(expression: Expr) -> Iterator[float]:
    """Yield the numbers that an expression over `ITSELF` compares it with."""
    for node in walk(expression):
        if isinstance(node, Call) and node.function in COMPARISONS and Name(ITSELF) in node.arguments:
            values = [_value(a) for a in node.arguments if not names_in(a)]
            yield from (v for v in values if v is not None and math.isfinite(v))


def _value(expression: Expr) -> float | None:
    """Return the value of an expression without names, None where it has none."""

    def plain(node: Expr) -> Expr:
        match node:
            case Call(function="divide", arguments=(a, b)):
                return Binary("/", a, b)
        return node

    try:
        return evaluate(replace(expression, plain), {})
    except ExprError:
        return None


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


@record(frozen=True)
class InputPlan:
    """An input: its position is its place in the plan."""

    name: str
    lower: float
    upper: float
    extrapolate: bool


@record(frozen=True)
class DegreePlan:
    """The degree of one term of one variable; it appears once, however many rules name it.

    Variables are counted through: first the inputs, then the outputs, which count with their crisp values.
    """

    variable: int
    term: str
    set: SetPlan


@record(frozen=True)
class RulePlan:
    """A rule: which firing strength it has, its weight, and the group of rules that it is chosen from.

    Args:
        strength: Position of its firing strength.
        weight: Its weight, where that counts before implication.
        group: Position of the activation method of its group; methods compare the rules of one group.
    """

    strength: int
    weight: float
    group: int = 0


@record(frozen=True)
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


@record(frozen=True)
class ChainPlan:
    """How far a term of an output has been activated by the rules before, which later rules read.

    Args:
        output: Position of the output.
        entries: Positions in its `implied`, of the rules before that name the term.
    """

    output: int
    entries: tuple[int, ...]


@record(frozen=True)
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

    def implication_of(self, term: SetPlan) -> str:
        """Return how rules imply one of its terms."""
        return term.implication or self.implication

    @property
    def mixes_implications(self) -> bool:
        """Whether rules imply its terms in different ways."""
        return any(self.terms[e.term].implication is not None for e in self.implied)

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


@record(frozen=True)
class ActivationPlan:
    """The activation method; see `model.method.Activation`."""

    kind: str = "general"
    count: int = 1
    threshold: float = 0.0
    comparison: CompareOp = ">="

    @property
    def compares(self) -> bool:
        """Whether it compares rules with each other, so that the activations of all must be known."""
        return self.kind not in ("general", "threshold")


@record(frozen=True)
class Plan:
    """A system as numbers: hashable, and equal for systems that compute the same in the same order.

    Args:
        inputs: In order of a kernel's arguments.
        degrees: Each degree that some rule uses, once.
        steps: Parts of firing strengths that are mentioned more than once, each an expression over degrees and earlier
            steps.
        strengths: Each distinct firing strength, an expression over the names of degrees and steps.
        rules: In the order written.
        activations: Which rules act, for each group of rules; one for all rules where no rule block differs.
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
    activations: tuple[ActivationPlan, ...]
    outputs: tuple[OutputPlan, ...]
    order: tuple[int, ...]
    chains: tuple[ChainPlan, ...] = ()
    least: float | None = 0.0

    def activation_of(self, rule: int) -> ActivationPlan:
        """Return the activation method of the group of a rule."""
        return self.activations[self.rules[rule].group]

    def activations_of(self, output: OutputPlan) -> tuple[ActivationPlan, ...]:
        """Return the activation methods of the rules that name an output."""
        return tuple(dict.fromkeys(self.activation_of(entry.rule) for entry in output.implied))

    @property
    def all_act(self) -> bool:
        """Whether no activation method leaves out or changes what rules do."""
        return all(a.kind == "general" for a in self.activations)

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
