"""Values of the free numbers of a step, checked against bounds and by the systems that they belong to."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from typing import Any

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.expr import Compare, Expr, ExprError, Logic, Name, Where, evaluate, walk
from fuzzyctl.kernels.free_values import FreeValues, changed_values, ends_of, require_bounds
from fuzzyctl.kernels.plan.equations import Equation, Equations, Evaluation
from fuzzyctl.kernels.plan.expansion import equations_of, with_values
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.model.checks.terms import has_computed_params, outside_ranges
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.shared_params import with_shared


class StepValues:
    """Takes and checks values of the free numbers of a controller.

    Args:
        controller: The controller.
        equations: What it expands to.
    """

    def __init__(self, controller: Controller, equations: Equations) -> None:
        self._controller, self._equations = controller, equations
        self._start = [s.start for s in equations.states]
        self._bounds = {p.name: p for p in controller.params if p.name in equations.free and p.bounds is not None}
        self._others = has_computed_params(controller)
        known = set(equations.free)
        self._params: list[Equation] = []
        for item in equations.body:
            if isinstance(item, Equation) and _is_arithmetic(item.value, known):
                self._params.append(item)
                known.add(item.name)
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
        own = {n: ends_of(p.bounds, numbers) for n, p in self._bounds.items() if p.bounds is not None}
        for call, values in self._systems:
            names = [f"{call.system.name}.{n}" for n, _ in call.free]
            own |= dict(zip(names, values.bounds, strict=True))
        return [own.get(name, (-math.inf, math.inf)) for name in self._equations.free]

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

    def _changed(self, known: Mapping[str, float]) -> Controller:
        own = {n: v for n, v in known.items() if n in self._controller.param_values.values}
        return with_shared(with_values(self._controller, own), own)

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


def _is_arithmetic(expr: Expr, known: Container[str]) -> bool:
    """Return whether an expression computes with known names alone, without conditions."""
    return all(
        part.name in known if isinstance(part, Name) else not isinstance(part, Where | Compare | Logic)
        for part in walk(expr)
    )
