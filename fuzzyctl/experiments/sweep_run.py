"""Run of a sweep from its plan to the files of its results."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzyctl.experiments import dask_workers, parquet, sweep_journal, sweep_workers
from fuzzyctl.experiments.result_files import Columns, Results, columns_of, results, write_csv
from fuzzyctl.experiments.sweep_journal import ABOUT, Journal
from fuzzyctl.experiments.sweep_plan import Plan, Run
from fuzzyctl.experiments.sweep_workers import Outcome, Setup, SweepError, setup_of
from fuzzyctl.support.cores import cores

#: Files that a sweep may leave.
NAMES = ("results.csv", "results.parquet", ABOUT, "times.csv")
FORMATS = ("csv", "parquet")


def table(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Columns:
    """Return the results by column, in the order of the runs; None for a missing value."""
    return columns_of([_row(run, done[run.number]) for run in runs])


def _row(run: Run, outcome: Outcome) -> dict[str, Any]:
    head = {"run": run.number, "scenario": run.scenario, "controller": run.controller, "repetition": run.repetition}
    return {**head, **run.values, **outcome.row}


def write(
    files: Results, formats: Iterable[str], plan: Plan[Any], done: Mapping[int, Outcome], about: Mapping[str, Any]
) -> None:
    """Write the results; with the same description they are the same bytes, `times.csv` aside."""
    columns = table(plan.runs, done)
    application = plan.runnable.application
    whole = {**about, "columns": {name: {"unit": plan.runnable.unit(plan.scenario, name)} for name in columns}}
    files.write_text(ABOUT, json.dumps(whole, indent=2, ensure_ascii=False) + "\n")
    for one in formats:
        if one == "csv":
            files.write("results.csv", lambda path: write_csv(path, columns))
        else:
            files.write("results.parquet", lambda path: parquet.write_table(path, columns, whole, application))
    times: Columns = {"run": [r.number for r in plan.runs], "wall_s": [done[r.number].wall_s for r in plan.runs]}
    files.write("times.csv", lambda path: write_csv(path, times))
    files.publish()


#: Shows how many of some runs are done while it is entered; gives a function to call with their number.
Shown = Callable[[int], AbstractContextManager[Callable[[int], None]]]


class InterruptedSweepError(SweepError):
    """Raised when Ctrl-C ended a sweep."""


@dataclass(frozen=True)
class Workers:
    """Who computes: processes here, one for each core unless said otherwise, or a dask cluster.

    Args:
        jobs: Number of processes.
        cluster: Address of a dask scheduler, or local:N.
    """

    jobs: int | None = None
    cluster: str | None = None

    def compute(self, setup: Setup, runs: Sequence[Run]) -> Iterator[Outcome]:
        """Yield the outcomes of runs as they come, in any order.

        Raises:
            SweepError: When the workers cannot be reached, or are lost.
        """
        if self.cluster is not None:
            return dask_workers.compute(setup, runs, self.cluster)
        return sweep_workers.compute(setup, runs, min(self.jobs or cores(), max(1, len(runs))))


@dataclass(frozen=True)
class Finished:
    """A sweep whose results are written.

    Args:
        summary: What there is to say.
        outcomes: Of all runs, by number.
    """

    summary: dict[str, Any]
    outcomes: Mapping[int, Outcome]


def silent(total: int) -> AbstractContextManager[Callable[[int], None]]:
    """Show nothing."""
    return nullcontext(lambda done: None)


def collect(outcomes: Iterable[Outcome], total: int, ready: int, keep: Callable[[Outcome], None], shown: Shown) -> None:
    """Take in outcomes.

    Args:
        outcomes: As they come.
        total: Runs there are.
        ready: Runs done before.
        keep: Called with each outcome.
        shown: Shows how many are done.

    Raises:
        SweepError: When runs cannot be computed; kept outcomes stay.
    """
    with shown(total) as move:
        for one in outcomes:
            if one.problem:
                raise SweepError(one.problem)
            keep(one)
            ready += 1
            move(ready)


def run(
    plan: Plan[Any],
    measures: tuple[str, ...],
    about: Mapping[str, Any],
    folder: Path,
    formats: Sequence[str] = ("csv",),
    workers: Workers = Workers(),
    resume: bool = False,
    shown: Shown = silent,
    shielded: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Finished:
    """Compute the missing runs, and write the results.

    Args:
        plan: The runs.
        measures: What to keep of each.
        about: From `sweep_journal.describe`.
        folder: Of the results.
        formats: Of `FORMATS`.
        workers: Who computes.
        resume: Whether a journal that is there goes on.
        shown: Shows how many runs are done.
        shielded: Keeps interruptions off while the results are written.

    Raises:
        DiagnosticError: When the results cannot be written, or belong to another sweep.
        InterruptedSweepError: When Ctrl-C came; the journal keeps the finished runs.
        SweepError: When a run cannot be computed at all; the journal keeps the finished runs.
    """
    sweep_journal.require_own(folder, NAMES)
    with results(folder, NAMES) as files:
        if resume:
            sweep_journal.require_something(folder, about)
        with sweep_journal.journal(folder, about, resume) as log:
            left = [one for one in plan.runs if one.number not in log.done]
            if left:
                _compute(workers.compute(setup_of(plan, measures=measures), left), len(left), log, folder, shown)
            with shielded():
                write(files, formats, plan, log.done, about)
                sweep_journal.remove(folder)
    return Finished(_summary(plan, log, len(left), folder), log.done)


def _compute(outcomes: Iterator[Outcome], left: int, kept: Journal, folder: Path, shown: Shown) -> None:
    ready = len(kept.done)
    total = ready + left
    try:
        collect(outcomes, total, ready, kept.add, shown)
    except KeyboardInterrupt as error:
        raise InterruptedSweepError(f"interrupted{_kept(kept, total, folder)}") from error
    except SweepError as error:
        raise SweepError(f"{error}{_kept(kept, total, folder)}") from error


def _kept(kept: Journal, total: int, folder: Path) -> str:
    count = len(kept.done)
    return f": {count:,} of {total:,} runs are kept in {folder}; go on with --resume" if count else ""


def _summary(plan: Plan[Any], kept: Journal, computed: int, folder: Path) -> dict[str, Any]:
    stopped = [row for row in (kept.done[one.number].row for one in plan.runs) if row["stopped"]]
    return {
        "runs": len(plan.runs),
        "computed": computed,
        "stopped": len(stopped),
        "reasons": dict(sorted(Counter(str(row["stop_reason"]) for row in stopped).items())),
        "files": [name for name in NAMES if (folder / name).exists()],
    }
