"""Helpers of all commands: reading scenarios, diagnostics."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from dwmr.scenario.file import SHIPPED, ScenarioFile, UnknownScenarioError, find, read
from fuzzyctl.cli.common import show
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import OverrideError


def read_scenario(scenario: str, overrides: Sequence[str]) -> ScenarioFile:
    """Read a scenario given as a shipped name or a path; an unknown name or a malformed override is wrong usage."""
    try:
        path = find(scenario)
        if path.is_relative_to(SHIPPED) and os.path.exists(f"{scenario}.toml"):
            say(f"note: the shipped '{scenario}' is read, not '{scenario}.toml' of this folder", err=True)
        return read(path, overrides)
    except (UnknownScenarioError, OverrideError) as error:
        raise click.UsageError(str(error)) from error


@contextmanager
def mistakes_as_diagnostics(style: str) -> Iterator[None]:
    """Print diagnostics instead of a traceback and leave with status 1."""
    try:
        yield
    except DiagnosticError as error:
        show(error.diagnostics, style)
        sys.exit(1)


def refuse_present(paths: Iterable[Path], force: bool, rules: Path | None = None) -> None:
    """Refuse to replace files, among them those of the folder of --rules.

    Raises:
        DiagnosticError: When one of them exists and `force` is not given.
    """
    present = [path for path in paths if path.exists() or path.is_symlink()]
    if present and not force:
        mistakes = []
        for path in present:
            other = "folder with --rules DIR" if path.parent == rules else "file with -o FILE"
            help_text = f"name another {other}, or replace it with --force"
            mistakes.append(Diagnostic("FZ005", f"{path} exists", help=help_text, file=str(path)))
        raise DiagnosticError(mistakes)
