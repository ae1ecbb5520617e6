"""`fuzzyctl why`: which rules act at a point, what each contributes, and how the output would change."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import click

from fuzzyctl.cli.common import (
    DONE,
    FORMAT,
    QUIET,
    answers_with_diagnostics,
    outside_range,
    plain,
    point_of,
    show,
)
from fuzzyctl.cli.loading import Choice, chooses, load_checked
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from fuzzyctl.explain.trace import Contribution, Trace
    from fuzzyctl.model.system import FuzzySystem


@click.command()
@click.argument("file")
@click.argument("values", nargs=-1, metavar="INPUT=VALUE...")
@click.option("-o", "--output", "out", metavar="FILE", help="Draw the rules that act, their sets cut: PNG, SVG or PDF.")
@click.option("--rules", "most", type=click.IntRange(1, 100), default=12, show_default=True, help="Most rules to show.")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def why(
    file: str,
    values: tuple[str, ...],
    out: str | None,
    most: int,
    form: str,
    choice: Choice,
) -> int:
    """Say why a system gives what it gives at a point.

    Prints the rules that act, the highest activation first, with what each contributes, and the slopes of the outputs.

    \b
    fuzzyctl why rules/ais_reaction.fz sigma=0.01 dsigma=0.3
    fuzzyctl why rules/tipper.fz service=7 food=8 -o why.svg
    """
    from fuzzyctl.explain.trace import trace

    system = load_checked(file, choice)
    given = point_of(system, values, "why")
    found = trace(system, given)
    warnings = outside_range(system, given)
    if form == "json":
        data = {
            "system": system.name,
            "semantics": system.method.semantics.profile,
            **plain(dataclasses.asdict(found)),
        }
        data["diagnostics"] = [w.as_dict() for w in warnings]
        write_json(data)
    else:
        show(warnings)
        say("\n".join(_lines(system, found, most)))
    if out is not None:
        _draw(system, found, out, most)
        say(f"wrote {out}", err=form == "json")
    return DONE


def _draw(system: FuzzySystem, found: Trace, out: str, most: int) -> None:
    from fuzzyctl.cli.plot import picture_file
    from fuzzyctl.plot.rules import draw_rules
    from fuzzyctl.plot.style import saved

    with saved(picture_file(out, out)) as figure:
        draw_rules(figure, system, found, most)


def _lines(system: FuzzySystem, found: Trace, most: int) -> list[str]:
    lines = []
    for output in system.outputs:
        unit = f" {output.unit}" if output.unit else ""
        lines.append(f"{output.name} = {found.outputs[output.name]!r}{unit}")
    if found.lets:
        units = {let.name: f" {let.unit}" if let.unit else "" for let in system.lets}
        lines += ["", "Lets", *(f"  {name} = {value:.6g}{units[name]}" for name, value in found.lets.items())]
    lines += ["", f"Degrees above 0 at {', '.join(f'{n} = {x:.6g}' for n, x in found.inputs.items())}"]
    for variable, degrees in found.degrees.items():
        above = [f"{term} {d:.4g}" for term, d in degrees.items() if d > 0.0]
        lines.append(f"  {variable}: {', '.join(above) or 'none'}")
    lines += ["", f"Rules that act: {len(found.rules)}; silent: {found.silent}"]
    for rule in found.rules[:most]:
        block = f"   (rules {rule.block})" if rule.block else ""
        lines.append(f"  {rule.activation:<8.4g}  {rule.text}{block}")
        lines += [f"            {_contribution(c)}" for c in rule.contributions]
    if len(found.rules) > most:
        lines.append(f"  and {len(found.rules) - most} more; --rules shows more of them")
    lines += ["", "Change per unit of an input, to the left and to the right"]
    for output_name, slopes in found.slopes.items():
        lines += [f"  {output_name} by {name}: {_slope(*pair)}" for name, pair in slopes.items()]
    return lines


def _contribution(c: Contribution) -> str:
    text = f"{c.output}: {c.share:.1%} of the activation, for {c.term}"
    if c.value is not None:
        text += f" = {c.value:.6g}"
    return text if c.pull is None else f"{text}, which pulls it by {c.pull:+.6g}"


def _slope(left: float, right: float) -> str:
    if math.isnan(left) or math.isnan(right):
        return f"{left:.6g} and {right:.6g}"
    same = abs(left - right) <= 1e-4 * max(abs(left), abs(right), 1e-12)
    return f"{right:.6g}" if same else f"{left:.6g} and {right:.6g}"
