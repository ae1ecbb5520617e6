"""`fuzzyctl compare`: where two files, or two ways to compute one, differ most, and which setting explains it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from click.core import ParameterSource

from fuzzyctl.cli.common import (
    BLOCK,
    DONE,
    FAILED,
    FORMAT,
    POINTS,
    QUIET,
    SET,
    STATE,
    NotNegative,
    answers_with_diagnostics,
    known_profiles,
    plain,
    show,
    states_of,
)
from fuzzyctl.cli.loading import (
    Choice,
    Opened,
    chosen_loops,
    examined_file,
    load_evaluable,
    open_blocks,
    settings_of,
    under,
)
from fuzzyctl.cli.progress import status_line
from fuzzyctl.cli.streams import say, table_lines, write_json
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import listed

if TYPE_CHECKING:
    from fuzzyctl.comparison.changes import Change
    from fuzzyctl.comparison.differences import Difference
    from fuzzyctl.comparison.explanation import Explanation
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.profiles import ProfileName
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.simulation.run import Run

#: The difference of an output, and its explanation if one is searched for.
_Result: TypeAlias = "tuple[Difference, Explanation | None]"


@dataclass(frozen=True)
class _Side:
    label: str
    block: Any
    blocks: tuple[Block, ...] = ()


def _profiles(_context: click.Context, _option: click.Parameter, text: str | None) -> tuple[str, ...]:
    """Return the profiles of a list; refuse unknown ones."""
    names = tuple(n.strip() for n in text.split(",")) if text else ()
    known_profiles(names)
    return names


@click.command()
@click.argument("first")
@click.argument("second", required=False)
@click.option(
    "--as",
    "profiles",
    metavar="PROFILE,...",
    callback=_profiles,
    help="Semantics to compute by; the first is compared with each.",
)
@POINTS
@click.option("--changes", is_flag=True, help="Show what was changed from the first file to the second instead.")
@click.option("--loops", is_flag=True, help="Run the loops of two files, and compare their measures.")
@click.option("--within", type=NotNegative(), metavar="TOLERANCE", help="Fail if they differ by more.")
@STATE
@FORMAT
@SET
@BLOCK
@QUIET
@answers_with_diagnostics
def compare(
    first: str,
    second: str | None,
    profiles: tuple[ProfileName, ...],
    points: int,
    changes: bool,
    loops: bool,
    within: float | None,
    state: tuple[str, ...],
    form: str,
    settings: tuple[str, ...],
    name: str | None,
) -> int:
    """Compare the numbers of two files or tools.

    \b
    fuzzyctl compare tipper --as matlab,pyfuzzylite,exact
    fuzzyctl new tip --from tipper
    fuzzyctl compare tipper tip.fz --within 1e-9
    fuzzyctl compare tipper tip.fz --changes
    git show HEAD:tip.fz | fuzzyctl compare - tip.fz --changes

    With one file, the results of several tools are compared. Outputs are compared at corners of terms, on an even
    grid and at random points; the search continues around the worst of them. Then settings are copied from the
    second to the first one by one, to find those that explain the difference there. Inputs and outputs are paired
    by name, the others in order.

    For controllers one step is compared, from the initial state or that of --state: the outputs, and the next
    values of states that both have.

    With --loops the loops of both files are run, paired by name, the others in order, and their measures are
    printed with the differences. --set then takes params of loops and of their blocks.

    With --changes settings, params, terms, rules, cells of tables and guarantees are compared, not lines of text:
    layout, comments and the order of the parts of a rule do not count, and a renamed term is the same term. '=' marks
    a different form of the same value.

    Exit code: 0; 1 if a difference exceeds --within, or with --changes if something was changed.
    """
    has_points = click.get_current_context().get_parameter_source("points") is ParameterSource.COMMANDLINE
    if changes:
        if second is None or profiles or has_points or loops or settings or state or within is not None:
            others = "--as, --points, --loops, --set, --state and --within"
            raise click.UsageError(f"--changes takes two files, without {others}")
        return print_changes(first, second, name, form)
    if loops:
        if second is None or profiles or has_points or state:
            raise click.UsageError("--loops takes two files, without --as, --points and --state")
        return DONE if compare_loops(first, second, name, settings, within, form) else FAILED
    from fuzzyctl.comparison.presentation import compared_data, compared_text

    sides = _sides(first, second, profiles, settings, name)
    comparisons = [(sides[0], other, _compared(sides[0].block, other.block, points, state)) for other in sides[1:]]
    if form == "json":
        pairs = [
            {"first": one.label, "second": other.label, "outputs": [compared_data(d, e) for d, e in results]}
            for one, other, results in comparisons
        ]
        write_json({"points": points, "pairs": pairs})
    else:
        texts = [
            compared_text(one.label, one.block, other.label, *zip(*rows, strict=True))
            for one, other, rows in comparisons
        ]
        say("\n\n".join(["\n".join(lines) for lines in texts] + _left_out(sides)))
    agree = within is None or all(d.within(within) for _, _, results in comparisons for d, _ in results)
    return DONE if agree else FAILED


def _sides(
    first: str, second: str | None, names: tuple[ProfileName, ...], settings: tuple[str, ...], name: str | None
) -> list[_Side]:
    """Load the sides; the first is compared with each of the others."""
    files = [first] if second is None else [first, second]
    if second is None and len(names) < 2:
        raise click.UsageError("name a second file, or two profiles or more: --as matlab,exact")
    if second is not None and len(names) > 2:
        raise click.UsageError("two files take one profile for both, or one for each")
    opened = [examined_file(file) for file in files]
    blocks = [load_evaluable(f, Choice(settings, name), one) for f, one in zip(files, opened, strict=True)]
    if not names:
        return [_Side(f, block, one.equations) for f, block, one in zip(files, blocks, opened, strict=True)]
    if second is None:
        return [_Side(f"{first} as {p}", under(blocks[0], p)) for p in names]
    pairs = zip(files, blocks, names if len(names) == 2 else names * 2, strict=True)
    return [_Side(f"{file} as {p}", under(block, p)) for file, block, p in pairs]


def _left_out(sides: Sequence[_Side]) -> list[str]:
    """Name the controllers, plants and loops of two files whose systems are compared."""
    from fuzzyctl.model.loop import Loop

    names = listed(dict.fromkeys(b.name for side in sides for b in side.blocks))
    if not names or any(side.block.name == b.name for side in sides for b in side.blocks):
        return []
    have_loops = all(any(isinstance(b, Loop) for b in side.blocks) for side in sides)
    return [f"systems only; not compared: {names}" + ("; --loops compares runs" if have_loops else "")]


def _compared(a: Any, b: Any, points: int, state: Sequence[str]) -> list[_Result]:
    """Return the difference of each output; settings explain those of systems in the state of the start."""
    from fuzzyctl.comparison.differences import differences, pairing
    from fuzzyctl.comparison.explanation import explanation

    pairing(a, b)  # refuses blocks of other inputs
    is_explained = not state and all(block.all_systems == (block,) for block in (a, b))
    with status_line() as report:
        try:
            gaps = differences(a, b, points=points, progress=report, states=_states(a, b, state))
        except ArgumentError as error:
            help_text = "'--loops' compares runs, '--changes' the texts"
            raise DiagnosticError([Diagnostic("FZ503", str(error), help=help_text)]) from None
        return [(d, explanation(a, b, d, progress=report) if is_explained else None) for d in gaps]


def _states(a: Any, b: Any, texts: Sequence[str]) -> list[list[float] | None]:
    """Return the state of each block with the numbers of `NAME=VALUE` texts, None for the initial one."""
    if not texts:
        return [None, None]
    from fuzzyctl.kernels.compile import compile

    return [list(s.values()) or None for s in states_of(texts, compile(a, "python"), compile(b, "python"))]


#: Name, first value, second value and difference of a measure; NaN where one has none.
Row = tuple[str, float, float, float]


def compare_loops(
    first: str, second: str, name: str | None, settings: Sequence[str], within: float | None, form: str
) -> bool:
    """Run the loops of two files in pairs, and print their measures side by side.

    Args:
        first: A file.
        second: Another one.
        name: The loop of both; None for all.
        settings: `NAME=VALUE` for params of either.
        within: Largest difference of a measure that passes; None for any.
        form: "text" or "json".

    Returns:
        Whether all runs reach their end, and the measures that both have agree up to `within`.
    """
    from fuzzyctl.simulation.simulate import simulate

    sides = [[loop for _, loop in chosen_loops(file, name)] for file in (first, second)]
    changed = settings_of(settings, [loop for side in sides for loop in side])
    ones, others = changed[: len(sides[0])], changed[len(sides[0]) :]
    pairs = [(simulate(a), simulate(b)) for a, b in _loop_pairs(ones, others)]
    for run in (run for pair in pairs for run in pair):
        show([run.stopped] if run.stopped is not None else [])
    if form == "json":
        write_json({"pairs": [_measures_data(first, second, a, b) for a, b in pairs]})
    else:
        say("\n\n".join("\n".join(_measures_text(first, second, a, b)) for a, b in pairs))
    ended = all(run.stopped is None for pair in pairs for run in pair)
    return ended and (within is None or all(_agree(row, within) for a, b in pairs for row in _rows(a, b)))


def _loop_pairs(ones: Sequence[Loop], others: Sequence[Loop]) -> Iterator[tuple[Loop, Loop]]:
    """Yield loops of the same name, then those of other names in order; loops without a partner are left out."""
    names = {loop.name: loop for loop in others}
    yield from ((loop, names[loop.name]) for loop in ones if loop.name in names)
    paired = {loop.name for loop in ones}
    rest = [loop for loop in ones if loop.name not in names]
    yield from zip(rest, [loop for loop in others if loop.name not in paired], strict=False)


def _rows(a: Run, b: Run) -> list[Row]:
    names = dict.fromkeys([*a.measures, *b.measures])
    values = [(n, a.measures.get(n, math.nan), b.measures.get(n, math.nan)) for n in names]
    return [(n, x, y, 0.0 if x == y else y - x) for n, x, y in values]


def _agree(row: Row, within: float) -> bool:
    _, first, second, difference = row
    return abs(difference) <= within or (math.isnan(first) and math.isnan(second))


def _measures_data(first: str, second: str, a: Run, b: Run) -> dict[str, Any]:
    measures = {n: {"first": x, "second": y, "difference": d} for n, x, y, d in _rows(a, b)}
    return {"first": f"{first}: {a.loop.name}", "second": f"{second}: {b.loop.name}", "measures": plain(measures)}


def _measures_text(first: str, second: str, a: Run, b: Run) -> Iterator[str]:
    yield f"{first}: {a.loop.name}  and  {second}: {b.loop.name}"
    rows = [("measure", "first", "second", "difference")]
    rows += [(n, _number(x), _number(y), _number(d)) for n, x, y, d in _rows(a, b)]
    yield from (f"  {line}" for line in table_lines(rows))


def _number(value: float) -> str:
    return "none" if math.isnan(value) else f"{value:.5g}"


#: How a change begins its line.
MARKS = {"added": "+", "removed": "-", "changed": "~", "renamed": "~", "rewritten": "="}


def print_changes(first: str, second: str, name: str | None, form: str) -> int:
    """Print the changes from one file to another, and return the exit code: 1 if there are any.

    Args:
        first: A file.
        second: Another one.
        name: The block of both; None for all, paired by name.
        form: "text" or "json".
    """
    before, after = _opened_both(first, second, name)
    pairs = _system_pairs(before, after)
    from fuzzyctl.comparison.changes import block_changes, changes, policy_changes
    from fuzzyctl.model.controller import EquationBlock

    policies = policy_changes(before.file.policy, after.file.policy)
    systems = [(a.name, changes(a, b)) for a, b in pairs]
    blocks = block_changes(before.of(EquationBlock), after.of(EquationBlock))
    is_changed = bool(policies or blocks or any(rows for _, rows in systems))
    if form == "json":
        data: dict[str, Any] = {
            "first": first,
            "second": second,
            "changes": _changes_data(policies),
            "systems": [{"system": name, "changes": _changes_data(rows)} for name, rows in systems],
        }
        if any(b.kind != "system" for b in (*before.blocks, *after.blocks)):
            data["blocks"] = [{"block": name, "changes": _changes_data(rows)} for name, rows in blocks]
        write_json(data)
        return FAILED if is_changed else DONE
    headed = [(f"system {name}" if len(systems) > 1 and rows else "", rows) for name, rows in systems]
    groups = [("", policies), *headed, *blocks]
    lines = [line for heading, rows in groups for line in (heading, *map(_change_line, rows)) if line]
    say("\n".join(lines) if is_changed else "nothing was changed")
    return FAILED if is_changed else DONE


def _opened_both(first: str, second: str, name: str | None) -> tuple[Opened, Opened]:
    """Open both files.

    Raises:
        DiagnosticError: With the errors of both.
    """
    opened: list[Opened] = []
    mistakes: list[Diagnostic] = []
    for file in (first, second):
        try:
            opened.append(open_blocks(file, Choice(name=name), hints=False))
        except DiagnosticError as error:
            mistakes.extend(error.diagnostics)
    if mistakes:
        raise DiagnosticError(mistakes)
    return opened[0], opened[1]


def _system_pairs(first: Opened, second: Opened) -> list[tuple[FuzzySystem, FuzzySystem]]:
    """Pair the systems of two files: by name, or the only ones.

    Raises:
        DiagnosticError: Where systems have no partner.
    """
    from fuzzyctl.model.system import FuzzySystem

    ones, others = first.of(FuzzySystem), second.of(FuzzySystem)
    if len(ones) == len(others) == 1:
        return [(ones[0], others[0])]
    lonely = [
        Diagnostic("FZ502", message, file=one.file.source.name, help="name one: --block")
        for one, mine, theirs in ((first, ones, others), (second, others, ones))
        for s in mine
        if s.name not in {o.name for o in theirs}
        for message in (f"system '{s.name}' is in one of the files only",)
    ]
    if lonely:
        raise DiagnosticError(lonely)
    by_name = {s.name: s for s in others}
    return [(s, by_name[s.name]) for s in ones]


def _changes_data(changes: Sequence[Change]) -> list[dict[str, Any]]:
    return [dataclasses.asdict(c) for c in changes]


def _change_line(change: Change) -> str:
    """Return a change on one line, with its lines in both files."""
    lines = [f"{sign}{line}" for sign, line in (("-", change.before_line), ("+", change.after_line)) if line]
    name = f" {change.name}" if change.name else ""
    texts = " → ".join(t for t in (change.before, change.after) if t is not None)
    place = f"   (lines {' '.join(lines)})" if lines else ""
    return f"{MARKS[change.kind]} {change.what}{name}: {texts}{place}"
