"""Standard output: text in the encoding of the terminal, data in UTF-8."""

from __future__ import annotations

import gc
import io
import os
import re
import signal
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, Final

import click

from fuzzyctl.diagnostics.diagnostic import paint, wrapped
from fuzzyctl.diagnostics.terminal import SPELT, printable, spelt

#: Characters that JSON may hold as they are, and that a terminal acts on or UTF-8 lacks.
_ESCAPED: Final = re.compile("[\\x7f-\\x9f\\u202a-\\u202e\\u2066-\\u2069\\ud800-\\udfff]")

#: Exit code of an interrupted command, by Ctrl-C or SIGTERM: 128 and the number of SIGINT, as shells count.
INTERRUPTED: Final = 130

#: Key of `click.Context.meta` that is present after an interruption that the command outlived.
OUTLIVED: Final = "fuzzyctl.interrupted"

#: New objects between two collections of garbage. A command makes large trees and hardly any cycles; with Python's 700
#: the collector takes half of the time that a large file does.
_COLLECTED: Final = 400_000


class Program(click.Group):
    """A command line program whose text for people never fails for its encoding, and never controls the terminal.

    Args:
        groups: By heading, and by name of a command its module, its function there, and its line in the list of
            commands. The module is imported when the command runs.
        moved: By name of an earlier command the words in place of it.
        options: What `click.Group` takes.
    """

    def __init__(
        self,
        *args: Any,
        groups: Mapping[str, Mapping[str, tuple[str, str, str]]] | None = None,
        moved: Mapping[str, str] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self.groups, self.moved = groups or {}, moved or {}
        self.deferred = {name: row for group in self.groups.values() for name, row in group.items()}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted({*super().list_commands(ctx), *self.deferred})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, or None for an unknown name."""
        if cmd_name not in self.commands and cmd_name in self.deferred:
            module, function, _ = self.deferred[cmd_name]
            self.add_command(getattr(import_module(module), function), cmd_name)
        return super().get_command(ctx, cmd_name)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the first argument names; an unknown one is reported with similar ones."""
        names = self.list_commands(ctx)
        if not ctx.resilient_parsing and not args[0].startswith("-") and args[0] not in names:
            from fuzzyctl.diagnostics.suggestions import did_you_mean

            begun = [f"'{name}'" for name in names if args[0] and name.startswith(args[0])]
            begun = [f"'{self.moved[args[0]]}'"] if args[0] in self.moved else begun
            hint = f"did you mean {' or '.join(begun)}?" if begun else did_you_mean(args[0], names)
            raise click.UsageError(f"No such command {args[0]!r}{f'; {hint}' if hint else '.'}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands."""
        if not self.deferred:
            super().format_commands(ctx, formatter)
            return
        width = max(map(len, self.deferred))
        for heading, group in self.groups.items():
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(width), row[2]) for name, row in group.items()])

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command that the arguments name."""
        gc.set_threshold(_COLLECTED)
        # Matrices are small: two threads on two busy cores decompose 2,000 x 10 numbers 25 times as slowly as one.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read by numpy, which the commands import
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors=SPELT)
        with warnings.catch_warnings(), writable_output():
            warnings.showwarning = _say_warning
            return super().main(*args, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; messages about wrong usage repeat names of files, and an interruption is a single line."""
        try:
            result = super().invoke(ctx)
        except click.ClickException as error:
            error.message = _lines(error.message)  # type: ignore[misc]  # final in its annotation only
            if isinstance(error, click.NoSuchOption) and error.option_name == "--system":
                error.possibilities = ["--block"]  # type: ignore[misc]  # the option of earlier versions
            raise
        except KeyboardInterrupt:
            say("interrupted", err=True)
            sys.exit(INTERRUPTED)
        except SystemExit:
            if OUTLIVED not in ctx.meta:
                raise
        if OUTLIVED in ctx.meta:
            sys.exit(INTERRUPTED)
        return result


@contextmanager
def writable_output() -> Iterator[None]:
    """End the program with one line if standard output cannot be written; a reader such as `head` may leave."""
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except OSError as error:
        with suppress(OSError, ValueError):  # Python would complain again when it closes the stream
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            sys.exit(0)
        place = f"'{error.filename}'" if error.filename else "the output"
        say(f"error: {place} cannot be written: {error.strerror or error}", err=True)
        sys.exit(1)


