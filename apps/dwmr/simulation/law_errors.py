"""Errors that the step of a control law in Python raises: the period, the robot and the line.

Compiled code names none of them. The periods are computed once more from what was before them, one at a time, and the
one in which the error comes with the step in Python.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from dwmr.control.laws.python_law import reported
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import TrackingError
from dwmr.simulation import loop
from dwmr.simulation.periods import Periods
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError


class LawError(DiagnosticError):
    """Raised when the step of a control law raises an error.

    Attributes:
        period: Number of the control period; those before it are recorded.
        robot: Number of the robot.
    """

    def __init__(self, diagnostic: Diagnostic, period: int, robot: int) -> None:
        super().__init__([diagnostic])
        self.period, self.robot = period, robot


class _WorkingMemory:
    """A copy of what the loop changes from one period to the next; records are left out, which it only writes.

    Args:
        periods: Those of the run.
    """

    def __init__(self, periods: Periods) -> None:
        parts = (periods.memory, periods.guard and periods.guard[1], periods.vehicles)
        self._kept = [(array, array.copy()) for part in parts for array in _arrays(part)]

    def restore(self) -> None:
        """Write the copy back."""
        for array, copy in self._kept:
            array[...] = copy


def _arrays(part: Any) -> Iterator[FloatArray]:
    """Yield the arrays of a named tuple, and of those in it."""
    if isinstance(part, np.ndarray):
        yield part
    elif isinstance(part, tuple):
        for name, one in zip(getattr(part, "_fields", ()), part, strict=True):
            if name != "record":
                yield from _arrays(one)


def decide(periods: Periods, first: int, last: int) -> tuple[int, int, int]:
    """Compute the periods from `first` up to but not including `last`, see `Periods.compute`.

    Raises:
        LawError: When the law raises an error; the periods before are recorded.
        DiagnosticError: When the law cannot be compiled into the loop.
    """
    obstacles, noise = periods.given(first, last)
    if not isinstance(periods.simulation.module, ModuleType):  # text raises no errors
        return periods.compute(first, last, obstacles, noise)
    before = _WorkingMemory(periods)
    try:
        return periods.compute(first, last, obstacles, noise)
    except DiagnosticError:
        before.restore()
        for k in range(first, last):
            now = obstacles[k - first : k - first + 2] if len(obstacles) > 1 else obstacles
            before = _WorkingMemory(periods)
            try:
                periods.compute(k, k + 1, now, noise[k - first : k - first + 1])
            except DiagnosticError as error:
                raise _in_python(periods, k, now, before, error) from None
        raise  # the law does not raise it again, or was not run


def _in_python(
    periods: Periods, period: int, obstacles: FloatArray, start: _WorkingMemory, compiled: DiagnosticError
) -> LawError:
    """Return what a law raises in a period as Python, with its line; as compiled code where that is another error."""
    module, memory = periods.simulation.module, periods.memory
    seen, slip = memory.seen.copy(), memory.slip.copy()
    start.restore()
    memory.slip[...] = slip  # what the robots measure before the law is asked
    if memory.seen is not memory.plant:
        memory.seen[...] = seen
    step, asked = getattr(module.step, "py_func", module.step), list[TrackingError]()

    def kept(error: TrackingError, *others: Any) -> Any:
        asked.append(error)
        return step(error, *others)

    (diagnostic,) = compiled.diagnostics
    try:
        with (
            reported(periods.simulation.name, Path(str(module.__file__)), "run"),
            np.errstate(divide="raise", invalid="raise"),
        ):
            getattr(loop.decide, "py_func", loop.decide)(
                period, periods.path, kept, periods.kernels, periods.world, memory, obstacles[0], obstacles[-1],
                periods.record, periods.law_record, periods.guard, periods.vehicles,
            )  # fmt: skip
    except DiagnosticError as python:
        (found,), kinds = python.diagnostics, (type(compiled.__cause__), type(python.__cause__))
        if kinds == (ZeroDivisionError, FloatingPointError):  # numbers of arrays have errors of their own
            diagnostic = replace(diagnostic, span=found.span)
        elif kinds[0] is kinds[1]:
            diagnostic = found
    robot, error = len(asked) - 1, asked[-1]
    seen_by_law = ", ".join(f"{name} = {value:.6g}" for name, value in zip(error._fields, error, strict=True))
    there = f"there, of robot {list(periods.simulation.scenario.robots)[robot]}: {seen_by_law}"
    return LawError(replace(diagnostic, facts=(*diagnostic.facts, there)), period, robot)
