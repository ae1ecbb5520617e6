"""`fuzzyctl fmt`: one canonical layout."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from fuzzyctl.cli.common import DONE, FAILED, answers_with_diagnostics, show
from fuzzyctl.errors import Diagnostic, DiagnosticError
from fuzzyctl.files import written_whole


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--check", "only_check", is_flag=True, help="Change nothing; exit 1 if a file is laid out otherwise.")
@answers_with_diagnostics
def fmt(files: tuple[str, ...], only_check: bool) -> int:
    """Lay rule files out: spacing, indentation, columns of tables.

    Comments and numbers stay as typed. '-' reads standard input and writes standard output.
    A file with syntax errors is left alone.
    """
    failed = False
    for file in files:
        try:
            failed = _format_file(file, only_check) or failed
        except DiagnosticError as error:
            show(error.diagnostics)
            failed = True
    return FAILED if failed else DONE


def _format_file(file: str, only_check: bool) -> bool:
    """Format one file; returns whether that is a failure."""
    from fuzzyctl.lang.formatter import format_source
    from fuzzyctl.lang.parser import parse
    from fuzzyctl.reading import decode, read_source

    source = decode(sys.stdin.buffer.read(), "<stdin>") if file == "-" else read_source(file)
    _, mistakes = parse(source)
    if mistakes:
        raise DiagnosticError(mistakes)
    text = format_source(source)
    if "".join(text.split()) != "".join(source.text.split()):
        message = "the layout would change more than white space; the file is left alone"
        raise DiagnosticError([Diagnostic("FZ005", message, file=source.name, help="please report this file")])
    if file == "-":
        click.echo(text, nl=False)
        return False
    if text == _as_stored(file):
        return False
    if only_check:
        click.echo(f"{file}: would be laid out otherwise")
        return True
    with written_whole(file) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    click.echo(f"{file}: laid out")
    return False


def _as_stored(file: str) -> str:
    """Return the file with its line ends as they are, so that CRLF counts as another layout."""
    return Path(file).read_bytes().decode("utf-8")
