"""Plan of a sweep: all its runs, checked before the first one starts."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.runnable import Runnable, S
from fuzzyctl.experiments.scenario_keys import OverrideError, literal, split_key
from fuzzyctl.experiments.sweep_spec import SpecFile
from fuzzyctl.experiments.sweep_variables import Variable, expand, generator, require_no_stars

#: More runs than this are refused: their results are kept in memory until the end.
MOST_RUNS = 1_000_000
#: Runs with mistakes that are shown; a thousand more would say the same.
MOST_SHOWN = 5


@dataclass(frozen=True)
class Run:
    """One run: everything a worker needs to compute it, and to see that it computes the same as was checked.

    Args:
        number: Its place in the results, from 0.
        scenario: Name of the scenario.
        path: Its file.
        controller: Under which the scenario is run.
        repetition: Number of the draw.
        values: Varied values by key.
        overrides: All values that replace those of the scenario, as `--set` has them.
        sha256: Of the scenario's files.
    """

    number: int
    scenario: str
    path: Path
    controller: str
    repetition: int
    values: Mapping[str, Any]
    overrides: tuple[str, ...]
    sha256: str = ""


@dataclass
class Plan(Generic[S]):
    """The runs of one sweep, and the files that they rest on.

    Args:
        runnable: Subject of the sweep.
        runs: In the order of the results.
        scenario: The scenario before anything varies.
        used: Checksums of the files besides the scenario's own that the runs rest on, by name.
        warnings: Keys that vary without effect.
    """

    runnable: Runnable[S]
    runs: list[Run]
    scenario: S
    used: dict[str, str] = field(default_factory=dict)
    warnings: tuple[Diagnostic, ...] = ()


def make(
    runnable: Runnable[S], file: SpecFile, overrides: Sequence[str], report: Callable[[int], None] | None = None
) -> Plan[S]:
    """Lay out the runs of a sweep, and check each of them with its drawn values; without compiling or computing.

    Args:
        runnable: Subject of the sweep.
        file: The SPEC.
        overrides: Values for all runs, as `--set` has them.
        report: Called with how many runs of each controller are checked.

    Raises:
        DiagnosticError: With the mistakes in the SPEC, or of the first runs that have any.
        OverrideError: When an override is malformed.
    """
    path = file.scenario_path(runnable.find)
    fixed = (*overrides, *(f"{key}={literal(value)}" for key, value in file.spec.set.items()))
    require_no_stars(file, runnable.common)
    _require_once(file, [o.partition("=")[0] for o in overrides])
    plan = Plan(runnable, [], _read(runnable, file, path, fixed, {}))
    controllers = _controllers(plan, file)
    _require_measures(plan, file, controllers)
    variables = expand(file, plan.scenario.settings, runnable.common)
    total = count(file) * len(controllers)
    if total > MOST_RUNS:
        message = f"these are {total:,} runs; at most {MOST_RUNS:,} are taken"
        raise DiagnosticError([file.diagnostic("FZ904", ("runs",), message)])
    _check(plan, file, _drafts(plan, file, controllers, variables, fixed), controllers, report)
    plan.warnings = tuple(_unread(plan, file, controllers))
    return plan


def joined(plans: Sequence[Plan[S]]) -> list[Run]:
    """Return the runs of several scenarios, numbered through."""
    runs = [run for one in plans for run in one.runs]
    return [dataclasses.replace(run, number=number) for number, run in enumerate(runs)]


def _unread(plan: Plan[S], file: SpecFile, controllers: Sequence[str]) -> Iterator[Diagnostic]:
    """Warn of varied keys that no run of the sweep reads."""
    for table in ("grid", "random"):
        for key in getattr(file.spec, table):
            what = plan.runnable.unread(plan.scenario, controllers, plan.used, split_key(key))
            if what:
                message = f"{table}.{key} varies in vain: no run reads {what}"
                facts = (f"the controllers of the sweep are {', '.join(controllers)}",)
                remark = file.diagnostic("FZ904", (table, key), message, facts=facts)
                yield dataclasses.replace(remark, severity="warning")


def count(file: SpecFile) -> int:
    """Return how many runs each controller has."""
    return file.spec.draws * file.spec.runs * math.prod(len(values) for values in file.spec.grid.values())


def _require_once(file: SpecFile, given: Sequence[str]) -> None:
    """Refuse a key that two of the SPEC's tables or the command line give."""
    seen: dict[str, str] = dict.fromkeys(given, "--set")
    mistakes = []
    for table in ("set", "grid", "random"):
        for key in getattr(file.spec, table):
            if key in seen:
                message = f"{table}.{key} is given by {seen[key]} already"
                mistakes.append(file.diagnostic("FZ904", (table, key), message))
            seen[key] = f"[{table}]"
    if mistakes:
        raise DiagnosticError(mistakes)


def _controllers(plan: Plan[S], file: SpecFile) -> tuple[str, ...]:
    """Return the controllers of a sweep; words for several ones written out.

    Raises:
        DiagnosticError: For an unknown name.
    """
    try:
        return plan.runnable.controllers(plan.scenario, file.spec.controllers or ())
    except UnknownNameError as error:
        message = f"controllers: there is no {error.kind} {error.name!r}"
        facts, hint = (f"there are {', '.join(error.known)}",), did_you_mean(error.name, error.known)
        raise DiagnosticError([file.diagnostic("FZ904", ("controllers",), message, facts=facts, help=hint)]) from None


