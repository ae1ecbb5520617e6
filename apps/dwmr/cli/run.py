"""`dwmr run SCENARIO`: run a scenario and write the results to a folder."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr import controllers
from dwmr.cli.common import (
    interrupts_wait,
    mistakes_as_diagnostics,
    progress,
    read_scenario,
    terminated_as_interrupted,
    warn,
)

if TYPE_CHECKING:
    from dwmr.folder import Results
    from dwmr.scenario import Scenario
    from dwmr.scenario_file import ScenarioFile
    from dwmr.simulate import Trajectory

ALL = "all"


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@click.option(
    "--controller",
    type=click.Choice([*controllers.names(), ALL]),
    show_default="the scenario's own",
    help="Control law to run, or all of them.",
)
@click.option(
    "--rules",
    "rules_folder",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder whose rule files replace those of the same name.",
)
@click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Replace a value of the scenario; repeatable."
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("dwmr-out"),
    metavar="DIR",
    help="Folder for the results.",
)
@click.option("--format", "style", type=click.Choice(["text", "json"]), default="text", help="What to print.")
def run(
    scenario: str,
    controller: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    style: str,
) -> None:
    """Run SCENARIO, a shipped name such as `paper` or a TOML file, and write the results to a folder.

    The folder receives summary.json, trajectory.npz, path.png and errors.png.
    """
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        file = read_scenario(scenario, overrides)
        summary, finished = _run(file, controller, rules_folder, overrides, folder, style)
    if style == "json":
        from dwmr.outputs import to_json

        click.echo(to_json(summary), nl=False)
    if not finished:
        sys.exit(1)


def _run(
    file: ScenarioFile,
    controller: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    style: str,
) -> tuple[dict[str, Any], bool]:
    """Prepare, run and write; return the summary and whether every run came to its end."""
    from dwmr.checks import check
    from dwmr.folder import results
    from dwmr.fuzzy_gains import Rules

    names = controllers.names() if controller == ALL else (controller or file.scenario.run.controller,)
    rules = Rules(file.scenario.rules, (*([rules_folder] if rules_folder else []), file.path.parent), file.places)
    if rules_folder:
        rules.require_use_of(rules_folder)
        rules.warnings += rules.near_misses(rules_folder)
    check(file, names, rules)
    warn([*file.warnings, *rules.warnings])
    with results(folder, ("summary.json", "trajectory.npz", "path.png", "errors.png")) as files:
        # the compiler comes only now, when nothing stands in the way of the run
        from dwmr import compiled, simulate
        from dwmr.metrics import TABLE_12_HORIZON, measure
        from dwmr.summary import describe

        simulations = [simulate.prepare(file, name, rules) for name in names]
        simulate.require_memory(simulations, file.places)
        summary = describe(file, rules, overrides)
        if not compiled.COMPILED:
            click.echo(
                "numba is not installed: the run is computed in plain Python, about a hundred times slower", err=True
            )
        trajectories = _simulate(simulations)
        with interrupts_wait():
            summary["controllers"] = {t.controller: measure(t, file.scenario) for t in trajectories}
            _write(files, summary, trajectories, file.scenario)
    done = len(trajectories) == len(names) and all(t.stop is None for t in trajectories)
    for name in names[len(trajectories) :]:
        click.echo(f"warning: {name} was not run: interrupted", err=True)
    if style == "text":
        from dwmr import report

        whole = file.scenario.run.horizon >= TABLE_12_HORIZON
        report.print_report(report.console(), summary, compare=file.scenario.name == "paper" and whole)
        click.echo(f"results in {folder}: {', '.join(n for n in files.names if (folder / n).exists())}")
    return summary, done


def _write(files: Results, summary: Mapping[str, Any], trajectories: Sequence[Trajectory], scenario: Scenario) -> None:
    """Write all files of a run; a picture that cannot be drawn is left out with a warning, and costs nothing else."""
    from dwmr import figures, outputs

    outputs.write_summary(files, summary)
    outputs.write_trajectories(files, trajectories, scenario.run.save_every, {**summary, "controllers": None})
    for name, draw in (("path.png", figures.draw_path), ("errors.png", figures.draw_errors)):
        try:
            with figures.large_numbers():
                files.write(name, lambda path, draw=draw: draw(path, trajectories, scenario))  # type: ignore[misc]
        except figures.CANNOT_DRAW as error:
            click.echo(f"warning: {name} could not be drawn: {str(error) or type(error).__name__}", err=True)
            files.drop(name)
    files.publish()


def _simulate(simulations: Sequence[Any]) -> list[Trajectory]:
    """Run the simulations one after another with a progress display on a terminal.

    An interruption keeps what is done: the laws that are finished, and what the present one has computed.
    """
    from dwmr.simulate import run as run_simulation

    trajectories: list[Trajectory] = []
    try:
        with progress() as start:
            for simulation in simulations:
                trajectory = run_simulation(simulation, start(simulation.name, simulation.scenario.run.steps + 1))
                trajectories.append(trajectory)
                if trajectory.stop is not None and trajectory.stop.reason == "interrupted":
                    break
    except KeyboardInterrupt:
        if not trajectories:
            raise
    return trajectories
