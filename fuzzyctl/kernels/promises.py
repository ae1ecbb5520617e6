"""Errors at points where no rule fires: refusals of compiled code, and outputs without `else` that are NaN."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import Expr, Name, names_in, replace_names
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import CallPlan, Plan
from fuzzyctl.kernels.program import scalar as python_backend
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.program.scalar import point_text, scalar_function

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


class Refusals:
    """Points that a program refuses, as exceptions that name the output and the point.

    Args:
        program: The program.
        names: Of its arguments.
    """

    def __init__(self, program: Program, names: Sequence[str]) -> None:
        refusals = [s for s in program.body if isinstance(s, Refuse)]
        self._outputs = {s.message: s.output for s in refusals}
        self._kinds, self._names = [s.output for s in refusals], tuple(names)

    def translated(self, error: ArithmeticError, point: Sequence[Any]) -> ArithmeticError:
        """Return the exception for an error of compiled code at a point; another error is returned unchanged."""
        output = self._outputs.get(str(error))
        return error if output is None else NoRuleFiresError(output, point_text(self._names, point))

    def place(self, code: int) -> tuple[int, str]:
        """Return the index of the point and the output of the code that a compiled loop returned for a refusal."""
        point, kind = divmod(code, len(self._kinds))
        return point, self._kinds[kind]


class Promises:
    """The promises of the outputs of a system.

    Args:
        plan: The system.
        known: Whether it is known beforehand that all of them are kept.
    """

    def __init__(self, plan: Plan, *, known: bool) -> None:
        self._plan = plan
        self._outputs = () if known else tuple(k for k, o in enumerate(plan.outputs) if o.otherwise is None)

    def check(self, arguments: Sequence[Any], result: float | tuple[float, ...]) -> None:
        """Check the result of one point.

        Args:
            arguments: The inputs, and the state if there is one.
            result: Result of the function.

        Raises:
            NoRuleFiresError: Where an output without `else` is NaN though nothing that it reads is.
        """
        plan = self._plan
        values = result if isinstance(result, tuple) else (result,)
        point = [float(a) for a in arguments[: len(plan.inputs)]]
        # What is held may be NaN at first: an output that reads it is NaN, too, and others promise what they promised.
        consequents = arguments[-1] if plan.states and len(arguments) > len(point) else ()
        if any(x != x for x in point) or any(c != c for c in consequents) or self._lacks_let(point):
            return
        for k in self._outputs:
            if values[k] != values[k] and all(values[r] == values[r] for r in plan.outputs[k].reads):
                raise NoRuleFiresError(plan.outputs[k].name, self.text_of(point))

    def check_block(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Check the results of many points; the first one that breaks a promise is named.

        Args:
            points: Shape (n, inputs).
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs).

        Raises:
            NoRuleFiresError: As `check` does.
        """
        import numpy as np

        # The least number is NaN if any is, and takes no memory; only then is it worth looking closer.
        if not self._outputs or not np.isnan(np.min(results, initial=np.inf)):
            return
        missing, bad = np.isnan(results), np.zeros(len(points), dtype=bool)
        for k in self._outputs:
            bad |= missing[:, k] & ~missing[:, list(self._plan.outputs[k].reads)].any(axis=1)
        bad &= ~np.isnan(points).any(axis=1)
        if states is not None:
            bad &= ~np.isnan(states[:, : len(self._plan.states)]).any(axis=1)
        for row in np.flatnonzero(bad):
            self.check(points[row].tolist(), tuple(results[row].tolist()))

    def check_run(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        """Check the results of points along time, from the state before the first one, if no block of them was."""

    def _lacks_let(self, point: Sequence[float]) -> bool:
        """Return whether a let has no value at a point, so that no output has one."""
        values = known_at(self._plan, point) if self._plan.lets else {}
        return any(values[let.name] != values[let.name] for let in self._plan.lets)

    def text_of(self, point: Sequence[float]) -> str:
        """Return a point for people."""
        return point_text([i.name for i in self._plan.inputs], point)


def known_at(plan: Plan, point: Sequence[float]) -> dict[str, float]:
    """Return the inputs as consequents see them, and the lets, by name."""
    values = {
        i.name: x if i.extrapolate else min(max(x, i.lower), i.upper) for i, x in zip(plan.inputs, point, strict=True)
    }
    for let in plan.lets:
        for call in let.calls:
            values[call.name] = _called(call, [value_of(a, values) for a in call.arguments])
        values[let.name] = value_of(let.value, values)
    return values


def value_of(expr: Expr, values: Mapping[str, float]) -> float:
    """Return the value of an expression over known names."""
    names = list(dict.fromkeys(n.name for n in names_in(expr)))
    # Names of calls are no names of Python.
    places = {name: f"x{k}" for k, name in enumerate(names)}
    function = scalar_function(replace_names(expr, {n: Name(place) for n, place in places.items()}))
    return float(function(**{places[n]: values[n] for n in names}))


def _called(call: CallPlan, arguments: Sequence[float]) -> float:
    """Return an output of another system, NaN where it has none."""
    names = [i.name for i in call.system.inputs]
    program = inference.evaluation(call.system)
    function = python_backend.compile_source(python_backend.evaluation_source(program), program, names)
    try:
        outputs = function(*arguments)
    except NoRuleFiresError:
        return math.nan
    return float(outputs[call.output] if isinstance(outputs, tuple) else outputs)
