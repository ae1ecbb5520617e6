"""Provenance in a summary: scenario, rule files, versions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dwmr.control.fuzzy_gains import Rules
from dwmr.scenario.file import ScenarioFile
from fuzzyctl.experiments.result_files import versions


def describe(file: ScenarioFile, rules: Rules, overrides: Sequence[str]) -> dict[str, Any]:
    """Return where the numbers of a run come from, as plain data; of files those that the run has read."""
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
        "laws": {name: {"sha256": used.sha256, "files": dict(used.files)} for name, used in sorted(rules.laws.items())},
        "versions": versions(),
    }