def _require_measures(plan: Plan[S], file: SpecFile, controllers: Sequence[str]) -> None:
    """Refuse measures that no run has; they would be missing from the results."""
    names = plan.runnable.measures(plan.scenario, controllers)
    mistakes = [
        file.diagnostic(
            "FZ904", ("measures",), f"measures: there is no measure {name!r}",
            facts=(f"there are {', '.join(names)}",), help=did_you_mean(name, names),
        )
        for name in file.spec.measures if names and name not in names
    ]  # fmt: skip
    if mistakes:
        raise DiagnosticError(mistakes)


def _drafts(
    plan: Plan[S], file: SpecFile, controllers: Sequence[str], variables: Sequence[Variable], fixed: Sequence[str]
) -> Iterator[list[Run]]:
    """Yield the runs of every member, every point of the grid and every repetition, one for each controller."""
    spec, number, seed = file.spec, itertools.count(), plan.runnable.seed
    keys = {*spec.grid, *spec.random, *(one.partition("=")[0] for one in fixed)}
    seeded = spec.runs > 1 and seed != "" and seed not in keys
    name, path = plan.scenario.name, plan.scenario.path
    members = plan.runnable.members(plan.scenario, controllers, spec)
    for member, point in itertools.product(members, itertools.product(*spec.grid.values())):
        for repetition in range(spec.runs):
            values = {**member, **dict(zip(spec.grid, point, strict=True))}
            values |= {one.key: one.draw(spec.seed, repetition) for one in variables}
            if seeded:
                values[seed] = int(generator(spec.seed, repetition, seed).integers(2**32))
            overrides = (*fixed, *(f"{key}={literal(value)}" for key, value in values.items()))
            yield [Run(next(number), name, path, one, repetition, values, overrides) for one in controllers]


def _check(
    plan: Plan[S],
    file: SpecFile,
    drafts: Iterator[list[Run]],
    controllers: Sequence[str],
    report: Callable[[int], None] | None,
) -> None:
    """Check every run with its values, and take it into the plan.

    Raises:
        DiagnosticError: With the mistakes of the first runs that have any.
    """
    mistakes, bad = dict[tuple[str, str, str], Diagnostic](), 0
    for group in drafts:
        first = group[0]
        try:
            changed = _read(plan.runnable, file, first.path, first.overrides, first.values, first.number)
            try:
                used = plan.runnable.check(changed, controllers)
            except DiagnosticError as error:
                raise _blame(file, error, first.values, first.number) from None
        except DiagnosticError as error:
            for one in error.diagnostics:
                # a mistake in every run, such as a misspelt key, shows once
                mistakes.setdefault((one.code, one.place, one.message.partition(": ")[2]), one)
            bad += 1
            if bad == MOST_SHOWN:
                break
            continue
        plan.used |= {name: one.sha256 for name, one in used.items()}
        plan.runs += [dataclasses.replace(run, sha256=changed.sha256) for run in group]
        if report is not None:
            report(len(plan.runs) // len(controllers))
    if mistakes:
        raise DiagnosticError(tuple(mistakes.values()))


def _read(
    runnable: Runnable[S],
    file: SpecFile,
    path: Path,
    overrides: Sequence[str],
    values: Mapping[str, Any],
    number: int | None = None,
) -> S:
    try:
        return runnable.read(path, overrides)
    except DiagnosticError as error:
        raise _blame(file, error, values, number) from None
    except OverrideError as error:
        key = next((k for k in (*values, *file.spec.set) if str(error).startswith(f"--set {k}=")), None)
        if key is None:
            raise
        message = str(error).partition(": ")[2]
        table, written = _written(file, key)
        raise DiagnosticError([file.diagnostic("FZ904", (table, written), f"{table}.{written}: {message}")]) from None


def _blame(file: SpecFile, error: DiagnosticError, values: Mapping[str, Any], number: int | None) -> DiagnosticError:
    """Return the mistakes of a run with its number, at the key of the SPEC that brought them."""
    return DiagnosticError([_blamed(file, one, values, number) for one in error.diagnostics])


def _blamed(file: SpecFile, one: Diagnostic, values: Mapping[str, Any], number: int | None) -> Diagnostic:
    key = one.file.removeprefix("--set ").partition("=")[0] if one.file.startswith("--set ") else ""
    message = one.message if number is None else f"run {number}: {one.message}"
    facts = one.facts
    if key in values:
        facts = (*facts, f"run {number} has {key} = {literal(values[key])}")
    elif number is not None and values:
        values_text = ", ".join(f"{k} = {literal(v)}" for k, v in list(values.items())[:4])
        facts = (*facts, f"run {number} has {values_text}{', ...' if len(values) > 4 else ''}")
    if key in values or key in file.spec.set:
        return dataclasses.replace(
            one, message=message, facts=facts, span=file.span(*_written(file, key)), file=file.source.name
        )
    return dataclasses.replace(one, message=message, facts=facts)


def _written(file: SpecFile, key: str) -> tuple[str, str]:
    """Return the table of the SPEC that gives a key of the scenario, and the key as it is written there."""
    for table in ("set", "grid", "random"):
        for written in getattr(file.spec, table):
            parts, pattern = split_key(key), split_key(written)
            if len(parts) == len(pattern) and all(p in (q, "*") for q, p in zip(parts, pattern, strict=True)):
                return table, written
    return "random", key
