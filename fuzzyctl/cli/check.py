"""`fuzzyctl check`: all mistakes of rule files at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzzyctl.cli.common import DONE, FAILED, FORMAT, answers_with_diagnostics, show
from fuzzyctl.errors import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.model.system import FuzzySystem


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@FORMAT
@answers_with_diagnostics
def check(files: tuple[str, ...], form: str) -> int:
    """Find the mistakes of rule files.

    Prints every mistake with file, line, column and repair. A system without 'else' must have a rule for every
    point of its inputs' ranges; this is proved, not sampled. Exit code 1 if there is an error; warnings pass.
    """
    from fuzzyctl.checking import check_source
    from fuzzyctl.reading import read_source

    found: list[Diagnostic] = []
    clean: list[str] = []
    for file in files:
        systems: tuple[FuzzySystem, ...] = ()
        try:
            systems, diagnostics = check_source(read_source(file), folder=Path(file).parent)
        except DiagnosticError as error:
            diagnostics = list(error.diagnostics)
        found.extend(diagnostics)
        if not any(d.severity == "error" for d in diagnostics):
            clean.extend(f"{file}: {s.name}: {len(s.rules)} rules, no errors" for s in systems)
    errors = sum(d.severity == "error" for d in found)
    show(found, form)
    if form == "text":
        for line in clean:
            click.echo(line)
        if found:
            click.echo(f"\n{_count(errors, 'error')}, {_count(len(found) - errors, 'warning')}", err=True)
    return FAILED if errors else DONE


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
