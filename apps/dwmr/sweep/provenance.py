"""Provenance of the results of a sweep: SPEC, scenario, rule files and versions."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from dwmr.control import laws
from dwmr.sweep.plan import Plan
from dwmr.sweep.spec_file import SpecFile
from fuzzyctl.experiments.results.summary import versions

#: Packages that no result depends on.
OUTSIDE = ("cli/", "figures/", "page/", "output/data/")


def describe(file: SpecFile, plan: Plan, overrides: Sequence[str]) -> dict[str, Any]:
    """Return where the results of a sweep come from, as plain data."""
    own = {law: _own(law, plan.scenario.path.parent) for law in dict.fromkeys(run.controller for run in plan.runs)}
    return {
        "spec": file.spec.model_dump(mode="json", exclude_none=True),
        "overrides": list(overrides),
        "runs": len(plan.runs),
        "scenario": {
            "name": plan.scenario.scenario.name,
            "file": plan.scenario.path.name,
            "sha256": plan.scenario.sha256,
            "inputs": hashlib.sha256("".join(run.sha256 for run in plan.runs).encode()).hexdigest(),
            "text": plan.scenario.places.texts(),
        },
        "rules": dict(sorted(plan.used.items())),
        "laws": {law: digest for law, digest in own.items() if digest},
        "versions": software(),
    }


def software() -> dict[str, str | None]:
    """Return the versions of what computes a run, and a checksum of the sources of this package."""
    return {**versions(), "sources": _sources()}


def _sources() -> str:
    digest, package = hashlib.sha256(), Path(__file__).parents[1]
    for source in sorted(package.rglob("*.py")):
        if not source.relative_to(package).as_posix().startswith(OUTSIDE):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _own(law: str, folder: Path) -> str:
    """Return the checksum of a control law that lies beside the scenario, else nothing."""
    path = folder / f"{law}.py"
    return hashlib.sha256(path.read_bytes()).hexdigest() if law not in laws.names() else ""


def differences(before: Mapping[str, Any], now: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """Yield the keys in which two descriptions differ."""
    for key in dict.fromkeys([*before, *now]):
        old, new = before.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from differences(old, new, f"{prefix}{key}.")
        elif old != new:
            yield f"{prefix}{key}"
