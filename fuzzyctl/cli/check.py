"""`fuzzyctl check`: all mistakes of rule files at once."""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import (
    AS,
    BLOCK,
    DIAGNOSTICS_FORMAT,
    DONE,
    FAILED,
    QUIET,
    STDIN,
    UNDECIDED,
    answers_with_diagnostics,
    heard,
    show,
)
from fuzzyctl.cli.loading import folder_of, require_own, source_of
from fuzzyctl.cli.streams import print_diff, say, write_data
from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.fixes import APPLICABILITIES
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean
from fuzzyctl.support.files import place_of, read_place

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.profiles import ProfileName

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
        The text after the fixes, and whether it differs from the text before.

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
    """Return how errors are fixed by the command; empty if no error has a fix."""
    diagnostics = [d for d in diagnostics if d.severity == "error"]
    number = {a: sum(d.fix is not None and d.fix.applicability == a for d in diagnostics) for a in APPLICABILITIES}
    if number["sure"]:
        return f"'--fix' repairs {number['sure']}"
    return f"'--fix likely' may repair {number['likely']}" if number["likely"] else ""


#: What `--deny` takes besides codes.
WARNINGS: Final = "warnings"
#: The code that leaves the exit code undecided.
UNCOVERED: Final = "FZ407"
#: The parts by which the size of a block is counted, by its kind.
_SIZES: Final = {
    "system": ("rules", "rule"),
    "controller": ("outputs", "output"),
    "plant": ("states", "state"),
    "loop": ("instances", "block"),
}


def _codes(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    """Raise BadParameter for the first unknown diagnostic code."""
    codes = [*CODES, *([WARNINGS] if param.name == "denied" else [])]
    for value in values:
        if value not in codes:
            hint = did_you_mean(value, codes) or "see: fuzzyctl explain"
            raise click.BadParameter(f"no diagnostic code '{value}'; {hint}")
    return values


@click.command(cls=WithFix)
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "--deny", "denied", multiple=True, callback=_codes, metavar="CODE", help="Make a warning, or all 'warnings', fail."
)
@click.option("--allow", "allowed", multiple=True, callback=_codes, metavar="CODE", help="Leave out a warning.")
@click.option(
    "--fix",
    type=click.Choice(APPLICABILITIES),
    metavar="[likely]",
    help="Apply sure fixes, with 'likely' also probable ones; then check the result.",
)
@click.option("--diff", "only_diff", is_flag=True, help="With --fix: print what would change; change nothing.")
@click.option("--watch", is_flag=True, help="Check one file again at every save, with INPUT=VALUE evaluate it.")
@click.option("-o", "--output", "out", metavar="OUT", help="With --watch: picture of the surface, folder of a loop.")
@BLOCK
@AS
@QUIET
@DIAGNOSTICS_FORMAT
@answers_with_diagnostics
def check(
    files: tuple[str, ...],
    denied: tuple[str, ...],
    allowed: tuple[str, ...],
    fix: str | None,
    only_diff: bool,
    watch: bool,
    out: str | None,
    name: str | None,
    profile: ProfileName | None,
    form: str,
) -> int:
    """Find mistakes in rule files.

    Prints every mistake with file, line, column and repair. A system without 'else' must have a rule for every
    point of its inputs' ranges; this is proved, not sampled. Guarantees that are quickly refuted are mistakes too;
    'fuzzyctl prove' decides the others. Exit code 1 if there is an error; warnings pass unless
    they are denied. Exit code 3 without errors if it is not decided whether some rule always fires.

    \b
    fuzzyctl check tipper
    fuzzyctl check --deny warnings --allow FZ208 tipper ais_reaction

    '--fix' applies the fixes of diagnostics to the files; the text of standard input goes to standard output.
    '--fix --diff' prints them as a diff, with exit code 1 if there are any.

    \b
    fuzzyctl check --watch tipper service=7 food=8 -o tip.png
    fuzzyctl check --watch water_tank --block fill -o fill

    '--watch' checks a file again at every save of it or of a file that it uses, evaluates it and draws its surface, or
    runs a loop. If there is a mistake, the earlier picture stays; a refuted guarantee is drawn. Ctrl-C ends it.

    A file '-' is standard input. 'allow' and 'deny' lines of a file apply first: what it allows is not reported.
    """
    if watch:
        if fix is not None or denied or allowed or profile is not None or form != "text":
            raise click.UsageError("--watch takes no other options than -o and --block")
        return watch_file(files[0], files[1:], out, name)
    if out is not None or name is not None:
        raise click.UsageError("-o and --block belong to --watch")
    if only_diff and fix is None:
        raise click.UsageError("'--diff' belongs to '--fix'")
    if only_diff:
        changes = [fix_file(file, likely=fix == "likely", only_diff=True)[1] for file in dict.fromkeys(files)]
        return FAILED if any(changes) else DONE
    reports: list[Diagnostic] = []
    clean: list[str] = []
    for file in dict.fromkeys(files):
        systems, diagnostics = _check_file(file, profile, fix)
        diagnostics = _enforced(diagnostics, denied, allowed)
        reports.extend(diagnostics)
        if not any(d.severity == "error" for d in diagnostics):
            label = STDIN if file == "-" else file
            # The text of standard input is on standard output, after its fixes.
            clean.extend(f"{label}: {_clean(s, diagnostics)}" for s in systems if fix is None or file != "-")
    undecided = any(d.code == UNCOVERED for d in reports)
    reports = heard(reports)
    show(reports, form)
    if form == "text":
        for line in clean:
            say(line)
        if reports:
            hint = fixable(reports) if fix is None else ""
            say(f"\n{_counted(reports)}{'; ' if hint else ''}{hint}", err=True)
    if any(d.severity == "error" for d in reports):
        return FAILED
    return UNDECIDED if undecided else DONE


