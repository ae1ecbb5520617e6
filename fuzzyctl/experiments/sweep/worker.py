"""Computation of one run by a worker; workers share only files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.runnable import Runnable
from fuzzyctl.experiments.sweep.plan import Plan, Run


class SweepError(Exception):
    """Raised when a sweep cannot go on."""


@dataclass(frozen=True)
class Setup:
    """What all runs of a sweep have in common.

    Args:
        runnable: What is run.
        used: Checksums of the files that the runs rest on, by name, as they were checked.
        measures: What to keep of each run.
    """

    runnable: Runnable[Any]
    used: tuple[tuple[str, str], ...]
    measures: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Args:
        number: Of the run.
        row: Its measures by column.
        wall_s: Computing time [s].
        problem: Why it could not be computed at all, which ends the sweep; else empty.
    """

    number: int
    row: Mapping[str, Any]
    wall_s: float
    problem: str = ""


def setup_of(*plans: Plan[Any], measures: tuple[str, ...]) -> Setup:
    """Return what all runs of some plans have in common."""
    used = {item for one in plans for item in one.used.items()}
    return Setup(plans[0].runnable, tuple(sorted(used)), measures)


def work(setup: Setup, run: Run) -> Outcome:
    """Compute a run."""
    runnable = _kept(setup).runnable
    try:
        scenario = runnable.read(run.path, run.overrides)
        ready = runnable.prepare(scenario, run.controller, setup.measures)
    except DiagnosticError as error:  # it was checked before: a file is not what it was, or code of the user raises
        return Outcome(
            run.number, {}, 0.0, f"run {run.number} of {run.path} was checked, but cannot be prepared:\n{error}"
        )
    if scenario.sha256 != run.sha256:
        return Outcome(run.number, {}, 0.0, f"{run.path} changed while the sweep ran")
    for name, used in ready.used.items():
        if (name, used.sha256) not in setup.used:
            return Outcome(run.number, {}, 0.0, f"{used.path} changed while the sweep ran")
    try:
        found = ready.compute()
    except DiagnosticError as error:  # code of the user raises
        return Outcome(run.number, {}, 0.0, f"run {run.number} of {run.path} cannot be computed:\n{error}")
    return Outcome(run.number, found.row, found.wall_s)


@cache
def _kept(setup: Setup) -> Setup:
    """Return the first of equal setups, so that what its runnable has read and proved serves all runs of a process."""
    return setup
