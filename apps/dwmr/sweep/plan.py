"""Plan of a sweep: all its runs, checked before the first one starts."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dwmr.control import laws as controllers
from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.scenario import file as scenario_file
from dwmr.scenario.file import ScenarioFile
from dwmr.simulation import preflight
from dwmr.sweep.spec_file import SpecFile
from dwmr.sweep.variables import Variable, expand, generator
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.settings.overrides import OverrideError, literal, split_key

#: More runs than this are refused: their results are kept in memory until the end.
MOST_RUNS = 1_000_000
#: Runs with mistakes that are shown; a thousand more would say the same.
MOST_SHOWN = 5
#: First number of the measurement noise of a run.
SEED = "run.seed"


@dataclass(frozen=True)
class Run:
    """One run: everything a worker needs to compute it, and to see that it computes the same as was checked.

    Args:
        number: Its place in the results, from 0.
        scenario: Name of the scenario.
        path: Its file.
        controller: Control law.
        repetition: Number of the draw.
        values: What varies, by key.
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
class Plan:
    """The runs of one sweep, and the files that they rest on.

    Args:
        runs: In the order of the results.
        scenario: The scenario before anything varies.
        rules_folder: Whose rule files replace those of the same name.
        used: Checksums of the rule files that the runs read, by role and name.
        warnings: What varies without effect.
    """

    runs: list[Run]
    scenario: ScenarioFile
    rules_folder: Path | None
    used: dict[str, str] = field(default_factory=dict)
    warnings: tuple[Diagnostic, ...] = ()


def folders(rules_folder: Path | None, file: ScenarioFile) -> tuple[Path, ...]:
    """Return where the rule files of a scenario are looked for."""
    return (*([rules_folder] if rules_folder else []), *file.folders)


def make(
    file: SpecFile, rules_folder: Path | None, overrides: Sequence[str], report: Callable[[int], None] | None = None
) -> Plan:
    """Lay out the runs of a sweep, and check each of them with its drawn values; nothing is compiled or simulated.

    Args:
        file: The SPEC.
        rules_folder: Whose rule files replace those of the same name.
        overrides: Values for all runs, as `--set` has them.
        report: Called with how many runs of each law are checked.

    Raises:
        DiagnosticError: With the mistakes in the SPEC, or of the first runs that have any.
        OverrideError: When an override is malformed.
    """
    path = file.scenario_path()
    fixed = (*overrides, *(f"{key}={literal(value)}" for key, value in file.spec.set.items()))
    _require_once(file, [o.partition("=")[0] for o in overrides])
    base = _read(file, path, fixed, {})
    laws = laws_of(file, base)
    variables = expand(file, base.scenario)
    total = count(file) * len(laws)
    if total > MOST_RUNS:
        message = f"these are {total:,} runs; at most {MOST_RUNS:,} are taken"
        raise DiagnosticError([file.diagnostic("FZ904", ("runs",), message)])
    given = {*file.spec.grid, *file.spec.random, *(one.partition("=")[0] for one in fixed)}
    seeded = file.spec.runs > 1 and SEED not in given
    drafts = _drafts(file, base, path, laws, variables, fixed, seeded)
    plan = Plan([], base, rules_folder)
    _check(file, plan, drafts, laws, rules_folder, report)
    plan.warnings = tuple(_idle(file, plan, laws))
    return plan


def _idle(file: SpecFile, plan: Plan, laws: Sequence[str]) -> Iterator[Diagnostic]:
    """Warn of what varies although no law of the sweep reads it: gains of other laws, params of unused rule files."""
    tables = {
        controllers.table(robot.controllers, law)[0] for law in laws for robot in plan.scenario.scenario.robots.values()
    }
    roles = {name.partition("/")[0] for name in plan.used}
    for table in ("grid", "random"):
        for key in getattr(file.spec, table):
            parts = split_key(key)
            at = parts.index("controllers") + 1 if "controllers" in parts[1:3] else 0
            if at and at < len(parts) and parts[at] not in (*tables, "*"):
                what = f"gains of {parts[at]}"
            elif parts[0] == "rules" and len(parts) > 1 and parts[1] not in (*roles, "*"):
                what = f"rule file {parts[1]}"
            elif key == "run.controller":
                what = "run.controller"
            else:
                continue
            message = f"{table}.{key} varies in vain: no run reads {what}"
            facts = (f"the control laws of the sweep are {', '.join(laws)}",)
            found = file.diagnostic("FZ904", (table, key), message, facts=facts)
            yield dataclasses.replace(found, severity="warning")


