"""What goes to standard output: text for people in the encoding of the terminal, data in UTF-8."""

from __future__ import annotations

import gc
import io
import json
import re
import sys
from typing import Any, Final

import click

from fuzzyctl.diagnostics.terminal import SPELT, printable

#: Characters that JSON may hold as they are, and that a terminal acts on or UTF-8 lacks.
_ESCAPED: Final = re.compile("[\\x7f-\\x9f\\u202a-\\u202e\\u2066-\\u2069\\ud800-\\udfff]")

#: New objects between two collections of garbage. A command makes large trees and hardly any cycles; with Python's 700
#: the collector takes half of the time that a large file does.
_COLLECTED: Final = 100_000


class Program(click.Group):
    """A command line program whose text for people never fails for its encoding, and never controls the terminal."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command that the arguments name."""
        gc.set_threshold(_COLLECTED)
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors=SPELT)
        return super().main(*args, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; messages about wrong usage repeat names of files, and an interruption is a single line."""
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            error.message = _lines(error.message)  # type: ignore[misc]  # final in its annotation only
            raise
        except KeyboardInterrupt:
            say("interrupted", err=True)
            sys.exit(1)


def say(text: object, *, err: bool = False) -> None:
    """Print text for people, which may have several lines."""
    # Without `file`, click writes UTF-8 to streams that are ASCII.
    click.echo(_lines(str(text)), file=sys.stderr if err else sys.stdout)


def _lines(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))


def write_data(text: str) -> None:
    """Write data to standard output: UTF-8 with its own line ends; a terminal gets it as text for people."""
    if sys.stdout.isatty():
        click.echo(_lines(text), nl=False, file=sys.stdout)
    else:
        click.echo(text.encode("utf-8", "surrogateescape"), nl=False)


def json_text(data: Any) -> str:
    """Return data as JSON that no terminal acts on; numbers that are not finite are for the caller to leave out."""
    text = json.dumps(data, ensure_ascii=False, indent=2)
    return _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def write_json(data: Any) -> None:
    """Write data as JSON to standard output."""
    write_data(f"{json_text(data)}\n")
