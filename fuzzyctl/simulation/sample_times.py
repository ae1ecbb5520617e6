"""Sample times of a loop: its step, the periods of its controllers, the number of its samples."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Call, evaluate, span_of, walk
from fuzzyctl.model.checks.blocks import MOST_SAMPLES
from fuzzyctl.model.controller import Definition, Instance, Result
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Loop
from fuzzyctl.model.plant import PLANT_FUNCTIONS, Plant
from fuzzyctl.simulation.loop_params import block_params

#: Most numbers that a run records: 0.8 gigabytes.
MOST_NUMBERS: Final = 100_000_000
#: Most steps of integration between two samples, and of a run, that dead times may demand.
MOST_BETWEEN: Final = 10_000
MOST_STEPS: Final = 20_000_000
#: Most numbers that dead times keep.
MOST_KEPT: Final = 20_000_000
#: Sample times are multiples of the step, and durations, up to this part of a step.
ALIGNED: Final = 1e-6


def sample_times(loop: Loop) -> tuple[float, dict[str, int]]:
    """Return the time between two samples [s], and every how many of them each controller runs, by name of its block.

    Raises:
        DiagnosticError: If the loop has neither step nor period, or a period is not a multiple of the step.
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
            message = f"block '{name}' runs every {period:g} s, which is not a multiple of the step of {step:g} s"
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


def samples_at(loop: Loop, step: float) -> int:
    """Return how many samples a run has, one each `step` seconds."""
    return math.floor(evaluate(loop.duration, loop.param_values.values) / step + ALIGNED) + 1


def measures_without_samples(loop: Loop) -> Iterator[Diagnostic]:
    """Warn of measures between whose begin and end there are fewer than two samples."""
    if loop.measures and (loop.step is not None or any(_periods(loop))):
        step = sample_times(loop)[0]
        count, params = samples_at(loop, step), loop.param_values.values
        for m in loop.measures:
            for call in walk(m.value):
                if isinstance(call, Call) and call.function in MEASURES:
                    window = bound(MEASURES[call.function], call)
                    begin, end = (evaluate(window[n], params) for n in ("begin", "end"))
                    first = max(math.ceil(begin / step - ALIGNED), 0)
                    last = count - 1 if math.isinf(end) else min(math.floor(end / step + ALIGNED), count - 1)
                    if last - first < 1:
                        message = f"measure '{m.name}' has no value: it takes two samples or more"
                        until = "on" if math.isinf(end) else f"to {end:g} s"
                        facts = (
                            f"{call.function}(...) takes those from {begin:g} s {until}",
                            f"the run has samples from 0 s to {(count - 1) * step:g} s, one each {step:g} s",
                        )
                        yield Diagnostic("FZ214", message, call.span, severity="warning", facts=facts)


def require_room(loop: Loop, signals: int) -> None:
    """Refuse a run of too many samples or numbers, and dead times that do not fit its step.

    Args:
        loop: The loop.
        signals: How many signals are recorded.

    Raises:
        DiagnosticError: For such a run, and for sample times that do not fit together.
    """
    step = sample_times(loop)[0]
    samples = samples_at(loop, step)
    if samples - 1 > MOST_SAMPLES:
        excess = f"the run has {samples - 1:,} samples", f"at most {MOST_SAMPLES:,}"
    elif samples * signals > MOST_NUMBERS:
        excess = (
            f"the run records {samples * signals:,} numbers, {signals} signals at {samples:,} samples",
            f"at most {MOST_NUMBERS:,}",
        )
    else:
        return _require_dead_times(loop, step)
    message, most = excess
    help_text = f"expected {most}: make the run shorter, or its step longer"
    raise DiagnosticError([Diagnostic("FZ703", message, span_of(loop.duration) or loop.span, help=help_text)])


def _require_dead_times(loop: Loop, step: float) -> None:
    """Refuse dead times that are too short, or too long, for the step of a loop."""
    samples, numbers, plants = samples_at(loop, step), 0.0, {p.name: p for p in loop.plants}
    mistakes: dict[str, Diagnostic] = {}
    for instance in loop.instances:
        for call, time in _dead_times(loop, instance, plants.get(instance.controller)):
            count, numbers = math.ceil(step / time * (1.0 - 1e-9)), numbers + 4.0 * time / step
            message = help_text = ""
            if count > MOST_BETWEEN or (count > 1 and count * samples > MOST_STEPS):
                message = f"a dead time of {time:g} s takes {count:,} steps of integration a sample, "
                message += f"{count * samples:,} in all"
                help_text = f"expected at most {MOST_BETWEEN:,} a sample and {MOST_STEPS:,} in all: "
                help_text += "leave the dead time out, or make the run or its step shorter"
            elif numbers > MOST_KEPT:
                message = f"a dead time of {time:g} s keeps {4.0 * time / step:.3g} numbers at steps of {step:g} s"
                help_text = f"expected at most {MOST_KEPT:,} for all dead times: make the step longer"
            if message:
                mistakes.setdefault(message, Diagnostic("FZ703", message, call.span or instance.span, help=help_text))
    if mistakes:
        raise DiagnosticError(list(mistakes.values()))


def _dead_times(loop: Loop, instance: Instance, plant: Plant | None) -> Iterator[tuple[Call, float]]:
    """Yield the calls of `delay` in a plant of a loop with positive dead times [s]."""
    items: tuple[Definition | Result, ...] = (
        () if plant is None else (*plant.definitions, *plant.results, *plant.derivatives)
    )
    calls = dict.fromkeys(e for i in items for e in walk(i.value) if isinstance(e, Call) and e.function == "delay")
    params = block_params(loop, instance) if calls else {}
    for call in calls:
        time = evaluate(bound(PLANT_FUNCTIONS["delay"], call)["time"], params)
        if 0.0 < time < math.inf:
            yield call, time
