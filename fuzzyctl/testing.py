"""Check texts and run commands in tests of rule files, and of programs that use them."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from click.testing import CliRunner

from fuzzyctl.analysis.check import check_source
from fuzzyctl.cli.main import main
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.model.block import Block
from fuzzyctl.records import dataclass

__all__ = ["CommandResult", "check_text", "run_command"]


@dataclass(frozen=True)
class CommandResult:
    """The end of a command.

    Args:
        exit_code: 0 done; 1 errors, a refuted claim; 2 wrong usage; 3 undecided.
        output: The text on standard output.
        errors: The text on standard error.
    """

    exit_code: int
    output: str
    errors: str


def check_text(
    text: str, name: str = "<text>", *, folder: str | os.PathLike[str] | None = None, guarantees: bool = True
) -> tuple[tuple[Block, ...], list[Diagnostic]]:
    """Check a text as `fuzzyctl check` checks a file.

    Args:
        text: A rule file, or a file of another tool by the suffix of `name`.
        name: The file name of diagnostics.
        folder: The folder of files that the text uses; None if it may not use any.
        guarantees: Whether to search for quick refutations of guarantees.

    Returns:
        The blocks without errors other than refuted claims, and all diagnostics sorted by location.

    Raises:
        ArgumentError: For an object that is not a text.
    """
    if not isinstance(text, str):
        raise ArgumentError(f"expected a text, got {text!r:.80}")
    within = None if folder is None else Path(folder)
    return check_source(SourceText(name, text), folder=within, guarantees=guarantees)


def run_command(
    *arguments: object, stdin: str | None = None, folder: str | os.PathLike[str] | None = None, **environment: str
) -> CommandResult:
    """Run `fuzzyctl ARGUMENTS` within this process.

    Args:
        arguments: The command and its arguments.
        stdin: The text on standard input.
        folder: The folder to run in; None for the current one.
        environment: Additional environment variables.

    Raises:
        Exception: Any exception that would end the command with a traceback.
    """
    with contextlib.chdir(folder or "."):
        result = CliRunner(env=environment).invoke(main, [str(x) for x in arguments], input=stdin, prog_name="fuzzyctl")
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return CommandResult(result.exit_code, result.stdout, result.stderr)
