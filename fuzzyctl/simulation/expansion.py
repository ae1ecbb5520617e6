"""From a loop to ordered equations: blocks expanded, dead times, signals over time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.expr import Call, Compare, Expr, Name, Number, Where, names_in, span_of
from fuzzyctl.kernels.plan.equations import DT, Equation, ordered
from fuzzyctl.kernels.plan.expansion import Expansion, Scope, lines_of, split
from fuzzyctl.kernels.program.builder import any_nan
from fuzzyctl.kernels.program.program import NAN
from fuzzyctl.model.block import Bounds
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import SIGNALS, TIME, Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.equations import DeadTime, External, LoopEquations, PlantState, block_signals, needs
from fuzzyctl.simulation.loop_params import starts_of, timing_params
from fuzzyctl.simulation.sample_times import require_room, sample_times, samples_at
from fuzzyctl.simulation.signals import Given, Signals, with_streams


def loop_equations(loop: Loop, extra: Sequence[Expr] = (), free: Sequence[str] = ()) -> LoopEquations:
    """Expand a well-formed loop.

    Args:
        loop: The loop.
        extra: Further expressions to record, as `#0`, `#1` and so on.
        free: Params and disturbances whose values are arguments of a run; starts of states are arguments anyway.

    Raises:
        DiagnosticError: For an algebraic loop, sample times that do not fit together, and a run of too many numbers.
        ArgumentError: For a free param that something needs as a constant, such as the start of a state.
    """
    fixed = timing_params(loop).intersection(free)
    if fixed:
        raise ArgumentError(f"'{min(fixed)}' cannot be free: the sample times or the duration depend on it")
    loop = with_streams(loop)
    free = [name for name in free if name not in starts_of(loop)]
    step, every = sample_times(loop)
    samples = samples_at(loop, step)
    expansion = _LoopExpansion(loop, step, every, free)
    scope = Scope(_as_controller(loop), "", {TIME: Name(TIME)}, step)
    expansion.enter(scope)
    disturbances = expansion.disturbances(loop, scope)
    signals = dict(_recorded(loop))
    scope.names |= {name: Name(name) for name in signals if name not in scope.names}
    signals |= {f"#{k}": expansion.expanded(e, scope) for k, e in enumerate(extra)}
    require_room(loop, len(signals))
    plants = {i.name for i in loop.instances if i.controller in {p.name for p in loop.plants}}
    memory = [s for s in expansion.states if s.name.partition(".")[0] not in plants]
    return LoopEquations(
        body=ordered(expansion.body),
        plant_states=tuple(expansion.plant_states()),
        states=tuple(memory),
        updates=tuple(expansion.update(s.name) for s in memory),
        held=frozenset(expansion.held),
        delays=tuple(expansion.delays),
        given=expansion.given,
        rates={_flag(n): n for n in set(every.values()) if n > 1},
        signals=signals,
        step=step,
        samples=samples,
        periods={name: n * step for name, n in every.items()},
        free=tuple(free),
        externals=tuple(_externals(loop, tuple(expansion.states_of_plants))),
        disturbances=disturbances,
    )


def _externals(loop: Loop, states: tuple[str, ...]) -> Iterator[External]:
    plants = {p.name: p for p in loop.plants if p.external}
    for i in loop.instances:
        plant = plants.get(i.controller)
        if plant is not None:
            inputs, outputs = (
                tuple(f"{i.name}.{s.name}" for s in signals) for signals in (plant.inputs, plant.results)
            )
            positions = tuple(states.index(f"{i.name}.{s.name}") for s in plant.states)
            yield External(plant, i.name, inputs, positions, outputs, i.span)


def _as_controller(block: Loop | Plant) -> Controller:
    """Return a plant or a loop as a controller: derivatives in place of next values."""
    shared = {n: getattr(block, n) for n in ("name", "params", "functions", "systems", "path", "span")}
    shared["definitions"] = block.definitions if isinstance(block, Plant) else block.signals
    if isinstance(block, Plant):
        return Controller(**shared, inputs=block.inputs, states=block.states, results=block.results,
                          updates=block.derivatives)  # fmt: skip
    plants = tuple(map(_as_controller, block.plants))
    return Controller(**shared, instances=block.instances, controllers=(*block.controllers, *plants))


def _recorded(loop: Loop) -> Iterator[tuple[str, Expr]]:
    """Yield the recorded signals by name: lets and disturbances, and inputs, states and outputs of the blocks."""
    for item in loop.signals:
        yield item.name, Name(item.name)
    for name, signal_ in block_signals(loop):
        yield f"{name}.{signal_.name}", Name(f"{name}.{signal_.name}")


def free_name(param: str) -> str:
    """Return the name of the value of a free param."""
    return f"#free.{param}"


def _runs(every: int) -> Expr:
    """Return whether a controller runs at a sample."""
    return Compare("==", Name(_flag(every)), Number(1.0))


def _flag(every: int) -> str:
    return f"#every.{every}"


class _LoopExpansion(Expansion):
    """Collects the equations of a loop; plants are expanded as controllers whose next values are derivatives."""

    def __init__(self, loop: Loop, step: float, every: Mapping[str, int], free: Sequence[str]) -> None:
        super().__init__()
        self.step, self.every, self.free_params = step, every, set(free)
        self.plants = {i.name for i in loop.instances if i.name not in every}
        self.held: set[str] = set()
        self.delays: list[DeadTime] = []
        self.given: dict[tuple[str, ...], Given] = {}
        self.states_of_plants: dict[str, PlantState] = {}
        self._delayed: dict[Expr, Name] = {}
        #: Whether a controller lacks an input, by name of its block.
        self._lacks: dict[str, Expr] = {}
        self._signals: dict[Expr, Expr] = {}

    def enter(self, scope: Scope) -> None:
        """Take the equations of a block whose inputs and params are known."""
        block, _, inner = scope.prefix.partition(".")
        if not inner:
            self._free_params(scope)
        if not block or inner:
            super().enter(scope)
            return
        if block in self.plants:
            scope.names.setdefault(TIME, Name(TIME))
        else:
            scope.period = self.every[block] * self.step
            scope.names[DT] = Number(scope.period)
        if block in self.plants:
            for state in scope.controller.states:
                name = f"{block}.{state.name}"
                ends = _ends(scope, state.bounds)
                start = scope.constant(state.start)
                self.states_of_plants[name] = PlantState(
                    name, start, Name(name), *ends, unit=state.unit, span=state.span
                )
        begin = len(self.body)
        super().enter(scope)
        if block in self.plants:
            outputs = {f"{scope.prefix}{r.name}" for r in scope.controller.results}
            # The value of an output of a plant in Python is its name.
            self.body[begin:] = [
                i
                for i in self.body[begin:]
                if not (isinstance(i, Equation) and i.name in outputs and i.value == Name(i.name))
            ]
            return
        if scope.controller.period is not None:
            scope.constant(scope.controller.period)
        inputs = [Name(f"{block}.{i.name}") for i in scope.controller.inputs]
        self._lacks |= {block: any_nan(inputs)} if inputs else {}
        for result in scope.controller.results:
            self.held.add(f"{block}.{result.name}")
            self._hold(f"{block}.{result.name}", block)

    def disturbances(self, loop: Loop, scope: Scope) -> dict[str, tuple[float, float, float]]:
        """Give disturbances their nominal values, or names if these are free, and return their ranges and values."""
        ranges = {}
        for d in loop.disturbances:
            low, high, nominal = (scope.constant(e) for e in (d.bounds.lower, d.bounds.upper, d.nominal))
            ranges[d.name] = low, high, nominal
            at = next(k for k, item in enumerate(self.body) if isinstance(item, Equation) and item.name == d.name)
            value = Name(free_name(d.name)) if d.name in self.free_params else Number(nominal)
            self.body[at] = Equation(d.name, value, d.span)
        return ranges

    def _free_params(self, scope: Scope) -> None:
        """Put names in the place of the values of free params, and of those that depend on them."""
        names = [p.name for p in scope.controller.params if scope.prefix + p.name in self.free_params]
        changed: dict[str, Expr] = {name: Name(free_name(scope.prefix + name)) for name in names}
        scope.names |= changed
        scope.symbolic |= changed
        scope.written = {**scope.written, **lines_of(scope.controller, changed)}
        self._enter_params(scope)

    def start(self, expr: Expr, scope: Scope) -> float:
        """Return a state before the run, which no free param may change."""
        return scope.constant(expr)

    def _hold(self, name: str, block: str) -> None:
        """Make an output NaN if an input is, and keep that of a controller that does not run at each sample."""
        at = next(k for k, item in enumerate(self.body) if isinstance(item, Equation) and item.name == name)
        item = self.body[at]
        assert isinstance(item, Equation)
        fresh = f"{name}#new"
        reads = block in self._lacks and needs(self.body, [item.value], {n.name for n in names_in(self._lacks[block])})
        value = Where(self._lacks[block], NAN, Name(fresh)) if reads else Name(fresh)
        self.body[at] = Equation(fresh, item.value, item.span)
        if self.every[block] > 1:
            value = Where(_runs(self.every[block]), value, self.keep(f"{name}#kept", 0.0, Name(name)))
        self.body.append(Equation(name, value, item.span))

    def update(self, name: str) -> Expr:
        """Return the next value of a state; that of a controller that does not run, or lacks an input, stays."""
        block, value = name.partition(".")[0], self.updates[name]
        if name.endswith("#kept"):
            return value
        if block in self._lacks:
            value = Where(self._lacks[block], Name(name), value)
        return Where(_runs(self.every[block]), value, Name(name)) if self.every.get(block, 1) > 1 else value

    def plant_states(self) -> Iterator[PlantState]:
        """Yield the states that are integrated, with their derivatives."""
        for name, state in self.states_of_plants.items():
            value = self.updates.get(name, state.derivative)
            yield PlantState(name, state.start, value, state.low, state.high, state.without_low, state.without_high,
                             state.unit, state.span)  # fmt: skip

    def _expanded(self, expr: Expr, scope: Scope) -> Expr:
        if isinstance(expr, Call) and self._is_continuous(scope):
            if expr.function == "delay":
                return self._dead_time(expr, scope)
            if expr.function in SIGNALS and expr.function not in scope.functions:
                return self._signal(expr, scope)
        return super()._expanded(expr, scope)

    def _is_continuous(self, scope: Scope) -> bool:
        return not scope.prefix or scope.prefix.partition(".")[0] in self.plants

    def _dead_time(self, call: Call, scope: Scope) -> Expr:
        positional, named = split(call.arguments)
        settings = dict(zip(("time", "start"), positional[1:], strict=False)) | named
        time = scope.constant(settings["time"])
        start = scope.constant(settings["start"]) if "start" in settings else 0.0
        if not (time >= 0.0 and math.isfinite(time)):
            message = f"a dead time of {time:g} s: expected a time that is not negative"
            raise DiagnosticError([Diagnostic("FZ302", message, span_of(settings["time"]))])
        if time == 0.0:
            return self.expanded(positional[0], scope)
        key = Call("delay", (Name(scope.prefix), *call.arguments))
        if key not in self._delayed:
            value = self.named(self.expanded(positional[0], scope), f"{scope.prefix}delay")
            name = self.fresh(f"{scope.prefix}delayed")
            self.delays.append(DeadTime(name, value, time, start, call.span))
            self._delayed[key] = Name(name)
        return self._delayed[key]

    def _signal(self, call: Call, scope: Scope) -> Expr:
        if call not in self._signals:
            writer = Signals(self.step, scope.constant, self._columns)
            self._signals[call] = self.named(writer.expression(call), call.function)
        return self._signals[call]

    def _columns(self, given: Given, count: int) -> tuple[Name, ...]:
        names = tuple(self.fresh("given") for _ in range(count))
        self.given[names] = given
        self.held.update(names)
        return tuple(map(Name, names))


def _ends(scope: Scope, bounds: Bounds | None) -> tuple[float, float, bool, bool]:
    if bounds is None:
        return -math.inf, math.inf, False, False
    return scope.constant(bounds.lower), scope.constant(bounds.upper), bounds.without_lower, bounds.without_upper
