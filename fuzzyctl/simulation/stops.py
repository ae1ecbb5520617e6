"""Why a run ends early, and what in a record has no value, as diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import to_text
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.equations import LARGEST, PlantState
from fuzzyctl.simulation.settings import blocks_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.simulation.run import Run

    FloatArray = npt.NDArray[np.float64]

_KEEP_DOMAINS: Final = "keep arguments of sqrt and log in their domain with max(x, 0), and divisors away from 0"


def interrupted(loop: Loop, time: float) -> Diagnostic:
    """Return the diagnostic of a run that was interrupted."""
    return Diagnostic("FZ707", f"the run was interrupted at t = {time:.6g} s", file=loop.path)


def left(
    state: PlantState, value: float, time: float, loop: Loop, positions: Mapping[str, int], past: FloatArray
) -> Diagnostic:
    """Return the diagnostic of a state that has left its range, or has no finite value.

    Args:
        state: The state.
        value: Its value.
        time: When that is [s].
        loop: The loop.
        positions: Columns of the record by name.
        past: The record of all samples before, shape (samples, signals).
    """
    if not math.isfinite(value) and len(past) and not np.isfinite(past[-1]).all():
        return _made_before(state, value, time, loop, positions, past)
    unit = f" {state.unit}" if state.unit else ""
    at = f"at t = {time:.6g} s"
    facts = [f"one sample before it was {past[-1, positions[state.name]]:.6g}{unit}"] if len(past) else []
    if not math.isfinite(value) or abs(value) >= LARGEST:
        message = f"state '{state.name}' is {_what(value)} {at}"
        help_text = f"use a shorter step or more substeps; {_KEEP_DOMAINS}"
    else:
        ends = f"{'(' if state.without_low or state.low == -math.inf else '['}{state.low:g}, "
        ends += f"{state.high:g}{')' if state.without_high or state.high == math.inf else ']'}"
        # What leaves the range by a rounding only is shown with all its digits.
        shown = f"{value:.6g}"
        shown = f"{value!r}" if state.holds(float(shown)) else shown
        message = f"state '{state.name}' left its range {at}: {shown}{unit} is outside of {ends}"
        help_text = "limit it in the plant, or declare a wider range"
    return Diagnostic("FZ701", message, state.span, facts=tuple(facts), help=help_text)


def _made_before(
    state: PlantState, value: float, time: float, loop: Loop, positions: Mapping[str, int], past: FloatArray
) -> Diagnostic:
    """Return the diagnostic of the signal that is not finite at the last sample, which a state has its value from."""
    name = _origin(loop, positions, past[-1], np.isfinite)
    before = time * (len(past) - 1) / len(past)
    message = f"'{name}' is {_what(past[-1, positions[name]])} at t = {before:.6g} s"
    facts = (f"one sample later state '{state.name}' is {_what(value)}",)
    notes = (Note(state.span, "the state is declared here"),) if state.span is not None else ()
    return Diagnostic("FZ701", message, _span_of_signal(loop, name), facts=facts, help=_KEEP_DOMAINS, notes=notes)


def first_without_value(record: FloatArray, columns: list[int]) -> tuple[int, int] | None:
    """Return the first row and column, of some columns of a record, with a number that is not finite.

    Args:
        record: All signals, shape (samples, signals).
        columns: Positions of the signals that count.
    """
    if math.isfinite(record.sum()):  # which is quickly known of a run where all is well
        return None
    bad = np.argwhere(~np.isfinite(record[:, columns]))
    return (int(bad[0, 0]), columns[bad[0, 1]]) if len(bad) else None


def without_value(loop: Loop, output: str, positions: Mapping[str, int], row: FloatArray, time: float) -> Diagnostic:
    """Return the diagnostic of an output of a plant that has no finite value.

    Args:
        loop: The loop.
        output: `BLOCK.OUTPUT`.
        positions: Columns of the record by name.
        row: All signals at that sample, shape (signals,).
        time: When that is [s].
    """
    block, _, own = output.partition(".")
    plant = blocks_of(loop)[next(i.controller for i in loop.instances if i.name == block)]
    result = next(r for r in plant.results if r.name == own)
    message = f"output '{output}' is {_what(row[positions[output]])} at t = {time:.6g} s"
    names = [f"{block}.{s.name}" for s in (*plant.inputs, *plant.states)]
    known = [f"{n} = {row[positions[n]]:.6g}" for n in names if math.isfinite(row[positions[n]])]
    facts = (f"there {', '.join(known)}",) if known else ()
    return Diagnostic("FZ701", message, result.span, facts=facts, help=_KEEP_DOMAINS)


def signals_without_value(run: Run) -> list[Diagnostic]:
    """Return a warning for the first signal of a run, up to its end, that is not a number at some sample."""
    bad = np.isnan(run.record).any(axis=1)
    if run.stopped is not None or not bad.any():
        return []
    first = int(np.argmax(bad))
    name = _origin(run.loop, run.positions, run.record[first], lambda row: ~np.isnan(row))
    if name.startswith("#"):
        name = to_text(run.judgement.signals[int(name[1:])])
    message = f"'{name}' is not a number at t = {run.t[first]:.6g} s"
    facts = [f"signals have no value at {int(bad.sum()):,} of {len(run):,} samples"]
    lost = [n for n, value in run.measures.items() if math.isnan(value)]
    if lost:
        facts.append(f"measures without a value: {', '.join(lost)}")
    span = _span_of_signal(run.loop, name)
    return [Diagnostic("FZ708", message, span, severity="warning", facts=tuple(facts), help=_KEEP_DOMAINS)]


def _span_of_signal(loop: Loop, name: str) -> Span | None:
    spans = {d.name: d.span for d in loop.definitions} | {i.name: i.span for i in loop.instances}
    return spans.get(name) or spans.get(name.partition(".")[0]) or loop.span


def _what(value: float) -> str:
    return "not a number" if math.isnan(value) else "infinite"


def _origin(
    loop: Loop, positions: Mapping[str, int], row: FloatArray, has_value: Callable[[FloatArray], npt.NDArray[np.bool_]]
) -> str:
    """Return which signal of a sample lost its value: an output of a block whose inputs have one, else the first."""
    kept = has_value(row)
    lost = [name for name, k in positions.items() if not kept[k]]
    for instance in loop.instances:
        block = blocks_of(loop)[instance.controller]
        inputs, outputs = ([f"{instance.name}.{s.name}" for s in own] for own in (block.inputs, block.results))
        made = [name for name in outputs if name in lost]
        if made and not any(name in lost for name in inputs):
            return made[0]
    return lost[0]
