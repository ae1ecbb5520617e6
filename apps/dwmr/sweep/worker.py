"""Computation of one run by a worker, and its measures as a row; workers share only files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.scenario import file as scenario_file
from dwmr.sweep.plan import Run, folders
from fuzzyctl.diagnostics.diagnostic import DiagnosticError


@dataclass(frozen=True)
class Setup:
    """What all runs of a sweep have in common.

    Args:
        rules_folder: Whose rule files replace those of the same name.
        used: Checksums of the rule files by role and name, as they were checked.
        measures: Groups of measures to keep.
    """

    rules_folder: Path | None
    used: tuple[tuple[str, str], ...]
    measures: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Args:
        number: Of the run.
        row: Its measures by column.
        wall_s: Computing time of its loop [s].
        problem: Why it could not be computed at all, which ends the sweep; else empty.
    """

    number: int
    row: Mapping[str, Any]
    wall_s: float
    problem: str = ""


def work(setup: Setup, run: Run) -> Outcome:
    """Compute a run."""
    # the compiler is loaded in the workers only
    from dwmr.results.metrics import measure
    from dwmr.simulation import simulate

    try:
        file = scenario_file.read(run.path, run.overrides)
        rules = Rules(file.scenario.rules, folders(setup.rules_folder, file), file.places, _known(setup))
        simulation = simulate.prepare(file, run.controller, rules)
    except DiagnosticError as error:  # it was checked before: a file is not what it was, or the law raises
        return Outcome(
            run.number, {}, 0.0, f"run {run.number} of {run.path} was checked, but cannot be prepared:\n{error}"
        )
    if file.sha256 != run.sha256:
        return Outcome(run.number, {}, 0.0, f"{run.path} changed while the sweep ran")
    for role, used in rules.used.items():
        if (f"{role}/{used.path.name}", used.sha256) not in setup.used:
            return Outcome(run.number, {}, 0.0, f"{used.path} changed while the sweep ran")
    try:
        trajectory = simulate.run(simulation)
    except DiagnosticError as error:  # the law raises
        return Outcome(run.number, {}, 0.0, f"run {run.number} of {run.path} cannot be computed:\n{error}")
    measures = measure(trajectory, file.scenario, setup.measures)
    return Outcome(run.number, dict(row(measures, setup.measures, trajectory.robots)), trajectory.wall_s)


@cache
def _known(setup: Setup) -> Known:
    """Return what this process knows about rule files: they are read and proved once."""
    return Known()


def row(measures: Mapping[str, Any], wanted: Sequence[str], robots: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield columns and values of a run: how it ended, then the measures wanted, keys of tables joined by dots.

    Args:
        measures: From `metrics.measure`.
        wanted: Groups to keep; one that the control law does not have is left out.
        robots: Names of the robots.
    """
    stopped = measures["stopped"] or {}
    yield "t_end", measures["t_end"]
    yield "stopped", bool(stopped)
    yield "stop_robot", stopped.get("robot")
    yield "stop_reason", stopped.get("reason")
    for group in wanted:
        if group in ("obstacles_hit", "robots_hit"):
            hits = [name for hit in measures[group] for name in hit.get("robots", [hit.get("robot")])]
            yield from ((f"{group}.{robot}", hits.count(robot)) for robot in robots)
        elif group in measures:
            yield from _flat(group, measures[group])


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, below in value.items():
            yield from _flat(f"{key}.{name}", below)
    else:
        yield key, value
