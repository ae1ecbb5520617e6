"""`dwmr calibrate SCENARIO`: fit of unpublished values to the paper's Table 12."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.table import Table

from dwmr.calibration.parameters import PARAMETERS, USUAL, present, scenario_text
from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics, refuse_present
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import INTERRUPTED, interrupts_wait, say, terminated_as_interrupted, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.result_files import finite
from fuzzyctl.support.cores import cores
from fuzzyctl.support.writing import write_together

if TYPE_CHECKING:
    from dwmr.calibration.search import Found
    from dwmr.scenario.model import Scenario


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@click.option(
    "--parameters",
    "names",
    metavar="NAMES",
    show_default="amplitudes and partition",
    help="Parameters to fit, such as constant_v,half_width; an unknown name lists all.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(1, 1_000_000),
    default=1000,
    metavar="N",
    help="About how many sets of values to run.",
)
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, metavar="S", help="Seed of the search.")
@click.option(
    "--jobs",
    type=click.IntRange(1, 256),
    show_default="all cores",
    metavar="N",
    help="Processes; the result does not depend on it.",
)
@click.option(
    "-o",
    "--output",
    "path",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("calibrated.toml"),
    metavar="FILE",
    help="Scenario to write.",
)
@click.option("--force", is_flag=True, help="Replace a file that exists.")
@run_options.format_option
def calibrate(
    scenario: str,
    names: str | None,
    evaluations: int,
    seed: int,
    jobs: int | None,
    path: Path,
    force: bool,
    style: str,
) -> None:
    """Fit values of SCENARIO that the paper does not print to its Table 12, all control laws together.

    Writes a scenario that extends SCENARIO with the values found.
    """
    wanted = _parameters(names)
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        task = run_options.read(scenario, None, ())
        start = _start(task, wanted, path, force)
        result = _search(task, start, evaluations, seed, jobs or cores())
        with interrupts_wait():
            _report(task, result, path, style)
    if result.interrupted:
        sys.exit(INTERRUPTED)


def _parameters(names: str | None) -> tuple[str, ...]:

    if names is None:
        return USUAL
    wanted = tuple(name.strip() for name in names.split(","))
    for name in wanted:
        if name not in PARAMETERS:
            hint = did_you_mean(name, tuple(PARAMETERS))
            message = f"{name!r} is none of {', '.join(PARAMETERS)}" + (f"; {hint}" if hint else "")
            raise click.BadParameter(message, param_hint="'--parameters'")
    if len(set(wanted)) < len(wanted):
        raise click.BadParameter("a parameter is named twice", param_hint="'--parameters'")
    return wanted


def _start(task: run_options.Task, names: tuple[str, ...], path: Path, force: bool) -> dict[str, float]:
    """Refuse a calibration that is impossible, or whose result cannot be written."""
    from dwmr.calibration.search import LAWS
    from dwmr.results.paper_tables import TABLE_12

    file = task.file
    run_options.check(task, LAWS)
    missing = [name for name in TABLE_12["smc"] if name not in file.scenario.robots]
    if missing:
        message = f"robots: Table 12 has a robot {missing[0]!r}, this scenario has none"
        raise DiagnosticError([file.places.diagnostic("FZ903", "robots", message)])
    refuse_present([path], force)
    if path.exists() and any(path.samefile(one) for one in file.files):
        raise click.BadParameter(f"{path} is the scenario itself, or one that it extends", param_hint="'--output'")
    if not path.parent.is_dir():
        raise DiagnosticError([Diagnostic("FZ005", f"{path} cannot be written: there is no folder {path.parent}")])
    values = dict(zip(names, present(file.scenario, names, file.places), strict=True))
    _warn_of_another_run(file.scenario)
    return values


def _warn_of_another_run(scenario: Scenario) -> None:
    """Warn of a scenario that differs from the printed values of Table 12's run."""
    from dwmr.results.paper_tables import as_text, differences

    if keys := differences(scenario, fitted=True):
        say(f"warning: {as_text(keys)}: Table 12 speaks of another run", err=True)


def _search(task: run_options.Task, start: dict[str, float], evaluations: int, seed: int, jobs: int) -> Found:
    from dwmr.calibration.search import search

    with progress() as begin:
        return search(task.file, start, evaluations, seed, jobs, begin("calibrating", evaluations))


def _report(task: run_options.Task, found: Found, path: Path, style: str) -> None:
    """Write the scenario and print the result."""
    from dwmr.output import report

    head = (
        f"{task.file.scenario.name} with values fitted to Table 12 by `dwmr calibrate`, cost {found.outcome.cost:.2f}."
    )
    text = scenario_text(task.file, found.values, path, head)
    write_together({path: text})
    data: dict[str, Any] = found.data()
    if style == "json":
        write_json(finite(data))
        return
    _show(report.console(), data)
    if found.interrupted:
        say("interrupted: these are the best values until then", err=True)
    say(f"wrote {path}")


def _show(out: Console, data: Mapping[str, Any]) -> None:
    """Print the result."""
    values = _table("Values", "parameter", "unit", "from", "to", "before", "now")
    for name, one in data["parameters"].items():
        bounds = (f"{PARAMETERS[name].low:g}", f"{PARAMETERS[name].high:g}")
        values.add_row(name, one["unit"], *bounds, f"{one['before']:.3f}", f"{one['value']:.3f}")
    out.print(values)
    out.print()
    ratios = _table("Errors over Table 12; least and greatest with one value changed by 5 %", "law", "robot", "error")
    for title in ("Table 12", "before", "now", "least", "greatest"):
        ratios.add_column(title, justify="right")
    for k, one in enumerate(data["entries"]):
        numbers = (f"{one[name]:.2f}" for name in ("before", "ratio", "least", "greatest"))
        ratios.add_row(
            one["law"], one["robot"], one["error"], f"{one['table_12']:.4f}", *numbers, end_section=k % 9 == 8
        )
    out.print(ratios)
    cost = data["cost"]
    out.print(f"cost {cost['before']:.2f} before, {cost['value']:.2f} now", highlight=False)


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", header_style="bold dim", box=None)
    for column in columns:
        table.add_column(column)
    return table
