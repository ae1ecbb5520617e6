"""Numerical output of a run: summary.json and the files of its signals."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.experiments.results.folder import Results

if TYPE_CHECKING:
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory

#: All files that a run leaves.
NAMES = (
    "summary.json",
    *(f"trajectory.{name}" for name in ("npz", "csv", "mat", "parquet")),
    "path.png",
    "errors.png",
)


def write_summary(files: Results, summary: Mapping[str, Any]) -> None:
    """Write summary.json; numbers that are not finite become null."""
    text = json.dumps(finite(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    files.write("summary.json", lambda path: _write_text(path, text))


def write_trajectories(
    files: Results,
    trajectories: Sequence[Trajectory],
    scenario: Scenario,
    metadata: Mapping[str, Any],
    formats: Sequence[str] = ("npz",),
) -> None:
    """Write the signals of all control laws with their Lyapunov functions, in each format as trajectory.FORMAT.

    Args:
        files: Where they go.
        trajectories: One per control law.
        scenario: What was run; of its samples every `run.save_every`-th is saved.
        metadata: What else to say about the run.
        formats: Of `data.FORMATS`.
    """
    from dwmr.output.data import files as formatted
    from dwmr.output.data import signals

    data = signals.of(trajectories, scenario, scenario.run.save_every, finite(metadata))
    for one in formats:
        files.write(f"trajectory.{one}", lambda path: formatted.save(path, data))


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def finite(data: Any) -> Any:
    """Return plain data with None for numbers that are not finite."""
    if isinstance(data, Mapping):
        return {k: finite(v) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [finite(v) for v in data]
    if isinstance(data, float) and not np.isfinite(data):
        return None
    return data
