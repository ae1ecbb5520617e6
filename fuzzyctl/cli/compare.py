"""`fuzzyctl compare`: where two files, or two ways to compute one, differ most, and which setting explains it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import DONE, FAILED, FORMAT, SET, SYSTEM, answers_with_diagnostics, load_checked

if TYPE_CHECKING:
    from fuzzyctl.comparison.differences import Difference
    from fuzzyctl.comparison.explanation import Cause
    from fuzzyctl.model.system import FuzzySystem


#: Least part of a difference that a cause is named for.
FELT: Final = 1e-3


@dataclass(frozen=True)
class _Side:
    label: str
    system: FuzzySystem


@click.command()
@click.argument("first")
@click.argument("second", required=False)
@click.option(
    "--as", "profiles", metavar="PROFILE,...", help="Semantics to compute by; the first is compared with each."
)
@click.option(
    "--points",
    type=click.IntRange(2, 10_000_000),
    default=10_000,
    show_default=True,
    help="How many points to compare.",
)
@click.option("--within", type=click.FloatRange(min=0.0), metavar="TOLERANCE", help="Fail where they differ by more.")
@FORMAT
@SET
@SYSTEM
@answers_with_diagnostics
def compare(
    first: str,
    second: str | None,
    profiles: str | None,
    points: int,
    within: float | None,
    form: str,
    settings: tuple[str, ...],
    name: str | None,
) -> int:
    """Compare the numbers of two files, or of one file as several tools compute it.

    \b
    fuzzyctl compare old.fz new.fz
    fuzzyctl compare tipper.fis --as matlab,pyfuzzylite,exact
    fuzzyctl compare tipper.fis tipper.fll --as exact

    Outputs are compared at corners of terms, on an even grid and at random points; around the worst of them it is
    looked for a worse one. Then settings of the second are put into the first, one by one, to see which of them
    explains the difference there. Inputs and outputs are paired by name, else by position.

    Exit code: 0; 1 where a difference exceeds --within.
    """
    sides = _sides(first, second, profiles, settings, name)
    found = [(sides[0], other, _compared(sides[0].system, other.system, points)) for other in sides[1:]]
    if form == "json":
        pairs = [_data(one, other, own) for one, other, own in found]
        click.echo(json.dumps({"points": points, "pairs": pairs}, ensure_ascii=False, indent=2))
    else:
        click.echo("\n\n".join(_text(one, other, own) for one, other, own in found))
    worst = max(d.largest for _, _, own in found for d, _ in own)
    return FAILED if within is not None and worst > within else DONE


def _sides(
    first: str, second: str | None, profiles: str | None, settings: tuple[str, ...], name: str | None
) -> list[_Side]:
    """Load what is compared: the first side with each of the others."""
    names = [n.strip() for n in profiles.split(",")] if profiles else []
    files = [first] if second is None else [first, second]
    if second is None and len(names) < 2:
        raise click.UsageError("name a second file, or two profiles or more: --as matlab,exact")
    if second is not None and len(names) > 2:
        raise click.UsageError("two files take one profile for both, or one for each")
    systems = [load_checked(file, settings, name) for file in files]
    if not names:
        return [_Side(file, system) for file, system in zip(files, systems, strict=True)]
    from fuzzyctl.model.profiles import as_profile

    if second is None:
        return [_Side(f"{first} as {p}", as_profile(systems[0], p)) for p in names]
    pairs = zip(files, systems, names if len(names) == 2 else names * 2, strict=True)
    return [_Side(f"{file} as {p}", as_profile(system, p)) for file, system, p in pairs]


def _compared(a: FuzzySystem, b: FuzzySystem, points: int) -> list[tuple[Difference, tuple[Cause, ...]]]:
    from fuzzyctl.comparison.differences import differences
    from fuzzyctl.comparison.explanation import causes

    return [(d, causes(a, b, d)) for d in differences(a, b, points=points)]


def _data(one: _Side, other: _Side, found: list[tuple[Difference, tuple[Cause, ...]]]) -> dict[str, Any]:
    return {"first": one.label, "second": other.label, "outputs": [compared_data(d, c) for d, c in found]}


def compared_data(d: Difference, causes: tuple[Cause, ...]) -> dict[str, Any]:
    """Return a difference and what explains it as plain data; null stands for no value, and for an infinite one."""
    return {
        "output": d.output,
        "largest": _plain(d.largest),
        "point": d.point,
        "first": _plain(d.first),
        "second": _plain(d.second),
        "mean": d.mean,
        "points": d.points,
        "one_sided": d.one_sided,
        "causes": [{"name": c.name, "first": c.before, "second": c.after, "explains": c.explains} for c in causes],
    }


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _text(one: _Side, other: _Side, found: list[tuple[Difference, tuple[Cause, ...]]]) -> str:
    return "\n".join(compared_text(one.label, one.system, other.label, *zip(*found, strict=True)))


def compared_text(
    first: str,
    system: FuzzySystem,
    second: str,
    found: Sequence[Difference],
    causes: Sequence[tuple[Cause, ...]],
) -> list[str]:
    """Return the lines of a comparison.

    Args:
        first: What the first one is called.
        system: Either of them, for the units.
        second: What the second one is called.
        found: The difference of each output.
        causes: What explains each.
    """
    lines = [f"{first}  and  {second}: {found[0].points:,} points"]
    units = {o.name: o.unit for o in system.outputs}
    for d, own in zip(found, causes, strict=True):
        unit = units.get(d.output, "")
        lines += [f"  {line}" for line in _output(d, own, f" {unit}" if unit else "", _beyond(system, d))]
    return lines


def _beyond(system: FuzzySystem, d: Difference) -> list[str]:
    """Name the inputs that stand outside their range in a system at the point of a difference."""
    return [
        f"{v.name} is outside its range there, [{system.number(v.lower):.6g}, {system.number(v.upper):.6g}]"
        for v in system.inputs
        if v.name in d.point and not system.number(v.lower) <= d.point[v.name] <= system.number(v.upper)
    ]


def _output(d: Difference, causes: tuple[Cause, ...], unit: str, beyond: Sequence[str] = ()) -> list[str]:
    if d.largest == 0.0:
        return [f"{d.output}: no difference"]
    where = ", ".join(f"{name} = {value:.6g}" for name, value in d.point.items())
    values = f"{d.first:.10g} and {d.second:.10g}{unit}"
    if math.isinf(d.largest):
        head = [f"{d.output}: one has no value at {where}: {values}"]
    else:
        head = [
            f"{d.output}: largest difference {d.largest:.3g}{unit} at {where}: {values}",
            f"  on average {d.mean:.3g}",
        ]
    head += [f"  {line}" for line in beyond]
    if d.one_sided:
        head.append(f"  at {d.one_sided:,} of {d.points:,} points only one has a value")
    return [*head, *(f"  {line}" for line in _causes(causes))]


def _causes(causes: tuple[Cause, ...]) -> list[str]:
    """Return one line for each cause that anyone would feel, the largest first, and what no cause explains."""
    shown = sorted((c for c in causes if abs(c.explains) >= FELT), key=lambda c: -abs(c.explains))
    names = [f"{c.name}: {c.before} → {c.after}" if c.before or c.after else c.name for c in shown]
    parts = [c.explains for c in shown]
    rest = 1.0 - sum(c.explains for c in causes)
    if abs(rest) >= FELT:
        names, parts = [*names, "the rest: several of what differs at once"], [*parts, rest]
    width = max(map(len, names), default=0)
    return [f"{name:{width}}  explains {100 * part:.3g} %" for name, part in zip(names, parts, strict=True)]
