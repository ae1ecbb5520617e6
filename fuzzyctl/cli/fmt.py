"""`fuzzyctl fmt`: one canonical layout."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import click

from fuzzyctl.cli.common import DIAGNOSTICS_FORMAT, DONE, FAILED, answers_with_diagnostics, show
from fuzzyctl.cli.loading import content_of, require_own
from fuzzyctl.cli.streams import print_diff, say, write_data
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.support.files import Place
from fuzzyctl.support.writing import written_whole


@dataclass(frozen=True)
class _Laid:
    """A file and its canonical layout.

    Args:
        source: The file as read, without a byte order mark.
        stored: Its text on disk, line ends included.
        text: Its canonical layout.
        place: Where it is.
    """

    source: SourceText
    stored: str
    text: str
    place: Place


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--check", "only_check", is_flag=True, help="Change nothing; exit 1 if a file is not formatted.")
@click.option("--diff", "only_diff", is_flag=True, help="Print what would change; change nothing; exit 1 if anything.")
@DIAGNOSTICS_FORMAT
@answers_with_diagnostics
def fmt(files: tuple[str, ...], only_check: bool, only_diff: bool, form: str) -> int:
    """Format rule files: spacing, indentation, columns of tables.

    Comments and numbers stay as typed. '-' reads standard input and writes standard output.
    A file with syntax errors is not changed.
    """
    if form != "text" and (not only_check or only_diff):
        raise click.UsageError("'--format' belongs to '--check'")
    diagnostics: list[Diagnostic] = []
    for file in files:
        try:
            laid = _laid_out(file)
            if not (only_check or only_diff):
                require_own(laid.place)
            if only_check or only_diff:
                diagnostics.extend(_differences(laid, only_check, only_diff, form))
            elif file == "-":
                write_data(laid.text)
            elif laid.text != laid.stored:
                with written_whole(laid.place.path) as temporary:
                    temporary.write_text(laid.text, encoding="utf-8", newline="\n")
                say(f"{file}: laid out")
        except DiagnosticError as error:
            if form == "text":
                show(error.diagnostics)
            diagnostics.extend(error.diagnostics)
    if form != "text":
        show(diagnostics, form)
    return FAILED if diagnostics else DONE


def _laid_out(file: str) -> _Laid:
    """Read a file and lay it out.

    Raises:
        DiagnosticError: When it cannot be read, or has syntax errors.
    """
    from fuzzyctl.formats.registry import format_of
    from fuzzyctl.lang.formatter import format_source
    from fuzzyctl.lang.parser import parse
    from fuzzyctl.support.files import decode

    foreign = format_of(file)
    if foreign is not None:
        message = f"only .fz files are laid out, and this is a {foreign.suffixes[0]} file"
        help_text = f"'fuzzyctl convert {file} {Path(file).stem}.fz' makes one"
        raise DiagnosticError([Diagnostic("FZ602", message, file=file, help=help_text)])
    data, place = content_of(file)
    source = decode(data, place.name)
    _, mistakes = parse(source)
    if mistakes:
        raise DiagnosticError(mistakes)
    text = format_source(source)
    if "".join(text.split()) != "".join(source.text.split()):
        message = "the layout would change more than white space; the file is left alone"
        raise DiagnosticError([Diagnostic("FZ006", message, file=source.name, help="please report this file")])
    # With line ends and byte order mark as they are, so that CRLF counts as another layout.
    return _Laid(source, data.decode("utf-8"), text, place)


def _differences(laid: _Laid, only_check: bool, only_diff: bool, form: str) -> list[Diagnostic]:
    """Print which files are not formatted, and return their diagnostics."""
    if laid.text == laid.stored:
        return []
    name = laid.source.name
    if only_diff:
        print_diff(name, laid.stored, laid.text)
    elif form == "text":
        say(f"{name}: the file is not formatted")
    help_text = f"run: fuzzyctl fmt {name}"
    return [Diagnostic("FZ006", "the line is not formatted", _first_difference(laid), help=help_text)]


def _first_difference(laid: _Laid) -> Span:
    """Return the first line that formatting changes; the first of all if only line ends differ."""
    offset = 0
    for line, wanted in zip_longest(laid.source.text.split("\n"), laid.text.split("\n"), fillvalue=""):
        if line.rstrip("\r") != wanted:
            return Span(laid.source, offset, offset + len(line))
        offset += len(line) + 1
    return Span(laid.source, 0, len(laid.source.line_text(1)))
