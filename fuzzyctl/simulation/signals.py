"""Signals over time as expressions: steps, pulses, ramps and sines exactly, noise and tables as columns."""

from __future__ import annotations

import hashlib
import itertools
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace as with_fields
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import (
    ONE,
    ZERO,
    Call,
    Compare,
    Expr,
    Keyword,
    Logic,
    Name,
    Number,
    Text,
    Where,
    evaluate,
    replace,
    span_of,
    walk,
)
from fuzzyctl.kernels.program.builder import LAST_ENTRY
from fuzzyctl.model.forms import bound, pairs_of
from fuzzyctl.model.loop import SIGNALS, TIME, Loop
from fuzzyctl.records import record

#: Times this part of a sample time beside a sample are that of the sample.
SAME: Final = 1e-9


@record(frozen=True)
class Noise:
    """A column of normal numbers, one for each sample.

    Args:
        sigma: Their standard deviation.
        seed: Where the generator begins.
    """

    sigma: float
    seed: int


@record(frozen=True)
class Table:
    """A column of a CSV file over time.

    Args:
        file: Its name, as written.
        column: Name of the column.
        time: Name of the column of times [s]; empty for the first one.
        span: Where it is written.
    """

    file: str
    column: str
    time: str
    span: Span | None = None


#: Columns that are known before a run.
Given = Noise | Table


class Signals:
    """Writes signals as expressions over the time.

    Args:
        step: Time between two samples [s].
        constant: Returns the value of an expression over params.
        column: Returns the names of columns that are known before the run.
    """

    def __init__(
        self, step: float, constant: Callable[[Expr], float], column: Callable[[Given, int], tuple[Name, ...]]
    ) -> None:
        self._step, self._constant, self._column = step, constant, column

    def expression(self, call: Call) -> Expr:
        """Return the value of a signal at the time `t`."""
        arguments = bound(SIGNALS[call.function], call)
        return _WRITERS[call.function](self, call, arguments)

    def time(self, expr: Expr) -> float:
        """Return a time [s]; one beside a sample is exactly that of the sample, as runs compute it."""
        value = self._constant(expr)
        nearest = value / self._step
        is_sample = math.isfinite(nearest) and abs(nearest - round(nearest)) <= SAME * max(1.0, abs(nearest))
        return round(nearest) * self._step if is_sample else value

    def steps(self, call: Call, _arguments: Mapping[str, Expr]) -> Expr:
        """Return the value of the last time that has come: a table, whatever its length."""
        values = {-sys.float_info.max: 0.0} | {self.time(p.key): self._constant(p.value) for p in pairs_of(call)}
        return Call(LAST_ENTRY, (Name(TIME), *(Number(v) for entry in values.items() for v in entry)))

    def pulse(self, _call: Call, arguments: Mapping[str, Expr]) -> Expr:
        """Return 1 between two times, else 0."""
        begin, end = self.time(arguments["begin"]), self.time(arguments["end"])
        inside = Logic("and", (_from(begin), Compare("<", Name(TIME), Number(end))))
        return Where(inside, ONE, ZERO)

    def ramp(self, _call: Call, arguments: Mapping[str, Expr]) -> Expr:
        """Return a straight line between two times, constant before and behind."""
        begin, end = self.time(arguments["begin"]), self.time(arguments["end"])
        low, high = self._constant(arguments["low"]), self._constant(arguments["high"])
        share = (Name(TIME) - begin) / (end - begin)
        inside = low + (high - low) * share
        return Where(_from(end), Number(high), Where(_from(begin), inside, Number(low)))

    def sine(self, _call: Call, arguments: Mapping[str, Expr]) -> Expr:
        """Return a sine."""
        frequency, amplitude, phase = (self._constant(arguments[n]) for n in ("frequency", "amplitude", "phase"))
        return amplitude * Call("sin", (2.0 * math.pi * frequency * Name(TIME) + phase,))

    def noise(self, _call: Call, arguments: Mapping[str, Expr]) -> Expr:
        """Return the number drawn for a sample."""
        drawn = Noise(self._constant(arguments["sigma"]), int(self._constant(arguments["seed"])))
        return self._column(drawn, 1)[0]

    def csv(self, call: Call, arguments: Mapping[str, Expr]) -> Expr:
        """Return a straight line between two samples."""
        file, column, time = (_text(arguments[n]) for n in ("file", "column", "time"))
        offset, slope = self._column(Table(file, column, time, span_of(call)), 2)
        return offset + slope * Name(TIME)


