"""Summary of a run as plain data: summary.json, and the versions of what computes."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from fuzzyctl.experiments.results.folder import Results

_PACKAGES = ("fuzzyctl", "numpy", "numba")


def write_summary(files: Results, summary: Mapping[str, Any], folder: str = "") -> None:
    """Write summary.json, behind the name of a folder inside; numbers that are not finite become null."""
    text = json.dumps(finite(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    files.write_text(f"{folder}summary.json", text)


def finite(data: Any) -> Any:
    """Return plain data with None for numbers that are not finite."""
    if isinstance(data, Mapping):
        return {k: finite(v) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [finite(v) for v in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def versions() -> dict[str, str | None]:
    """Return the versions of what computes a run."""
    return {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