def _say_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning for people, without the line of the program that gives it."""
    say(f"warning: {message}", err=True)


def say(text: object, *, err: bool = False) -> None:
    """Print text for people, which may have several lines."""
    # Without `file`, click writes UTF-8 to streams that are ASCII.
    click.echo(_lines(str(text)), file=sys.stderr if err else sys.stdout)


def _lines(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))


def use_color(stream: Any) -> bool:
    """Whether a stream is a terminal that wants colour (https://no-color.org)."""
    return bool(stream.isatty()) and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"


def terminal_width(stream: Any) -> int | None:
    """Return the columns of a terminal; None for a pipe or a file, whose lines are read by programs."""
    if not stream.isatty():
        return None
    try:
        return os.get_terminal_size(stream.fileno()).columns or None
    except OSError:
        return None


def table_lines(rows: Iterable[Sequence[str]], align: str = "<") -> list[str]:
    """Return the rows of a table as lines: the first column to the left, the others as `align` says, `<` or `>`."""
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    signs = ("<", *align * (len(widths) - 1))
    cells = [[f"{c:{sign}{w}}" for c, sign, w in zip(row, signs, widths, strict=True)] for row in rows]
    return ["  ".join(row).rstrip() if align == "<" else "  ".join(row) for row in cells]


def write_data(text: str) -> None:
    """Write data to standard output: UTF-8 with its own line ends; a terminal gets it as text for people."""
    if sys.stdout.isatty():
        click.echo(_lines(text), nl=False, file=sys.stdout)
    else:
        click.echo(text.encode("utf-8", "surrogateescape"), nl=False)


def json_text(data: Any) -> str:
    """Return data as JSON that no terminal acts on; numbers that are not finite are for the caller to leave out."""
    import json

    text = json.dumps(data, ensure_ascii=False, indent=2)
    return _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def write_json(data: Any) -> None:
    """Write data as JSON to standard output."""
    write_data(f"{json_text(data)}\n")


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Let Ctrl-C wait while results are written, which takes a second or two; the command exits with `INTERRUPTED`."""
    asked: list[int] = []
    before = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        with suppress(ValueError):  # signals belong to the main thread
            before[number] = signal.signal(number, lambda n, _: asked.append(n))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if asked:
            say("interrupted while the results were written; they are whole", err=True)
            outlive()


def outlive() -> None:
    """Let the command finish its output after an interruption, and then exit with `INTERRUPTED`."""
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta[OUTLIVED] = True


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C, so that finished work is kept."""
    before = None
    with suppress(ValueError):
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)


#: Words that a claim, its reason or the end of the line follows, with their styles.
TONES: Final = {
    **dict.fromkeys(("proved", "met"), "green"),
    **dict.fromkeys(("refuted", "not met", "broken", "problem", "missing"), "red"),
    **dict.fromkeys(("undecided", "stopped", "not installed"), "yellow"),
}
_WORD: Final = re.compile(rf"(?:(?<=: )|^)({'|'.join(TONES)})(?=:|;|$|  \()")
#: The subject of a line: a name with its value, or the text before a colon.
_SUBJECT: Final = re.compile(r"^(?! )(?:\S+(?= = )|(?!(?:problem|proved|met)\b).+?(?=: ))")
#: Columns by which a wrapped line is farther from the left than its first one.
_FARTHER: Final = 4


def painted(text: str, *, color: bool, width: int | None, encoding: str | None) -> str:
    """Return a report as a terminal shows it; see `fuzzyctl.diagnostics.diagnostic.render`."""
    lines = [spelt(printable(line), encoding) for line in text.split("\n")]
    return "\n".join(_shown(line, color=color, width=width) for line in lines)


def _shown(line: str, *, color: bool, width: int | None) -> str:
    """Return a line as a terminal shows it."""
    indent = len(line) - len(line.lstrip(" ")) + _FARTHER
    head, *others = wrapped(line, width, first=0, indent=indent)
    rows = [head, *(" " * indent + other.lstrip(" ") for other in others)]
    if not color:
        return "\n".join(rows)
    rows[0] = _SUBJECT.sub(lambda match: paint(match[0], "bold"), rows[0])
    return "\n".join(_WORD.sub(lambda match: paint(match[0], TONES[match[0]]), row) for row in rows)


def print_diff(name: str, before: str, after: str) -> None:
    """Print the lines of a unified diff that `patch` can apply; in colour on a terminal."""
    lines = _diff(name, before, after)
    if use_color(sys.stdout):
        click.echo("".join(map(_colored, lines)), nl=False, file=sys.stdout)
    else:
        write_data("".join(lines))


def _diff(name: str, before: str, after: str) -> list[str]:
    from difflib import unified_diff

    # Line feeds alone end a line.
    old, new = (re.findall(r"[^\n]*\n|[^\n]+", text) for text in (before, after))
    lines = unified_diff(old, new, name, name)
    return [line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines]


def _colored(line: str) -> str:
    tone = {"-": "31", "+": "32", "@": "36"}.get(line[:1])
    text = printable(line[:-1])
    return f"\x1b[{tone}m{text}\x1b[0m\n" if tone else f"{text}\n"