def count(file: SpecFile) -> int:
    """Return how many runs each control law has."""
    return file.spec.runs * math.prod(len(values) for values in file.spec.grid.values())


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


def laws_of(file: SpecFile, base: ScenarioFile) -> tuple[str, ...]:
    """Return the control laws of a sweep; words for several laws written out.

    Raises:
        DiagnosticError: For a name that is none.
    """
    laws: list[str] = []
    for name in file.spec.controllers or (base.scenario.run.controller,):
        if name not in controllers.GROUPS and not controllers.exists(name, base.path.parent):
            known = (*controllers.names(), *controllers.GROUPS)
            message = f"controllers: there is no control law {name!r}"
            more = {"facts": (f"there are {', '.join(known)}",), "help": did_you_mean(name, known)}
            raise DiagnosticError([file.diagnostic("FZ904", ("controllers",), message, **more)])
        laws += controllers.group(name)
    return tuple(dict.fromkeys(laws))


def _drafts(
    file: SpecFile,
    base: ScenarioFile,
    path: Path,
    laws: Sequence[str],
    variables: Sequence[Variable],
    fixed: Sequence[str],
    seeded: bool,
) -> Iterator[list[Run]]:
    """Yield the runs of every point of the grid and every repetition, one for each control law."""
    spec, number = file.spec, itertools.count()
    for point in itertools.product(*spec.grid.values()):
        for repetition in range(spec.runs):
            values = dict(zip(spec.grid, point, strict=True))
            values |= {one.key: one.draw(spec.seed, repetition) for one in variables}
            if seeded:
                values[SEED] = int(generator(spec.seed, repetition, SEED).integers(2**32))
            given = (*fixed, *(f"{key}={literal(value)}" for key, value in values.items()))
            name = base.scenario.name
            yield [Run(next(number), name, path, law, repetition, values, given) for law in laws]


def _check(
    file: SpecFile,
    plan: Plan,
    drafts: Iterator[list[Run]],
    laws: Sequence[str],
    rules_folder: Path | None,
    report: Callable[[int], None] | None,
) -> None:
    """Read and prove every run with its values, and take it into the plan.

    Raises:
        DiagnosticError: With the mistakes of the first runs that have any.
    """
    known, mistakes, bad = Known(), dict[tuple[str, str, str], Diagnostic](), 0
    for group in drafts:
        first = group[0]
        try:
            changed = _read(file, first.path, first.overrides, first.values, first.number)
            rules = Rules(changed.scenario.rules, folders(rules_folder, changed), changed.places, known)
            try:
                preflight.check(changed, laws, rules)
            except DiagnosticError as error:
                raise _blame(file, error, first.values, first.number) from None
        except DiagnosticError as error:
            for one in error.diagnostics:
                # what is wrong in every run, such as a misspelt key, shows once
                mistakes.setdefault((one.code, one.place, one.message.partition(": ")[2]), one)
            bad += 1
            if bad == MOST_SHOWN:
                break
            continue
        plan.used |= {f"{role}/{used.path.name}": used.sha256 for role, used in rules.used.items()}
        plan.runs += [dataclasses.replace(run, sha256=changed.sha256) for run in group]
        if report is not None:
            report(len(plan.runs) // len(laws))
    if mistakes:
        raise DiagnosticError(tuple(mistakes.values()))


def _read(
    file: SpecFile, path: Path, overrides: Sequence[str], values: Mapping[str, Any], number: int | None = None
) -> ScenarioFile:
    try:
        return scenario_file.read(path, overrides)
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
        shown = ", ".join(f"{k} = {literal(v)}" for k, v in list(values.items())[:4])
        facts = (*facts, f"run {number} has {shown}{', ...' if len(values) > 4 else ''}")
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
