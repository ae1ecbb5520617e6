"""MATLAB's .mat, version 5: a struct for each control law, `robots`, and `metadata` as JSON text."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from dwmr.output.data.signals import TIME, Data, described

#: The text at the head of the file; what scipy writes there has the time of day in it.
_HEAD = b"MATLAB 5.0 MAT-file, written by dwmr".ljust(116)


def save(path: Path, data: Data) -> None:
    """Write the signals; `t` is a column, as MATLAB has it."""
    variables: dict[str, Any] = {law: dict(run) for law, run in data.runs.items()}
    variables["robots"] = np.array(data.robots, dtype=object)
    # JSON's own escapes, because MATLAB's text has two bytes a character at most
    variables["metadata"] = json.dumps(described(data))
    with path.open("w+b") as file:
        io.savemat(file, variables, long_field_names=True, oned_as="column")
        file.seek(0)
        file.write(_HEAD)


def load(path: Path) -> Data:
    """Read what `save` wrote.

    Raises:
        ValueError: When it is something else.
    """
    try:
        variables = io.loadmat(str(path), squeeze_me=False)
    except (io.matlab.MatReadError, NotImplementedError) as error:
        raise ValueError(str(error)) from error
    metadata = json.loads(str(variables["metadata"][0]))
    runs = {law: _run(variables[law][0, 0], names) for law, names in metadata.pop("laws").items()}
    return Data(runs, metadata)


def _run(struct: Any, names: list[str]) -> dict[str, Any]:
    run = {name: np.ascontiguousarray(struct[name], dtype=np.float64) for name in names}
    run[TIME] = run[TIME].reshape(-1)
    return run
