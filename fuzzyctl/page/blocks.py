"""What a page shows of controllers and of runs of loops, as plain data."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.unit import StepUnit, ends
from fuzzyctl.expr import Expr, Name
from fuzzyctl.model.loop import Loop
from fuzzyctl.page.proofs import controller_proofs
from fuzzyctl.simulation.settings import params_of

if TYPE_CHECKING:
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.simulation.panels import Panel
    from fuzzyctl.simulation.plain_run import PlainRun
    from fuzzyctl.simulation.run import Run

#: Most samples of a run that a page holds, and digits of each.
SAMPLES: Final = 600
DIGITS: Final = 6
#: Where the slider of a signal without an end of its range ends.
REACH: Final = 10.0


def controller_data(unit: StepUnit, *, proofs: bool = False) -> dict[str, Any]:
    """Return what is shown of a controller.

    Args:
        unit: The controller.
        proofs: Whether bounds and verdicts are among it, which take numpy.
    """
    controller = unit.controller
    inputs = []
    for signal in controller.inputs:
        lower, upper = ends(unit, signal.bounds)
        low = lower if math.isfinite(lower) else min(-REACH, upper - REACH)
        high = upper if math.isfinite(upper) else max(REACH, lower + REACH)
        inputs.append({"name": signal.name, "label": signal.label, "unit": signal.unit, "lower": low, "upper": high})
    layout = StepJavaScriptLayout(unit)
    return {
        "kind": "controller",
        "name": controller.name,
        "title": controller.title,
        "source": controller.citation,
        "facts": _params(controller.param_values.values),
        "inputs": inputs,
        "outputs": [{"name": r.name, "label": r.label, "unit": r.unit} for r in controller.results],
        "state": layout.has_state,
        "period": unit.equations.period,
        **(controller_proofs(controller) if proofs else {"bounds": None, "verdicts": []}),
    }


def loop_data(run: Run) -> dict[str, Any]:
    """Return what is shown of a run: its signals, every n-th sample where there are many, measures and requirements."""
    from fuzzyctl.simulation.panels import panels

    found = _loop_data(
        run.loop, run.t.tolist(), run.positions, lambda e: run.signal(e).tolist(), run.solver, run.params
    )
    for shown, panel in zip(found["panels"], panels(run.loop, run.positions), strict=True):
        shown |= _limits(run, panel)
    return {
        **found,
        **_judged(run),
        "stopped": run.stopped.message if run.stopped is not None else "",
    }


def _judged(run: Run | PlainRun) -> dict[str, Any]:
    """Return the measures of a run, and which requirements it meets."""
    values = run.measures
    measures = [[m.label or m.name, f"{values[m.name]:.6g}{f' {m.unit}' if m.unit else ''}"] for m in run.loop.measures]
    return {"measures": measures, "verdicts": [["met" if r.holds else "not met", r.text, ""] for r in run.requirements]}


def _limits(run: Run, panel: Panel) -> dict[str, Any]:
    """Return the ends of the axis of a panel, which peaks do not crush."""
    from fuzzyctl.page import limits  # numpy

    lines = [limits.Line(panel.label, run.t, run[panel.signal])]
    if panel.reference is not None:
        lines.append(limits.Line("reference", run.t, run.signal(panel.reference)))
    found = limits.of(lines)
    return {"y": found.shown, "whole": found.whole, "note": found.note}


def _inputs(
    loop: Loop, recorded: Collection[str], signal: Callable[[Expr], list[float]], shown: list[int]
) -> Iterator[dict[str, Any]]:
    """Yield for each controller and system what its inputs are at the samples shown; of several calls the first."""
    from fuzzyctl.simulation.sample_times import sample_times

    controllers, samples, found = {c.name: c for c in loop.controllers}, sample_times(loop)[1], set()
    for instance in loop.instances:
        controller = controllers.get(instance.controller)
        if controller is None:
            continue
        rows = [k - k % samples[instance.name] for k in shown]
        known = [(controller.name, "", [i.name for i in controller.inputs])]
        known += [(s.name, f"{s.name}.", [i.name for i in s.inputs]) for s in _systems(controller)]
        for name, prefix, names in known:
            signals = [f"{instance.name}.{prefix}{n}" for n in names]
            if name not in found and set(signals) <= set(recorded):
                found.add(name)
                own = [signal(Name(s)) for s in signals]
                yield {"block": name, "values": [_shortened([values[k] for k in rows]) for values in own]}


def _systems(controller: Controller) -> Iterator[FuzzySystem]:
    """Yield the systems that a controller and those inside it call."""
    yield from controller.systems
    for inner in controller.controllers:
        yield from _systems(inner)


def plain_loop_data(run: PlainRun) -> dict[str, Any]:
    """Return what is shown of a run without numpy; a note says what differs."""
    loop = run.loop
    found = _loop_data(loop, run.t, run.signals, run.signal, "RK4", {})
    note = "The noise is drawn by another generator than that of 'fuzzyctl simulate', so numbers differ."
    return found | _judged(run) | {"stopped": run.stopped, "note": note if run.has_noise else ""}


def refused_loop_data(loop: Loop, why: str) -> dict[str, Any]:
    """Return what is shown of a loop that is not run: why."""
    return {"kind": "loop", "name": loop.name, "title": loop.title, "source": loop.citation, "refused": why}


def _loop_data(
    loop: Loop,
    t: list[float],
    recorded: Collection[str],
    signal: Callable[[Expr], list[float]],
    solver: str,
    params: Mapping[str, float],
) -> dict[str, Any]:
    """Return what is shown of any run.

    Args:
        loop: What was run.
        t: Times of the samples [s].
        recorded: Names of its signals.
        signal: Returns a signal, a number for each sample.
        solver: What integrated the plants.
        params: Values of free params.
    """
    from fuzzyctl.simulation.panels import panels

    every = max(1, math.ceil(len(t) / SAMPLES))
    shown = sorted({*range(0, len(t), every), *range(len(t))[-1:]})
    kinds = {c.name: "controller" for c in loop.controllers} | {p.name: "plant" for p in loop.plants}

    def values(expr: Expr) -> list[float | None]:
        own = signal(expr)
        return _shortened([own[k] for k in shown])

    return {
        "kind": "loop",
        "name": loop.name,
        "title": loop.title,
        "source": loop.citation,
        "facts": [
            ["blocks", ", ".join(f"{name} ({kind})" for name, kind in kinds.items())],
            ["solver", solver],
            ["samples", f"{len(t):,}{f', each {every}th is shown' if every > 1 else ''}"],
            *_params(params_of(loop) | dict(params)),
        ],
        "t": _shortened([t[k] for k in shown]),
        "panels": [
            {
                "name": p.signal,
                "label": p.label,
                "held": p.held,
                "values": values(Name(p.signal)),
                "reference": values(p.reference) if p.reference is not None else None,
            }
            for p in panels(loop, recorded)
        ],
        "inputs": list(_inputs(loop, recorded, signal, shown)),
    }


def _shortened(values: list[float]) -> list[float | None]:
    """Return numbers as pictures need them; None for one that is not finite."""
    return [float(f"{v:.{DIGITS}g}") if math.isfinite(v) else None for v in values]


def _params(values: Mapping[str, float]) -> list[list[str]]:
    return [[name, f"{value:.9g}"] for name, value in values.items()]
