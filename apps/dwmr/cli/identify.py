"""`dwmr identify`: parameters of a robot's body and drives from a log."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics, read_scenario
from fuzzyctl.cli.common import show
from fuzzyctl.cli.progress import stages
from fuzzyctl.cli.streams import say, terminated_as_interrupted, write_json
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.result_files import finite, one_file
from fuzzyctl.experiments.scenario_keys import literal

if TYPE_CHECKING:
    from dwmr.results.identification import Estimate, Identified
    from dwmr.scenario.file import ScenarioFile
    from dwmr.scenario.model import Scenario


#: Repairs of a log.
_LOG = "log a differential drive under commands that change by large steps, and its velocities, without long gaps"
_UNITS = "write v and v_c in m/s, omega and omega_c in rad/s, with the same signs"


@click.command(context_settings={"show_default": True})
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--scenario", default="paper", metavar="SCENARIO", help="Scenario of the robots; values start from it.")
@run_options.set_option
@click.option(
    "-o", "--output", "path", type=click.Path(path_type=Path), metavar="FILE", help="Write a scenario with the values."
)
@run_options.format_option
def identify(log: Path, scenario: str, overrides: tuple[str, ...], path: Path | None, style: str) -> None:
    """Identify mass, inertia, friction, lag, limits of acceleration and dead time of robots from a LOG.

    LOG is a CSV file or a rosbag2 with the commands and velocities of robots of the scenario. The plant of the scenario
    is fitted to it; intervals are of 95 % confidence.
    """
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        file = read_scenario(scenario, overrides)
        if path is not None and path.resolve() in (log.resolve(), file.path.resolve()):
            raise click.BadParameter(f"{path} is read; write another file.", param_hint="'--output'")
        with nullcontext() if path is None else one_file(path) as files:
            identified = _identified(log, file.scenario)
            if path is not None and files is not None:
                files.write_text(path.name, "\n".join(_toml(log, file, overrides, identified, path)) + "\n")
                files.publish()
    if style == "json":
        write_json(finite({robot: dataclasses.asdict(one) for robot, one in identified.items()}))
        return
    from dwmr.output.report import console, print_identified

    print_identified(console(), identified)
    if path is not None:
        say(f"wrote {path}")


def _identified(path: Path, scenario: Scenario) -> dict[str, Identified]:
    """Return the estimates of each robot of a log.

    Raises:
        DiagnosticError: With the mistakes of the log.
    """
    from dwmr.results import logs
    from dwmr.results.identification import UnexplainedError, identify, obstacle_to
    from dwmr.scenario.vehicle_limits import others

    with stages() as begin:
        begin("reading", 0)
        by_robot, warnings = logs.read_logs(path, scenario, (*logs.VELOCITIES, *logs.COMMANDS))
        reasons = {name: obstacle_to(one) for name, one in by_robot.items()}
        reasons |= {
            name: "only a differential drive can be identified" for name in others(scenario) if name in by_robot
        }
        if any(reasons.values()):
            raise DiagnosticError([logs.mistake(path, f"{name}: {why}", _LOG) for name, why in reasons.items() if why])
        show(warnings)
        identified = {}
        for name, one in by_robot.items():
            try:
                identified[name] = identify(one, scenario, name, begin(f"fitting {name}", 0))
            except UnexplainedError as error:
                raise DiagnosticError([logs.mistake(path, f"{name}: {error}", _UNITS)]) from None
        return identified


def _toml(
    log: Path, file: ScenarioFile, overrides: tuple[str, ...], identified: Mapping[str, Identified], path: Path
) -> Iterator[str]:
    """Yield the lines of a scenario with the determined values, beside those of a scenario."""
    from dwmr.scenario.file import SHIPPED

    is_shipped = file.path.parent == SHIPPED
    base = file.path.stem if is_shipped else os.path.relpath(file.path, path.parent)
    yield f"# Written by `dwmr identify` from {literal(log.name)}; intervals are of 95 % confidence."
    if overrides:
        yield f"# Besides --set {' --set '.join(map(literal, overrides))}."
    yield from ("", f"extends = {literal(base)}", f"name = {literal(path.stem)}")
    for robot, one in identified.items():
        tables: dict[str, list[str]] = {"": [], "friction": [], "actuator": []}
        for estimate in one.estimates:
            table, _, key = estimate.key.rpartition(".")
            tables[table].append(_line(key, estimate))
        name = robot if re.fullmatch("[A-Za-z0-9_-]+", robot) else literal(robot)
        for table, lines in tables.items():
            yield from ("", f"[robots.{name}{'.' * bool(table)}{table}]", *lines)


def _line(key: str, estimate: Estimate) -> str:
    """Return a line of a scenario: a comment for a value that is not determined, and for the dead time."""
    if estimate.low is None or estimate.high is None:
        return f"# {key}: {estimate.why}"
    text = f"{key} = {estimate.value:.6g}"
    interval = f"{estimate.unit}, {estimate.low:.4g} to {estimate.high:.4g}"
    return f"# {text}  # {interval}; the plant has none" if key == "dead_time" else f"{text}  # {interval}"
