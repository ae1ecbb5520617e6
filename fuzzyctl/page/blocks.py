"""What a page shows of controllers and of runs of loops, as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.unit import StepUnit, ends
from fuzzyctl.page.proofs import controller_proofs
from fuzzyctl.simulation.settings import params_of

if TYPE_CHECKING:
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.plot.time_series import Panel
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
    from fuzzyctl.plot.time_series import panels  # numpy, which controllers do without

    every = max(1, math.ceil(len(run) / SAMPLES))
    shown = sorted({*range(0, len(run), every), *range(len(run))[-1:]})
    measures = run.measures
    kinds = {c.name: "controller" for c in run.loop.controllers} | {p.name: "plant" for p in run.loop.plants}
    return {
        "kind": "loop",
        "name": run.loop.name,
        "title": run.loop.title,
        "source": run.loop.citation,
        "facts": [
            ["blocks", ", ".join(f"{name} ({kind})" for name, kind in kinds.items())],
            ["solver", run.solver],
            ["samples", f"{len(run):,}{f', each {every}th is shown' if every > 1 else ''}"],
            *_params(params_of(run.loop) | dict(run.params)),
        ],
        "t": _shortened(run.t[shown]),
        "panels": [_panel(run, p, shown) for p in panels(run)],
        "inputs": list(_inputs(run, shown)),
        "measures": [
            [m.label or m.name, f"{measures[m.name]:.6g}{f' {m.unit}' if m.unit else ''}"] for m in run.loop.measures
        ],
        "verdicts": [["met" if r.holds else "not met", r.text, ""] for r in run.requirements],
        "stopped": run.stopped.message if run.stopped is not None else "",
    }


def _inputs(run: Run, shown: list[int]) -> Iterator[dict[str, Any]]:
    """Yield for each controller and system what its inputs are at the samples shown; of several calls the first."""
    from fuzzyctl.simulation.sample_times import sample_times

    controllers, samples, found = {c.name: c for c in run.loop.controllers}, sample_times(run.loop)[1], set()
    for instance in run.loop.instances:
        controller = controllers.get(instance.controller)
        if controller is None:
            continue
        rows = [k - k % samples[instance.name] for k in shown]
        known = [(controller.name, "", [i.name for i in controller.inputs])]
        known += [(s.name, f"{s.name}.", [i.name for i in s.inputs]) for s in _systems(controller)]
        for name, prefix, names in known:
            signals = [f"{instance.name}.{prefix}{n}" for n in names]
            if name not in found and set(signals) <= set(run.names):
                found.add(name)
                yield {"block": name, "values": [_shortened(run[s][rows]) for s in signals]}


def _systems(controller: Controller) -> Iterator[FuzzySystem]:
    """Yield the systems that a controller and those inside it call."""
    yield from controller.systems
    for inner in controller.controllers:
        yield from _systems(inner)


def _panel(run: Run, panel: Panel, shown: list[int]) -> dict[str, Any]:
    reference = _shortened(run.signal(panel.reference)[shown]) if panel.reference is not None else None
    values = _shortened(run[panel.signal][shown])
    return {"name": panel.signal, "label": panel.label, "held": panel.held, "values": values, "reference": reference}


def _shortened(values: Any) -> list[float | None]:
    """Return numbers as pictures need them; None for one that is not finite."""
    return [float(f"{v:.{DIGITS}g}") if math.isfinite(v) else None for v in values.tolist()]


def _params(values: Mapping[str, float]) -> list[list[str]]:
    return [[name, f"{value:.9g}"] for name, value in values.items()]
