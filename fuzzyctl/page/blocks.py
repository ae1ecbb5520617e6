"""Controllers and runs of loops as the plain data of a page."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fuzzyctl.codegen.comments import ends
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.expr import Expr, Name
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.kernels.plan.expansion import STARTED
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.loop_params import params_of

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdicts
    from fuzzyctl.diagnostics.source import Span
    from fuzzyctl.model.controller import Signal
    from fuzzyctl.simulation.members import Tube
    from fuzzyctl.simulation.panels import Panel
    from fuzzyctl.simulation.plain_run import PlainRun
    from fuzzyctl.simulation.run import Run

#: Most samples of a run that a page holds, most numbers of all its runs, fewest samples.
SAMPLES: Final = 400
NUMBERS: Final = 15_000
FEWEST: Final = 100
#: Share of the height of a panel below which a peak is not seen: half a pixel.
SEEN: Final = 0.005


class Drawn(NamedTuple):
    """A line before it is thinned: its values at all samples, and the height of its panel in the same unit."""

    values: Sequence[float]
    height: float


class Samples(NamedTuple):
    """The samples that a page holds of a run, all increasing.

    Args:
        every: How far those that the slider of the time reaches are apart.
        shown: These, and the last one.
        peaks: For each line the samples between these that its picture needs.
    """

    every: int
    shown: list[int]
    peaks: list[list[int]]


def samples(count: int, drawn: Sequence[Drawn], followed: int, runs: int) -> Samples:
    """Return which samples a page holds, fewer where lines have many peaks.

    Args:
        count: How many samples the run has.
        drawn: Its lines.
        followed: How many signals are not drawn, but held at the times of the slider; the time is one.
        runs: How many runs the page has.
    """
    most, rows = NUMBERS // runs, len(drawn) + followed
    widest = max(1, math.ceil(count / FEWEST))
    every = max(1, min(math.ceil(count / min(SAMPLES, max(1, most // rows))), widest))
    while True:
        indices = sorted({*range(0, count, every), *range(count)[-1:]})
        extremes = [peaks(line, indices) for line in drawn]
        size = len(indices) * rows + 2 * sum(map(len, extremes))
        if size <= most or every == widest:
            return Samples(every, indices, extremes)
        every = min(math.ceil(every * size / most), widest)


def peaks(line: Drawn, indices: Sequence[int]) -> list[int]:
    """Return the samples of the least and the greatest value of each stretch where they lie beyond its ends.

    So a picture has the band that chattering fills, and lines that are smooth cost nothing.

    Args:
        line: The line.
        indices: The samples at which stretches end, increasing.
    """
    values, seen, extremes = line.values, SEEN * line.height, set()
    for start, stop in pairwise(indices):
        inside = values[start + 1 : stop]
        if not inside:
            continue
        least, greatest = min(inside), max(inside)
        low, high = sorted((values[start], values[stop]))
        for value, beyond in ((least, low - least), (greatest, greatest - high)):
            if math.isfinite(value) and not beyond <= seen:
                extremes.add(start + 1 + inside.index(value))
    return sorted(extremes)


#: Most stretches of a band.
STRETCHES: Final = 200
#: Digits of values, and of times, by which marks find their samples.
DIGITS: Final = 6
TIME_DIGITS: Final = 9
#: The state of an operator: its blocks, and its name.
_OPERATOR: Final = re.compile(r"(?:(.+)\.)?\w+#\d+(?:\.(\w+))?")


def controller_data(unit: Unit) -> dict[str, Any]:
    """Return the data of a controller, without proofs, which take numpy."""
    controller = unit.controller
    layout = JavaScriptLayout(unit)
    return {
        "kind": "controller",
        "name": controller.name,
        "title": controller.title,
        "source": controller.citation,
        "facts": _params(controller.param_values.values),
        "inputs": [_signal(unit, s) for s in controller.inputs],
        "outputs": [_signal(unit, r) for r in controller.results],
        "state": layout.has_state,
        "states": _states(unit, layout),
        "period": unit.equations.period,
        "members": {s.name: name for (name, _), s in zip(layout.members, unit.slots, strict=True) if name != s.name},
        "bounds": None,
        "verdicts": [],
    }


def _signal(unit: Unit, signal: Signal) -> dict[str, Any]:
    """Return the data of an input or output; None for an end that its range does not have."""
    lower, upper = (end if math.isfinite(end) else None for end in ends(unit, signal.bounds))
    return {"name": signal.name, "label": signal.label, "unit": signal.unit, "lower": lower, "upper": upper}


def _states(unit: Unit, layout: JavaScriptLayout) -> dict[str, str]:
    """Return for each member of the state its label, or the operator or call that keeps it, as it is written."""
    spans = {s.name: s.span for s in unit.equations.states}
    called = {s for e in unit.equations.body if isinstance(e, Evaluation) for s in e.states}
    labels = {s.name: f"{s.label or s.name}{f' [{s.unit}]' if s.unit else ''}" for s in unit.controller.states}
    labels[STARTED] = "whether a step was made"
    states = {}
    for (member, _), slot in zip(layout.members, unit.slots, strict=True):
        span, parts = spans.get(slot.name) or spans.get(f"{slot.name}.0"), _OPERATOR.fullmatch(slot.name)
        if slot.name not in labels and span is not None:
            if slot.name in called:
                labels[slot.name] = _kept_by_call(slot.name, _written(span))
            elif parts is not None:
                block, detail = parts.groups()
                written = f"{block}: {_written(span)}" if block else _written(span)
                labels[slot.name] = f"{written}, {detail}" if detail else written
        states[member] = labels.get(slot.name, slot.name)
    return states


def _written(span: Span) -> str:
    """Return a call as it is written, on one line."""
    text = " ".join(span.text.split()).replace("( ", "(")
    return text + ")" * (text.count("(") - text.count(")"))  # which the span of a call leaves out


def _kept_by_call(state: str, call: str) -> str:
    """Return the state of a call of a system: the consequent of a rule, or the last value of an output."""
    owner, _, slot = state.rpartition(".")
    output, _, number = slot.removesuffix("]").partition("[")
    block, _, system = owner.rpartition(".")
    start = f"{owner} = " if "#" not in system else f"{block}: " if block else ""
    return f"{start}{call}, {f'adaptive consequent {number} of {output}' if number else f'last value of {output}'}"


def loop_data(run: Run, runs: int = 1, proofs: Verdicts | None = None) -> dict[str, Any]:
    """Return the data of a run: its signals, of many samples each n-th and peaks, measures and requirements.

    Args:
        run: The run.
        runs: How many runs the page shows.
        proofs: Verdicts on claims about all members of the family; None without such claims.
    """
    data = _loop_data(
        run.loop, run.t.tolist(), run.positions, lambda e: run.signal(e).tolist(), run.solver, run.params, runs
    )
    judged, tube = _judged(run), None if proofs is None else proofs.tube
    if proofs is not None:
        from fuzzyctl.page.systems import verdict_row  # proofs, which the start of the studio does without

        # A proof is about this run, too.
        of_run = {r.text: r.verdict for r in run.requirements}
        rows = [verdict_row(v)[:3] for v in proofs]
        for row in rows:
            row[2] += f"; {of_run[row[1]]}" if row[0] == "undecided" and row[1] in of_run else ""
        judged["verdicts"][len(run.loop.requirements) :] = rows
    if tube is not None:
        for panel in data["panels"]:
            _add_band(panel, tube)
    return {**data, **judged, "stopped": run.stopped.message if run.stopped is not None else ""}


def _add_band(panel: dict[str, Any], tube: Tube) -> None:
    """Give a panel the bounds of its signal, over at most `STRETCHES` stretches, and axes that hold them."""
    import numpy as np

    from fuzzyctl.plot import limits

    if panel["name"] not in tube.bounds:
        return
    low, high = (side.tolist() for side in tube.bounds[panel["name"]])
    every = math.ceil(len(low) / STRETCHES)
    starts = range(0, len(low), every or 1)
    lows, highs = [min(low[k : k + every]) for k in starts], [max(high[k : k + every]) for k in starts]
    if not lows or not all(map(math.isfinite, (*lows, *highs))):
        return
    ends = [tube.begin[0], *(tube.end[min(k + every, len(low)) - 1] for k in starts)]
    lines = [panel, panel["reference"] or {"values": [], "peaks": [[], []]}]
    seen = [v for line in lines for v in (*line["values"], *line["peaks"][1]) if v is not None]
    panel["whole"] = limits.whole(np.array([*seen, *lows, *highs]))
    panel["y"] = panel["y"] if panel["note"] else panel["whole"]
    panel["tube"] = {"t": _shortened(ends, TIME_DIGITS), "low": _shortened(lows), "high": _shortened(highs)}


def _measure_text(value: float, unit: str) -> str:
    if not math.isfinite(value):
        return "no value (NaN)" if math.isnan(value) else "infinite" if value > 0.0 else "-infinite"
    return f"{value:.6g}{f' {unit}' if unit else ''}"


def _judged(run: Run | PlainRun) -> dict[str, Any]:
    """Return the measures of a run, and which requirements it meets."""
    values = run.measures
    measures = [[m.label or m.name, _measure_text(values[m.name], m.unit)] for m in run.loop.measures]
    return {"measures": measures, "verdicts": [[r.verdict, r.text, ""] for r in run.requirements]}


def _limits(t: list[float], panel: Panel, signal: Callable[[Expr], list[float]]) -> dict[str, Any]:
    """Return the ends of the axis of a panel, which peaks do not crush."""
    import numpy as np

    from fuzzyctl.plot import limits

    times = np.array(t)
    lines = [limits.Line(panel.label, times, np.array(signal(Name(panel.signal))))]
    if panel.reference is not None:
        lines.append(limits.Line("reference", times, np.array(signal(panel.reference))))
    bounds = limits.of(lines)
    return {"y": bounds.shown, "whole": bounds.whole, "note": bounds.note}


class _Call(NamedTuple):
    """A call of a block: its name, the calling block, its signals, and the samples for which they are held."""

    block: str
    call: str
    signals: list[str]
    held: int


def _calls(loop: Loop, recorded: Collection[str]) -> Iterator[_Call]:
    """Yield the calls whose inputs are recorded."""
    from fuzzyctl.simulation.sample_times import sample_times

    controllers, samples = {c.name: c for c in loop.controllers}, sample_times(loop)[1]
    for instance in loop.instances:
        controller = controllers.get(instance.controller)
        if controller is None:
            continue
        calls = [(controller.name, instance.name, instance.name, [i.name for i in controller.inputs])]
        for system in {s.name: s for s in controller.all_systems}.values():
            title, names = f"{instance.name}.{system.name}", [i.name for i in system.inputs]
            calls.append((system.name, instance.name, title, names))
            call = 2
            while f"{title}.{call}.{names[0]}" in recorded:
                calls.append((system.name, f"{instance.name}, call {call}", f"{title}.{call}", names))
                call += 1
        for name, label, prefix, names in calls:
            signals = [f"{prefix}.{n}" for n in names]
            if set(signals) <= set(recorded):
                yield _Call(name, label, signals, samples[instance.name])


def plain_loop_data(run: PlainRun) -> dict[str, Any]:
    """Return the data of a run without numpy, with a note on the differences."""
    loop = run.loop
    data = _loop_data(loop, run.t, run.signals, run.signal, "RK4", {})
    note = "The noise is drawn by another generator than that of 'fuzzyctl simulate', so numbers differ."
    return data | _judged(run) | {"stopped": run.stopped, "note": note if run.has_noise else ""}


def refused_loop_data(loop: Loop, why: str) -> dict[str, Any]:
    """Return the data of a loop that is not run, with the reason."""
    return {"kind": "loop", "name": loop.name, "title": loop.title, "source": loop.citation, "refused": why}


def _loop_data(
    loop: Loop,
    t: list[float],
    recorded: Collection[str],
    signal: Callable[[Expr], list[float]],
    solver: str,
    params: Mapping[str, float],
    runs: int = 1,
) -> dict[str, Any]:
    """Return the data of any run.

    Args:
        loop: The loop.
        t: Times of the samples [s].
        recorded: Names of its signals.
        signal: Returns a signal, a number for each sample.
        solver: What integrated the plants.
        params: Values of free params.
        runs: How many runs the page shows.
    """
    from fuzzyctl.simulation.panels import panels

    drawn, calls = panels(loop, recorded), list(_calls(loop, recorded))
    limits = [_limits(t, p, signal) for p in drawn]
    lines = [
        Drawn(signal(expr), bounds["y"][1] - bounds["y"][0])
        for p, bounds in zip(drawn, limits, strict=True)
        for expr in (Name(p.signal), p.reference)
        if expr is not None
    ]
    every, indices, peaks = samples(len(t), lines, 1 + sum(len(c.signals) for c in calls), runs)
    rows = iter([_line(t, line.values, indices, bounds) for line, bounds in zip(lines, peaks, strict=True)])
    kinds = {c.name: "controller" for c in loop.controllers} | {p.name: "plant" for p in loop.plants}
    return {
        "kind": "loop",
        "name": loop.name,
        "title": loop.title,
        "source": loop.citation,
        "facts": [
            ["blocks", ", ".join(f"{name} ({kind})" for name, kind in kinds.items())],
            ["solver", solver],
            ["samples", f"{len(t):,}{f', 1 of {every} and peaks between are shown' if every > 1 else ''}"],
            *_params(params_of(loop) | dict(params)),
        ],
        "t": _shortened([t[k] for k in indices], TIME_DIGITS),
        "panels": [
            {
                "name": p.signal,
                "label": p.label,
                "held": p.held,
                **next(rows),
                "reference": next(rows) if p.reference is not None else None,
                **bounds,
            }
            for p, bounds in zip(drawn, limits, strict=True)
        ],
        "inputs": [_inputs(c, signal, indices) for c in calls],
    }


def _inputs(call: _Call, signal: Callable[[Expr], list[float]], indices: list[int]) -> dict[str, Any]:
    """Return the inputs of a call of a system at the samples that are shown, each held for the period of its block."""
    signals = [signal(Name(name)) for name in call.signals]
    values = [_shortened([column[k - k % call.held] for k in indices]) for column in signals]
    return {"block": call.block, "call": call.call, "values": values}


def _line(t: Sequence[float], values: Sequence[float], indices: list[int], peaks: list[int]) -> dict[str, Any]:
    """Return a line: its values at the samples that are shown, times and values of peaks between."""
    at = _shortened([t[k] for k in peaks], TIME_DIGITS)
    return {"values": _shortened([values[k] for k in indices]), "peaks": [at, _shortened([values[k] for k in peaks])]}


def _shortened(values: list[float], digits: int = DIGITS) -> list[float | None]:
    """Return numbers as pictures need them; None for one that is not finite."""
    return [float(f"{v:.{digits}g}") if math.isfinite(v) else None for v in values]


def _params(values: Mapping[str, float]) -> list[list[str]]:
    return [[name, f"{value:.9g}"] for name, value in values.items()]
