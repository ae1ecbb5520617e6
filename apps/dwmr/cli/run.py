"""Commands that run a scenario and write its results: `dwmr run` to a folder, `dwmr report` to one HTML page."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.common import show
from fuzzyctl.cli.progress import Begin, stages
from fuzzyctl.cli.streams import interrupts_wait, outlive, say, terminated_as_interrupted, write_json
from fuzzyctl.cli.sweeps import data_option, require_formats
from fuzzyctl.experiments.result_files import finite, one_file, results, write_summary

if TYPE_CHECKING:
    from dwmr.results.logs import Log
    from dwmr.simulation.simulate import Trajectory
    from fuzzyctl.experiments.result_files import Results


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.controller_option
@run_options.rules_option
@run_options.set_option
@run_options.output_option("folder", "dwmr-out", "DIR", "Folder for the results.")
@data_option(("npz", "csv", "mat", "parquet"), "npz", "signals")
@click.option(
    "--bag",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    show_default=False,
    help="Record the run of one control law as rosbag2, the format of ROS 2, in a new folder.",
)
@click.option(
    "--beside",
    type=click.Path(path_type=Path),
    metavar="TABLE|LOG",
    show_default=False,
    help="Compare the run, also a changed one, with table12 or table13 of the paper, or with a log of real robots: "
    "CSV or rosbag2.",
)
@run_options.format_option
def run(
    scenario: str,
    controller: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    formats: tuple[str, ...],
    bag: Path | None,
    beside: Path | None,
    style: str,
) -> None:
    """Run SCENARIO, a shipped name such as `paper` or a TOML file, and write the results to a folder.

    The folder receives summary.json, path.png, errors.png, and the signals as trajectory.npz or as --data says.
    """
    require_formats(formats)
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        with stages() as begin:
            begin("reading", 0)
            task = run_options.read(scenario, rules_folder, overrides)
            names = run_options.laws_of(task, controller)
            _require_bag(bag, folder, names, task)
            table = _table(beside, names, task)
            logs = _logs(beside, task, folder) if beside is not None and table is None else {}
            summary, written = _run(task, names, folder, formats, bag, logs, begin)
        if len(summary["controllers"]) < len(names) or any(map(_is_interrupted, summary["controllers"].values())):
            say(f"interrupted: the results of {', '.join(summary['controllers'])} until then are in {folder}", err=True)
            outlive()
        if style == "text":
            _say(task, summary, names, folder, written, table)
            if bag is not None:
                say(f"recorded {bag}")
    finished = [run["stopped"] is None for run in summary["controllers"].values()]
    if style == "json":
        write_json(finite(summary))
    if not all(finished):
        sys.exit(1)


def _is_interrupted(run: Mapping[str, Any]) -> bool:
    return run["stopped"] is not None and run["stopped"]["reason"] == "interrupted"


def _require_bag(bag: Path | None, folder: Path, names: Sequence[str], task: run_options.Task) -> None:
    """Refuse a bag that cannot be written, before anything is computed."""
    if bag is None:
        return
    from dwmr.output import bag as rosbag

    if len(names) > 1:
        message = f"a bag holds the run of one control law, and --controller names {len(names)}: {', '.join(names)}."
        raise click.BadParameter(message, param_hint="'--bag'")
    if bag.resolve() == folder.resolve():
        raise click.BadParameter(
            f"{bag} is the folder of the results, and a bag is one of its own.", param_hint="'--bag'"
        )
    if not rosbag.available():
        raise click.ClickException("--bag needs rosbags, which is not installed: pip install 'fuzzyctl[ros]'")
    if unfit := rosbag.unfit_names(task.file.scenario.robots):
        raise click.ClickException("\n".join(unfit))
    rosbag.require_new(bag)


def _table(beside: Path | None, names: Sequence[str], task: run_options.Task) -> int | None:
    """Return the number of the paper's table that --beside names, None if it names another file.

    Raises:
        click.BadParameter: If no law or robot of the run is in the table, and for another table.
    """
    from dwmr.results.paper_tables import TABLES

    tables = {f"table{number}": number for number in TABLES}
    number = tables.get(str(beside))
    if beside is not None and number is None and beside.name.lower().startswith("table") and not beside.exists():
        message = f"{beside} is no file, and the paper's tables are {' and '.join(tables)}."
        raise click.BadParameter(message, param_hint="'--beside'")
    if number is not None:
        robots = set(task.file.scenario.robots)
        if not any(robots & set(TABLES[number].get(name, {})) for name in names):
            rows = "; ".join(f"{law}: {', '.join(by_robot)}" for law, by_robot in TABLES[number].items())
            message = f"Table {number} has no row of this run; it has {rows}."
            raise click.BadParameter(message, param_hint="'--beside'")
    return number


def _logs(path: Path, task: run_options.Task, folder: Path) -> Mapping[str, Log]:
    """Return the logs of a file by robot, and print warnings about them.

    Raises:
        click.BadParameter: If the results replace the file.
    """
    from dwmr.output.data import NAMES
    from dwmr.results import logs

    if path.name in NAMES and path.resolve().parent == folder.resolve():
        message = f"{path} is replaced by the results; name another folder with -o."
        raise click.BadParameter(message, param_hint="'--beside'")
    by_robot, warnings = logs.read_logs(path, task.file.scenario, horizon=task.file.scenario.run.horizon)
    show(warnings)
    return by_robot


def _run(
    task: run_options.Task,
    names: Sequence[str],
    folder: Path,
    formats: Sequence[str],
    bag: Path | None,
    logs: Mapping[str, Log],
    begin: Begin,
) -> tuple[dict[str, Any], list[str]]:
    """Check, run and write; return the summary and the names of the files."""
    from dwmr.output.data import NAMES

    begin("proving", 0)
    run_options.check(task, names)
    with results(folder, NAMES) as files:
        trajectories = run_options.simulate(task, names, begin)
        with interrupts_wait():
            summary = _measure(task, trajectories, logs, begin)
            _write(files, summary, trajectories, formats, task, logs, begin)
            if bag is not None:
                from dwmr.output import bag as rosbag

                begin("recording", 0)
                rosbag.save(bag, trajectories[0], task.file.scenario)
    return summary, [name for name in files.names if (folder / name).exists()]


def _measure(
    task: run_options.Task, trajectories: Sequence[Trajectory], logs: Mapping[str, Log], begin: Begin
) -> dict[str, Any]:
    from dwmr.results.metrics import measure

    move = begin("measuring", len(trajectories))
    summary: dict[str, Any] = {**run_options.describe(task), "controllers": {}}
    for k, one in enumerate(trajectories):
        summary["controllers"][one.controller] = measure(one, task.file.scenario)
        if logs:
            from dwmr.results.logs import differences

            summary["controllers"][one.controller]["log"] = differences(one, logs)
        move(k + 1)
    return summary


def _say(
    task: run_options.Task,
    summary: Mapping[str, Any],
    names: Sequence[str],
    folder: Path,
    written: Sequence[str],
    table: int | None,
) -> None:
    """Print the results, and where they are."""
    from dwmr.output import report
    from dwmr.results.paper_tables import beside

    for name in names[len(summary["controllers"]) :]:
        say(f"warning: {name} was not run: interrupted", err=True)
    printed, why_not = beside(task.file.scenario, table)
    picture = str(folder / "path.png") if "path.png" in written else ""
    report.print_report(report.console(), summary, printed, why_not, picture)
    say(f"results in {folder}: {', '.join(written)}")


def _write(
    files: Results,
    summary: Mapping[str, Any],
    trajectories: Sequence[Trajectory],
    formats: Sequence[str],
    task: run_options.Task,
    logs: Mapping[str, Log],
    begin: Begin,
) -> None:
    """Write all files of a run; a picture that cannot be drawn is left out with a warning."""
    move = begin("drawing", 3)
    from dwmr import figures
    from dwmr.output.data import write_trajectories

    move(1)  # matplotlib is there
    scenario = task.file.scenario
    pictures: dict[str, Callable[..., None]] = {
        "path.png": partial(figures.draw_path, logs=logs), "errors.png": figures.draw_errors,
    }  # fmt: skip
    for k, (name, draw) in enumerate(pictures.items()):
        if why := figures.draw_file(files, name, partial(draw, trajectories=trajectories, scenario=scenario)):
            say(f"warning: {name} could not be drawn: {why}", err=True)
        move(k + 2)
    begin("writing", 0)
    write_summary(files, summary)
    about = {**summary, "controllers": None, "scenario": {**summary["scenario"], "text": task.file.texts}}
    write_trajectories(files, trajectories, scenario, about, formats)
    files.publish()


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.output_option("path", "report.html", "FILE", "HTML page to write; an existing one is replaced.")
@run_options.controller_option
@run_options.rules_option
@run_options.set_option
def report(
    scenario: str, path: Path, controller: str | None, rules_folder: Path | None, overrides: tuple[str, ...]
) -> None:
    """Run SCENARIO, a shipped name or a TOML file, and write one HTML page about it.

    The page holds tables, settings and interactive plots, and opens without a network.
    """
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        task = run_options.read(scenario, rules_folder, overrides)
        finished = _report(task, run_options.laws_of(task, controller), path)
    if not finished:
        sys.exit(1)


def _report(task: run_options.Task, names: tuple[str, ...], path: Path) -> bool:
    """Check, run and write; return whether every run came to its end."""
    run_options.check(task, names)
    with one_file(path) as files:
        trajectories = run_options.simulate_whole(task, names)
        with interrupts_wait():
            from dwmr.page.document import page
            from dwmr.results.metrics import measure

            summary = run_options.describe(task)
            summary["controllers"] = {t.controller: measure(t, task.file.scenario) for t in trajectories}
            text = page(summary, trajectories, task.file.scenario)
            files.write_text(path.name, text)
            files.publish()
    run_options.say_stops(trajectories)
    say(f"wrote {path}: {len(text.encode()) / 1e6:.1f} MB")
    return all(t.stop is None for t in trajectories)
