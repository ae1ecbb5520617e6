"""Checks of units in guarantees: sums and comparisons need equal units, where units are given.

Numbers take any unit, and so do products and quotients: of units, which are texts, only the slopes of outputs
are computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import (
    COMPARISONS,
    Binary,
    Call,
    Compare,
    Expr,
    Keyword,
    Logic,
    Name,
    Negate,
    children,
    span_of,
    to_text,
)
from fuzzyctl.model.checks.dimensions import are_same, surely_differ
from fuzzyctl.model.controller import Definition, EquationBlock, Instance
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.model.system import FuzzySystem

#: Functions whose value is measured in the unit of their arguments.
_JOINING = ("abs", "min", "max", "floor", "ceil", "round", "mod", "fmod", "clamp")
#: Operators with state, and `delay` of plants: the power of a second by which the unit of their value differs from that
#: of their first argument; None for a value without unit.
_OPERATORS: Final[dict[str, int | None]] = {
    "previous": 0,
    "difference": 0,
    "lowpass": 0,
    "rate_limit": 0,
    "delay": 0,
    "derivative": -1,
    "integral": 1,
    "hysteresis": None,
}
#: The same for their settings that have the unit of the first argument, and settings that are times.
_SETTINGS: Final[dict[tuple[str, str], int]] = {
    ("previous", "start"): 0,
    ("delay", "start"): 0,
    ("hysteresis", "low"): 0,
    ("hysteresis", "high"): 0,
    ("rate_limit", "rate"): -1,
    ("integral", "start"): 1,
}
_TIMES: Final = frozenset({("lowpass", "time"), ("derivative", "filter")})


def unlike_units(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find quantities of different units that a guarantee compares, adds, or puts in each other's place."""
    units = _of_system(system)
    for guarantee in system.guarantees:
        units.unit(guarantee.claim)
        if guarantee.when is not None:
            units.unit(guarantee.when)
        if guarantee.within is not None:
            units.join([*_measured(guarantee.claim), guarantee.within])
    yield from units.mistakes


def _measured(claim: Expr) -> Sequence[Expr]:
    """Return what of a claim is measured in the unit of its tolerance."""
    match claim:
        case Compare(left=Call(function="lipschitz", arguments=(output, _))):
            return (output,)
        case Compare(left=left):
            return (left,)
        case Call(function="bounded" | "increasing" | "decreasing", arguments=(output, *_)):
            return (output,)
    return ()


def _of_system(system: FuzzySystem) -> Units:
    of = {p.name: p.unit for p in system.params} | {v.name: v.unit for v in system.variables}
    units = Units(of, {o.name: [v.unit for v in system.inputs] for o in system.outputs})
    for other in system.compared:
        for o in other.outputs:
            units.of[f"{other.name}.{o.name}"] = o.unit
            units.arguments[f"{other.name}.{o.name}"] = [v.unit for v in other.inputs]
    return units


