"""Provenance of the results of a sweep: SPEC, scenario, rule files and versions."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from fuzzyctl.experiments.sweep.plan import Plan
from fuzzyctl.experiments.sweep.spec_file import SpecFile


def describe(file: SpecFile, plan: Plan[Any], overrides: Sequence[str]) -> dict[str, Any]:
    """Return where the results of a sweep come from, as plain data."""
    controllers = tuple(dict.fromkeys(run.controller for run in plan.runs))
    return {
        "spec": file.spec.model_dump(mode="json", exclude_none=True),
        "overrides": list(overrides),
        "runs": len(plan.runs),
        "scenario": {
            "name": plan.scenario.name,
            "file": plan.scenario.path.name,
            "sha256": plan.scenario.sha256,
            "inputs": hashlib.sha256("".join(run.sha256 for run in plan.runs).encode()).hexdigest(),
            "text": list(plan.scenario.texts),
        },
        "rules": dict(sorted(plan.used.items())),
        "laws": dict(plan.runnable.own_files(plan.scenario, controllers)),
        "versions": plan.runnable.software(),
    }


def sources(folder: Path, outside: tuple[str, ...] = ()) -> str:
    """Return one checksum of the sources of a package and of what runs sweeps.

    Args:
        folder: Of the package.
        outside: Beginnings of paths in it that no result depends on.
    """
    digest, experiments = hashlib.sha256(), Path(__file__).parents[1]
    found = [one for one in sorted(folder.rglob("*.py")) if not one.relative_to(folder).as_posix().startswith(outside)]
    for source in (*found, *sorted(experiments.rglob("*.py"))):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def differences(before: Mapping[str, Any], now: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """Yield the keys in which two descriptions differ."""
    for key in dict.fromkeys([*before, *now]):
        old, new = before.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from differences(old, new, f"{prefix}{key}.")
        elif old != new:
            yield f"{prefix}{key}"
