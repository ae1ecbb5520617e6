"""`fuzzyctl check`: all mistakes of rule files at once."""

from __future__ import annotations

import click

from fuzzyctl.cli.common import DONE, FAILED, FORMAT, answers_with_diagnostics, show
from fuzzyctl.errors import Diagnostic, DiagnosticError


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@FORMAT
@answers_with_diagnostics
def check(files: tuple[str, ...], form: str) -> int:
    """Find the mistakes of rule files.

    Prints every mistake with file, line, column and repair. A system without 'else' must have a rule for every
    point of its inputs' ranges; this is proved, not sampled. Exit code 1 if there is an error; warnings pass.
    """
    from fuzzyctl.checking import check as check_file

    found: list[Diagnostic] = []
    clean = []
    for file in files:
        try:
            system, diagnostics = check_file(file)
        except DiagnosticError as error:
            system, diagnostics = None, list(error.diagnostics)
        found.extend(diagnostics)
        if system is not None:
            clean.append(f"{file}: {system.name}: {len(system.rules)} rules, no errors")
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
