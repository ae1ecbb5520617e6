"""`fuzzyctl compare`: where two files, or two ways to compute one, differ most, and which setting explains it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

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
    states_of,
)
from fuzzyctl.cli.loading import Choice, examined_file, load_evaluable, under
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import listed

if TYPE_CHECKING:
    from fuzzyctl.comparison.differences import Difference
    from fuzzyctl.comparison.explanation import Cause, Explanation
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.profiles import ProfileName


#: Least part of a difference that a cause is named for.
LEAST_SHARE: Final = 1e-3


#: What is found of an output: the difference, and what explains it if that is looked for.
_Result: TypeAlias = "tuple[Difference, Explanation | None]"


@dataclass(frozen=True)
class _Side:
    label: str
    block: Any
    blocks: tuple[Block, ...] = ()


def _profiles(_context: click.Context, _option: click.Parameter, given: str | None) -> tuple[str, ...]:
    """Return the profiles of a list, and refuse what is none."""
    names = tuple(n.strip() for n in given.split(",")) if given else ()
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
@click.option("--within", type=NotNegative(), metavar="TOLERANCE", help="Fail where they differ by more.")
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

    One file is compared as several tools compute it. Outputs are compared at corners of terms, on an even grid and at
    random points; around the worst of them it is looked for a worse one. Then settings of the second are put into the
    first, one by one, to see which of them explains the difference there. Inputs and outputs are paired by name, those
    of other names in order.

    Of controllers one step is compared, from the state of the start or that of --state: the outputs, and the next
    values of states that both have.

    With --loops the loops of both files are run, paired by name, those of other names in order, and their measures are
    printed with the differences. --set then takes params of loops and of their blocks.

    With --changes settings, params, terms, rules, cells of tables and guarantees are compared, not lines of text:
    layout, comments and the order of the parts of a rule do not count, and a renamed term is the same term. '=' marks
    what is written in another way and has the same value.

    Exit code: 0; 1 where a difference exceeds --within, or with --changes where something was changed.
    """
    has_points = click.get_current_context().get_parameter_source("points") is ParameterSource.COMMANDLINE
    if changes:
        if second is None or profiles or has_points or loops or settings or state or within is not None:
            others = "--as, --points, --loops, --set, --state and --within"
            raise click.UsageError(f"--changes takes two files, without {others}")
        from fuzzyctl.cli.compare_changes import print_changes

        return print_changes(first, second, name, form)
    if loops:
        if second is None or profiles or has_points or state:
            raise click.UsageError("--loops takes two files, without --as, --points and --state")
        from fuzzyctl.cli.compare_loops import compare_loops

        return DONE if compare_loops(first, second, name, settings, within, form) else FAILED
    sides = _sides(first, second, profiles, settings, name)
    found = [(sides[0], other, _compared(sides[0].block, other.block, points, state)) for other in sides[1:]]
    if form == "json":
        pairs = [_data(one, other, own) for one, other, own in found]
        write_json({"points": points, "pairs": pairs})
    else:
        say("\n\n".join([*(_text(one, other, own) for one, other, own in found), *_left_out(sides)]))
    agree = within is None or all(d.within(within) for _, _, own in found for d, _ in own)
    return DONE if agree else FAILED


def _sides(
    first: str, second: str | None, names: tuple[ProfileName, ...], settings: tuple[str, ...], name: str | None
) -> list[_Side]:
    """Load what is compared: the first side with each of the others."""
    files = [first] if second is None else [first, second]
    if second is None and len(names) < 2:
        raise click.UsageError("name a second file, or two profiles or more: --as matlab,exact")
    if second is not None and len(names) > 2:
        raise click.UsageError("two files take one profile for both, or one for each")
    opened = [examined_file(file) for file in files]
    found = [load_evaluable(f, Choice(settings, name), one) for f, one in zip(files, opened, strict=True)]
    if not names:
        return [_Side(f, block, one.equations) for f, block, one in zip(files, found, opened, strict=True)]
    if second is None:
        return [_Side(f"{first} as {p}", under(found[0], p)) for p in names]
    pairs = zip(files, found, names if len(names) == 2 else names * 2, strict=True)
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
    with progress() as report:
        try:
            found = differences(a, b, points=points, progress=report, states=_states(a, b, state))
        except ArgumentError as error:
            help_text = "'--loops' compares runs, '--changes' the texts"
            raise DiagnosticError([Diagnostic("FZ503", str(error), help=help_text)]) from None
        return [(d, explanation(a, b, d, progress=report) if is_explained else None) for d in found]


def _states(a: Any, b: Any, texts: Sequence[str]) -> list[list[float] | None]:
    """Return the state of each block with the numbers of `NAME=VALUE` texts, None for that of the start."""
    if not texts:
        return [None, None]
    from fuzzyctl.kernels.compile import compile

    return [list(s.values()) or None for s in states_of(texts, compile(a, "python"), compile(b, "python"))]


def _data(one: _Side, other: _Side, found: list[_Result]) -> dict[str, Any]:
    return {"first": one.label, "second": other.label, "outputs": [compared_data(d, e) for d, e in found]}


