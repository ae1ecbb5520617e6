"""Type of a plan: a system as numbers and indices, flat and hashable."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import (
    CompareOp,
    Expr,
)
from fuzzyctl.kernels.plan.sets import SetPlan
from fuzzyctl.model.method import AVERAGES, DEFUZZIFIERS, EACH_ALONE, OVER_RULES
from fuzzyctl.records import record


@record(frozen=True)
class HeldPlan:
    """Mark of an output that holds its previous value if no rule fires, at first `start`."""

    start: float


#: A planned output without a firing rule: a number (NaN for `else nan`), its previous value, an exception, or
#: nothing, since it has been promised that some rule always fires.
Otherwise = float | HeldPlan | Literal["error"] | None


class OutputCycleError(FuzzyctlError):
    """Raised when outputs read each other in a circle, so that no order of computing them exists."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(f"outputs depend on each other: {' → '.join(names)}")


@record(frozen=True)
class InputPlan:
    """An input: its position is its place in the plan."""

    name: str
    lower: float
    upper: float
    extrapolate: bool


@record(frozen=True)
class LetPlan:
    """A named value of the inputs, an expression over them and lets before it; antecedents read it within its range.

    Args:
        name: Its name.
        lower: Lower end of the range.
        upper: Upper end of the range.
        value: The expression, over calls as well.
        calls: Its calls: names with a system, the position of an output and arguments.
    """

    name: str
    lower: float
    upper: float
    value: Expr
    calls: tuple[CallPlan, ...] = ()


@record(frozen=True)
class CallPlan:
    """An output of another system at arguments, which are expressions over the inputs, lets and calls before it."""

    name: str
    system: Plan
    output: int
    arguments: tuple[Expr, ...]


@record(frozen=True)
class DegreePlan:
    """The degree of one term of one variable; it appears once, however many rules name it.

    Variables are counted through: the inputs, the outputs, which count with their crisp values, and the lets.
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
        factor: Last factor of the activation: a weight that counts after implication.
        change: Function of the hedges over the activation `ITSELF`; None without hedges.
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
        resolution: Number of sample points of the set, None for an exact method.
        grid: Places of the sample points.
        implication: One of `formulas.IMPLICATIONS`.
        aggregation: One of `formulas.AGGREGATIONS`.
        terms: The consequents: the terms in order of declaration, then those without a name.
        implied: One entry for each rule that names the output, in order of the rules.
        otherwise: Its value if no rule fires.
        rate: For an adaptive output dC_k/dt divided by ξ_k over the names of the inputs, else None.
        reads: Positions of the outputs it depends on, directly or through others.
        merge: Summands of a sum over rules; see `model.method`.
        total: Divisor of an average; see there.
        equal: Largest difference of degrees that count as equal; see there.
        clamped: Whether its value is held within its range.
        rule: Rule for the samples; see `model.method.Defuzzifier`.
        tolerance: Part of the largest degree by which maxima may fall short of it, None for the usual one.
        by: What smallest and largest of the maxima are measured by.
        places: Whether places that Tsukamoto's method finds are clamped to the range; see `model.method`.
        none_active: Maxima of a set that is 0 everywhere; see there.
        fallback: When its `else` applies; see there.
        value: Its value, over the names of inputs, lets and other outputs, if no rules set it; else None.
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
    value: Expr | None = None

    def implication_of(self, term: SetPlan) -> str:
        """Return how rules imply one of its terms."""
        return term.implication or self.implication

    @cached_property
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
        return not DEFUZZIFIERS[self.kind].divides

    @property
    def inverts(self) -> bool:
        """Whether it takes the places where monotone consequents have the activations."""
        return DEFUZZIFIERS[self.kind].takes == "place"

    @property
    def takes_degrees(self) -> bool:
        """Whether it takes the degrees that consequents have at the activations."""
        return DEFUZZIFIERS[self.kind].takes == "degree"


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
        return self.kind not in EACH_ALONE


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
        lets: Named values, each after those it reads.
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
    lets: tuple[LetPlan, ...] = ()

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(v.name for v in some) for some in (self.inputs, self.outputs))
        return printable(f"Plan({inputs} -> {outputs}; {counted(len(self.rules), 'rule')})")

    @cached_property
    def named_steps(self) -> dict[str, Expr]:
        """The steps by their names in expressions."""
        return {step_name(i): step for i, step in enumerate(self.steps)}

    def activation_of(self, rule: int) -> ActivationPlan:
        """Return the activation method of the group of a rule."""
        return self.activations[self.rules[rule].group]

    def activations_of(self, output: OutputPlan) -> tuple[ActivationPlan, ...]:
        """Return the activation methods of the rules that name an output."""
        return tuple(dict.fromkeys(self.activation_of(entry.rule) for entry in output.implied))

    @property
    def all_act(self) -> bool:
        """Whether every rule keeps its activation under all activation methods."""
        return all(a.kind == "general" for a in self.activations)

    def variable(self, position: int) -> InputPlan:
        """Return an input, output or let as antecedents read it: its value within its range."""
        if position < len(self.inputs):
            return self.inputs[position]
        others: tuple[OutputPlan | LetPlan, ...] = (*self.outputs, *self.lets)
        other = others[position - len(self.inputs)]
        return InputPlan(other.name, other.lower, other.upper, extrapolate=False)

    @property
    def has_formulas(self) -> bool:
        """Whether it has lets, or outputs that are formulas."""
        return bool(self.lets) or any(o.value is not None for o in self.outputs)

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
        """The peaks of the declared terms, one for each entry of `states`, then the first values of holding outputs."""
        starts = (self.outputs[o].otherwise for o in self.held)
        return (
            *(self.outputs[o].terms[self.outputs[o].implied[k].term].peak for o, k in self.states),
            *(h.start for h in starts if isinstance(h, HeldPlan)),
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
