"""Numerical output of a run: summary.json and the files of its signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fuzzyctl.experiments.result_files import Results, finite

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
