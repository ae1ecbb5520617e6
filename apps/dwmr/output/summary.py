"""Provenance in a summary: scenario, rule files, versions."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from dwmr.control.fuzzy_gains import Rules
from dwmr.scenario.file import ScenarioFile
from fuzzyctl.experiments.settings.locations import Places

_PACKAGES = ("fuzzyctl", "numpy", "numba")


def describe(file: ScenarioFile, rules: Rules, overrides: Sequence[str]) -> dict[str, Any]:
    """Return where the numbers of a run come from, as plain data; of the rule files those that the run has read."""
    return {
        "scenario": {
            "name": file.scenario.name,
            "file": file.path.name,
            "sha256": file.sha256,
            "overrides": list(overrides),
        },
        "rules": {
            role: {
                "file": used.path.name,
                "sha256": used.sha256,
                "files": dict(used.files),
                "params": file.scenario.rules[role].params,
            }
            for role, used in sorted(rules.used.items())
        },
        "versions": versions(),
    }


def texts(file: ScenarioFile) -> list[dict[str, str]]:
    """Return name and text of a scenario's file and of those it extends, as they were read."""
    found: list[dict[str, str]] = []
    places: Places | None = file.places
    while places is not None:
        found.append({"file": Path(places.source.name).name, "text": places.source.text})
        places = places.base
    return found


def versions() -> dict[str, str | None]:
    """Return the versions of what computes a run."""
    return {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
