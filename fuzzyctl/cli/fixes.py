"""`check --fix`: rule files after the fixes of their diagnostics."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import STDIN
from fuzzyctl.cli.loading import folder_of, require_own, source_of
from fuzzyctl.cli.streams import say, write_data
from fuzzyctl.diagnostics.fixes import APPLICABILITIES
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.support.shipped import place_of

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.source import SourceText

_OPTION: Final = "--fix"
_MARK: Final = "\ufeff"


class WithFix(click.Command):
    """A command whose option `--fix` may be followed by how sure the fixes must be."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; `--fix` alone means `--fix sure`."""
        joined: list[str] = []
        for k, word in enumerate(args):
            if word == "--":
                joined += args[k:]
                break
            if joined and joined[-1] == _OPTION and word in APPLICABILITIES:
                joined[-1] = f"{_OPTION}={word}"
            else:
                joined.append(word)
        return super().parse_args(ctx, [f"{_OPTION}=sure" if word == _OPTION else word for word in joined])


def fix_file(file: str, *, likely: bool, only_diff: bool) -> tuple[SourceText, bool]:
    """Fix a rule file in its place, or standard input to standard output, or print what would change.

    Args:
        file: Path of the file, '-' for standard input.
        likely: Whether to make fixes that are only likely.
        only_diff: Whether to print a diff and change nothing.

    Returns:
        The text after the fixes, and whether it differs from what was there.

    Raises:
        DiagnosticError: When the file cannot be read or written; it is then as it was.
    """
    from fuzzyctl.loading.fixing import fix_source

    place = place_of(file)
    if not only_diff:
        require_own(place)
    source = source_of(file)
    done = fix_source(source, folder=folder_of(file), likely=likely)
    changed = done.source is not source
    if only_diff:
        from fuzzyctl.cli.unified_diff import print_diff

        print_diff(STDIN if file == "-" else file, source.text, done.source.text)
    elif file == "-":
        write_data(done.source.text)
    elif changed:
        _write(place.path, done.source.text)
        say(f"{file}: {counted(len(done.repaired), 'mistake')} fixed", err=True)
    return done.source, changed


def _write(path: Path, text: str) -> None:
    """Write a text, behind the byte order mark that the file had, if it had one."""
    from fuzzyctl.support.writing import written_whole

    mark = _MARK if path.read_bytes().startswith(_MARK.encode()) else ""
    with written_whole(path) as temporary:
        temporary.write_text(mark + text, encoding="utf-8", newline="")


def fixable(diagnostics: Collection[Any]) -> str:
    """Return how errors are fixed by the command; empty where none can be."""
    diagnostics = [d for d in diagnostics if d.severity == "error"]
    number = {a: sum(d.fix is not None and d.fix.applicability == a for d in diagnostics) for a in APPLICABILITIES}
    if number["sure"]:
        return f"'--fix' repairs {number['sure']}"
    return f"'--fix likely' may repair {number['likely']}" if number["likely"] else ""
