"""Scenario file of a calibration: it extends the calibrated scenario with the fitted values."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dwmr.calibration.parameters import keys
from dwmr.config.shipped import SHIPPED
from dwmr.scenario.file import ScenarioFile
from fuzzyctl.experiments.scenario_keys import override


def scenario_text(file: ScenarioFile, values: Mapping[str, float], path: Path, head: str) -> str:
    """Return the text of a scenario with other values.

    Args:
        file: The scenario it extends.
        values: Values by parameter.
        path: Where the text will stand.
        head: Comment for its first lines.
    """
    data: dict[str, Any] = {}
    if any(key.startswith("disturbances.") for name in values for key in keys(file.scenario, name, file.places)):
        # lists replace those below, so all disturbances are written, with what they were given
        given = file.scenario.disturbances
        data["disturbances"] = [one.model_dump(exclude_none=True, exclude_unset=True) for one in given]
    for name, value in values.items():
        for key in keys(file.scenario, name, file.places):
            override(data, f"{key}={value!r}")
    lines = [f"# {line}".rstrip() for line in head.splitlines()]
    lines += ["", f'extends = "{_base(file.path, path.parent)}"', f'name = "{path.stem}"', *_tables(data, "")]
    return "\n".join(lines) + "\n"


def _base(path: Path, folder: Path) -> str:
    """Return how a file in a folder names the scenario it extends."""
    if path.parent == SHIPPED:
        return path.stem
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()


def _tables(data: Mapping[str, Any], prefix: str) -> list[str]:
    """Return the lines of tables and lists of tables, in TOML."""
    lines: list[str] = []
    values = {k: v for k, v in data.items() if not isinstance(v, dict | list)}
    if values:
        lines += ["", f"[{prefix}]", *_values(values)]
    for key, value in data.items():
        full = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            lines += _tables(value, full)
        elif isinstance(value, list):
            for one in value:
                lines += ["", f"[[{full}]]", *_values(one)]
    return lines


def _values(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_value(value)}" for key, value in table.items()]


def _value(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple | list):
        return f"[{', '.join(_value(v) for v in value)}]"
    return repr(value)
