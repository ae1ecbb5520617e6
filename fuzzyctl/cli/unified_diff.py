"""Unified diffs of a file and what a command would make of it."""

from __future__ import annotations

import difflib
import re
import sys

import click

from fuzzyctl.cli.common import use_color
from fuzzyctl.cli.streams import write_data
from fuzzyctl.diagnostics.terminal import printable


def print_diff(name: str, before: str, after: str) -> None:
    """Print the lines of a unified diff that `patch` can apply; in colour on a terminal."""
    lines = _diff(name, before, after)
    if use_color(sys.stdout):
        click.echo("".join(map(_colored, lines)), nl=False, file=sys.stdout)
    else:
        write_data("".join(lines))


def _diff(name: str, before: str, after: str) -> list[str]:
    lines = difflib.unified_diff(_lines(before), _lines(after), name, name)
    return [line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines]


def _lines(text: str) -> list[str]:
    """Split a text at line feeds alone, which stay."""
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def _colored(line: str) -> str:
    tone = {"-": "31", "+": "32", "@": "36"}.get(line[:1])
    text = printable(line[:-1])
    return f"\x1b[{tone}m{text}\x1b[0m\n" if tone else f"{text}\n"