def _clean(block: Block, diagnostics: list[Diagnostic]) -> str:
    """Return the line for a block without errors; it names the reason for exit code 3 even if quiet."""
    undecided = {d.span for d in diagnostics if d.code == UNCOVERED}
    coverage = "; coverage not decided" if any(o.span in undecided for o in block.outputs) else ""
    parts, word = _SIZES[block.kind]
    return f"{block.name}: {counted(len(getattr(block, parts)), word)}, no errors{coverage}"


def _check_file(file: str, profile: ProfileName | None, fix: str | None) -> tuple[tuple[Block, ...], list[Diagnostic]]:
    """Check a file, after its fixes where they are wanted."""
    from fuzzyctl.analysis.check import check_source

    try:
        source = fix_file(file, likely=fix == "likely", only_diff=False)[0] if fix is not None else source_of(file)
        return check_source(source, folder=folder_of(file), profile=profile)
    except DiagnosticError as error:
        return (), list(error.diagnostics)


def _enforced(diagnostics: list[Diagnostic], denied: tuple[str, ...], allowed: tuple[str, ...]) -> list[Diagnostic]:
    """Apply `--deny` and `--allow`; a code said alone counts more than `warnings`."""
    from fuzzyctl.loading.policy import enforce

    every = set(CODES) - set(allowed) if WARNINGS in denied else set()
    return [
        e
        for d in diagnostics
        for e in enforce([d], allowed, set(denied) | (every if d.severity == "warning" else set()))
    ]


def _counted(diagnostics: list[Diagnostic]) -> str:
    number = Counter(d.severity for d in diagnostics)
    hints = [counted(number["hint"], "hint")] if number["hint"] else []
    return ", ".join([counted(number["error"], "error"), counted(number["warning"], "warning"), *hints])


#: Seconds between two looks at the files.
_INTERVAL: Final = 0.2
#: When a file was written, and its size; None for one that is not there.
_State = dict[Path, tuple[int, int] | None]


def watch_file(file: str, values: Sequence[str], out: str | None, name: str | None) -> int:
    """Check a rule file again at every save, and show the results, until Ctrl-C.

    Args:
        file: The file; a save of a file that it uses counts, too.
        values: `INPUT=VALUE` of a point to evaluate.
        out: The picture of the surface, or the folder of the run of a loop.
        name: The block; a loop is run.
    """
    path = read_place(file)[1].path
    try:
        for _ in _saves(path, lambda: time.sleep(_INTERVAL)):
            if sys.stdout.isatty():
                click.clear()
            say(f"{file}, {time.strftime('%H:%M:%S')}")
            for command in _commands(file, path, values, out, name):
                if _run(command) != DONE and (command[0] != "check" or _is_stopped(path)):
                    break
    except KeyboardInterrupt:
        say("", err=True)
    return DONE


def _commands(file: str, path: Path, values: Sequence[str], out: str | None, name: str | None) -> Iterator[list[str]]:
    """Yield the commands of a save; each runs only if the one before found no mistake."""
    from fuzzyctl.loading.examination import look_through
    from fuzzyctl.support.files import read_source

    yield ["check", file]
    chosen, written = ([option, text] if text is not None else [] for option, text in (("--block", name), ("-o", out)))
    loops = look_through(read_source(path), folder=path.parent, loop=name).loops if chosen else ()
    if name in [loop.name for loop in loops]:
        if values:
            raise click.UsageError(f"values of inputs belong to a system, and '{name}' is a loop")
        yield ["simulate", file, *chosen, *written]
        return
    if values:
        yield ["eval", file, *values, *chosen]
    if written:
        yield ["plot-surface", file, *chosen, *written]


def _is_stopped(path: Path) -> bool:
    """Return whether a file has mistakes besides guarantees that do not hold."""
    from fuzzyctl.analysis.check import check_source
    from fuzzyctl.support.files import read_source

    try:
        return any(d.stops for d in check_source(read_source(path), folder=path.parent)[1])
    except DiagnosticError:
        return True


def _run(words: list[str]) -> int:
    """Run a command of this program and return its exit code."""
    from fuzzyctl.cli.main import main

    try:
        main.main(args=words, prog_name="fuzzyctl", standalone_mode=False)
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 1
    except click.ClickException as error:
        error.show()
        return error.exit_code
    return DONE


def _saves(path: Path, wait: Callable[[], object]) -> Iterator[None]:
    """Yield once at first, and then whenever a file or one that it brings in has changed."""
    seen: _State | None = None
    while True:
        now = _state(path)
        if now != seen:
            seen = now
            yield
        else:
            wait()


def _state(path: Path) -> _State:
    """Return when each of the files was written."""
    from fuzzyctl.loading.assembly import files_read

    try:
        used = files_read(path)
    except DiagnosticError:
        used = ()
    return {p: _written(p) for p in (path, *used)}


def _written(path: Path) -> tuple[int, int] | None:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
