"""Text of runs: measures side by side, requirements, accuracy."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fuzzyctl.simulation.run import Run


def text_of(runs: Sequence[Run], labels: Sequence[str], width: int | None = None) -> str:
    """Return what people read of runs.

    Args:
        runs: The runs.
        labels: What they are called, one for each.
        width: Columns of the terminal, None for a pipe; a wider table is printed in several parts.
    """
    lines = [line for run, label in zip(runs, labels, strict=True) for line in _head(run, label)]
    table = _measures(runs, labels, width)
    table += _own(runs, labels)
    claims = [line for run, label in zip(runs, labels, strict=True) for line in _requirements(run, label, len(runs))]
    return "\n".join([*lines, *([""] if table else []), *table, *([""] if claims else []), *claims])


def _head(run: Run, label: str) -> Iterator[str]:
    yield f"{label}: {run.loop.title}" if run.loop.title else label
    end = f"{run.t[-1]:.6g} s" if len(run) else "0 s"
    how = (
        f"{run.solver} with {run.substeps} {'step' if run.substeps == 1 else 'steps'} a sample"
        if run.substeps
        else run.solver
    )
    yield f"  {end} in {len(run):,} {'sample' if len(run) == 1 else 'samples'}, {how}"
    if run.error:
        name, error = max(run.error.items(), key=lambda item: item[1])
        finer = "half the step changes" if run.substeps else "a tenth of the tolerances changes"
        yield f"  {finer} {name} by {error:.2g}{', the other states by no more' if len(run.error) > 1 else ''}"
    if run.stopped is not None and run.loop.measures:
        yield "  stopped: the measures are of the samples up to there"


def _measures(runs: Sequence[Run], labels: Sequence[str], width: int | None) -> list[str]:
    """Return a table: a row for each measure of any run, a column for each run."""
    measures = {m.name: m for run in runs for m in run.loop.measures}
    rows = [[_title(m.name, m.label), *(_value(run, m.name, m.unit) for run in runs)] for m in measures.values()]
    if not rows:
        return []
    header = [["measure", *labels]] if len(runs) > 1 else []
    widths = [max(len(row[k]) for row in (*header, *rows)) for k in range(len(runs) + 1)]
    parts: list[list[int]] = []
    for k in range(1, len(widths)):
        if parts and (width is None or sum(widths[j] + 2 for j in (*parts[-1], k)) - 2 <= width):
            parts[-1].append(k)
        else:
            parts.append([0, k])
    lines = [["  ".join(row[k].ljust(widths[k]) for k in part).rstrip() for row in (*header, *rows)] for part in parts]
    return [line for part in lines for line in ("", *part)][1:]


def _own(runs: Sequence[Run], labels: Sequence[str]) -> Iterator[str]:
    """Name the measures that only one of several runs has."""
    for run, label in zip(runs, labels, strict=True):
        others = {m.name for other in runs if other is not run for m in other.loop.measures}
        own = [m.name for m in run.loop.measures if m.name not in others]
        if own and len(runs) > 1:
            yield f"only {label} measures: {', '.join(own)}"


def _title(name: str, label: str) -> str:
    return f"{name}  {label}" if label else name


def _value(run: Run, name: str, unit: str) -> str:
    if name not in run.measures:
        return ""
    value = run.measures[name]
    return "none" if math.isnan(value) else f"{value:.5g} {unit}".rstrip()


def _requirements(run: Run, label: str, count: int) -> Iterator[str]:
    for r in run.requirements:
        facts = f"  ({', '.join(r.facts)})" if r.facts else ""
        verdict = "met" if r.holds else "not met"
        yield f"{f'{label}: ' if count > 1 else ''}require {r.text}: {verdict}{facts}"