class Units:
    """Units of expressions; those that do not fit together are collected.

    Args:
        of: The unit of each name, and of the result of each call of `arguments`; empty or absent for any.
        arguments: The units that the arguments of a call are measured in.
    """

    def __init__(self, of: dict[str, str], arguments: dict[str, list[str]]) -> None:
        self.of, self.arguments = of, arguments
        self._computed: set[str] = set()
        self.mistakes: list[Diagnostic] = []

    def unit(self, expr: Expr) -> str:
        """Return the unit of an expression, an empty text where it may be any."""
        match expr:
            case Name(name=name):
                return self.of.get(name, "")
            case Negate(operand=operand):
                return self.unit(operand)
            case Binary(op="+" | "-", left=left, right=right):
                return self.join([left, right])
            case Compare(left=Call(function="lipschitz", arguments=(Name() as output, Name() as along)), right=bound):
                self._slope(output.name, along.name, bound)
                return ""
            case Compare(left=Call(function="total"), right=least):
                unit = self.unit(least)
                if unit and surely_differ(unit, "1"):
                    self._report(f"'{to_text(least)}' is measured in {unit}, a strength has no unit", least)
                return ""
            case Compare(left=left, right=right):
                self.join([left, right])
                return ""
            case Call(function="bounded", arguments=arguments):
                self.join(arguments)
                return ""
            case Call(function=function, arguments=arguments) if function in COMPARISONS:
                self.join(arguments)
                return ""
            case Call(function=function, arguments=arguments) if function in _JOINING:
                return self.join(arguments)
            case Call(function="where", arguments=(condition, *choices)):
                self.unit(condition)
                return self.join(choices)
            case Call(function=function) if function in _OPERATORS:
                return self._of_operator(expr)
            case Call(function=function, arguments=arguments) if function in self.arguments:
                self.take(function, arguments, self.arguments[function])
                return self.of.get(function, "")
            case Logic(operands=operands):
                for operand in operands:
                    self.unit(operand)
                return ""
        for part in children(expr):
            self.unit(part)
        return ""

    def join(self, parts: Sequence[Expr]) -> str:
        """Return the unit that all parts share; report the first that has another than one before it."""
        pairs = [(part, unit) for part in parts if (unit := self.unit(part))]
        for part, unit in pairs[1:]:
            if self._differ(unit, pairs[0][1]):
                first = to_text(pairs[0][0])
                message = f"'{first}' is measured in {pairs[0][1]}, '{to_text(part)}' in {unit}"
                self._report(message, part)
                return ""
        return pairs[0][1] if pairs else ""

    def define(self, name: str, value: Expr) -> None:
        """Report a value that is measured in another unit than the name that it is given."""
        unit, declared = self.unit(value), self.of.get(name, "")
        if unit and declared and self._differ(unit, declared):
            self._report(f"'{name}' is measured in {declared}, '{to_text(value)}' in {unit}", value)

    def define_rate(self, name: str, value: Expr) -> None:
        """Report a derivative by time that is measured in another unit than the state per second."""
        unit, declared = self.unit(value), self.of.get(name, "")
        if unit and declared and surely_differ(unit, declared, "s"):
            message = f"'{to_text(value)}' is measured in {unit}, the derivative of '{name}' in {declared} per s"
            self._report(message, value)

    def _of_operator(self, call: Call) -> str:
        """Return the unit of an operator with state, after its settings."""
        function, positional = call.function, [a for a in call.arguments if not isinstance(a, Keyword)]
        unit = self.unit(positional[0]) if positional else ""
        names = OPERATORS[function].settings  # `delay` of plants takes a time in place of samples
        named = [(a.name, a.value) for a in call.arguments if isinstance(a, Keyword)]
        for name, value in [*zip(names, positional[1:], strict=False), *named]:
            measure, power = self.unit(value), _SETTINGS.get((function, name))
            wanted = "s" if (function, name) in _TIMES else "" if power is None else self._over_time(unit, power)
            if measure and wanted and surely_differ(measure, wanted):
                message = f"'{to_text(value)}' is measured in {measure}, '{name}' of '{function}' in {wanted}"
                self._report(message, value)
        power = _OPERATORS[function]
        return "" if power is None else self._over_time(unit, power)

    def _over_time(self, unit: str, power: int) -> str:
        """Return a unit times a power of a second."""
        if not unit or not power:
            return unit
        whole = unit if unit.isalpha() else f"({unit})"
        over_time = f"{whole} s" if power > 0 else f"{whole}/s"
        self._computed.add(over_time)
        return over_time

    def _differ(self, one: str, other: str) -> bool:
        """Return whether two units differ; of one that is computed, beyond doubt."""
        if {one, other} & self._computed:
            return surely_differ(one, other)
        return not are_same(one, other)

    def _slope(self, output: str, along: str, bound: Expr) -> None:
        """Report a bound of a slope in another unit than that of the output per that of the input."""
        unit, above, below = self.unit(bound), self.of.get(output, ""), self.of.get(along, "")
        if unit and above and below and surely_differ(unit, above, below):
            due = "has no unit" if are_same(above, below) else f"in {above} per {below}"
            slope = f"a slope of '{output}' along '{along}'"
            self._report(f"'{to_text(bound)}' is measured in {unit}, {slope} {due}", bound)

    def take(self, function: str, arguments: Sequence[Expr], wanted: Sequence[str]) -> None:
        """Report arguments that are measured in other units than a call takes."""
        for argument, unit in zip(arguments, wanted, strict=False):
            measure = self.unit(argument)
            if measure and unit and self._differ(measure, unit):
                self._report(f"'{to_text(argument)}' is measured in {measure}, '{function}' takes {unit}", argument)

    def _report(self, message: str, place: Expr) -> None:
        help_text = "use quantities of one unit here; write a factor where units are to be converted"
        self.mistakes.append(Diagnostic("FZ312", message, span_of(place), help=help_text))


def unlike_block_units(block: EquationBlock) -> Iterator[Diagnostic]:
    """Find quantities of different units that a block compares, adds, connects, or gives to a name."""
    units = Units({p.name: p.unit for p in block.params}, {})
    for instance in block.instances:
        callee = block.callee(instance)
        signals = (*callee.inputs, *callee.states, *callee.outputs)
        units.of |= {f"{instance.name}.{s.name}": s.unit for s in signals}
    units.of |= {s.name: s.unit for s in (*block.inputs, *block.states, *block.outputs)}
    units.arguments = {s.name: [i.unit for i in s.inputs] for s in block.systems}
    if isinstance(block, Loop):
        units.of |= {d.name: d.unit for d in block.disturbances}
    _define(units, block.definitions, block.systems)
    for result in block.outputs:
        units.define(result.name, result.value)
    define_change = units.define_rate if isinstance(block, Plant) else units.define
    for change in block.changes:
        define_change(change.name, change.value)
    for state in block.states:
        units.define(state.name, state.start)
    for instance in block.instances:
        _connect(units, instance, block.callee(instance))
    for loop_measure in block.measures if isinstance(block, Loop) else ():
        units.of.setdefault(loop_measure.name, loop_measure.unit)
        units.define(loop_measure.name, loop_measure.value)
    for guarantee in block.always if isinstance(block, Loop) else ():
        units.unit(guarantee.claim)
    yield from {(d.message, d.span): d for d in units.mistakes}.values()


def _define(units: Units, definitions: Sequence[Definition], systems: Sequence[FuzzySystem]) -> None:
    """Enter the units of definitions; those that come after their use are found in the second pass."""
    outputs = {s.name: {o.name: o.unit for o in s.outputs} for s in systems}
    for _ in range(2):
        for d in definitions:
            by_output = outputs.get(d.value.function) if isinstance(d.value, Call) else None
            units.of[d.name] = (
                units.unit(d.value) if not by_output or len(by_output) > 1 else next(iter(by_output.values()))
            )
            for output, unit in (by_output or {}).items():
                units.of[f"{d.name}.{output}"] = unit
    for d in definitions:
        units.unit(d.value)


def _connect(units: Units, instance: Instance, callee: EquationBlock) -> None:
    """Compare the units of arguments with those of the inputs that they are connected to."""
    positional = [a for a in instance.arguments if not isinstance(a, Keyword)]
    inputs = {i.name: i.unit for i in callee.inputs}
    named = [(a.value, inputs[a.name]) for a in instance.arguments if isinstance(a, Keyword) and a.name in inputs]
    for argument, unit in (*zip(positional, inputs.values(), strict=False), *named):
        units.take(callee.name, [argument], [unit])
