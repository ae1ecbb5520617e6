"""From a controller to ordered equations: functions, operators with state, instances and calls of systems expanded."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import (
    CONSTANTS,
    ONE,
    ZERO,
    Call,
    Compare,
    Expr,
    Keyword,
    Logic,
    Name,
    Number,
    Where,
    children,
    evaluate,
    names_in,
    rebuilt,
    span_of,
)
from fuzzyctl.kernels.plan.build import OutputPlan, plan
from fuzzyctl.kernels.plan.equations import DT, Equation, Equations, Evaluation, KeptState, ordered
from fuzzyctl.kernels.plan.free import FreeNumber, free_names
from fuzzyctl.model.block import Bounds, Param
from fuzzyctl.model.checks.checks import unused_params
from fuzzyctl.model.controller import Controller, Definition, Function, Result
from fuzzyctl.model.shared_params import with_shared
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import dataclass, record

#: Most parts of expressions that a controller expands to, and their deepest nesting.
MOST_PARTS: Final = 50_000
DEEPEST: Final = 200
#: Most levels of controllers inside controllers.
DEEPEST_INSTANCES: Final = 20
#: Most levels of named conditions inside each other that are written out in a choice.
DEEPEST_CONDITIONS: Final = 8
#: Name of the state that says whether a step was made.
STARTED: Final = "#started"
#: Most steps that `delay` keeps, and that all delays of a controller do.
MOST_SAMPLES: Final = 10_000
MOST_DELAYED: Final = 100_000


def equations_of(controller: Controller, free: Sequence[str] = ()) -> Equations:
    """Expand a well-formed controller.

    Args:
        controller: The controller.
        free: Names of numbers that are states: its params, and numbers of the systems that it calls, as `SYSTEM.NAME`.

    Raises:
        DiagnosticError: For an algebraic loop, with the names that form it.
        UnknownNameError: For a free number that it does not have.
        ArgumentError: For a free number that must be known before the program is written.
    """
    expansion = Expansion()
    names, numbers = free_names(controller, free)
    expansion.free = {n: FreeNumber(*n.split(".", 1)) for n in names if n not in controller.param_values.values}
    period = None if controller.period is None else evaluate(controller.period, controller.param_values.values)
    symbolic: dict[str, Expr] = {n: Name(n) for n in names if n not in expansion.free}
    scope = Scope(controller, "", {s.name: Name(s.name) for s in controller.inputs}, period, symbolic)
    scope.written = lines_of(controller, symbolic)
    expansion.enter(scope)
    for name, number in zip(names, numbers, strict=True):
        expansion.keep(name, number, Name(name))
    outputs = tuple((r.name, scope.names[r.name]) for r in controller.results)
    return Equations(
        inputs=tuple(s.name for s in controller.inputs),
        states=tuple(expansion.states),
        body=ordered(expansion.body),
        outputs=outputs,
        updates=tuple(expansion.updates[s.name] for s in expansion.states),
        period=period,
        parts=expansion.parts,
        free=names,
        starts_vary=expansion.starts_vary,
    )


def _defined(controller: Controller) -> tuple[Definition | Result, ...]:
    return (*controller.definitions, *controller.results)


@dataclass
class Scope:
    """Meanings of the names of one controller."""

    controller: Controller
    prefix: str
    names: dict[str, Expr]
    period: float | None
    #: Params that are not numbers, since they are free or depend on free ones.
    symbolic: dict[str, Expr] = field(default_factory=dict)
    #: Those of them by the line that declares them: a line before the first block declares a param of all blocks.
    written: Mapping[Span, Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        controller = self.controller
        values = controller.param_values.values
        self.names |= {name: value for name, value in self.symbolic.items() if name not in self.names}
        self.names |= {name: Number(value) for name, value in values.items() if name not in self.names}
        names = [s.name for s in controller.states] + [d.name for d in _defined(controller)]
        self.names |= {name: Name(self.prefix + name) for name in names}
        self.names[DT] = Name(DT) if self.period is None else Number(self.period)
        self.functions = {f.name: f for f in controller.functions}
        self.systems = {s.name: s for s in controller.systems}
        self.conditions = controller.conditions
        self.names |= {name: Name(self.prefix + name) for name in self._members()}

    def _members(self) -> Iterator[str]:
        """Yield the names of the outputs of instances, and of systems with several outputs."""
        controllers = {c.name: c for c in self.controller.controllers}
        for instance in self.controller.instances:
            yield from (f"{instance.name}.{r.name}" for r in controllers[instance.controller].results)
        for item in _defined(self.controller):
            called = self.systems.get(item.value.function) if isinstance(item.value, Call) else None
            if called is not None and len(called.outputs) > 1:
                yield from (f"{item.name}.{o.name}" for o in called.outputs)

    def constant(self, expr: Expr) -> float:
        """Compute an expression over params, none of them free."""
        free = self.free_in(expr)
        if free:
            span = span_of(expr)
            at = "" if span is None else f" at {span}"
            raise ArgumentError(f"'{free[0]}' cannot be free: a constant depends on it{at}")
        values = {n.name: self.names.get(n.name) for n in names_in(expr)}
        return evaluate(expr, {n: e.value for n, e in values.items() if isinstance(e, Number)})

    def free_in(self, expr: Expr) -> list[str]:
        """Return the params in an expression that depend on free numbers."""
        return [n.name for n in names_in(expr) if n.name in self.symbolic] if self.symbolic else []

    def computed(self, bounds: Bounds | None) -> Bounds | None:
        """Return a range with numbers as ends; None for one that depends on free params."""
        if bounds is None or not all(
            n.name in CONSTANTS or isinstance(self.names.get(n.name), Number)
            for e in (bounds.lower, bounds.upper)
            for n in names_in(e)
        ):
            return None
        lower, upper = (Number(self.constant(e)) for e in (bounds.lower, bounds.upper))
        return dataclasses.replace(bounds, lower=lower, upper=upper)


@dataclass
class Expansion:
    """Collects the equations of a controller and of its instances."""

    states: list[KeptState] = field(default_factory=list)
    body: list[Equation | Evaluation] = field(default_factory=list)
    updates: dict[str, Expr] = field(default_factory=dict)
    _calls: dict[tuple[object, ...], tuple[str, ...]] = field(default_factory=dict)
    _operators: dict[tuple[str, tuple[Expr, ...], str], Expr] = field(default_factory=dict)
    _count: int = 0
    parts: int = 0
    #: Samples that all delays keep.
    delayed: int = 0
    _depth: int = 0
    #: Free numbers of systems by the names of their states.
    free: dict[str, FreeNumber] = field(default_factory=dict)
    #: Whether states before the first step depend on free numbers.
    starts_vary: bool = False
    #: The functions that are being expanded.
    _functions: list[str] = field(default_factory=list)

    def enter(self, scope: Scope) -> None:
        """Take the equations of a controller whose inputs and params are known."""
        controller = scope.controller
        if scope.prefix.count(".") > DEEPEST_INSTANCES:
            message = f"controllers lie more than {DEEPEST_INSTANCES} levels inside each other"
            raise DiagnosticError([Diagnostic("FZ106", message, controller.span)])
        self._enter_params(scope)
        for state in controller.states:
            name = scope.prefix + state.name
            start = self.start(state.start, scope)
            self.states.append(KeptState(name, start, scope.computed(state.bounds), state.span))
        for instance in controller.instances:
            self._enter_instance(scope, instance.name, instance.controller, instance.arguments)
        for item in _defined(controller):
            name = scope.prefix + item.name
            value = self._several(scope, item.name, item.value)
            if value is not None:
                self.body.append(Equation(name, value, item.span))
        for update in controller.updates:
            self.updates[scope.prefix + update.name] = self.expanded(update.value, scope)

    def _enter_params(self, scope: Scope) -> None:
        """Take the params that are computed from free ones, each after those that it reads."""
        expressions = {p.name: p.expression for p in scope.controller.params}
        for param in scope.controller.param_values.values if scope.symbolic else ():
            if param not in scope.symbolic and scope.free_in(expressions[param]):
                name = f"{scope.prefix}{param}"
                self.body.append(Equation(name, self.expanded(expressions[param], scope), span_of(expressions[param])))
                scope.symbolic[param] = scope.names[param] = Name(name)

    def start(self, expr: Expr, scope: Scope) -> float:
        """Return the present value of a state before the first step."""
        self.starts_vary = self.starts_vary or bool(scope.free_in(expr))
        return evaluate(expr, scope.controller.param_values.values)

    def _enter_instance(self, scope: Scope, name: str, of: str, arguments: tuple[Expr, ...]) -> None:
        inner = next(c for c in scope.controller.controllers if c.name == of)
        inputs = [s.name for s in inner.inputs]
        positional, named = split(arguments)
        bound = dict(zip(inputs, positional, strict=False)) | {n: v for n, v in named.items() if n in inputs}
        params, symbolic = self._split_params({n: v for n, v in named.items() if n not in inputs}, scope)
        symbolic |= _written(inner.params, named, scope)
        names: dict[str, Expr] = {}
        for key, value in symbolic.items():
            prefixed = f"{scope.prefix}{name}.{key}"
            if value != Name(prefixed):  # a free number of the instance itself, under its own name
                self.body.append(Equation(prefixed, value))
            symbolic[key] = Name(prefixed)
        for key, value in bound.items():
            prefixed = f"{scope.prefix}{name}.{key}"
            self.body.append(Equation(prefixed, self.expanded(value, scope), span_of(value)))
            names[key] = Name(prefixed)
        spans = {p.span for p in inner.params if p.name in named}
        written = {line: v for line, v in scope.written.items() if line not in spans} | lines_of(inner, symbolic)
        changed = with_shared(with_values(inner, params), params)
        self.enter(Scope(changed, f"{scope.prefix}{name}.", names, scope.period, symbolic, written))

    def _several(self, scope: Scope, name: str, value: Expr) -> Expr | None:
        """Return the value of a definition; None for a call of a system with several outputs."""
        if isinstance(value, Call) and value.function in scope.systems:
            names = self._evaluation(value, scope, name)
            outputs = scope.systems[value.function].outputs
            if len(outputs) > 1:
                for o, n in zip(outputs, names, strict=True):
                    self.body.append(Equation(f"{scope.prefix}{name}.{o.name}", Name(n), value.span))
                return None
            return Name(names[0])
        return self.expanded(value, scope)

    def expanded(self, expr: Expr, scope: Scope) -> Expr:
        """Return an expression over names of equations, states and inputs.

        Raises:
            DiagnosticError: For an expansion that is too large, too deep or without end.
        """
        self.parts += 1
        if self.parts > MOST_PARTS:
            message = f"the block expands to more than {MOST_PARTS:,} parts of expressions"
            help_text = "give values that are used several times a name with 'let'"
            raise DiagnosticError([Diagnostic("FZ112", message, span_of(expr), help=help_text)])
        if self._depth > DEEPEST:
            message = f"the expression nests deeper than {DEEPEST} levels where its functions are expanded"
            help_text = "split it: give parts a name with 'let'"
            raise DiagnosticError([Diagnostic("FZ106", message, span_of(expr), help=help_text)])
        self._depth += 1
        try:
            return self._expanded(expr, scope)
        finally:
            self._depth -= 1

    def _expanded(self, expr: Expr, scope: Scope) -> Expr:
        match expr:
            case Number():
                return expr
            case Name(name=name):
                return Number(CONSTANTS[name]) if name in CONSTANTS else scope.names[name]
            case Call(function=function) if function in OPERATORS:
                return self._operator(expr, scope)
            case Call(function=function, arguments=arguments) if function in scope.functions:
                value = self._applied(scope.functions[function], arguments, scope, expr.span)
                return Where(value, ONE, ZERO) if isinstance(value, Compare | Logic) else value
            case Call(function=function) if function in scope.systems:
                return Name(self._evaluation(expr, scope)[0])
            case Call(function="where", arguments=(condition, then, otherwise)):
                choices = (self.expanded(e, scope) for e in (then, otherwise))
                return Where(self.condition(condition, scope), *choices)
            case Logic(op=op, operands=operands, span=span):
                return Logic(op, tuple(self.condition(o, scope) for o in operands), span)
            case Call(function="clamp", arguments=arguments):
                x, low, high = (self.expanded(a, scope) for a in arguments)
                return Call("min", (Call("max", (x, low)), high))
        return rebuilt(expr, [self.expanded(e, scope) for e in children(expr)])

    def condition(self, expr: Expr, scope: Scope, levels: int = DEEPEST_CONDITIONS) -> Expr:
        """Return a condition, those that it names written out; a value of 1 or 0 holds if it is above 0."""
        match expr:
            case Logic(op=op, operands=operands, span=span):
                return Logic(op, tuple(self.condition(o, scope, levels) for o in operands), span)
            case Name(name=name) if levels and name in scope.conditions:
                return self.condition(scope.conditions[name], scope, levels - 1)
        match self.expanded(expr, scope):
            case Compare() as compare:
                return compare
            case Where(condition=condition, then=Number(value=1.0), otherwise=Number(value=0.0)):
                return condition
            case value:
                return Compare(">", value, ZERO)

    def _applied(self, function: Function, arguments: tuple[Expr, ...], scope: Scope, span: Span | None) -> Expr:
        if function.name in self._functions:
            circle = " → ".join([*self._functions[self._functions.index(function.name) :], function.name])
            message = f"function '{function.name}' calls itself"
            raise DiagnosticError(
                [Diagnostic("FZ217", message, function.span, facts=(circle,), help="remove one of these calls")]
            )
        values = [self.named(self.expanded(a, scope), function.name) for a in arguments]
        inner = Scope(scope.controller, scope.prefix, {}, scope.period, scope.symbolic, scope.written)
        inner.names |= dict(zip(function.parameters, values, strict=True))
        inner.conditions = {}
        self._functions.append(function.name)
        value = self.expanded(function.expression, inner)
        self._functions.pop()
        return value

    def _evaluation(self, call: Call, scope: Scope, name: str = "") -> tuple[str, ...]:
        """Return the names of the outputs of a system for some arguments.

        Its states are called after the definition of that name, or after the system where it has none.
        """
        system = scope.systems[call.function]
        inputs = [i.name for i in system.inputs]
        positional, named = split(call.arguments)
        bound = dict(zip(inputs, positional, strict=False)) | {n: v for n, v in named.items() if n in inputs}
        params, symbolic = self._split_params({n: v for n, v in named.items() if n not in inputs}, scope)
        system = _changed(system, params)
        arguments = tuple(self.expanded(bound[i], scope) for i in inputs)
        for state, number in self.free.items():
            if number.system == call.function:
                if number.name in params:
                    raise ArgumentError(f"'{state}' cannot be free: a call of the system sets it")
                symbolic[number.name] = Name(state)
        shared = _written(system.params, {**named, **symbolic}, scope)
        if shared:
            symbolic |= {p.name: shared[p.name] for p in _read_params(system) if p.name in shared}
        free = tuple(symbolic.items())
        key = (system, arguments, free)
        if key not in self._calls:
            start = self.fresh(scope.prefix + call.function)
            self._calls[key] = tuple(f"{start}.{o.name}" for o in system.outputs)
            states = self._states_of(system, scope.prefix + name if name else start, call.span)
            if states and free:
                raise ArgumentError(f"'{call.function}.{free[0][0]}' cannot be free: the system has a state")
            updates = tuple(f"{start}.next.{k}" for k in range(len(states)))
            self.updates |= {s.name: Name(u) for s, u in zip(states, updates, strict=True)}
            self.states += states
            state_names = tuple(s.name for s in states)
            self.body.append(Evaluation(system, arguments, self._calls[key], call.span, state_names, updates, free))
        return self._calls[key]

    def _states_of(self, system: FuzzySystem, name: str, span: Span | None) -> list[KeptState]:
        """Return the states of an evaluation: one for each rule of an adaptive output, and the outputs that hold."""
        planned = plan(system)
        names = [f"{name}.{planned.outputs[o].name}[{k + 1}]" for o, k in planned.states]
        ranges: list[Bounds | None] = [_range_of(planned.outputs[o]) for o, _ in planned.states]
        names += [f"{name}.{planned.outputs[o].name}" for o in planned.held]
        ranges += [None] * len(planned.held)
        return [KeptState(*one, span) for one in zip(names, planned.initial_state, ranges, strict=True)]

    def _split_params(self, changes: Mapping[str, Expr], scope: Scope) -> tuple[dict[str, float], dict[str, Expr]]:
        """Return the present values of params that a call sets, and expressions for those that depend on free ones."""
        symbolic = {n: self.expanded(v, scope) for n, v in changes.items() if scope.free_in(v)}
        values = scope.controller.param_values.values
        return {n: evaluate(v, values) if n in symbolic else scope.constant(v) for n, v in changes.items()}, symbolic

    def _operator(self, call: Call, scope: Scope) -> Expr:
        positional, named = split(call.arguments)
        x, *rest = positional
        settings = dict(zip(OPERATORS[call.function].settings, rest, strict=False)) | named
        key = (call.function, call.arguments, scope.prefix)
        if key not in self._operators:
            use = _Use(self, scope, self.fresh(scope.prefix + call.function), settings, call)
            self._operators[key] = _EXPANSIONS[call.function](use, x)
        return self._operators[key]

    def named(self, value: Expr, hint: str) -> Expr:
        """Return a name for a value, or the value itself where it is one."""
        if isinstance(value, Name | Number):
            return value
        name = self.fresh(hint)
        self.body.append(Equation(name, value, span_of(value)))
        return Name(name)

    def fresh(self, hint: str) -> str:
        """Return a name that no controller can declare."""
        self._count += 1
        return f"{hint}#{self._count}"

    def keep(self, name: str, start: float, update: Expr, span: Span | None = None) -> Name:
        """Add a state and return its value before the step."""
        self.states.append(KeptState(name, start, span=span))
        self.updates[name] = update
        return Name(name)


@record(frozen=True)
class _Use:
    """One use of an operator with state."""

    expansion: Expansion
    scope: Scope
    name: str
    settings: Mapping[str, Expr]
    call: Call

    @property
    def dt(self) -> Expr:
        return self.scope.names[DT]

    @property
    def is_first(self) -> Expr:
        """Whether this is the first step."""
        if STARTED not in self.expansion.updates:
            self.expansion.keep(STARTED, 0.0, ONE, self.call.span)
        return Compare("==", Name(STARTED), ZERO)

    def constant(self, setting: str) -> float:
        return self.scope.constant(self.settings[setting])

    def start(self) -> float:
        return self.expansion.start(self.settings["start"], self.scope) if "start" in self.settings else 0.0

    def value(self, expr: Expr) -> Expr:
        return self.expansion.expanded(expr, self.scope)

    def atom(self, expr: Expr) -> Expr:
        return self.expansion.named(self.value(expr), self.name)

    def keep(self, suffix: str, start: float, update: Expr) -> Name:
        return self.expansion.keep(f"{self.name}{suffix}", start, update, self.call.span)

    def result(self, value: Expr) -> Expr:
        return self.expansion.named(value, self.name)


def _previous(use: _Use, x: Expr) -> Expr:
    return use.keep("", use.start(), use.value(x))


def _difference(use: _Use, x: Expr) -> Expr:
    value = use.atom(x)
    before = use.keep("", 0.0, value)
    return use.result(Where(use.is_first, ZERO, value - before))


def _derivative(use: _Use, x: Expr) -> Expr:
    difference = _difference(use, x)
    if "filter" not in use.settings:
        return use.result(difference / use.dt)
    lag = use.value(use.settings["filter"])
    name = f"{use.name}.filtered"
    value = use.result((lag * Name(name) + difference) / (lag + use.dt))
    use.expansion.keep(name, 0.0, value, use.call.span)
    return value


def _integral(use: _Use, x: Expr) -> Expr:
    name, value = f"{use.name}.sum", use.value(x)
    moved: Expr = Name(name) + use.dt * value
    if "hold" in use.settings:
        moved = Where(use.expansion.condition(use.settings["hold"], use.scope), Name(name), moved)
    return use.expansion.keep(name, use.start(), moved, use.call.span)


def _lowpass(use: _Use, x: Expr) -> Expr:
    value, lag = use.atom(x), use.value(use.settings["time"])
    name = f"{use.name}.filtered"
    moved = Name(name) + use.dt / (lag + use.dt) * (value - Name(name))
    result = use.result(Where(use.is_first, value, moved))
    use.expansion.keep(name, 0.0, result, use.call.span)
    return result


def _rate_limit(use: _Use, x: Expr) -> Expr:
    value = use.atom(x)
    most = use.expansion.named(use.value(use.settings["rate"]) * use.dt, use.name)
    name = f"{use.name}.limited"
    limited = Call("min", (Call("max", (value, Name(name) - most)), Name(name) + most))
    result = use.result(Where(use.is_first, value, limited))
    use.expansion.keep(name, 0.0, result, use.call.span)
    return result


def _hysteresis(use: _Use, x: Expr) -> Expr:
    value = use.atom(x)
    low, high = (use.value(use.settings[s]) for s in ("low", "high"))
    name = f"{use.name}.on"
    on = Where(Compare(">=", value, high), ONE, Where(Compare("<=", value, low), ZERO, Name(name)))
    result = use.result(on)
    use.expansion.keep(name, use.start(), result, use.call.span)
    return result


def _delay(use: _Use, x: Expr) -> Expr:
    samples, start = use.constant("samples"), use.start()
    if not (1 <= samples <= MOST_SAMPLES and samples == int(samples)):
        message = f"a delay of {samples:g} samples: expected a whole number from 1 to {MOST_SAMPLES:,}"
        help_text = "write the number of steps, the time over the sample time; without a delay write the value itself"
        raise DiagnosticError([Diagnostic("FZ302", message, span_of(use.settings["samples"]), help=help_text)])
    use.expansion.delayed += int(samples)
    if use.expansion.delayed > MOST_DELAYED:
        message = f"the delays of the controller keep more than {MOST_DELAYED:,} samples"
        raise DiagnosticError(
            [Diagnostic("FZ112", message, use.call.span, help="delay fewer values, or sample slower")]
        )
    value = use.value(x)
    for k in range(int(samples)):
        value = use.keep(f".{k}", start, value)
    return value


#: Writers of the equations of each operator.
_EXPANSIONS: Final[dict[str, Callable[[_Use, Expr], Expr]]] = {
    "previous": _previous,
    "difference": _difference,
    "derivative": _derivative,
    "integral": _integral,
    "lowpass": _lowpass,
    "rate_limit": _rate_limit,
    "hysteresis": _hysteresis,
    "delay": _delay,
}


def _written(params: Iterable[Param], changes: Mapping[str, Expr], scope: Scope) -> dict[str, Expr]:
    """Return the params that are written once for all blocks and free, but for those that are given."""
    texts = {p.name: scope.written[p.span] for p in params if p.span is not None and p.span in scope.written}
    return {name: value for name, value in texts.items() if name not in changes}


def lines_of(controller: Controller, values: Mapping[str, Expr]) -> dict[Span, Expr]:
    """Return values of params by the line that declares them."""
    return {p.span: values[p.name] for p in controller.params if p.name in values and p.span is not None}


def with_values(controller: Controller, values: Mapping[str, float]) -> Controller:
    """Return a controller with some params set to numbers."""
    params = tuple(
        dataclasses.replace(p, expression=Number(values[p.name])) if p.name in values else p for p in controller.params
    )
    return dataclasses.replace(controller, params=params)


def _changed(system: FuzzySystem, params: Mapping[str, float]) -> FuzzySystem:
    """Return a system with some params set; the same one, with all that it has kept, where they are so already."""
    numbers = {p.name: str(p.expression.value) for p in system.params if isinstance(p.expression, Number)}
    if all(numbers.get(name) == str(value) for name, value in params.items()):
        return system
    return system.with_params(**params)


def _read_params(system: FuzzySystem) -> tuple[Param, ...]:
    """Return the params that something else than unused params reads."""
    block = system
    while unused := {d.span for d in unused_params(block)}:
        block = dataclasses.replace(block, params=tuple(p for p in block.params if p.span not in unused))
    return block.params


def _range_of(output: OutputPlan) -> Bounds:
    """Return the range that the adaptive consequents of an output stay in."""
    lower, upper = Number(output.lower), Number(output.upper)
    return Bounds(lower=lower, upper=upper, without_lower=False, without_upper=False)


def split(arguments: tuple[Expr, ...]) -> tuple[list[Expr], dict[str, Expr]]:
    """Return arguments by position and by name."""
    positional = [a for a in arguments if not isinstance(a, Keyword)]
    return positional, {a.name: a.value for a in arguments if isinstance(a, Keyword)}