def _from(time: float) -> Expr:
    return Compare(">=", Name(TIME), Number(time))


def _text(expr: Expr) -> str:
    assert isinstance(expr, Text)
    return expr.text


_WRITERS: Final[Mapping[str, Callable[[Signals, Call, Mapping[str, Expr]], Expr]]] = {
    "steps": Signals.steps,
    "pulse": Signals.pulse,
    "ramp": Signals.ramp,
    "sine": Signals.sine,
    "noise": Signals.noise,
    "csv": Signals.csv,
}


def with_streams(loop: Loop) -> Loop:
    """Return a loop whose noises without a seed have one from the name of their signal.

    The only noise without a seed keeps the seed 0, if no other has it.
    """
    calls = [c for _, value in _signals(loop) for c in _noises(value)]
    seeds = [_seed(c, loop) for c in calls if _is_seeded(c)]
    if len(calls) == len(seeds) or (len(calls) == len(seeds) + 1 and 0.0 not in seeds):
        return loop
    values = [_streamed(name, value) for name, value in _signals(loop)]
    rest = iter(values)
    definitions = tuple(with_fields(d, value=next(rest)) for d in loop.definitions)
    instances = tuple(with_fields(i, arguments=tuple(next(rest) for _ in i.arguments)) for i in loop.instances)
    return with_fields(loop, definitions=definitions, instances=instances)


def equal_seeds(loop: Loop) -> Iterator[Diagnostic]:
    """Warn of noises with one seed, which are the same numbers."""
    first: dict[float, Call] = {}
    for call in (c for _, value in _signals(loop) for c in _noises(value) if _is_seeded(c)):
        seed = _seed(call, loop)
        before = first.setdefault(seed, call)
        if before is not call:
            notes = () if before.span is None else (Note(before.span, "the other one"),)
            message = f"two noises have the seed {seed:g}: they are the same numbers"
            help_text = "leave the seeds out, so that each draws other numbers, or make one signal of both with 'let'"
            yield Diagnostic("FZ214", message, call.span, severity="warning", notes=notes, help=help_text)


def _signals(loop: Loop) -> Iterator[tuple[str, Expr]]:
    """Yield the lets of a loop, and the arguments of its blocks as `BLOCK.INPUT`."""
    yield from ((d.name, d.value) for d in loop.definitions)
    inputs = {b.name: [s.name for s in b.inputs] for b in (*loop.controllers, *loop.plants)}
    for i in loop.instances:
        names = itertools.chain(inputs[i.controller], itertools.repeat(""))
        for a, name in zip(i.arguments, names, strict=False):
            yield f"{i.name}.{a.name if isinstance(a, Keyword) else name}", a


def _noises(value: Expr) -> Iterator[Call]:
    return (e for e in walk(value) if isinstance(e, Call) and e.function == "noise")


def _is_seeded(call: Call) -> bool:
    return len(call.arguments) > 1


def _seed(call: Call, loop: Loop) -> float:
    return evaluate(bound(SIGNALS["noise"], call)["seed"], loop.param_values.values)


def _streamed(signal: str, value: Expr) -> Expr:
    """Return the value of a signal with seeds: of its name, and of `NAME.2` for the second noise in it."""
    count = itertools.count(1)

    def change(node: Expr) -> Expr:
        if not (isinstance(node, Call) and node.function == "noise") or _is_seeded(node):
            return node
        number = next(count)
        name = signal if number == 1 else f"{signal}.{number}"
        seed = int.from_bytes(hashlib.blake2b(name.encode(), digest_size=6).digest(), "little")
        return Call("noise", (*node.arguments, Keyword("seed", Number(float(seed)))), node.span)

    return replace(value, change)
