"""Equations of a loop: integrated, delayed, held and recorded signals, and the needs of some values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, ZERO, Call, Expr, Name, Number, names_in, replace_names
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equation, Evaluation, KeptState
from fuzzyctl.kernels.plan.plan import OutputPlan
from fuzzyctl.model.controller import Signal
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.rule import Consequent, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output, Term
from fuzzyctl.records import record
from fuzzyctl.simulation.loop_params import blocks_of
from fuzzyctl.simulation.signals import Given, Noise

#: Larger values of a state count as infinite.
LARGEST: Final = 1e300


@record(frozen=True)
class PlantState:
    """A state that is integrated.

    Args:
        name: `BLOCK.STATE`.
        start: Its value at the beginning.
        derivative: Its derivative by time.
        low: The lower end of its range, -inf for none.
        high: The upper end.
        without_low: Whether the lower end is outside of the range.
        without_high: Whether the upper end is.
        unit: Its unit.
    """

    name: str
    start: float
    derivative: Expr
    low: float = -math.inf
    high: float = math.inf
    without_low: bool = False
    without_high: bool = False
    unit: str = ""
    span: Span | None = field(default=None, compare=False, repr=False)

    def holds(self, value: float) -> bool:
        """Return whether a value is finite and in the range."""
        above = value > self.low if self.without_low else value >= self.low
        below = value < self.high if self.without_high else value <= self.high
        return above and below and abs(value) < LARGEST


@record(frozen=True)
class DeadTime:
    """A signal and its value some time ago.

    Args:
        name: Of the delayed value.
        signal: The signal.
        time: How long ago [s].
        start: The value before the run.
    """

    name: str
    signal: Expr
    time: float
    start: float
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True)
class External:
    """A plant in Python or an FMU: its outputs are known before the equations, and what follows comes from its inputs.

    Args:
        plant: The plant.
        block: Name of its block.
        inputs: Names of its inputs.
        states: Positions of its states among those of all plants.
        outputs: Names of its outputs.
    """

    plant: Plant
    block: str
    inputs: tuple[str, ...]
    states: tuple[int, ...]
    outputs: tuple[str, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True)
class LoopEquations:
    """A loop as equations in an order in which they can be computed.

    Args:
        body: Equations and calls of systems, each after those that it reads.
        plant_states: The states that are integrated.
        states: The states of controllers.
        updates: The next value of each of them.
        held: Names whose value is kept from one sample to the next: outputs of controllers, noise.
        delays: Dead times.
        given: Signals that are known before the run, by the names of their columns.
        rates: By name of a flag every how many samples it is 1, else 0.
        signals: Recorded expressions by name.
        step: Time between two samples [s].
        samples: How many there are.
        periods: The sample time of each state's controller [s], by name of the block.
        free: Names of params and disturbances whose values are arguments of a run: `BLOCK.PARAM`, or `NAME` of the
            loop.
        externals: Plants in Python and FMUs.
        disturbances: The lower end, the upper end and the nominal value of each disturbance, by name.
        errors: The largest magnitudes of names that have any value up to it, another one at each sample.
    """

    body: tuple[Equation | Evaluation, ...]
    plant_states: tuple[PlantState, ...]
    states: tuple[KeptState, ...]
    updates: tuple[Expr, ...]
    held: frozenset[str]
    delays: tuple[DeadTime, ...]
    given: Mapping[tuple[str, ...], Given]
    rates: Mapping[str, int]
    signals: Mapping[str, Expr]
    step: float
    samples: int
    periods: Mapping[str, float]
    free: tuple[str, ...] = ()
    externals: tuple[External, ...] = ()
    disturbances: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)

    @property
    def integrated(self) -> list[Expr]:
        """Values needed between two samples: derivatives, inputs of plants in Python, signals that are delayed."""
        external = {k for e in self.externals for k in e.states}
        derivatives = [s.derivative for k, s in enumerate(self.plant_states) if k not in external]
        inputs = [Name(n) for e in self.externals if e.plant.python for n in e.inputs]
        return [*derivatives, *inputs, *(d.signal for d in self.delays)]


def block_signals(loop: Loop) -> Iterator[tuple[str, Signal]]:
    """Yield inputs, states and outputs of the blocks of a loop, each with the name of its block."""
    for instance in loop.instances:
        block = blocks_of(loop)[instance.controller]
        yield from ((instance.name, s) for s in (*block.inputs, *block.states, *block.results))


def with_calls(equations: LoopEquations) -> LoopEquations:
    """Return equations that also record the inputs of systems that blocks call, as `BLOCK.SYSTEM.INPUT`.

    Of several calls of a system in a block the second is `BLOCK.SYSTEM.2.INPUT`, and so on as they are evaluated.
    """
    signals, calls = dict(equations.signals), Counter[str]()
    for call in equations.body:
        if isinstance(call, Evaluation):
            name = f"{call.names[0].partition('.')[0]}.{call.system.name}"
            calls[name] += 1
            prefix = name if calls[name] == 1 else f"{name}.{calls[name]}"
            for signal, argument in zip(call.system.inputs, call.arguments, strict=True):
                signals.setdefault(f"{prefix}.{signal.name}", argument)
    return replace(equations, signals=signals)


@record(frozen=True)
class Integers:
    """How far the integers of a controller are from its numbers.

    Args:
        inputs: By name of an input the ends that it is limited to, and the largest error of rounding.
        outputs: By name of an output its largest error.
    """

    inputs: Mapping[str, tuple[float, float, float]]
    outputs: Mapping[str, float]


@record(frozen=True)
class Chip:
    """The integers that controllers of a loop compute with.

    Args:
        form: The format, such as Q3.12.
        blocks: By name of a block.
        reason: Why a block has none, an empty text if all have.
    """

    form: str
    blocks: Mapping[str, Integers]
    reason: str = ""


def on_chip(equations: LoopEquations, blocks: Mapping[str, Integers]) -> LoopEquations:
    """Return a loop whose controllers are integers: they read rounded inputs, and others read outputs that are off.

    The state of a controller is that in double precision: the errors of outputs hold for all of its steps.

    Args:
        equations: The loop.
        blocks: By name of a block its integers.
    """
    inside: dict[str, dict[str, Expr]] = {}
    outside: dict[str, Expr] = {}
    further: dict[str, Equation] = {}
    errors = dict(equations.errors)
    for block, integers in blocks.items():
        for name, (low, high, error) in integers.inputs.items():
            signal = f"{block}.{name}"
            limited = Call("clip", (Name(signal), Number(low), Number(high)))
            further[signal] = Equation(f"{signal}#chip", limited + Name(f"{signal}#error"))
            inside.setdefault(block, {})[signal] = Name(f"{signal}#chip")
            errors[f"{signal}#error"] = error
        for name, error in integers.outputs.items():
            signal = f"{block}.{name}"
            further[signal] = Equation(f"{signal}#chip", Name(signal) + Name(f"{signal}#error"))
            outside[signal] = Name(f"{signal}#chip")
            errors[f"{signal}#error"] = error
    inputs = {f"{block}.{name}" for block, integers in blocks.items() for name in integers.inputs}

    def read(name: str, expr: Expr) -> Expr:
        """Return the right side of an equation of a name."""
        block = "" if name in inputs else name.partition(".")[0]
        return replace_names(expr, inside.get(block, outside))

    body: list[Equation | Evaluation] = []
    for item in equations.body:
        if isinstance(item, Evaluation):
            body.append(replace(item, arguments=tuple(read(item.names[0], a) for a in item.arguments)))
            continue
        body.append(replace(item, value=read(item.name, item.value)))
        body += [further[item.name]] if item.name in further else []
    return replace(
        equations,
        body=tuple(body),
        plant_states=tuple(replace(s, derivative=read("", s.derivative)) for s in equations.plant_states),
        updates=tuple(read(s.name, u) for s, u in zip(equations.states, equations.updates, strict=True)),
        signals={name: read("", value) for name, value in equations.signals.items()},
        delays=tuple(replace(d, signal=read("", d.signal)) for d in equations.delays),
        held=equations.held | {f"{s}#chip" for s in outside},
        errors=errors,
    )


def with_any_noise(equations: LoopEquations, deviations: float | None) -> LoopEquations:
    """Return a loop whose noise has any value up to some standard deviations at each sample; None for its seeds."""
    if deviations is None:
        return equations
    drawn = {names: noise for names, noise in equations.given.items() if isinstance(noise, Noise)}
    noise = {name: deviations * abs(noise.sigma) for names, noise in drawn.items() for name in names}
    rest = {names: column for names, column in equations.given.items() if names not in drawn}
    return replace(equations, given=rest, errors={**equations.errors, **noise})


def without_adaptation(equations: LoopEquations) -> LoopEquations:
    """Return a loop whose adaptive consequents are states of controllers, and whose adaptive systems have no state.

    An adaptive output is the sum of its consequents C_k times the shares ξ_k of their rules, and C_k moves by
    dt rate ξ_k within the range of the output. Systems that hold outputs, or read adaptive ones, are left as they are.
    """
    body: list[Equation | Evaluation] = []
    errors = dict(equations.errors)
    for item in equations.body:
        if not (isinstance(item, Evaluation) and item.states and _is_separable(item.system)):
            body.append(item)
            continue
        planned, system = plan(item.system), _with_shares(item.system)
        name = item.states[0]
        arguments = tuple(Name(f"{name}#{i.name}") for i in item.system.inputs)
        body += [Equation(a.name, value, item.span) for a, value in zip(arguments, item.arguments, strict=True)]
        names = [f"{name}#{o.name}" for o in system.outputs]
        value_of = dict(zip((o.name for o in system.outputs), map(Name, names), strict=True))
        body.append(Evaluation(system, arguments, tuple(names), item.span))
        inputs = dict(zip((i.name for i in item.system.inputs), arguments, strict=True))
        period = Number(equations.periods[name.partition(".")[0]])
        sums: dict[int, Expr] = {o: value_of[output.name] for o, output in enumerate(planned.outputs)}
        for (o, k), state, update in zip(planned.states, item.states, item.updates, strict=True):
            output, share = planned.outputs[o], value_of[_share(planned.outputs[o].name, k)]
            assert output.rate is not None
            sums[o] = sums[o] + share * Name(state)
            moved = Name(state) + period * replace_names(output.rate, inputs) * share
            body.append(Equation(update, Call("clip", (moved, Number(output.lower), Number(output.upper))), item.span))
        for o, (output, result) in enumerate(zip(planned.outputs, item.names, strict=True)):
            if output.rate is not None:  # the kernel divides a sum of products by a sum
                errors[f"{result}#error"] = 2.0**-50 * len(output.implied) * max(abs(output.lower), abs(output.upper))
                sums[o] = sums[o] + Name(f"{result}#error")
            body.append(Equation(result, sums[o], item.span))
    return replace(equations, body=tuple(body), errors=errors)


def _is_separable(system: FuzzySystem) -> bool:
    """Return whether the consequents of a system can be taken out of it."""
    planned, inputs = plan(system), {i.name for i in system.inputs}

    def is_usual(output: OutputPlan) -> bool:
        usual = (output.merge, output.total, output.fallback) == ("rules", "activations", "unfired")
        return output.rate is None or (usual and inputs.issuperset(n.name for n in names_in(output.rate)))

    alone = all(len({c.output for c in r.consequents}) == len(r.consequents) for r in system.rules)
    plain = alone and not any(c.hedges for r in system.rules for c in r.consequents)
    return plain and not (planned.held or any(o.reads for o in planned.outputs)) and all(map(is_usual, planned.outputs))


def _share(output: str, rule: int) -> str:
    return f"{output}[{rule + 1}]"


def _with_shares(system: FuzzySystem) -> FuzzySystem:
    """Return a system with an output for the share ξ_k of each rule in an adaptive one, which itself has its `else`.

    The consequents of a share are 1 for its rule and 0 for all others; ξ_k is 0 where no rule fires.
    """
    terms = tuple(Term(name=n, membership=Membership(kind="constant", arguments=(x,))) for n, x in _PARTS.items())
    adaptive = {o.name for o in system.outputs if o.adaptive is not None}
    outputs: list[Output] = []
    for output in system.outputs:
        if output.name not in adaptive:
            outputs.append(output)
            continue
        fixed = replace(output, adaptive=None, terms=terms)
        outputs.append(fixed)
        otherwise = output.otherwise if output.otherwise in (None, "nan", "error") else ZERO
        for k in range(len(system.conclusions[output.name])):
            outputs.append(replace(fixed, name=_share(output.name, k), lower=ZERO, upper=ONE, otherwise=otherwise))
    rules: list[Rule] = []
    for r, rule in enumerate(system.rules):
        consequents = [c for c in rule.consequents if c.output not in adaptive]
        for name in sorted(adaptive & {c.output for c in rule.consequents}):
            consequents.append(Consequent(output=name, term="zero"))
            for k, (of, _) in enumerate(system.conclusions[name]):
                consequents.append(Consequent(output=_share(name, k), term="one" if of == r else "zero"))
        rules.append(replace(rule, consequents=tuple(consequents)))
    return replace(system.with_rules(rules), outputs=tuple(outputs), guarantees=())


#: Terms of shares.
_PARTS: Final = {"zero": ZERO, "one": ONE}


def needs(body: Sequence[Equation | Evaluation], values: Sequence[Expr], names: Set[str]) -> bool:
    """Return whether some values need one of some names, themselves or through equations."""
    makers = {n: i for i in body for n in (i.defined if isinstance(i, Evaluation) else (i.name,))}
    seen: set[str] = set()
    stack = list(values)
    while stack:
        names_read = {n.name for n in names_in(stack.pop())} - seen
        if names_read & names:
            return True
        seen |= names_read
        for item in (makers[n] for n in names_read if n in makers):
            stack += item.arguments if isinstance(item, Evaluation) else (item.value,)
    return False


def reached(equations: LoopEquations, values: Sequence[Expr]) -> tuple[list[Equation | Evaluation], list[str]]:
    """Return the equations that some values need between two samples, and the held names that these read."""
    makers: dict[str, Equation | Evaluation] = {}
    for item in equations.body:
        makers |= dict.fromkeys(item.defined if isinstance(item, Evaluation) else (item.name,), item)
    needed: set[int] = set()
    held_names: dict[str, None] = {}
    stack = list(values)
    while stack:
        for name in names_in(stack.pop()):
            if name.name in equations.held:
                held_names[name.name] = None
                continue
            maker = makers.get(name.name)
            if maker is not None and id(maker) not in needed:
                needed.add(id(maker))
                stack += maker.arguments if isinstance(maker, Evaluation) else (maker.value,)
    return [item for item in equations.body if id(item) in needed], list(held_names)
