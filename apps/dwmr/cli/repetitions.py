"""Commands that run scenarios many times: `dwmr compare`, with confidence intervals, and `dwmr sweep`."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from dwmr.control import laws as controllers
from dwmr.scenario.file import UnknownScenarioError, find
from fuzzyctl.cli.progress import stages
from fuzzyctl.cli.streams import outlive, say, terminated_as_interrupted, write_json
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
    from dwmr.sweep.bench import Entry as BenchEntry
    from dwmr.sweep.bench import Tuned
    from dwmr.sweep.comparison import Entry
    from fuzzyctl.experiments.sweep_plan import Plan
    from fuzzyctl.experiments.sweep_run import Workers
    from fuzzyctl.experiments.sweep_spec import SpecFile


_SEEDS = click.IntRange(0, 2**63 - 1)
_seed_option = click.option("--seed", type=_SEEDS, metavar="N", default=0, help="Seed of all random draws.")
_vary_option = click.option(
    "--vary",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="SPEC",
    show_default="masses, starts and disturbances, by about a tenth",
    help="SPEC of dwmr sweep; its [random] gives the variation.",
)


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
@_seed_option
@_vary_option
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


_COUNTS = click.IntRange(1, 10_000)


@click.command(context_settings={"show_default": True})
@click.argument("scenarios", nargs=-1, required=True, metavar="SCENARIO...")
@click.option(
    "--controller",
    "names",
    metavar="LAWS",
    default="aifqsmc,fcafsmc,smc,kanayama,backstepping,super_twisting",
    help="Control laws, separated by commas; others are compared with the first one.",
)
@click.option("--budget", type=_COUNTS, metavar="N", default=20, help="Candidates for the gains of each law.")
@click.option("--training", type=_COUNTS, metavar="N", default=3, help="Repetitions that laws are tuned on.")
@click.option("--runs", type=_COUNTS, metavar="N", default=10, help="Held-out repetitions.")
@_seed_option
@_vary_option
@run_options.rules_option
@run_options.set_option
@run_options.format_option
def bench(
    scenarios: tuple[str, ...],
    names: str,
    budget: int,
    training: int,
    runs: int,
    seed: int,
    vary: Path | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    style: str,
) -> None:
    """Tune control laws equally in SCENARIOs, shipped names or TOML files, and compare them on held-out runs."""
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        from dwmr.sweep import comparison

        varied, laws = comparison.variation(vary), run_options.words_of(names)
        run_options.require_once("SCENARIO...", scenarios)
        plans = [_plan(varied, one, laws, training + runs, seed, rules_folder, overrides) for one in scenarios]
        _require_names(plans)
        entries, tuned, stopped = _bench(plans, training, budget, seed, rules_folder)
    if style == "json":
        gains = {name: {law: dataclasses.asdict(one) for law, one in by.items()} for name, by in tuned.items()}
        write_json(finite({"tuned": gains, "entries": [dataclasses.asdict(one) for one in entries]}))
    else:
        from dwmr.output import report
        from dwmr.sweep.bench import print_bench

        print_bench(report.console(), entries, budget, training, runs)
    for line in stopped:
        say(f"warning: {line}", err=True)
    if stopped:
        sys.exit(1)


def _bench(
    plans: Sequence[Plan[ScenarioFile]], training: int, budget: int, seed: int, rules_folder: Path | None
) -> tuple[list[BenchEntry], dict[str, dict[str, Tuned]], list[str]]:
    """Return measures, tuned gains by scenario and law, and warnings; an interruption keeps the finished laws."""
    from dwmr.sweep import bench as benchmark
    from dwmr.sweep.robots import Robots

    entries: list[BenchEntry] = []
    tuned: dict[str, dict[str, Tuned]] = {}
    stopped: list[str] = []
    with stages() as begin:
        for plan in plans:
            name, measured = plan.scenario.scenario.name, dict[str, Any]()
            one = benchmark.Bench(Robots(rules_folder), plan, training, budget, seed)
            try:
                for law in dict.fromkeys(run.controller for run in plan.runs):
                    gains = one.tune(law, begin(f"{name}: tuning {law}", budget))
                    begin(f"{name}: running {law}", 0)
                    measured[law] = one.measure(law, gains.gains)
                    tuned.setdefault(name, {})[law] = gains
                    if lost := measured[law].count(None):
                        stopped.append(f"{name}, {law}: {lost} of {len(measured[law])} runs stopped and are left out")
            except KeyboardInterrupt:
                if not tuned:
                    raise
                say(
                    f"interrupted: done are {', '.join(f'{one}: {law}' for one, by in tuned.items() for law in by)}",
                    err=True,
                )
                outlive()
                return [*entries, *benchmark.entries(name, measured, seed)], tuned, stopped
            entries += benchmark.entries(name, measured, seed)
    return entries, tuned, stopped


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
