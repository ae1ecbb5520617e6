"""`dwmr check SCENARIO...`: every mistake of scenarios and their rule files, without a run."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import show_diagnostics
from fuzzyctl.cli.streams import say

if TYPE_CHECKING:
    from dwmr.cli.run_options import Task
    from fuzzyctl.diagnostics.diagnostic import Diagnostic


@click.command(context_settings={"show_default": True})
@click.argument("scenarios", nargs=-1, required=True, metavar="SCENARIO...")
@run_options.rules_option
@run_options.set_option
@click.option("--format", "style", type=click.Choice(["text", "json"]), default="text", help="How to print.")
def check(scenarios: tuple[str, ...], rules_folder: Path | None, overrides: tuple[str, ...], style: str) -> None:
    """Check SCENARIOs, shipped names or TOML files, and their rule files; nothing is simulated.

    The rule files of all control laws that a scenario has gains for are read, and what those laws rely on is proved.
    """
    reported: list[Diagnostic] = []
    for scenario in scenarios:
        diagnostics, summary = _check(scenario, rules_folder, overrides)
        reported += [d for d in diagnostics if d not in reported]
        if style == "text" and summary:
            say(summary)
    if style == "json" or reported:
        show_diagnostics(reported, style)
    if any(d.severity == "error" for d in reported):
        sys.exit(1)


def _check(scenario: str, rules_folder: Path | None, overrides: Sequence[str]) -> tuple[list[Diagnostic], str]:
    """Return the diagnostics of one scenario, and what to say of it if it has no errors."""
    from fuzzyctl.diagnostics.diagnostic import DiagnosticError

    try:
        task = run_options.read(scenario, rules_folder, overrides)
    except DiagnosticError as error:
        return list(error.diagnostics), ""
    warnings, laws = [*task.file.warnings], _laws(task)
    try:
        from dwmr.simulation import preflight

        preflight.check(task.file, laws, task.rules)
    except DiagnosticError as error:
        return [*warnings, *task.rules.warnings, *error.diagnostics], ""
    robots, kind = len(task.file.scenario.robots), task.file.scenario.reference.kind
    summary = (
        f"{scenario}: {robots} robot{'s' if robots != 1 else ''} on a reference of kind {kind}; "
        f"{', '.join(laws)}: no errors"
    )
    return [*warnings, *task.rules.warnings], summary


def _laws(task: Task) -> tuple[str, ...]:
    """Return the laws to check: those that some robot has gains for, and the scenario's own choice."""
    from dwmr.scenario.overview import laws_of

    scenario = task.file.scenario
    return tuple(dict.fromkeys([*laws_of(scenario.robots.values()), scenario.run.controller]))
