"""`dwmr calibrate SCENARIO`: fit of unpublished values to the paper's Table 12."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import INTERRUPTED, interrupts_wait, say, terminated_as_interrupted, write_json
from fuzzyctl.support.cores import cores

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
    help="Parameters to fit, such as constant_v,half_width; a word that is none lists them.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(1, 1_000_000),
    default=1000,
    metavar="N",
    help="About how many sets of values to run.",
)
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, metavar="S", help="Of the search.")
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
        found = _search(task, start, evaluations, seed, jobs or cores())
        with interrupts_wait():
            _report(task, found, path, style)
    if found.interrupted:
        sys.exit(INTERRUPTED)


def _parameters(names: str | None) -> tuple[str, ...]:
    from dwmr.calibration.parameters import PARAMETERS, USUAL
    from fuzzyctl.diagnostics.suggestions import did_you_mean

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
    """Refuse what cannot be calibrated, or whose result could not be written, before the search begins."""
    from dwmr.calibration.cost import LAWS
    from dwmr.calibration.parameters import present
    from dwmr.results.metrics import TABLE_12
    from dwmr.scenario import template
    from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

    file = task.file
    run_options.check(task, LAWS)
    missing = [name for name in TABLE_12["smc"] if name not in file.scenario.robots]
    if missing:
        message = f"robots: Table 12 has a robot {missing[0]!r}, this scenario has none"
        raise DiagnosticError([file.places.diagnostic("FZ903", "robots", message)])
    template.refuse_present([path], force)
    if path.exists() and any(path.samefile(one) for one in file.files):
        raise click.BadParameter(f"{path} is the scenario itself, or one that it extends", param_hint="'--output'")
    if not path.parent.is_dir():
        raise DiagnosticError([Diagnostic("FZ005", f"{path} cannot be written: there is no folder {path.parent}")])
    values = dict(zip(names, present(file.scenario, names, file.places), strict=True))
    _warn_of_another_run(file.scenario)
    return values


def _warn_of_another_run(scenario: Scenario) -> None:
    """Warn of a scenario that differs from what is printed of the run behind Table 12."""
    from dwmr.results.paper_run import differences, said

    if found := differences(scenario, fitted=True):
        say(f"warning: {said(found)}: Table 12 speaks of another run", err=True)


def _search(task: run_options.Task, start: dict[str, float], evaluations: int, seed: int, jobs: int) -> Found:
    from dwmr.calibration.search import search

    with progress() as begin:
        return search(task.file, start, evaluations, seed, jobs, begin("calibrating", evaluations))


def _report(task: run_options.Task, found: Found, path: Path, style: str) -> None:
    """Write the scenario and print what was found."""
    from dwmr.calibration import table
    from dwmr.calibration.writing import scenario_text
    from dwmr.output import report
    from fuzzyctl.experiments.result_files import finite
    from fuzzyctl.support.writing import write_together

    head = (
        f"{task.file.scenario.name} with values fitted to Table 12 by `dwmr calibrate`, cost {found.outcome.cost:.2f}."
    )
    text = scenario_text(task.file, found.values, path, head)
    write_together({path: text})
    data: dict[str, Any] = table.as_data(found)
    if style == "json":
        write_json(finite(data))
        return
    table.show(report.console(), data)
    if found.interrupted:
        say("interrupted: these are the best values until then", err=True)
    say(f"wrote {path}")
