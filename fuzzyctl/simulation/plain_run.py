"""A run in generated Python, for browsers: what `simulate` computes, but for noise.

Signals take no numpy; tables over time, measures and requirements take the part of it that `studio.arrays` has.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.expr import Expr, Name, evaluate
from fuzzyctl.kernels.compile import operations
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.dead_times import dead_times
from fuzzyctl.simulation.equations import LoopEquations, with_calls
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.judgement import Judgement, Requirement
from fuzzyctl.simulation.runge_kutta import LoopPrograms, interpreted, printed, programs, refused
from fuzzyctl.simulation.signals import Noise, Table

#: Most operations of a run: CPython takes about a second for them, in a browser a few.
MOST: Final = 30_000_000


class PlainRunError(FuzzyctlError):
    """A loop cannot be run without numpy; the message names the reason."""


@dataclass(frozen=True)
class PlainRun:
    """One run of a loop.

    Args:
        loop: The loop.
        t: Times of the samples [s].
        signals: All signals by name, a number for each sample; `#0` and so on are operands of measures.
        substeps: Steps of integration between two samples.
        stopped: Why it ended early; empty for a run to its end.
        has_noise: Whether there is noise, which is drawn by another generator than that of numpy.
        operations: How much was computed.
    """

    loop: Loop
    t: list[float]
    signals: Mapping[str, list[float]]
    substeps: int
    stopped: str
    has_noise: bool
    operations: int

    def signal(self, expr: Expr) -> list[float]:
        """Return a signal, an operand of a measure, or a constant: a number for each sample."""
        judged = Judgement(self.loop).signals
        if expr in judged:
            return self.signals[f"#{judged.index(expr)}"]
        if isinstance(expr, Name) and expr.name in self.signals:
            return self.signals[expr.name]
        return [evaluate(expr, self.loop.param_values.values)] * len(self.t)

    @cached_property
    def measures(self) -> dict[str, float]:
        """The measures by name, of the samples up to the stop if the run was stopped; NaN for one without a value."""
        import numpy as np

        return Judgement(self.loop).measures(np.array(self.t), lambda e: np.array(self.signal(e)), {})

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """Whether each requirement holds; none does in a run that was stopped."""
        import numpy as np

        judgement, times = Judgement(self.loop), np.array(self.t)
        signal, stopped = lambda e: np.array(self.signal(e)), bool(self.stopped)
        return judgement.requirements(self.measures, times, signal, {}, stopped=stopped)


def plain_run(loop: Loop, most: int = MOST, *, record_calls: bool = False) -> PlainRun:
    """Simulate a loop by generated Python, with RK4.

    Args:
        loop: A well-formed loop.
        most: Most operations.
        record_calls: Whether the inputs of systems that blocks call are among the signals.

    Raises:
        PlainRunError: For plants in Python, FMUs, and a run that takes more operations.
        DiagnosticError: For a loop that cannot be run, or a table that cannot be read.
    """
    equations = loop_equations(loop, Judgement(loop).signals)
    for external in equations.externals:
        raise PlainRunError(f"plant '{external.plant.name}' is {'in Python' if external.plant.python else 'an FMU'}")
    equations = with_calls(equations) if record_calls else equations
    written = programs(equations)
    delayed = dead_times(equations, 1)
    substeps = delayed.steps
    cost = operations(written.sample) + 4 * substeps * operations(written.derivative)
    if cost * equations.samples > most:
        raise PlainRunError(f"the run takes {cost * equations.samples:.2g} operations, more than {most:.2g}")
    columns = _given(equations, loop)
    x, c = [s.start for s in equations.plant_states], [s.start for s in equations.states] * 2
    count, width = equations.samples, len(equations.signals)
    record, lags = [0.0] * (count * width), ([0.0] * delayed.size, delayed.integers, delayed.weights)
    kernel = interpreted(*printed(equations, written))
    code = kernel(0, count, count, substeps, equations.step, x, c, [], columns, record, *lags)
    done, stopped = (count, "") if code < 0 else _stopped(code, equations, written)
    signals = {name: record[k : done * width : width] for k, name in enumerate(equations.signals)}
    ended = _first_without_value(loop, signals, done)
    if ended is not None:
        done, name = ended
        stopped = f"'{name}' has no finite value at t = {done * equations.step:.6g} s"
        signals = {n: values[:done] for n, values in signals.items()}
    times = [k * equations.step for k in range(done)]
    has_noise = any(isinstance(one, Noise) for one in equations.given.values())
    return PlainRun(loop, times, signals, substeps, stopped, has_noise, cost * count)


def _given(equations: LoopEquations, loop: Loop) -> list[float]:
    """Return the columns of noise and tables, sample by sample."""
    columns: list[list[float]] = []
    for one in equations.given.values():
        if isinstance(one, Noise):
            drawn = random.Random(one.seed)
            columns.append([drawn.gauss(0.0, one.sigma) for _ in range(equations.samples)])
        else:
            columns += _lines(one, equations, Path(loop.path).parent)
    return [value for row in zip(*columns, strict=True) for value in row]


def _lines(table: Table, equations: LoopEquations, folder: Path) -> list[list[float]]:
    import numpy as np

    from fuzzyctl.simulation.columns import lines_of

    times = np.array([k * equations.step for k in range(equations.samples)])
    return [column.tolist() for column in lines_of(table, times, folder)]


def _stopped(code: int, equations: LoopEquations, written: LoopPrograms) -> tuple[int, str]:
    """Return how many samples there are, and the mistake at the next."""
    states, outputs = equations.plant_states, refused(written)
    sample, kind = divmod(code, max(len(states) + len(outputs), 1))
    at = f"at t = {sample * equations.step:.6g} s"
    if kind >= len(states):
        return sample, f"no rule fires for output '{outputs[kind - len(states)]}' {at}"
    return sample, f"state '{states[kind].name}' left its range {at}"


def _first_without_value(loop: Loop, signals: Mapping[str, list[float]], done: int) -> tuple[int, str] | None:
    """Return the first sample at which an output of a plant is not finite, with its name."""
    plants = {p.name: p.results for p in loop.plants}
    names = [f"{i.name}.{r.name}" for i in loop.instances for r in plants.get(i.controller, ())]
    return next(((k, n) for k in range(done) for n in names if not math.isfinite(signals[n][k])), None)
