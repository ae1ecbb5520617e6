"""Affine forms of expressions in exact arithmetic: a constant plus coefficients of inputs and of outputs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction

from fuzzyctl.expr import CONSTANTS, Binary, Call, Expr, Name, Negate, Number
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record


@record(frozen=True)
class Line:
    """`factor · input + shift`; `input` is a position, None if the factor is 0."""

    input: int | None
    factor: Fraction
    shift: Fraction

    def at(self, point: tuple[Fraction, ...]) -> Fraction:
        """Return its value at a point."""
        return self.shift if self.input is None else self.factor * point[self.input] + self.shift

    @property
    def is_exact(self) -> bool:
        """Whether floats compute it without rounding."""
        return self.shift == 0 and abs(self.factor) == 1


@record(frozen=True)
class Taken:
    """An output, by position, at some arguments, one for each input of its system.

    `system` is 0 for the own one, from 1 on for those that its guarantees compare it with.
    """

    output: int
    arguments: tuple[Line, ...]
    system: int = 0


@record(frozen=True)
class Affine:
    """A number, inputs by position and outputs, each times a number."""

    number: Fraction
    inputs: Mapping[int, Fraction]
    outputs: Mapping[Taken, Fraction]

    def plus(self, other: Affine, factor: Fraction) -> Affine:
        """Return self + factor · other."""
        inputs, outputs = dict(self.inputs), dict(self.outputs)
        for i, c in other.inputs.items():
            inputs[i] = inputs.get(i, Fraction(0)) + factor * c
        for t, c in other.outputs.items():
            outputs[t] = outputs.get(t, Fraction(0)) + factor * c
        return Affine(
            self.number + factor * other.number,
            {i: c for i, c in inputs.items() if c},
            {t: c for t, c in outputs.items() if c},
        )

    def times(self, factor: Fraction) -> Affine:
        """Return factor · self."""
        return _of_number(Fraction(0)).plus(self, factor)

    @property
    def is_number(self) -> bool:
        """Whether it is the same everywhere."""
        return not self.inputs and not self.outputs

    def line(self) -> Line | None:
        """Return it as a line of one input, None for anything else."""
        if self.outputs or len(self.inputs) > 1:
            return None
        for i, c in self.inputs.items():
            return Line(i, c, self.number)
        return Line(None, Fraction(0), self.number)


def _of_number(value: Fraction) -> Affine:
    return Affine(value, {}, {})


class Reader:
    """Reads expressions of one system."""

    def __init__(self, system: FuzzySystem) -> None:
        self.values = {n: Fraction(v) for n, v in system.values.items()}
        self.values |= {n: Fraction(v) for n, v in CONSTANTS.items() if math.isfinite(v)}
        self.inputs = {v.name: i for i, v in enumerate(system.inputs)}
        self.outputs = {v.name: (0, i) for i, v in enumerate(system.outputs)}
        #: The inputs of each system as they are at a point; of a compared one that has others too, nothing.
        self.here = [tuple(Line(i, Fraction(1), Fraction(0)) for i in range(len(system.inputs)))]
        for s, other in enumerate(system.compared, start=1):
            self.outputs |= {f"{other.name}.{o.name}": (s, i) for i, o in enumerate(other.outputs)}
            positions = [self.inputs[v.name] for v in other.inputs if v.name in self.inputs]
            self.here.append(tuple(Line(i, Fraction(1), Fraction(0)) for i in positions))

    def read(self, expr: Expr) -> Affine | None:
        """Return an expression as a sum, None if it is not one."""
        match expr:
            case Number(value=value):
                return _of_number(Fraction(value)) if math.isfinite(value) else None
            case Name(name=name):
                return self._name(name)
            case Negate(operand=operand):
                part = self.read(operand)
                return None if part is None else part.times(Fraction(-1))
            case Binary(op=op, left=left, right=right):
                return self._binary(op, self.read(left), self.read(right))
            case Call(function=function, arguments=arguments) if function in self.outputs:
                lines = [*self._lines(arguments)]
                if len(lines) < len(arguments):
                    return None
                s, output = self.outputs[function]
                return Affine(Fraction(0), {}, {Taken(output, tuple(lines), s): Fraction(1)})
        return None

    def _name(self, name: str) -> Affine | None:
        if name in self.inputs:
            return Affine(Fraction(0), {self.inputs[name]: Fraction(1)}, {})
        if name in self.outputs:
            s, output = self.outputs[name]
            return Affine(Fraction(0), {}, {Taken(output, self.here[s], s): Fraction(1)})
        return _of_number(self.values[name]) if name in self.values else None

    def _lines(self, arguments: tuple[Expr, ...]) -> Iterator[Line]:
        for argument in arguments:
            part = self.read(argument)
            line = None if part is None else part.line()
            if line is not None:
                yield line

    @staticmethod
    def _binary(op: str, a: Affine | None, b: Affine | None) -> Affine | None:
        if a is None or b is None:
            return None
        match op:
            case "+" | "-":
                return a.plus(b, Fraction(1 if op == "+" else -1))
            case "*" if a.is_number or b.is_number:
                return b.times(a.number) if a.is_number else a.times(b.number)
            case "/" if b.is_number and b.number:
                return a.times(1 / b.number)
        return None
