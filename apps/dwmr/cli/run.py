"""`dwmr run SCENARIO`: run a scenario and write the results to a folder."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import formats as data_formats
from dwmr.cli import running
from dwmr.cli.common import interrupts_wait, mistakes_as_diagnostics, terminated_as_interrupted
from fuzzyctl.cli.streams import say, write_data

if TYPE_CHECKING:
    from dwmr.folder import Results
    from dwmr.simulate import Trajectory


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@running.controller_option
@running.rules_option
@running.set_option
@running.output_option("folder", "dwmr-out", "DIR", "Folder for the results.")
@data_formats.data_option(("npz", "csv", "mat", "parquet"), "npz", "signals")
@running.format_option
def run(
    scenario: str,
    controller: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    formats: tuple[str, ...],
    style: str,
) -> None:
    """Run SCENARIO, a shipped name such as `paper` or a TOML file, and write the results to a folder.

    The folder receives summary.json, path.png, errors.png, and the signals as trajectory.npz or as --data says.
    """
    data_formats.require(formats)
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        task = running.read(scenario, rules_folder, overrides)
        summary, finished = _run(task, running.laws_of(task, controller), folder, formats, style)
    if style == "json":
        from dwmr.outputs import to_json

        write_data(to_json(summary))
    if not finished:
        sys.exit(1)


def _run(
    task: running.Task, names: Sequence[str], folder: Path, formats: Sequence[str], style: str
) -> tuple[dict[str, Any], bool]:
    """Check, run and write; return the summary and whether every run came to its end."""
    from dwmr.folder import results
    from dwmr.outputs import NAMES

    scenario = task.file.scenario
    running.check(task, names)
    with results(folder, NAMES) as files:
        trajectories = running.simulate(task, names)
        with interrupts_wait():
            from dwmr.metrics import measure
            from dwmr.summary import describe

            summary = describe(task.file, task.rules, task.overrides)
            summary["controllers"] = {t.controller: measure(t, scenario) for t in trajectories}
            _write(files, summary, trajectories, formats, task)
    done = len(trajectories) == len(names) and all(t.stop is None for t in trajectories)
    for name in names[len(trajectories) :]:
        say(f"warning: {name} was not run: interrupted", err=True)
    if style == "text":
        from dwmr import report
        from dwmr.paper_run import beside

        printed, why_not = beside(scenario)
        picture = str(folder / "path.png") if (folder / "path.png").exists() else ""
        report.print_report(report.console(), summary, printed, why_not, picture)
        say(f"results in {folder}: {', '.join(n for n in files.names if (folder / n).exists())}")
    return summary, done


def _write(
    files: Results,
    summary: Mapping[str, Any],
    trajectories: Sequence[Trajectory],
    formats: Sequence[str],
    task: running.Task,
) -> None:
    """Write all files of a run; a picture that cannot be drawn is left out with a warning, and costs nothing else."""
    from dwmr import figures, outputs
    from dwmr.summary import texts

    scenario = task.file.scenario
    outputs.write_summary(files, summary)
    about = {**summary, "controllers": None, "scenario": {**summary["scenario"], "text": texts(task.file)}}
    outputs.write_trajectories(files, trajectories, scenario, about, formats)
    for name, draw in (("path.png", figures.draw_path), ("errors.png", figures.draw_errors)):
        try:
            with figures.large_numbers():
                files.write(name, partial(draw, trajectories=trajectories, scenario=scenario))
        except figures.CANNOT_DRAW as error:
            say(f"warning: {name} could not be drawn: {str(error) or type(error).__name__}", err=True)
            files.drop(name)
    files.publish()
