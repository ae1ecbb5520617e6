"""Sample times of a loop: its step, the periods of its controllers, the number of its samples."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import evaluate, span_of
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.settings import block_params

#: Sample times are multiples of the step, and durations, up to this part of a step.
ALIGNED: Final = 1e-6


def sample_times(loop: Loop) -> tuple[float, dict[str, int]]:
    """Return the time between two samples [s], and every how many of them each controller runs, by name of its block.

    Raises:
        DiagnosticError: Where nothing says how often, or a period is no multiple of the step.
    """
    periods = dict(_periods(loop))
    if loop.step is None and not periods:
        message = f"loop '{loop.name}' has no sample time"
        help_text = "add one to its 'run' line, such as: run 10 s step 10 ms"
        raise DiagnosticError([Diagnostic("FZ702", message, loop.span, help=help_text)])
    step = min(periods.values()) if loop.step is None else evaluate(loop.step, loop.param_values.values)
    every = {i.name: 1 for i in loop.instances if i.controller in {c.name for c in loop.controllers}}
    mistakes = []
    for name, period in periods.items():
        count = period / step
        every[name] = max(round(count), 1)
        if abs(count - every[name]) > ALIGNED * every[name]:
            instance = next(i for i in loop.instances if i.name == name)
            message = f"block '{name}' runs every {period:g} s, which is no multiple of the step of {step:g} s"
            help_text = f"write a step that divides all periods, such as: step {_divisor(periods.values()):g} s"
            span = instance.span if loop.step is None or period > step else span_of(loop.step)
            mistakes.append(Diagnostic("FZ702", message, span, help=help_text))
    if mistakes:
        raise DiagnosticError(mistakes)
    return step, every


def _periods(loop: Loop) -> Iterator[tuple[str, float]]:
    """Yield the blocks of controllers that have a period, with it [s]."""
    controllers = {c.name: c for c in loop.controllers}
    for instance in loop.instances:
        controller = controllers.get(instance.controller)
        if controller is not None and controller.period is not None:
            yield instance.name, evaluate(controller.period, block_params(loop, instance))


def _divisor(periods: Iterable[float]) -> float:
    """Return the largest time that divides some periods, up to microseconds."""
    return math.gcd(*(max(round(p * 1e6), 1) for p in periods)) / 1e6


def samples_of(loop: Loop) -> int:
    """Return how many samples a run has.

    Raises:
        DiagnosticError: For sample times that do not fit together.
    """
    return samples_at(loop, sample_times(loop)[0])


def samples_at(loop: Loop, step: float) -> int:
    """Return how many samples a run has, one each `step` seconds."""
    return math.floor(evaluate(loop.duration, loop.param_values.values) / step + ALIGNED) + 1
