"""The folder of results: checked before the run, written under temporary names, then renamed."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fuzzyctl.errors import Diagnostic, DiagnosticError

from dwmr.simulate import SIGNALS, Trajectory


def prepare_folder(folder: Path) -> None:
    """Create the folder of results and make sure that files can be written into it.

    Raises:
        DiagnosticError: When this cannot be done.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".dwmr-"):
            pass
    except OSError as error:
        raise _refused(folder, error) from error


def write(folder: Path, name: str, fill: Callable[[Path], None]) -> Path:
    """Write a file under a temporary name and rename it when it is whole.

    Args:
        folder: Where it goes.
        name: Its name; the temporary one keeps the suffix.
        fill: Writes the content to a path.

    Raises:
        DiagnosticError: When it cannot be written; nothing half-written stays.
    """
    part = folder / f".{os.getpid()}-{name}"
    try:
        fill(part)
        part.replace(folder / name)
    except OSError as error:
        raise _refused(folder / name, error) from error
    finally:
        part.unlink(missing_ok=True)
    return folder / name


def write_summary(folder: Path, summary: Mapping[str, Any]) -> Path:
    """Write summary.json; numbers that are not finite become null."""
    text = to_json(summary)
    return write(folder, "summary.json", lambda path: _write_text(path, text))


def to_json(data: Any) -> str:
    """Return plain data as JSON with numbers that are not finite as null."""
    return json.dumps(_finite(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_trajectories(folder: Path, trajectories: Sequence[Trajectory], every: int, metadata: Mapping[str, Any]) -> Path:
    """Write trajectory.npz.

    Arrays are named CONTROLLER/SIGNAL, shape (samples, robots), with CONTROLLER/t, shape (samples,); `metadata` is JSON text
    with units, meanings and the robots' names.

    Args:
        folder: Where it goes.
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
    return write(folder, "trajectory.npz", lambda path: _write_npz(path, arrays))


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


def _refused(path: Path, error: OSError) -> DiagnosticError:
    message = f"{path} cannot be written: {error.strerror or error}"
    return DiagnosticError([Diagnostic("FZ909", message, file=str(path), help="name another folder with -o DIR")])
