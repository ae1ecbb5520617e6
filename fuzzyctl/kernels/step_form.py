"""Steps of controllers: their programs over an explicit state, their form, and values of their free numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.expr import Compare, Expr, ExprError, Logic, Name, Number, Where, evaluate, replace_names, walk
from fuzzyctl.kernels.algorithms.select import COMPILED, algorithm_of
from fuzzyctl.kernels.backends.arguments import float_array, input_number
from fuzzyctl.kernels.forms import Form, Promises
from fuzzyctl.kernels.free_values import (
    FreeValues,
    changed_values,
    ends_of,
    free_program,
    require_bounds,
    with_named_state,
)
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.inference import evaluation_with_rates
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.kernels.plan.equations import DT, Equation, Equations, Evaluation
from fuzzyctl.kernels.plan.expansion import equations_of, with_values
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, STATE, Assign, Item, Program
from fuzzyctl.kernels.program.traversal import embed, uses
from fuzzyctl.model.checks.terms import has_computed_params, outside_ranges
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.shared_params import with_shared

if TYPE_CHECKING:
    from fuzzyctl.annotations import FloatArray
    from fuzzyctl.model.system import FuzzySystem

#: Meaning of the time since the step before.
_TIME: Final = "> 0 s and finite"


class StepPromises(Promises):
    """The promises of the outputs of systems that a step calls; they are looked at where an output is NaN.

    Args:
        equations: The step, with systems that raise where no rule fires.
        names: Of the arguments of its programs.
    """

    def __init__(self, equations: Equations, names: Sequence[str]) -> None:
        self._equations, self._names = equations, names

    @cached_property
    def _step(self) -> Callable[..., None]:
        program = step_program(self._equations)
        return scalar.compile_source(scalar.storing_source(program), program, self._names)

    def check_block(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Check the results of many steps side by side; the first one that breaks a promise is named.

        Args:
            points: Shape (n, arguments).
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs) or more.

        Raises:
            NoRuleFiresError: Where no rule fires for an output without `else`.
        """
        for row in self._missing(points, results):
            self._replay(points[row : row + 1], None if states is None else states[row])

    def check_run(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        """Check the results of steps along time, from the state before the first one; see `check_block`."""
        missing = self._missing(points, results)
        if len(missing):
            self._replay(points[: missing[-1] + 1], state)

    def _replay(self, points: FloatArray, state: FloatArray | None) -> None:
        """Make some steps along time, and raise `NoRuleFiresError` at the first one that breaks a promise."""
        values = [] if state is None else state.tolist()
        outputs = len(self._equations.outputs)
        row = [0.0] * (outputs + len(values))
        for point in points.tolist():
            self._step(*point, *((values,) if values else ()), row)
            values = row[outputs:]

    def _missing(self, points: FloatArray, results: FloatArray) -> Sequence[int]:
        """Return the rows with an output that is NaN though no argument is."""
        import numpy as np

        least = np.minimum.reduce(results, axis=None, initial=np.inf)  # NaN if any is; all is faster than a part
        if least == least:
            return []
        outputs = results[:, : len(self._equations.outputs)]
        return np.flatnonzero(np.isnan(outputs).any(axis=1) & ~np.isnan(points).any(axis=1)).tolist()


def _strict(equations: Equations) -> Equations:
    """Return equations whose systems raise where no rule fires for an output without `else`."""

    def strict(system: FuzzySystem) -> FuzzySystem:
        outputs = tuple(replace(o, otherwise="error") if o.otherwise is None else o for o in system.outputs)
        return replace(system, outputs=outputs) if outputs != system.outputs else system

    body = tuple(replace(e, system=strict(e.system)) if isinstance(e, Evaluation) else e for e in equations.body)
    return replace(equations, body=body)


class StepForm(Form):
    """A controller: equations that give the outputs and the next state.

    Args:
        equations: Equations of the step.
        algorithm: How systems are computed, see `compile`.
        values: Takes the values of free numbers, which are the last states; None for a controller without.
        checked: Whether outputs of its systems without `else` that have no value are errors, as they are in systems.
    """

    moves = True

    def __init__(
        self, equations: Equations, algorithm: str = "auto", values: StepValues | None = None, *, checked: bool = False
    ) -> None:
        outputs, state_names = [name for name, _ in equations.outputs], [s.name for s in equations.states]
        super().__init__(equations.inputs, outputs, state_names, equations.free)
        self.period = equations.period
        self.needs_time = self.period is None and equations.reads_time
        if self.period is None:
            self.argument_names = (*self.input_names, DT)
        self._equations, self._algorithm, self._values = equations, algorithm, values
        self._program = step_program(equations, algorithm)
        strict = _strict(equations) if checked else equations
        self.promises = StepPromises(strict, self.argument_names) if strict != equations else None
        self._checked = checked

    def __reduce__(self) -> tuple[Any, ...]:
        maker = partial(StepForm, checked=self._checked)
        return maker, (self._equations, self._algorithm, self._values)

    def point(self, backend: str) -> Program:
        """Return the program for one point."""
        return self._program

    def named(self) -> tuple[Program, tuple[str, ...]]:
        """Return the program of all rules with the state as its last arguments, and their names."""

        def point(call: Evaluation) -> Program:
            # Of the programs of a system, the one with all rules has a derivative.
            is_plain = not (call.states or call.free)
            return inference.evaluation(plan(call.system)) if is_plain else system_program(call, "rules")

        return with_named_state(named_step(self._equations, point)[0])

    def start(self, changed: Mapping[str, Any]) -> Sequence[float] | FloatArray:
        """Return the state before the first step, with some free numbers changed."""
        return super().start(changed) if self._values is None else self._values.state(changed)

    def _start(self) -> Sequence[float]:
        return [s.start for s in self._equations.states]

    @property
    def free_bounds(self) -> Sequence[tuple[float, float]]:
        """The ends of the range of each free number."""
        return () if self._values is None else self._values.bounds

    def times(self, dt: Any) -> list[float]:
        """Return the time of one step, checked, as an argument of the programs, or no argument."""
        if self.period is not None:
            if dt is not None:
                raise ArgumentError(f"the controller has a period of {self.period:g} s, so that 'dt' is not given")
            return []
        if dt is None and not self.needs_time:
            return [1.0]  # any time makes the same step
        if dt is None:
            raise ArgumentError("'dt' is missing: the controller has no 'every' line")
        time = dt if type(dt) is float else input_number(DT, dt)
        if not 0.0 < time < math.inf:
            raise ValueOutOfBoundsError(DT, dt, _TIME)
        return [time]

    def with_times(self, points: Any, dt: Any) -> Any:
        """Return points with the times of the steps, checked, as a last column."""
        import numpy as np

        if self.period is not None:
            self.times(dt)
            return points
        shape = points.shape[:-1]
        if dt is None or type(dt) is float:  # the usual case
            times: Any = self.times(dt)[0]
        else:
            times = float_array(dt, DT)
            try:
                shape = np.broadcast_shapes(shape, times.shape)
            except ValueError:
                raise ArgumentError(f"'dt' of shape {times.shape} does not fit points of shape {shape}") from None
            is_time = (times > 0) & (times < math.inf)
            if not np.all(is_time):
                raise ValueOutOfBoundsError(DT, float(times[~is_time].flat[0]), _TIME)
        whole = np.empty((*shape, points.shape[-1] + 1))
        whole[..., :-1], whole[..., -1] = points, times
        return whole


def step_program(equations: Equations, algorithm: str = "auto") -> Program:
    """Write the program of a step.

    Args:
        equations: Equations of the step.
        algorithm: How systems are computed, see `select.ALGORITHMS`.

    Its arguments are the inputs, and dt where the controller has no period; its results are the outputs, then the next
    state. Where an input is NaN the outputs are NaN, and the state stays as it is.
    """
    return _tested_once(named_step(equations, lambda call: system_program(call, algorithm))[0])


def _tested_once(program: Program) -> Program:
    """Name the test for NaN that all results share: numba would compile each copy of it."""
    tests = {r.condition for r in program.results if isinstance(r, Where)}
    if len(program.results) == 1 or len(tests) != 1:
        return program
    body = (*program.body, Assign("lacks", numeric(*tests)))
    is_missing = Compare("==", Name("lacks"), Number(1.0))
    results = [Where(is_missing, r.then, r.otherwise) for r in program.results if isinstance(r, Where)]
    return replace(program, body=body, results=tuple(results))


def system_program(call: Evaluation, algorithm: str) -> Program:
    """Write the program of a system that a step calls: the outputs, then the rates of a system with states."""
    if call.states:
        return evaluation_with_rates(plan(call.system), most_pairs=COMPILED)
    if call.free:
        program = free_program(free_plan(call.system, [name for name, _ in call.free]))
        free = program.arguments[len(call.arguments) :]
        if set(free) & set(uses(program)):
            return program
        # Where only ranges depend on free numbers, all algorithms are open.
        point = algorithm_of(plan(call.system), algorithm).point
        return replace(point, arguments=(*point.arguments, *free))
    return algorithm_of(plan(call.system), algorithm).point


def named_step(equations: Equations, point: Callable[[Evaluation], Program]) -> tuple[Program, dict[str, Expr]]:
    """Write the program of a step, and return the values of the names of the equations.

    Args:
        equations: Equations of the step.
        point: Writes the program of a system that the step calls, as `system_program` does.
    """
    builder = Builder()
    arguments = [Name(f"x{k}") for k in range(len(equations.inputs) + (equations.period is None))]
    env: dict[str, Expr] = dict(zip(equations.inputs, arguments, strict=False))
    if equations.period is None:
        env[DT] = arguments[-1]
    states = [Item(STATE, k) for k in range(len(equations.states))]
    env |= {s.name: item for s, item in zip(equations.states, states, strict=True)}
    for item in equations.body:
        if isinstance(item, Evaluation):
            inputs = (*item.arguments, *(value for _, value in item.free))
            values = [builder.let(numeric(replace_names(a, env))) for a in inputs]
            before = [env[s] for s in item.states]
            dt = env[DT] if equations.period is None else Number(equations.period)
            outcome = evaluated(builder, plan(item.system), point(item), values, before, dt)
            env |= dict(zip(item.defined, outcome, strict=True))
        else:
            env[item.name] = builder.let(numeric(replace_names(item.value, env)))
    outputs = [env[value.name] if isinstance(value, Name) else value for _, value in equations.outputs]
    updates = [builder.let(numeric(replace_names(u, env))) for u in equations.updates]
    results = [*outputs, *updates]
    if arguments:
        lacks = any_nan(arguments)
        missing: list[Expr] = [*([NAN] * len(outputs)), *states]
        results = [Where(lacks, old, new) for old, new in zip(missing, results, strict=True)]
    return builder.program(arguments, results, state=len(states)), env


def evaluated(
    builder: Builder, system: Plan, program: Program, values: Sequence[Expr], before: Sequence[Expr], dt: Expr
) -> list[Expr]:
    """Write an evaluation of a system and return its outputs, then the next values of its states.

    A consequent that adapts moves by dt times its rate within the range of its output; an output that holds keeps its
    value. A state stays as it is where its rate or its output is NaN.
    """
    if not before:
        return embed(builder, program, values)
    (first, *_) = before
    assert isinstance(first, Item)
    assert isinstance(first.index, int)
    results = embed(builder, program, values, state=first.index)
    outputs, rates = results[: len(system.outputs)], results[len(system.outputs) :]
    following: list[Expr] = []
    for (o, _), old, rate in zip(system.states, before, rates, strict=False):
        moved = builder.let(old + dt * rate)
        following.append(clip(moved, system.outputs[o].lower, system.outputs[o].upper))
    following += [outputs[o] for o in system.held]
    states = [Where(any_nan([new]), old, new) for old, new in zip(before, map(builder.let, following), strict=True)]
    return [*outputs, *map(builder.let, states)]


def numeric(value: Expr) -> Expr:
    """Return a value, 1 or 0 for a condition."""
    return Where(value, Number(1.0), Number(0.0)) if isinstance(value, Compare | Logic) else value


class StepValues:
    """Takes and checks values of the free numbers of a controller.

    Args:
        controller: The controller.
        equations: Its equations.
    """

    def __init__(self, controller: Controller, equations: Equations) -> None:
        self._controller, self._equations = controller, equations
        self._start = [s.start for s in equations.states]
        self._bounds = {p.name: p for p in controller.params if p.name in equations.free and p.bounds is not None}
        self._others = has_computed_params(controller)
        free = set(equations.free)
        self._params: list[Equation] = []
        for item in equations.body:
            if isinstance(item, Equation) and _is_arithmetic(item.value, free):
                self._params.append(item)
                free.add(item.name)
        calls = [item for item in equations.body if isinstance(item, Evaluation) and item.free]
        self._systems = [
            (c, FreeValues(free_plan(c.system, [n for n, _ in c.free]), f"{c.system.name}.")) for c in calls
        ]

    def __reduce__(self) -> tuple[Any, ...]:
        """Make the values anew in another process: functions that were compiled stay behind."""
        return StepValues, (self._controller, self._equations)

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The ends of the range that each param declares; infinite for another number."""
        numbers = self._controller.param_values.values
        ends = {n: ends_of(p.bounds, numbers) for n, p in self._bounds.items() if p.bounds is not None}
        for call, values in self._systems:
            names = [f"{call.system.name}.{n}" for n, _ in call.free]
            ends |= dict(zip(names, values.bounds, strict=True))
        return [ends.get(name, (-math.inf, math.inf)) for name in self._equations.free]

    def state(self, changed: Mapping[str, Any]) -> list[float]:
        """Return the state before the first step.

        Args:
            changed: Values of free numbers by name; the others are those of the controller.

        Raises:
            UnknownNameError: For a name that is not free.
            ValueOutOfBoundsError: For values outside the bounds of their params, or that a system cannot have.
            ArgumentError: For values under which a param or a let has no value, such as a division by 0.
        """
        names, first = self._equations.free, len(self._start) - len(self._equations.free)
        values = changed_values(names, self._start[first:], changed).tolist()
        self._require(dict(zip(names, values, strict=True)))
        if not self._equations.starts_vary or not changed:
            return [*self._start[:first], *values]
        again = equations_of(self._changed(dict(zip(names, values, strict=True))))
        return [*(s.start for s in again.states), *values]

    def _changed(self, values: Mapping[str, float]) -> Controller:
        params = {n: v for n, v in values.items() if n in self._controller.param_values.values}
        return with_shared(with_values(self._controller, params), params)

    def _require(self, known: dict[str, float]) -> None:
        for name, value in known.items():
            if value - value != 0.0:
                raise ValueOutOfBoundsError(f"free number {name!r}", value, "a finite number")
        numbers = self._controller.param_values.values | known
        for name, param in self._bounds.items():
            assert param.bounds is not None
            require_bounds(name, known[name], param.bounds, numbers, param.unit)
        for o in outside_ranges(self._changed(known), {}) if self._others else ():
            raise ValueOutOfBoundsError(f"{o.what} under these free numbers", o.value, f"in {o.text}")
        for equation in self._params:
            try:
                known[equation.name] = evaluate(equation.value, known)
            except ExprError as error:
                message = f"'{equation.name}' has no value under these free numbers: {error.message}"
                raise ArgumentError(message) from None
        for call, values in self._systems:
            values.of([evaluate(value, known) for _, value in call.free])


def _is_arithmetic(expr: Expr, names: Container[str]) -> bool:
    """Return whether an expression computes with known names alone, without conditions."""
    return all(
        part.name in names if isinstance(part, Name) else not isinstance(part, Where | Compare | Logic)
        for part in walk(expr)
    )
