"""Counterparts of the paper: `dwmr figures SCENARIO` draws its figures, `dwmr paper` writes figures and tables."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.progress import Begin, progress, stages
from fuzzyctl.cli.streams import interrupts_wait, outlive, say, terminated_as_interrupted
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.result_files import columns_of, finite, results, write_csv

if TYPE_CHECKING:
    from dwmr.figures.paper import PaperFigure
    from dwmr.page.document import PaperPart
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

    These are Figs. 8 to 28, or Figs. 29 to 39 for rigid bodies. Each figure is drawn from a run under its own control
    law; index.md describes it.
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
    """Warn about figures that do not exist if they were selected by number; index.md lists all."""
    for number, why in left_out.items():
        if asked:
            say(f"warning: figure {number} is left out: {why}", err=True)


def _draw(
    task: run_options.Task, wanted: Sequence[PaperFigure], left_out: dict[int, str], folder: Path, suffix: str
) -> bool:
    """Run the laws that the figures show, draw and write; return whether all came to their end."""
    scenario = task.file.scenario
    laws = tuple(dict.fromkeys(f.law for f in wanted))
    run_options.check(task, laws)
    with results(folder, (*(f.file(suffix) for f in wanted), INDEX)) as files:
        trajectories = {t.controller: t for t in run_options.simulate_whole(task, laws)}
        with progress("") as start:
            move = start("figures", len(wanted))
            for k, figure in enumerate(wanted):
                why = _draw_one(figure, trajectories[figure.law], scenario, suffix, files)
                if why:
                    say(f"warning: figure {figure.number}: {why}", err=True)
                    left_out[figure.number] = why
                move(k + 1)
        drawn = [f.number for f in wanted if f.number not in left_out]
        text = index_text(drawn, left_out, suffix, scenario)
        files.write_text(INDEX, text)
        with interrupts_wait():
            files.publish()
    run_options.say_stops(trajectories.values())
    say(f"{len(drawn)} figure{'s' if len(drawn) != 1 else ''} in {folder}, described in {folder / INDEX}")
    return all(t.stop is None for t in trajectories.values()) and len(drawn) == len(wanted)


def _draw_one(figure: PaperFigure, trajectory: Trajectory, scenario: Scenario, suffix: str, files: Results) -> str:
    """Draw one figure; return why it could not be drawn, or an empty text."""
    from dwmr.figures import draw_file, paper

    why = draw_file(files, figure.file(suffix), lambda path: paper.draw(figure, path, trajectory, scenario))
    if why:
        why = f"it could not be drawn: {why}"
    return why


def index_text(made: Collection[int], left_out: Mapping[int, str], suffix: str, scenario: Scenario) -> str:
    """Return the text of index.md: every figure with its caption, and why others are missing.

    Args:
        made: Numbers of the figures that were drawn.
        left_out: Why others were not, by number.
        suffix: Of the pictures' files.
        scenario: Scenario of the runs.
    """
    from dwmr.figures import paper

    items = [f for f in paper.FIGURES if f in paper.usual(scenario) or f.number in made or f.number in left_out]
    lines = [
        f"# Figures of the scenario {_plain(scenario.name)}",
        "",
        f"Counterparts of Figs. {items[0].number} to {items[-1].number} of Goto, Bertol, Martins, drawn from simulated "
        "runs. Disturbance windows are shaded; a bar at the foot of a panel marks obstacle avoidance, one at its head "
        "the load. Signals are drawn by the least and greatest value of every stretch of time, so that chattering "
        "shows as the band it fills.",
        "",
    ]
    for figure in items:
        lines.append(f"## Fig. {figure.number}: {figure.title} ({figure.subject})")
        lines.append("")
        if figure.number in made:
            lines += [figure.about, "", f"![Fig. {figure.number}]({figure.file(suffix)})", ""]
        else:
            lines += [f"Left out: {left_out.get(figure.number, 'not selected by --only')}.", ""]
    lines += [
        "## The paper's other figures",
        "",
        "Figs. 1 to 4 are drawings of geometry and block diagrams, without numbers. Figs. 5 to 7 are membership "
        "functions: `fuzzyctl plot --terms` draws them from the rule files. Figs. 8 to 28 show the simulation, "
        "`dwmr figures paper`, and Figs. 29 to 39 the experiment, with rigid bodies, `dwmr figures experiment`.",
        "",
    ]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Return text for Markdown with nothing that it would take for markup."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]()<>#+!|" else " " if c in "\r\n" else c for c in text)


#: Scenarios and control laws of the paper: its simulation, and its experiment with rigid bodies.
PARTS = (("paper", ("smc", "aifqsmc", "fcafsmc")), ("experiment", ("aifqsmc",)))
PAGE, MANIFEST = "index.html", "manifest.json"


@click.command(context_settings={"show_default": True})
@run_options.output_option("folder", "dwmr-paper", "DIR", "Folder for tables, figures, page and manifest.")
@run_options.set_option
def paper(folder: Path, overrides: tuple[str, ...]) -> None:
    """Write the counterparts of all tables and figures of the paper's results.

    These are Tables 12 and 13 and Figs. 8 to 39, from the scenarios `paper` and `experiment`. index.html shows all with
    captions and the paper's numbers; manifest.json has checksums and settings.
    """
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        parts, left_out, interrupted = _reproduce(folder, overrides)
    for line in (f"{what} left out: {why}" for what, why in left_out.items()):
        say(f"warning: {line}", err=True)
    for part in parts:
        for line in part.sentences():
            say(line)
    say(f"{sum(len(part.pictures) for part in parts)} figures in {folder}, shown in {folder / PAGE}")
    if interrupted:
        outlive()
    elif not all(part.finished for part in parts):
        sys.exit(1)


def _reproduce(folder: Path, overrides: tuple[str, ...]) -> tuple[list[PaperPart], dict[str, str], bool]:
    """Run, draw and write all; return the parts, reasons for missing ones, and whether Ctrl-C ended it."""
    from dwmr.figures.paper import FIGURES

    parts: list[PaperPart] = []
    left_out: dict[str, str] = {}
    interrupted = False
    tasks = list(_tasks(overrides, left_out))
    tables = [f"table{number}.csv" for number in (12, 13)]
    names = (*tables, *(figure.file("png") for figure in FIGURES), PAGE, MANIFEST)
    with results(folder, names) as files:
        with stages() as begin:
            try:
                for task, laws in tasks:
                    for law in laws:
                        _run_and_draw(task, law, files, parts, left_out, begin)
            except KeyboardInterrupt:
                if not parts:
                    raise
                interrupted = True
        with interrupts_wait():
            _summarise(files, parts, left_out, interrupted)
            files.publish()
    return parts, left_out, interrupted


def _tasks(overrides: tuple[str, ...], left_out: dict[str, str]) -> Iterator[tuple[run_options.Task, tuple[str, ...]]]:
    """Yield the checked scenarios of the paper and their laws, without those of MuJoCo if it is missing."""
    from dwmr.figures.paper import usual
    from dwmr.simulation import mujoco_plant

    for name, laws in PARTS:
        task = run_options.read(name, None, overrides)
        try:
            mujoco_plant.require(task.file)
        except DiagnosticError as error:
            (missing,) = error.diagnostics
            numbers = [figure.number for figure in usual(task.file.scenario)]
            left_out[f"Table 13 and Figs. {numbers[0]} to {numbers[-1]}"] = f"{missing.message}: {missing.help}"
        else:
            run_options.check(task, laws)
            yield task, laws


def _run_and_draw(
    task: run_options.Task,
    law: str,
    files: Results,
    parts: list[PaperPart],
    left_out: dict[str, str],
    begin: Begin,
) -> None:
    """Run a scenario under a law and draw its figures at once, so that an interruption keeps them."""
    from dwmr.figures.paper import usual
    from dwmr.page.document import PaperPart
    from dwmr.results.metrics import measure

    scenario = task.file.scenario
    (trajectory,) = run_options.simulate_whole(task, (law,), begin)
    run_options.say_stops((trajectory,))
    if not parts or parts[-1].scenario is not scenario:
        parts.append(PaperPart(scenario, {"controllers": {}}, {}))
    part = parts[-1]
    part.summary["controllers"][law] = measure(trajectory, scenario)
    part.summary.update(run_options.describe(task))
    figures = [figure for figure in usual(scenario) if figure.law == law]
    move = begin(f"drawing {scenario.name}, {law}", len(figures))
    for k, figure in enumerate(figures):
        try:
            why = figure.obstacle_to(scenario) or _draw_one(figure, trajectory, scenario, "png", files)
        except KeyboardInterrupt:
            files.drop(figure.file("png"))
            raise
        if why:
            left_out[f"Fig. {figure.number}"] = why
        else:
            part.pictures[figure] = files.read(figure.file("png"))
        move(k + 1)


def _summarise(files: Results, parts: Sequence[PaperPart], left_out: Mapping[str, str], interrupted: bool) -> None:
    """Write the tables, the page and the manifest; none of them depends on the time of the runs."""
    from dwmr.page.document import paper_page

    about = {figure.file("png"): figure.caption for part in parts for figure in part.pictures}
    for part in parts:
        if rows := part.table():
            name = f"table{part.printed}.csv"
            about[name] = f"Table {part.printed} beside our errors"
            files.write(name, partial(write_csv, columns=columns_of(rows)))
    about[PAGE] = "all of these on one page"
    files.write_text(PAGE, paper_page(parts, left_out, interrupted))
    manifest = {
        "complete": not left_out and not interrupted,
        "interrupted": interrupted,
        "left_out": dict(left_out),
        "files": {
            name: {"sha256": hashlib.sha256(files.read(name)).hexdigest(), "about": text}
            for name, text in sorted(about.items())
        },
        "runs": [part.origin() for part in parts],
    }
    files.write_text(MANIFEST, json.dumps(finite(manifest), indent=2, ensure_ascii=False) + "\n")
