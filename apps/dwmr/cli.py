"""Command line: `dwmr run SCENARIO`. Heavy parts are imported inside the commands that need them."""

from __future__ import annotations

import io
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr import controllers

if TYPE_CHECKING:
    from dwmr.folder import Results
    from dwmr.scenario import Scenario
    from dwmr.scenario_file import ScenarioFile
    from dwmr.simulate import Trajectory
    from fuzzyctl.errors import Diagnostic

ALL = "all"


class Program(click.Group):
    """The command line program; a standard output that cannot be written to is a message, no traceback."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command that the arguments name."""
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):  # a terminal or a file that has no Greek shows question marks
                stream.reconfigure(errors="replace")
        try:
            try:
                return super().main(*args, **kwargs)
            finally:
                sys.stdout.flush()
        except OSError as error:
            with suppress(OSError, ValueError):  # Python would complain again when it closes the stream
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            if not isinstance(error, BrokenPipeError):
                click.echo(f"error: {error}", err=True)
            sys.exit(1)


@click.group(cls=Program, context_settings={"help_option_names": ["-h", "--help"]})
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
    with _mistakes_as_diagnostics(style), _terminated_as_interrupted():
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
    from dwmr.folder import results
    from dwmr.fuzzy_gains import Rules

    names = controllers.names() if controller == ALL else (controller or file.scenario.run.controller,)
    rules = Rules(file.scenario.rules, (*([rules_folder] if rules_folder else []), file.path.parent), file.places)
    if rules_folder:
        rules.require_use_of(rules_folder)
        rules.warnings += rules.near_misses(rules_folder)
    check(file, names, rules)
    _warn([*file.warnings, *rules.warnings])
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
        with _interrupts_wait():
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


def _warn(diagnostics: Sequence[Diagnostic]) -> None:
    from fuzzyctl.errors import render_all

    if diagnostics:
        click.echo(render_all(diagnostics, color=sys.stderr.isatty()), err=True)


def _simulate(simulations: Sequence[Any]) -> list[Trajectory]:
    """Run the simulations one after another with a progress display on a terminal.

    An interruption keeps what is done: the laws that are finished, and what the present one has computed.
    """
    from dwmr.simulate import run as run_simulation

    trajectories: list[Trajectory] = []
    try:
        with _progress() as start:
            for simulation in simulations:
                trajectory = run_simulation(simulation, start(simulation.name, simulation.scenario.run.steps + 1))
                trajectories.append(trajectory)
                if trajectory.stop is not None and trajectory.stop.reason == "interrupted":
                    break
    except KeyboardInterrupt:
        if not trajectories:
            raise
    return trajectories


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Let Ctrl-C wait while results are written, which takes a second or two."""
    asked: list[int] = []
    before = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        with suppress(ValueError):  # signals belong to the main thread
            before[number] = signal.signal(number, lambda n, _: asked.append(n))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if asked:
            click.echo("interrupted while the results were written; they are whole", err=True)


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C, so that it keeps what is done."""
    before = None
    with suppress(ValueError):
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)


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
