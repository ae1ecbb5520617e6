"""Reachable sets of a loop: the controllers at their samples, the plants between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.flow import Flow, NoTubeError
from fuzzyctl.analysis.reach.forms import Form, Value, as_form
from fuzzyctl.analysis.reach.series import Nodes, Series
from fuzzyctl.analysis.reach.sets import modes, reduced, with_symbols
from fuzzyctl.analysis.reach.surfaces import SystemSurface
from fuzzyctl.expr import Expr, Name
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.model.loop import TIME
from fuzzyctl.simulation.equations import LoopEquations, reached
from fuzzyctl.simulation.expansion import free_name


@dataclass
class Step:
    """The set over a part of a step.

    Args:
        time: At its begin [s].
        length: Its length [s].
        over: Values of the claims' expressions over it.
        begin: The same at its begin.
        states: Forms of the plants' states over it.
    """

    time: float
    length: float
    over: list[Value]
    begin: list[Value]
    states: list[Form]


class ReachableSets:
    """Encloses all runs of a loop.

    Args:
        equations: The loop, with the expressions that claims compare as its signals `#0`, `#1` and so on.
        count: How many of these there are.
        given: Columns that are known before the run, shape (samples, columns).
    """

    def __init__(self, equations: LoopEquations, count: int, given: Form) -> None:
        self.equations, self.given = equations, given
        self.free = [free_name(n) for n in equations.free]
        surfaces: dict[object, SystemSurface] = {}
        tables = {}
        for item in equations.body:
            if isinstance(item, Evaluation):
                surfaces.setdefault(item.system, SystemSurface(item.system))
                tables[id(item)] = surfaces[item.system]
        plant = [s.name for s in equations.plant_states]
        memory = [s.name for s in equations.states]
        columns = [n for names in equations.given for n in names]
        claims = [equations.signals[f"#{k}"] for k in range(count)]
        derivatives: list[Expr] = [s.derivative for s in equations.plant_states]
        between, self.held = reached(equations, [*derivatives, *claims])
        shared = [TIME, *plant]
        fixed = [*self.held, *self.free, *(c for c in columns if c not in self.held), *memory]
        self.flow = Flow(Nodes([*shared, *fixed], between, derivatives, tables), len(plant))
        self.claims = Nodes([*shared, *fixed], between, claims, tables)
        inputs = [*shared, *memory, *self.free, *columns, *equations.rates]
        held: list[Expr] = [Name(n) for n in self.held]
        self.sample = Nodes(inputs, equations.body, [*held, *equations.updates], tables)
        self.plant, self.memory, self.columns = plant, memory, columns

    def run(
        self, x: list[Form], m: list[Form], free: list[Value], kept: int, substeps: int = 1, stop: Callable[[], bool] | None = None
    ) -> Iterator[Step]:
        """Yield the sets over the steps of the run.

        Args:
            x, m: Forms of the plants' and the controllers' states at the begin, shape (boxes, 2 + symbols).
            free: Values of the free params.
            kept: How many of the first symbols are never reduced.
            substeps: Steps between two samples to begin with.
            stop: Returns whether to stop.

        Raises:
            DomainError, NoTubeError: If no enclosure is known.
        """
        equations, step = self.equations, self.equations.step
        before: list[Form] = []
        for k in range(equations.samples):
            time = k * step
            flags = [1.0 if k % n == 0 else 0.0 for n in equations.rates.values()]
            columns = [float(v) for v in self.given[k]] if self.columns else []
            results = Series(self.sample, [time, *x, *m, *free, *columns, *flags]).extend()
            held, updates = results[: len(self.held)], results[len(self.held) :]
            other = [v for n, v in zip(self.columns, columns, strict=True) if n not in self.held]
            constants: list[Value] = [*held, *free, *other, *m]
            begin = Series(self.claims, [time, *x, *constants]).extend()
            if k + 1 == equations.samples:
                yield Step(time, 0.0, begin, begin, x)
                return
            count, part = substeps, 0
            while part < count:
                length = step / count
                try:
                    end, over = self.flow.advance(time + part * length, length, x, constants)
                except NoTubeError:
                    if count >= 256:
                        raise
                    count, part = 2 * count, 2 * part
                    continue
                clock = np.array([[time + (part + 0.5) * length, 0.5 * length * 1e-9]])
                clock = np.concatenate([clock, np.zeros((1, x[0].shape[-1] - 2)), [[0.5 * length]]], -1) if x else clock
                values = Series(self.claims, [clock, *over, *constants]).extend()
                yield Step(time + part * length, length, values, begin, over)
                x, part = end, part + 1
            m = [as_form(u) for u in updates]
            rows = with_symbols([*(as_form(a) for a in x), *(np.broadcast_to(a, (x[0].shape[0], a.shape[-1])) for a in m)])
            rows = reduced(rows, kept, modes(before, rows) if before else None)
            before = rows
            x, m = rows[: len(x)], rows[len(x) :]


def start_of(values: Sequence[tuple[float, float]], boxes: int = 1) -> list[Form]:
    """Return forms of ranges, each with a symbol of its own."""
    width = len(values)
    results = []
    for k, (low, high) in enumerate(values):
        a = np.zeros((boxes, 2 + width))
        a[:, 0], a[:, 2 + k] = 0.5 * (low + high), 0.5 * (high - low)
        results.append(a)
    return results


__all__ = ["ReachableSets", "Step", "forms", "start_of"]
