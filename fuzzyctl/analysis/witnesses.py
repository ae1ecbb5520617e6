"""Witnesses: points at which a kernel breaks a guarantee."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.analysis.claims import Bound, Every, Slope, Some, Truth, bounds_in, compared_outputs, is_limit, named
from fuzzyctl.analysis.verdicts import Witness
from fuzzyctl.analysis.work import Work, compilation, evaluation
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import (
    CONSTANTS,
    FUNCTIONS,
    Binary,
    Call,
    Compare,
    Expr,
    ExprError,
    Name,
    Negate,
    Number,
    evaluate,
    to_text,
)
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.model.system import FuzzySystem

if TYPE_CHECKING:
    from fuzzyctl.kernels.compile import Kernel

#: Largest error of functions such as `exp`, relative to the sides of the comparison.
_ROUNDING: Final = Fraction(1, 1 << 40)

#: An exact number, and whether it was computed without functions that round.
Value = tuple[Fraction, bool]


class NoValueError(ArithmeticError):
    """Raised if an expression has no value, such as an output that is NaN."""


class Judge:
    """Evaluates claims of a system at points."""

    def __init__(self, system: FuzzySystem, work: Work | None = None) -> None:
        self.system, self.work = system, work
        self.inputs = [v.name for v in system.inputs]
        self.params: Mapping[str, float] = {**CONSTANTS, **system.values}
        self.compared = {c.name: Judge(c) for c in system.compared}

    @cached_property
    def kernel(self) -> Kernel:
        """The kernel that users call."""
        from fuzzyctl.kernels.compile import compile

        return compile(self.system, "python")

    @cached_property
    def units(self) -> float:
        """The work of an evaluation of the kernel."""
        flat = plan(self.system)
        if self.work is not None:
            self.work.takes(compilation(flat))
        return evaluation(flat)

    def spends(self, units: float) -> bool:
        """Count one evaluation of the kernel and some units of work, and return whether there were as many."""
        return self.work is None or self.work.takes(self.units + units)

    def outputs(self, point: Sequence[float]) -> dict[str, float]:
        """Return the values of all outputs; NaN where one has none."""
        names = [o.name for o in self.system.outputs]
        state: list[Any] = [self.kernel.start()] if self.kernel.n_states else []
        try:
            result = self.kernel(*point, *state)
        except NoRuleFiresError:
            return dict.fromkeys(names, math.nan)
        return dict(zip(names, (result,) if len(names) == 1 else result, strict=True))

    def broken(self, truth: Truth, region: Truth, point: Sequence[float]) -> Witness | None:
        """Return a point as a witness if it lies in the region and the claim is false there."""
        try:
            if not self.holds(region, point) or self.holds(truth, point):
                return None
            failing = [b for b in bounds_in(truth) if not self.holds(b, point)]
            return Witness(dict(zip(self.inputs, point, strict=True)), self._sides(failing[0], point))
        except (NoValueError, ExprError, OverflowError):
            return None

    def lies_in(self, region: Truth, point: Sequence[float]) -> bool:
        """Return whether a region holds at a point and has a value there."""
        try:
            return self.holds(region, point)
        except (NoValueError, ExprError, OverflowError):
            return False

    def silent(self, output: str, point: Sequence[float]) -> Witness:
        """Return a point where no rule moves an output as a witness, in words that say how."""
        strength = 0.0 if self.kernel.n_states else self.strength(output, point)
        side = (f"rules that fire for {output}", 0.0)
        if strength > 0.0:
            side = (f"largest activation, which does not move {output}", strength)
        return Witness(dict(zip(self.inputs, point, strict=True)), (side,))

    def _sides(self, bound: Bound, point: Sequence[float]) -> tuple[tuple[str, float], ...]:
        origin = bound.origin
        sides = (origin.left, origin.right) if isinstance(origin, Compare) else (bound.left, bound.right)
        here = self.outputs(point)
        results = {
            to_text(s): self._endless(s, point, here) or float(self.value(s, point, here)[0])
            for s in sides
            if not isinstance(s, Number)
        }
        return tuple(results.items())

    def holds(self, truth: Truth, point: Sequence[float]) -> bool:
        """Return whether a claim holds at a point, for the numbers that the kernel returns."""
        match truth:
            case Every(parts=parts):
                return all(self.holds(p, point) for p in parts)
            case Some(parts=parts):
                return any(self.holds(p, point) for p in parts)
            case Bound(left=left, right=right, tolerance=tolerance, strict=strict) as bound:
                here = self.outputs(point)
                endless = self._endless(left, point, here) - self._endless(right, point, here)
                if math.isinf(endless):
                    return endless > 0.0
                (a, exact_a), (b, exact_b) = self.value(left, point, here), self.value(right, point, here)
                slack = tolerance if exact_a and exact_b else tolerance + _ROUNDING * (abs(a) + abs(b))
                if not tolerance and not is_limit(self.system, bound):
                    # Such a claim is about exact arithmetic, and a difference in the last digits breaks it not.
                    slack += sum(map(self.rounding, {*named(left), *named(right)} & self.outputs_named), Fraction(0))
                return a - b + slack > 0 if strict and exact_a and exact_b else a - b + slack >= 0
        raise TypeError(f"{type(truth).__name__} is about all points")

    def _endless(self, expr: Expr, point: Sequence[float], here: Mapping[str, float]) -> float:
        """Return the value of a sum or a magnitude of outputs where one is infinite, 0 anywhere else."""
        match expr:
            case Name(name=name) if name in here:
                return here[name] if math.isinf(here[name]) else 0.0
            case Negate(operand=operand):
                return -self._endless(operand, point, here)
            case Call(function=function, arguments=arguments) if function in here:
                value = self.outputs(self._floats(arguments, point, here))[function]
                return value if math.isinf(value) else 0.0
            case Call(function="abs", arguments=(operand,)):
                return abs(self._endless(operand, point, here))
            case Binary(op="+" | "-" as op, left=left, right=right):
                a, b = self._endless(left, point, here), self._endless(right, point, here)
                for part in [part for part, value in ((left, a), (right, b)) if (a or b) and not value]:
                    self.value(part, point, here)  # which has one, or so has the whole none
                return a + b if op == "+" else a - b
        return 0.0

    def value(self, expr: Expr, point: Sequence[float], here: Mapping[str, float]) -> Value:
        """Return the value of an expression at a point, `here` being the outputs there.

        Args:
            expr: Over inputs, params and outputs.
            point: Values of the inputs.
            here: Values of the outputs by name.

        Returns:
            The value, and whether it is exact.

        Raises:
            NoValueError: Where it has none.
        """
        match expr:
            case Number(value=number):
                return _finite(number), True
            case Name(name=name):
                if name in self.inputs:
                    return _finite(point[self.inputs.index(name)]), True
                if "." in name:
                    return self._elsewhere(name, [point[self.inputs.index(n)] for n in self._inputs_of(name)]), True
                return _finite(here[name] if name in here else self.params[name]), True
            case Negate(operand=operand):
                a, exact = self.value(operand, point, here)
                return -a, exact
            case Binary(op="^", left=left, right=right):
                return self._rounded(lambda u, v: evaluate(Number(u) ** Number(v), {}), (left, right), point, here)
            case Binary(op=op, left=left, right=right):
                return _combined(op, self.value(left, point, here), self.value(right, point, here))
            case Call(function=function, arguments=arguments) if function in here:
                return _finite(self.outputs(self._floats(arguments, point, here))[function]), True
            case Call(function="total", arguments=(Name(name=name),)):
                return _finite(self.strength(name, point)), True
            case Call(function=function, arguments=arguments) if "." in function:
                return self._elsewhere(function, self._floats(arguments, point, here)), True
            case Call(function="abs" | "min" | "max" as function, arguments=arguments):
                parts = [self.value(a, point, here) for a in arguments]
                exact = all(e for _, e in parts)
                numbers = [v for v, _ in parts]
                return (abs(numbers[0]) if function == "abs" else {"min": min, "max": max}[function](numbers)), exact
            case Call(function=function, arguments=arguments) if function in FUNCTIONS:
                return self._rounded(partial(_called, function), arguments, point, here)
        raise NoValueError

    def strength(self, output: str, point: Sequence[float]) -> float:
        """Return the largest activation among the rules of an output, as kernels compute it."""
        strengths = self._strengths(*point)
        several = strengths if isinstance(strengths, tuple) else (strengths,)
        return float(several[[o.name for o in self.system.outputs].index(output)])

    @cached_property
    def _strengths(self) -> Any:
        flat = plan(self.system)
        program = inference.largest_activations(flat)
        return scalar.compile_source(scalar.evaluation_source(program), program, self.inputs)

    def _inputs_of(self, name: str) -> list[str]:
        """Return the inputs of the system of an output of another one, `SYSTEM.OUTPUT`."""
        return self.compared[name.partition(".")[0]].inputs

    def _elsewhere(self, name: str, point: Sequence[float]) -> Fraction:
        """Return an output of another system at a point of its inputs."""
        system, _, output = name.partition(".")
        return _finite(self.compared[system].outputs(point)[output])

    def _rounded(
        self, function: Any, parts: Iterable[Expr], point: Sequence[float], here: Mapping[str, float]
    ) -> Value:
        return _finite(function(*self._floats(parts, point, here))), False

    def _floats(self, parts: Iterable[Expr], point: Sequence[float], here: Mapping[str, float]) -> list[float]:
        """Return the values of expressions as floats."""
        return [self._float(p, point, here) for p in parts]

    def _float(self, expr: Expr, point: Sequence[float], here: Mapping[str, float]) -> float:
        """Return the value of an expression as a float; a zero that a name stands for keeps its sign."""
        value = float(self.value(expr, point, here)[0])
        match expr:
            case Name(name=name) if value == 0.0 and name in self.inputs:
                return point[self.inputs.index(name)]
            case Name(name=name) if value == 0.0:
                return here.get(name, 0.0)
            case Negate(operand=operand) if value == 0.0:
                return -self._float(operand, point, here)
        return value

    def rounding(self, output: str) -> Fraction:
        """Return how far rounding may move differences of an output, `SYSTEM.OUTPUT` for one of another system."""
        other, _, name = output.rpartition(".")
        system = self.compared[other].system if other else self.system
        variable = system.output(name)
        ends = [abs(system.number(e)) for e in (variable.lower, variable.upper)]
        return Fraction(max(ends)) / (1 << 36)

    @cached_property
    def outputs_named(self) -> set[str]:
        """The outputs that claims may name: those of the system and `SYSTEM.OUTPUT`."""
        return {o.name for o in self.system.outputs} | compared_outputs(self.system)

    def broken_slope(self, slope: Slope, point: Sequence[float], far: float, error: Fraction) -> Witness | None:
        """Return a pair of points that breaks a word about slopes: a point, and one with another value of the input.

        Args:
            slope: The claim.
            point: The first point.
            far: The input at the second point.
            error: How far kernels may be off; a claim that is broken by less may be broken by rounding only.
        """
        k = self.inputs.index(slope.input)
        first, second = list(point), list(point)
        second[k] = far
        if first[k] > far:
            first, second = second, first
        a, b = (self.outputs(p)[slope.output] for p in (first, second))
        if math.isnan(a) or math.isnan(b) or first == second:
            return None
        rise = Fraction(b) - Fraction(a)
        if slope.word == "lipschitz":
            run = Fraction(second[k]) - Fraction(first[k])
            broken = abs(rise) - Fraction(slope.limit) * run > slope.tolerance + 2 * error
        else:
            broken = (-rise if slope.word == "increasing" else rise) > slope.tolerance + 2 * error
        if not broken:
            return None
        points = [dict(zip(self.inputs, p, strict=True)) for p in (first, second)]
        sides = [(f"{slope.output} at {slope.input} = {p[k]:.9g}", v) for p, v in ((first, a), (second, b))]
        return Witness(points[0], tuple(sides), points[1])


def _called(function: str, *values: float) -> float:
    return evaluate(Call(function, tuple(Number(x) for x in values)), {})


def _finite(value: float) -> Fraction:
    if not math.isfinite(value):
        raise NoValueError
    return Fraction(value)


def _combined(op: str, a: Value, b: Value) -> Value:
    exact = a[1] and b[1]
    match op:
        case "+":
            return a[0] + b[0], exact
        case "-":
            return a[0] - b[0], exact
        case "*":
            return a[0] * b[0], exact
    if not b[0]:
        raise NoValueError
    return a[0] / b[0], exact
