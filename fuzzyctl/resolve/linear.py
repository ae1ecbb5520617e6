"""Plants of one line as linear equations: transfer functions, zeros and poles, matrices.

A rational function becomes its controllable canonical form in the scaled variable s / w, w a power of two near the
fastest pole, so that its coefficients and states are of moderate size and the scaling rounds nothing. Zeros and poles
become a cascade of sections of first and second order, since expanding their product would lose digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Expr, Name, Number, walk
from fuzzyctl.model.block import ParamValues
from fuzzyctl.model.controller import Definition, Result, Signal, State
from fuzzyctl.records import dataclass

#: Most terms of a sum that is one expression.
LONGEST: Final = 80


@dataclass
class LinearPlant:
    """Equations of a linear plant, collected section by section.

    Args:
        values: Values of the params, by which the scale is chosen.
    """

    values: ParamValues
    inputs: list[Signal] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    definitions: list[Definition] = field(default_factory=list)
    results: list[Result] = field(default_factory=list)
    derivatives: list[Definition] = field(default_factory=list)

    def takes(self, names: Sequence[str], delay: Expr) -> list[Expr]:
        """Add inputs; return the names that enter the equations: the inputs, or their delayed values."""
        self.inputs += [Signal(name=n) for n in names]
        if delay == ZERO:
            return [Name(n) for n in names]
        delayed = [f"delayed_{n}" for n in names]
        self.definitions += [
            Definition(name=d, value=Call("delay", (Name(n), delay))) for n, d in zip(names, delayed, strict=True)
        ]
        return [Name(d) for d in delayed]

    def defines(self, name: str, value: Expr) -> Expr:
        """Give a value a name, unless it is one."""
        if isinstance(value, Name):
            return value
        self.definitions.append(Definition(name=name, value=value))
        return Name(name)

    def gives(self, name: str, value: Expr) -> None:
        """Add an output."""
        self.results.append(Result(name=name, value=value))

    def adds(self, derivative: Expr) -> None:
        """Add a state, which starts at 0, with its derivative."""
        name = self.state(len(self.states) + 1)
        self.states.append(State(name=name, start=ZERO))
        self.derivatives.append(Definition(name=name, value=derivative))

    @staticmethod
    def state(number: int) -> str:
        """Return the name of a state."""
        return f"x{number}"

    def fraction(self, num: Sequence[Expr], den: Sequence[Expr], u: Expr) -> Expr:
        """Add the states of a proper rational function and return its output for an input.

        Args:
            num: Coefficients of the numerator, the highest power first; no more than those of the denominator.
            den: Coefficients of the denominator; the first one is not 0.
            u: The input.
        """
        order = len(den) - 1
        a = [divided(c, den[0]) for c in reversed(den[1:])]
        b = [divided(c, den[0]) for c in reversed(num)]
        direct = b.pop() if len(b) > order else ZERO
        b += [ZERO] * (order - len(b))
        b = [minus(bk, times(direct, ak)) for bk, ak in zip(b, a, strict=True)]
        speed = self._speed(a)
        scales = [Number(speed ** (k - order)) for k in range(order)]
        first = len(self.states)
        states = [Name(self.state(first + k + 1)) for k in range(order)]
        for following in states[1:]:
            self.adds(times(Number(speed), following))
        if states:
            back = self.total([(times(ak, scale), x) for ak, scale, x in zip(a, scales, states, strict=True)])
            self.adds(times(Number(speed), minus(u, back)))
        return self.total([*((times(bk, s), x) for bk, s, x in zip(b, scales, states, strict=True)), (direct, u)])

    def total(self, terms: Sequence[tuple[Expr, Expr]]) -> Expr:
        """Return the sum of products, those that are 0 left out; partial sums of many terms have names."""
        result: Expr | None = None
        for number, (factor, x) in enumerate((f, x) for f, x in terms if f != ZERO):
            if number and number % LONGEST == 0 and result is not None:
                result = self.defines(f"sum{len(self.definitions) + 1}", result)
            if isinstance(factor, Number) and factor.value < 0 and result is not None:
                result = Binary("-", result, times(Number(-factor.value), x))
            else:
                term = times(factor, x)
                result = term if result is None else Binary("+", result, term)
        return ZERO if result is None else result

    def _speed(self, coefficients: Sequence[Expr]) -> float:
        """Return a power of two near the largest bound of a root that one coefficient gives."""
        order = len(coefficients)
        numbers = [self.values.of(c) for c in coefficients]
        sizes = [abs(c) ** (1 / (order - k)) for k, c in enumerate(numbers) if c and math.isfinite(c)]
        largest = max(sizes, default=1.0)
        return 2.0 ** round(math.log2(largest))


def is_finite(expr: Expr) -> bool:
    """Whether all numbers of an expression are finite."""
    return all(math.isfinite(e.value) for e in walk(expr) if isinstance(e, Number))


def divided(a: Expr, b: Expr) -> Expr:
    """Return a quotient, computed where both are numbers."""
    if b == ONE:
        return a
    return Number(a.value / b.value) if isinstance(a, Number) and isinstance(b, Number) else Binary("/", a, b)


def times(a: Expr, b: Expr) -> Expr:
    """Return a product, computed where both are numbers."""
    if isinstance(a, Number) and isinstance(b, Number):
        return Number(a.value * b.value)
    if ZERO in (a, b):
        return ZERO
    return b if a == ONE else a if b == ONE else Binary("*", a, b)


def minus(a: Expr, b: Expr) -> Expr:
    """Return a difference, computed where both are numbers."""
    if isinstance(a, Number) and isinstance(b, Number):
        return Number(a.value - b.value)
    return a if b == ZERO else Binary("-", a, b)


def sections(zeros: Sequence[Root], poles: Sequence[Root]) -> list[tuple[list[Expr], list[Expr]]]:
    """Return numerators and denominators of second and first order whose product has some zeros and poles."""
    numerators, denominators = _factors(zeros), _factors(poles)
    twos = [f for f in numerators if len(f) == 3]
    rest = [f for f in numerators if len(f) < 3]
    results = []
    for factor in denominators:
        numerator: list[Expr] = (
            twos.pop(0) if twos and len(factor) == 3 else rest.pop(0) if rest and not twos else [ONE]
        )
        results.append((numerator, factor))
    return results


#: A real root, or the real and imaginary part of a conjugate pair.
Root = tuple[Expr] | tuple[Expr, Expr]


def _factors(roots: Sequence[Root]) -> list[list[Expr]]:
    """Return polynomials of second order, and one of first order where the number of roots is odd."""
    real = [r[0] for r in roots if len(r) == 1]
    factors = [_pair(*r) for r in roots if len(r) == 2]
    for p, q in zip(real[::2], real[1::2], strict=False):
        factors.append([ONE, _negated(_plus(p, q)), times(p, q)])
    return [*factors, *([[ONE, _negated(real[-1])]] if len(real) % 2 else [])]


def _pair(re: Expr, im: Expr) -> list[Expr]:
    return [ONE, times(Number(-2.0), re), _plus(times(re, re), times(im, im))]


def _plus(a: Expr, b: Expr) -> Expr:
    if isinstance(a, Number) and isinstance(b, Number):
        return Number(a.value + b.value)
    return a if b == ZERO else b if a == ZERO else Binary("+", a, b)


def _negated(a: Expr) -> Expr:
    return minus(ZERO, a)
