"""Commands that run scenarios many times: `dwmr compare`, with confidence intervals, and `dwmr sweep`."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from dwmr.control import laws as controllers
from dwmr.scenario.file import UnknownScenarioError, find
from fuzzyctl.cli.streams import say, terminated_as_interrupted, write_json
from fuzzyctl.cli.sweeps import (
    checking,
    computing,
    dask_option,
    data_option,
    failures,
    jobs_option,
    planned,
    require_formats,
    require_one,
    sentence,
    swept,
)
from fuzzyctl.experiments.result_files import finite, one_file, versions, write_csv
from fuzzyctl.experiments.scenario_keys import OverrideError

if TYPE_CHECKING:
    from dwmr.scenario.file import ScenarioFile
    from dwmr.sweep.comparison import Entry
    from fuzzyctl.experiments.sweep_plan import Plan
    from fuzzyctl.experiments.sweep_run import Workers
    from fuzzyctl.experiments.sweep_spec import SpecFile


@click.command(context_settings={"show_default": True})
@click.argument("scenarios", nargs=-1, required=True, metavar="SCENARIO...")
@click.option(
    "--controller",
    "names",
    metavar="LAWS",
    default="all",
    help=f"Control laws, separated by commas; several at once: {', '.join(controllers.GROUPS)}.",
)
@click.option("--runs", type=click.IntRange(1, 100_000), metavar="N", default=1, help="Repetitions with varied values.")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), metavar="N", default=0, help="Seed of all random draws.")
@click.option(
    "--vary",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="SPEC",
    show_default="masses, starts and disturbances, by about a tenth",
    help="SPEC of dwmr sweep; its [random] gives the variation.",
)
@run_options.rules_option
@run_options.set_option
@jobs_option
@dask_option
@click.option(
    "-o", "--output", "path", type=click.Path(path_type=Path), metavar="FILE", help="CSV or Parquet to write."
)
@run_options.format_option
def compare(
    scenarios: tuple[str, ...],
    names: str,
    runs: int,
    seed: int,
    vary: Path | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    jobs: int | None,
    cluster: str | None,
    path: Path | None,
    style: str,
) -> None:
    """Compare control laws in SCENARIOs, shipped names or TOML files, by errors, chattering, distances and collisions.

    With --runs above 1 every law meets the same variations of each scenario, and means have confidence intervals.
    """
    require_one(jobs, cluster)
    _require_format(path)
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        from dwmr.sweep import comparison
        from fuzzyctl.experiments.sweep_run import Workers

        varied = comparison.variation(vary)
        laws = run_options.words_of(names)
        run_options.require_once("SCENARIO...", scenarios)
        plans = [_plan(varied, name, laws, runs, seed, rules_folder, overrides) for name in scenarios]
        _require_names(plans)
        entries = _compute(plans, Workers(jobs, cluster))
        if path is not None:
            _write(path, entries)
    _print(entries, style, runs, plans)
    if path is not None and style == "text":
        say(f"wrote {path}")
    if any(one.stopped for one in entries):
        sys.exit(1)


def _require_format(path: Path | None) -> None:
    if path is None:
        return
    suffix = path.suffix.removeprefix(".").lower()
    if suffix not in ("csv", "parquet"):
        raise click.BadParameter(f"{str(path)!r} ends neither in .csv nor in .parquet.", param_hint="'-o'")
    require_formats([suffix])


def _require_names(plans: Sequence[Plan[ScenarioFile]]) -> None:
    """Refuse scenarios of the same name: the tables could not tell them apart."""
    files: dict[str, Path] = {}
    for file in (plan.scenario for plan in plans):
        name = file.scenario.name
        if name in files and files[name].resolve() == file.path.resolve():
            raise click.BadParameter(f"{file.path} is given twice.", param_hint="'SCENARIO...'")
        if name in files:
            both = f"{files[name]} and {file.path}"
            raise click.UsageError(f"two scenarios have the name {name!r}: {both}; give one of them another 'name'")
        files[name] = file.path


def _plan(
    varied: SpecFile,
    scenario: str,
    laws: Sequence[str],
    runs: int,
    seed: int,
    rules_folder: Path | None,
    overrides: Sequence[str],
) -> Plan[ScenarioFile]:
    """Lay out and check the runs of one scenario; unknown names are wrong usage."""
    from dwmr.sweep import comparison

    try:
        path = find(scenario)
        for name in laws:
            run_options.require_law(name, path.parent, scenario)
        with checking(runs) as report:
            return comparison.make(varied, path, laws, runs, seed, rules_folder, overrides, report)
    except (UnknownScenarioError, OverrideError) as error:
        raise click.UsageError(str(error)) from error


def _compute(plans: Sequence[Plan[ScenarioFile]], workers: Workers) -> list[Entry]:
    from dwmr.sweep import comparison
    from fuzzyctl.experiments.sweep_plan import joined
    from fuzzyctl.experiments.sweep_run import collect
    from fuzzyctl.experiments.sweep_workers import Outcome, setup_of

    runs, done = joined(plans), dict[int, Outcome]()
    outcomes = workers.compute(setup_of(*plans, measures=comparison.GROUPS), runs)
    with failures():
        collect(outcomes, len(runs), 0, lambda outcome: done.update({outcome.number: outcome}), computing)
    return list(comparison.entries(runs, done))


def _write(path: Path, found: Sequence[Entry]) -> None:

    columns = {f.name: [getattr(one, f.name) for one in found] for f in dataclasses.fields(found[0])}
    with one_file(path) as files:
        if path.suffix.lower() == ".csv":
            files.write(path.name, lambda part: write_csv(part, columns))
        else:
            from dwmr.output.data import KEY
            from fuzzyctl.experiments import parquet

            files.write(path.name, lambda part: parquet.write_table(part, columns, {"versions": versions()}, KEY))
        files.publish()


def _print(found: Sequence[Entry], style: str, runs: int, plans: Sequence[Plan[ScenarioFile]] = ()) -> None:
    if style == "json":
        write_json(finite({"runs": runs, "entries": [dataclasses.asdict(one) for one in found]}))
        return
    from dwmr.output import report
    from dwmr.results.paper_tables import beside
    from dwmr.sweep.comparison import print_comparison

    scenarios = [plan.scenario.scenario for plan in plans] if runs == 1 else []
    print_comparison(report.console(), found, runs, {one.name: beside(one)[0] for one in scenarios})


@click.command(context_settings={"show_default": True})
@click.argument("spec", type=click.Path(path_type=Path))
@run_options.rules_option
@run_options.set_option
@run_options.output_option("folder", "dwmr-sweep", "DIR", "Folder for the results.")
@data_option(("csv", "parquet"), "csv", "results")
@jobs_option
@dask_option
@click.option("--resume", is_flag=True, help="Go on with a sweep that was interrupted.")
@run_options.format_option
def sweep(
    spec: Path,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    formats: tuple[str, ...],
    jobs: int | None,
    cluster: str | None,
    resume: bool,
    style: str,
) -> None:
    """Run a scenario many times, with the values that SPEC, a TOML file, gives or draws.

    \b
    scenario = "paper"
    runs = 3
    [set]
    "run.horizon" = 5.0
    [random]
    "robots.*.x_0" = { normal = [0.0, 0.2], relative = "offset" }

    `scenario` is a file beside the SPEC, or a shipped name: 'dwmr show' lists these.

    The folder receives results.csv or results.parquet with one row per run, sweep.json, which says where they come
    from, and times.csv. A sweep that was interrupted or killed goes on with --resume.
    """
    require_one(jobs, cluster)
    require_formats(formats)
    with mistakes_as_diagnostics(style):
        from dwmr.sweep.robots import Robots, read_spec

        file, plan = planned(spec, read_spec, lambda _: Robots(rules_folder), overrides)
        summary = swept(file, plan, overrides, folder, formats, (jobs, cluster), resume).summary
    if style == "json":
        write_json(summary)
    else:
        say(sentence(summary, folder))
