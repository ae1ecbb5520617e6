"""Command line: `dwmr run SCENARIO`. Heavy parts are imported inside the commands that need them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr import controllers

if TYPE_CHECKING:
    from dwmr.scenario_file import ScenarioFile
    from dwmr.simulate import Trajectory
    from fuzzyctl.errors import Diagnostic

ALL = "all"


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="fuzzyctl")
def main() -> None:
    """Simulate formations of mobile robots under sliding mode control.

    \b
    dwmr run paper                              the paper's run: three robots, an eight, three obstacles
    dwmr run paper --controller all             all control laws beside the paper's Table 12
    dwmr run paper --rules my-rules             the same with your own rule files
    dwmr run paper --set rules.ais_reaction.k_s=0.5 --set run.horizon=60
    """


@main.command(context_settings={"show_default": True})
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
    with _mistakes_as_diagnostics(style):
        file = _read(scenario, overrides)
        summary, finished = _run(file, controller, rules_folder, overrides, folder, style)
    if style == "json":
        from dwmr.outputs import to_json

        click.echo(to_json(summary), nl=False)
    if not finished:
        sys.exit(1)


def _read(scenario: str, overrides: Sequence[str]) -> ScenarioFile:
    from dwmr import overrides as values
    from dwmr import scenario_file

    try:
        return scenario_file.read(scenario_file.find(scenario), overrides)
    except (scenario_file.UnknownScenarioError, values.OverrideError) as error:
        raise click.UsageError(str(error)) from error


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
    from dwmr.folder import prepare_folder, write
    from dwmr.fuzzy_gains import Rules

    names = controllers.names() if controller == ALL else (controller or file.scenario.run.controller,)
    rules = Rules(file.scenario.rules, (*([rules_folder] if rules_folder else []), file.path.parent), file.places)
    check(file, names, rules)
    prepare_folder(folder)

    # the compiler and the plots come only now, when nothing stands in the way of the run
    from dwmr import compiled, figures, outputs, report, simulate
    from dwmr.metrics import TABLE_12_HORIZON, measure
    from dwmr.summary import describe

    simulations = [simulate.prepare(file, name, rules) for name in names]
    if not compiled.COMPILED:
        click.echo(
            "numba is not installed: the run is computed in plain Python, about a hundred times slower", err=True
        )
    trajectories = _simulate(simulations)
    summary = describe(file, rules, overrides)
    summary["controllers"] = {t.controller: measure(t, file.scenario) for t in trajectories}
    outputs.write_trajectories(folder, trajectories, file.scenario.run.save_every, summary | {"controllers": None})
    write(folder, "path.png", lambda p: figures.draw_path(p, trajectories, file.scenario))
    write(folder, "errors.png", lambda p: figures.draw_errors(p, trajectories, file.scenario))
    outputs.write_summary(folder, summary)
    if style == "text":
        whole = file.scenario.run.horizon >= TABLE_12_HORIZON
        report.print_report(report.console(), summary, compare=file.scenario.name == "paper" and whole)
        click.echo(f"results in {folder}: summary.json, trajectory.npz, path.png, errors.png")
    return summary, all(t.stop is None for t in trajectories)


def _simulate(simulations: Sequence[Any]) -> list[Trajectory]:
    """Run the simulations one after another with a progress display on a terminal; Ctrl-C keeps what is done."""
    from dwmr.simulate import run as run_simulation

    trajectories: list[Trajectory] = []
    with _progress() as start:
        for simulation in simulations:
            trajectory = run_simulation(simulation, start(simulation.name, simulation.scenario.run.steps + 1))
            trajectories.append(trajectory)
            if trajectory.stop is not None and trajectory.stop.reason == "interrupted":
                break
    return trajectories


@contextmanager
def _progress() -> Iterator[Callable[[str, int], Callable[[int], None]]]:
    """Offer a function that begins a progress bar and returns how to move it; silent unless on a terminal."""
    if not sys.stderr.isatty():
        yield lambda name, total: lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:

        def start(name: str, total: int) -> Callable[[int], None]:
            task = progress.add_task(f"{name} (compiling at the first run)", total=total)

            def move(done: int) -> None:
                progress.update(task, completed=done, description=name)

            return move

        yield start


@contextmanager
def _mistakes_as_diagnostics(style: str) -> Iterator[None]:
    """Print diagnostics instead of a traceback and leave with status 1."""
    from fuzzyctl.errors import DiagnosticError

    try:
        yield
    except DiagnosticError as error:
        _show(error.diagnostics, style)
        sys.exit(1)


def _show(diagnostics: Sequence[Diagnostic], style: str) -> None:
    import json

    from fuzzyctl.errors import render_all

    if style == "json":
        click.echo(json.dumps({"diagnostics": [d.as_dict() for d in diagnostics]}, indent=2, ensure_ascii=False))
    else:
        click.echo(render_all(diagnostics, color=sys.stderr.isatty()), err=True)
