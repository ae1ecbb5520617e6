"""`dwmr figures SCENARIO`: the counterparts of the paper's Figs. 8 to 39."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import interrupts_wait, say, terminated_as_interrupted

if TYPE_CHECKING:
    from dwmr.figures.paper import PaperFigure
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory
    from fuzzyctl.experiments.result_files import Results

INDEX = "index.md"


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.output_option("folder", "dwmr-figures", "DIR", "Folder for the pictures and their index.md.")
@click.option("--format", "suffix", type=click.Choice(["png", "pdf", "svg"]), default="png", help="Kind of pictures.")
@click.option("--only", metavar="NUMBERS", help="Only these figures, such as 8,12 or 13-23.")
@run_options.rules_option
@run_options.set_option
def figures(
    scenario: str,
    folder: Path,
    suffix: str,
    only: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
) -> None:
    """Draw the counterparts of the paper's figures for SCENARIO, a shipped name or a TOML file.

    They are Figs. 8 to 28, and of rigid bodies Figs. 29 to 39. Each figure is drawn from a run under its own control
    law; index.md says what it shows.
    """
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        task = run_options.read(scenario, rules_folder, overrides)
        # matplotlib comes only now, when there is a scenario to draw
        wanted = _wanted(only, task.file.scenario)
        left_out = {f.number: why for f in wanted if (why := f.obstacle_to(task.file.scenario))}
        wanted = [f for f in wanted if f.number not in left_out]
        _say(left_out, only is not None)
        if not wanted:
            raise click.ClickException("the scenario has none of these figures")
        finished = _draw(task, wanted, left_out, folder, suffix)
    if not finished:
        sys.exit(1)


def _wanted(only: str | None, scenario: Scenario) -> list[PaperFigure]:
    from dwmr.figures import paper

    try:
        chosen = [f.number for f in paper.usual(scenario)] if only is None else paper.numbers(only)
    except ValueError as error:
        raise click.UsageError(f"--only {only}: {error}") from error
    return [f for f in paper.FIGURES if f.number in chosen]


def _say(left_out: Mapping[int, str], asked: bool) -> None:
    """Name figures that were asked for by number and do not exist; of the others index.md speaks."""
    for number, why in left_out.items():
        if asked:
            say(f"warning: figure {number} is left out: {why}", err=True)


def _draw(
    task: run_options.Task, wanted: Sequence[PaperFigure], left_out: dict[int, str], folder: Path, suffix: str
) -> bool:
    """Run the laws that the figures show, draw and write; return whether all came to their end."""
    from dwmr.figures.index import index
    from fuzzyctl.experiments.result_files import results

    scenario = task.file.scenario
    laws = tuple(dict.fromkeys(f.law for f in wanted))
    run_options.check(task, laws)
    with results(folder, (*(f.file(suffix) for f in wanted), INDEX)) as files:
        trajectories = {t.controller: t for t in run_options.simulate(task, laws)}
        if len(trajectories) < len(laws) or any(
            t.stop and t.stop.reason == "interrupted" for t in trajectories.values()
        ):
            raise KeyboardInterrupt
        with progress("") as start:
            move = start("figures", len(wanted))
            for k, figure in enumerate(wanted):
                why = _draw_one(figure, trajectories[figure.law], scenario, suffix, files)
                if why:
                    left_out[figure.number] = why
                move(k + 1)
        made = [f.number for f in wanted if f.number not in left_out]
        text = index(made, left_out, suffix, scenario)
        files.write(INDEX, lambda path: _write(path, text))
        with interrupts_wait():
            files.publish()
    run_options.say_stops(trajectories.values())
    say(f"{len(made)} figure{'s' if len(made) != 1 else ''} in {folder}, described in {folder / INDEX}")
    return all(t.stop is None for t in trajectories.values()) and len(made) == len(wanted)


def _draw_one(figure: PaperFigure, trajectory: Trajectory, scenario: Scenario, suffix: str, files: Results) -> str:
    """Draw one figure; return why it could not be drawn, or an empty text."""
    from dwmr.figures import CANNOT_DRAW, large_numbers, paper

    name = figure.file(suffix)
    try:
        with large_numbers():
            files.write(name, lambda path: paper.draw(figure, path, trajectory, scenario))
    except CANNOT_DRAW as error:
        files.drop(name)
        why = f"it could not be drawn: {str(error) or type(error).__name__}"
        say(f"warning: figure {figure.number}: {why}", err=True)
        return why
    return ""


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
