"""What a run leaves behind in numbers: summary.json and trajectory.npz."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.folder import Results
from dwmr.loop import SIGNALS
from dwmr.simulate import Trajectory

#: All files that a run leaves.
NAMES = ("summary.json", "trajectory.npz", "path.png", "errors.png")


def write_summary(files: Results, summary: Mapping[str, Any]) -> None:
    """Write summary.json; numbers that are not finite become null."""
    text = to_json(summary)
    files.write("summary.json", lambda path: _write_text(path, text))


def to_json(data: Any) -> str:
    """Return plain data as JSON with numbers that are not finite as null."""
    return json.dumps(_finite(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_trajectories(
    files: Results, trajectories: Sequence[Trajectory], every: int, metadata: Mapping[str, Any]
) -> None:
    """Write trajectory.npz.

    Arrays are named CONTROLLER/SIGNAL, shape (samples, robots), with CONTROLLER/t, shape (samples,); `metadata` is
    JSON text with units, meanings and the robots' names.

    Args:
        files: Where it goes.
        trajectories: One per control law.
        every: Samples between two that are saved.
        metadata: What else to say about the run.
    """
    arrays: dict[str, Any] = {}
    units: dict[str, Any] = {"t": {"unit": "s", "doc": "time"}}
    for one in trajectories:
        arrays[f"{one.controller}/t"] = one.t[::every]
        for signal in (*SIGNALS, *one.law_signals):
            arrays[f"{one.controller}/{signal.name}"] = one[signal.name][::every]
            units[signal.name] = {"unit": signal.unit, "doc": signal.doc}
    about = {**metadata, "robots": list(trajectories[0].robots), "signals": units}
    arrays["metadata"] = np.array(to_json(about))
    files.write("trajectory.npz", lambda path: _write_npz(path, arrays))


def _write_npz(path: Path, arrays: Mapping[str, Any]) -> None:
    with path.open("wb") as file:
        np.savez(file, **arrays)


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _finite(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {k: _finite(v) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(v) for v in data]
    if isinstance(data, float) and not np.isfinite(data):
        return None
    return data
