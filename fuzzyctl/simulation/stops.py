"""Why a run ends early, and what in a record has no value, as diagnostics."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, names_in, span_of, to_text
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.equations import LARGEST, PlantState
from fuzzyctl.simulation.loop_params import blocks_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.plan.equations import KeptState
    from fuzzyctl.simulation.run import Run

    FloatArray = npt.NDArray[np.float64]

_KEEP_DOMAINS: Final = "keep arguments of sqrt and log in their domain with max(x, 0), and divisors away from 0"
_START: Final = "give it a finite start"
#: Most signals without a value that are named beside the first one.
_MOST_NOTES: Final = 3


def interrupted(loop: Loop, time: float) -> Diagnostic:
    """Return the diagnostic of a run that was interrupted."""
    return Diagnostic("FZ707", f"the run was interrupted at t = {time:.6g} s", file=loop.path)


def left(
    state: PlantState,
    value: float,
    time: float,
    loop: Loop,
    positions: Mapping[str, int],
    past: FloatArray,
    kept: Sequence[KeptState] = (),
) -> Diagnostic:
    """Return the diagnostic of a state that has left its range, or has no finite value.

    Args:
        state: The state.
        value: Its value.
        time: When that is [s].
        loop: The loop.
        positions: Columns of the record by name.
        past: The record of all samples before, shape (samples, signals).
        kept: States of controllers, whose starts may be infinite.
    """
    if not math.isfinite(value) and len(past) and not np.isfinite(past[-1]).all():
        return _made_before(state, value, time, loop, positions, past, kept)
    unit = f" {state.unit}" if state.unit else ""
    at = f"at t = {time:.6g} s"
    facts = [f"one sample before it was {past[-1, positions[state.name]]:.6g}{unit}"] if len(past) else []
    if not math.isfinite(value) or abs(value) >= LARGEST:
        message = f"state '{state.name}' is {_what(value)} {at}"
        help_text = f"use a shorter step or more substeps; {_KEEP_DOMAINS}" if len(past) else _START
    else:
        ends = f"{'(' if state.without_low or state.low == -math.inf else '['}{state.low:g}, "
        ends += f"{state.high:g}{')' if state.without_high or state.high == math.inf else ']'}"
        # A value that leaves the range by a rounding only is shown with all its digits.
        digits = f"{value:.6g}"
        digits = f"{value!r}" if state.holds(float(digits)) else digits
        message = f"state '{state.name}' left its range {at}: {digits}{unit} is outside of {ends}"
        help_text = "limit it in the plant, or declare a wider range"
    return Diagnostic(
        "FZ701", message, state.span or _span_of_signal(loop, state.name), facts=tuple(facts), help=help_text
    )


def _made_before(
    state: PlantState,
    value: float,
    time: float,
    loop: Loop,
    positions: Mapping[str, int],
    past: FloatArray,
    kept: Sequence[KeptState],
) -> Diagnostic:
    """Return the diagnostic of the signal that is not finite at the last sample, which a state has its value from."""
    name = _origins(loop, positions, ~np.isfinite(past[-1:]))[0][1]
    before = time * (len(past) - 1) / len(past)
    message = f"'{name}' is {_what(past[-1, positions[name]])} at t = {before:.6g} s"
    facts = (f"one sample later state '{state.name}' is {_what(value)}",)
    spans = [(state.span, "the state is declared here")]
    block = f"{name.partition('.')[0]}."
    starts = dict.fromkeys(k.span for k in kept if k.name.startswith(block) and not math.isfinite(k.start))
    spans += [(span, "what is kept here starts infinite") for span in starts]
    notes = tuple(Note(span, text) for span, text in spans if span is not None)
    help_text = _KEEP_DOMAINS
    if starts:  # which it may still have at a later sample
        help_text = _START if len(past) == 1 else f"give what is kept a finite start, or {_KEEP_DOMAINS}"
    return Diagnostic("FZ701", message, _span_of_signal(loop, name), facts=facts, help=help_text, notes=notes)


def first_without_value(record: FloatArray, columns: list[int]) -> tuple[int, int] | None:
    """Return the first row and column, of some columns of a record, with a number that is not finite.

    Args:
        record: All signals, shape (samples, signals).
        columns: Positions of the signals that count.
    """
    with np.errstate(invalid="ignore"):  # inf - inf
        total = record.sum()  # quickly computed, and finite where all is well
    if math.isfinite(total):
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
    block, _, short = output.partition(".")
    plant = blocks_of(loop)[next(i.controller for i in loop.instances if i.name == block)]
    result = next(r for r in plant.results if r.name == short)
    message = f"output '{output}' is {_what(row[positions[output]])} at t = {time:.6g} s"
    names = [f"{block}.{s.name}" for s in (*plant.inputs, *plant.states)]
    finite = [f"{n} = {row[positions[n]]:.6g}" for n in names if math.isfinite(row[positions[n]])]
    facts = (f"there {', '.join(finite)}",) if finite else ()
    return Diagnostic("FZ701", message, result.span or _span_of_signal(loop, output), facts=facts, help=_KEEP_DOMAINS)


def signals_without_value(run: Run) -> list[Diagnostic]:
    """Return a warning for the signals of a run, up to its end, that are not numbers at some sample.

    It is that of the first one; others that were not computed from it are notes.
    """
    bad = np.isnan(run.record)
    if run.stopped is not None or not bad.any():
        return []
    (first, name), *others = _origins(run.loop, run.positions, bad, run.judgement.signals)
    label, span = _shown(name, run)
    message = f"'{label}' is not a number at t = {run.t[first]:.6g} s"
    facts = [f"signals have no value at {int(bad.any(axis=1).sum()):,} of {len(run):,} samples"]
    lost = [n for n, value in run.measures.items() if math.isnan(value)]
    if lost:
        facts.append(f"measures without a value: {', '.join(lost)}")
    notes = []
    for k, other in others[:_MOST_NOTES]:
        text, place = _shown(other, run)
        notes += [Note(place, f"nor is '{text}' at t = {run.t[k]:.6g} s")] if place is not None else []
    if len(others) > _MOST_NOTES:
        facts.append(f"nor are {len(others) - _MOST_NOTES} more signals")
    return [
        Diagnostic(
            "FZ708", message, span, severity="warning", facts=tuple(facts), help=_KEEP_DOMAINS, notes=tuple(notes)
        )
    ]


def _shown(name: str, run: Run) -> tuple[str, Span | None]:
    """Return the text of a signal and its place."""
    if name.startswith("#"):
        expr = run.judgement.signals[int(name[1:])]
        return to_text(expr), span_of(expr) or run.loop.span
    return name, _span_of_signal(run.loop, name)


def _span_of_signal(loop: Loop, name: str) -> Span | None:
    spans = {d.name: d.span for d in loop.signals} | {i.name: i.span for i in loop.instances}
    return spans.get(name) or spans.get(name.partition(".")[0]) or loop.span


def _what(value: float) -> str:
    return "not a number" if math.isnan(value) else "infinite"


def _origins(
    loop: Loop, positions: Mapping[str, int], bad: npt.NDArray[np.bool_], judged: Sequence[Expr] = ()
) -> list[tuple[int, str]]:
    """Return the signals that lost their value first, before their operands, with the sample.

    Args:
        loop: The loop.
        positions: Columns of the record by name.
        bad: Whether a signal has no value, shape (samples, signals), some of it.
        judged: The expressions of the signals `#0`, `#1` and so on.

    Returns:
        In order of time, outputs of blocks first, one of each block.
    """
    first = {name: int(np.argmax(bad[:, k])) for name, k in positions.items() if bad[:, k].any()}
    read = {f"#{k}": e for k, e in enumerate(judged)} | {d.name: d.value for d in loop.signals}
    sources = {name: [n.name for n in names_in(e)] for name, e in read.items()}
    block_of: dict[str, str] = {}
    for instance in loop.instances:
        block = blocks_of(loop)[instance.controller]
        inputs, outputs = (
            [f"{instance.name}.{s.name}" for s in upstream] for upstream in (block.inputs, block.results)
        )
        arguments = [n.name for a in instance.arguments for n in names_in(a)]
        sources |= dict.fromkeys(inputs, arguments)
        sources |= dict.fromkeys(outputs, inputs)
        block_of |= dict.fromkeys(outputs, instance.name)
    origins: dict[str, tuple[int, str]] = {}
    for name, k in sorted(first.items(), key=lambda item: (item[1], item[0] not in block_of)):
        upstream = sources.get(name) or sources.get(name.partition(".")[0]) or []
        if all(first.get(n, k + 1) > k for n in upstream):
            origins.setdefault(block_of.get(name, name), (k, name))
    return list(origins.values()) or [(k, name) for name, k in first.items()][:1]