def compared_data(d: Difference, explained: Explanation | None) -> dict[str, Any]:
    """Return a difference and what explains it as plain data; null stands for no value, and for an infinite one."""
    gap, largest = d.gap, () if explained is None else explained.largest
    return {
        "output": d.output,
        "largest": _plain(d.largest),
        "point": d.point,
        "first": _plain(d.first),
        "second": _plain(d.second),
        "mean": d.mean,
        "points": d.points,
        "one_sided": d.one_sided,
        "causes": _causes_data(largest),
        "causes_of_mean": _causes_data(largest if explained is None else explained.mean or largest),
        "gap": None
        if gap is None
        else {
            "point": gap.point,
            "first": _plain(gap.first),
            "second": _plain(gap.second),
            "causes": _causes_data(() if explained is None else explained.gap),
        },
    }


def _causes_data(causes: tuple[Cause, ...]) -> list[dict[str, Any]]:
    return [{"name": c.name, "first": c.before, "second": c.after, "explains": c.explains} for c in causes]


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _text(one: _Side, other: _Side, found: list[_Result]) -> str:
    return "\n".join(compared_text(one.label, one.block, other.label, *zip(*found, strict=True)))


def compared_text(
    first: str,
    block: Any,
    second: str,
    found: Sequence[Difference],
    explanations: Sequence[Explanation | None],
) -> list[str]:
    """Return the lines of a comparison.

    Args:
        first: What the first one is called.
        block: Either of them, for the units.
        second: What the second one is called.
        found: The difference of each output.
        explanations: What explains each, None if that is not looked for.
    """
    count = found[0].points
    lines = [f"{first}  and  {second}: {count:,} point{'' if count == 1 else 's'}"]
    units = {o.name: o.unit for o in block.outputs} | {f"next {s.name}": s.unit for s in block.states}
    for d, own in zip(found, explanations, strict=True):
        unit = units.get(d.output, "")
        lines += [f"  {line}" for line in _output(d, own, f" {unit}" if unit else "", _beyond(block, d))]
    return lines


def _beyond(block: Any, d: Difference) -> list[str]:
    """Name the inputs that are outside of their range in a block at the point of a difference."""
    ranges = {v.name: block.range_of(v) for v in block.inputs if v.name in d.point}
    return [
        f"{name} is outside its range there, [{low:.6g}, {high:.6g}]"
        for name, (low, high) in ranges.items()
        if not low <= d.point[name] <= high
    ]


def _output(d: Difference, explained: Explanation | None, unit: str, beyond: Sequence[str] = ()) -> list[str]:
    if d.largest == 0.0 and d.gap is None:
        return [f"{d.output}: no difference"]
    lines = [f"{d.output}: no difference where both have a value"]
    # Where each point has one value only there is nothing to say but that.
    if d.largest > 0.0 and d.valued:
        at = _where(d.point, d.first, d.second, unit)
        lines = [f"{d.output}: largest difference {d.largest:.3g}{unit} at {at}", *_indented(beyond)]
        mean = [f"  on average {d.mean:.3g}"]
        if explained is None:
            lines += mean
        else:
            causes = ["  that is rounding"] if explained.rounding else _indented(_causes(explained.largest))
            # Causes of the mean stand below it where they are others.
            own = _indented(_indented(_causes(explained.mean))) if explained.mean else []
            lines += [*causes, *mean, *own] if own else [*mean, *causes]
    elif not d.valued:
        lines = [f"{d.output}: nowhere have both a value"]
    if d.gap is not None:
        at = _where(d.gap.point, d.gap.first, d.gap.second, unit)
        lines.append(f"  at {d.one_sided:,} of {d.points:,} points only one has a value, such as {at}")
        if explained is not None:
            settings = [_cause(c) for c in explained.gap] or ["several of what differs at once"]
            lines += [f"    gone with {setting}" for setting in settings]
    return lines


def _where(point: Mapping[str, float], first: float, second: float, unit: str) -> str:
    where = ", ".join(f"{name} = {value:.6g}" for name, value in point.items())
    return f"{where}: {first:.10g} and {second:.10g}{unit}"


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _causes(causes: tuple[Cause, ...]) -> list[str]:
    """Return one line for each cause with a part worth naming, the largest first, and what no cause explains."""
    shown = sorted((c for c in causes if abs(c.explains) >= LEAST_SHARE), key=lambda c: -abs(c.explains))
    names = [_cause(c) for c in shown]
    parts = [c.explains for c in shown]
    rest = 1.0 - sum(c.explains for c in causes)
    if abs(rest) >= LEAST_SHARE:
        names, parts = [*names, "the rest: several of what differs at once"], [*parts, rest]
    width = max(map(len, names), default=0)
    return [f"{name:{width}}  explains {100 * part:.3g} %" for name, part in zip(names, parts, strict=True)]


def _cause(c: Cause) -> str:
    return f"{c.name}: {c.before} → {c.after}" if c.before or c.after else c.name
