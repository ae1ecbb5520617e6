"""What a summary says about its origin: scenario, rule files, versions."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from dwmr.fuzzy_gains import Rules
from dwmr.scenario_file import ScenarioFile

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
                "params": file.scenario.rules[role].params,
            }
            for role, used in sorted(rules.used.items())
        },
        "versions": {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}},
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
