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


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Yield what differs between two descriptions, in words."""
    yield from dict.fromkeys(_in_words(*key) for key in _keys(before, now))


def _keys(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield the keys in which two descriptions differ."""
    for key in dict.fromkeys([*before, *now]):
        old, new = before.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from ((key, *inner) for inner in _keys(old, new))
        elif old != new:
            yield (key,)


def _in_words(part: str, *keys: str) -> str:
    """Return what a key of a description is about."""
    match part, keys:
        case "spec", _:
            return f"{'.'.join(keys)} of the SPEC"
        case "overrides", _:
            return "values of --set"
        case "runs", _:
            return "number of runs"
        case "scenario", ("inputs",):
            return "settings of the runs"
        case "scenario", ("name" | "file",):
            return "name of the scenario"
        case "scenario", _:
            return "text of the scenario"
        case "rules", _:
            return f"file {Path(keys[-1]).name}" if keys else "files that are used"
        case "laws", _:
            return f"law {keys[-1]}" if keys else "laws"
        case _:
            return f"version of {keys[-1]}" if keys and keys[-1] != "sources" else "version of this program"
