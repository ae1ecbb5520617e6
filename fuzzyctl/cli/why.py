"""`fuzzyctl why`: which rules act at a point, what each contributes, and how the output would change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from fuzzyctl.cli.common import (
    DONE,
    FORMAT,
    QUIET,
    SVG_TEXT,
    answers_with_diagnostics,
    outside_range,
    plain,
    point_of,
    report,
    show,
)
from fuzzyctl.cli.loading import Choice, chooses, load_checked
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from fuzzyctl.explain.trace import Trace
    from fuzzyctl.model.system import FuzzySystem


@click.command()
@click.argument("file")
@click.argument("values", nargs=-1, metavar="INPUT=VALUE...")
@click.option("-o", "--output", "out", metavar="FILE", help="Draw the rules that act, their sets cut: PNG, SVG or PDF.")
@SVG_TEXT
@click.option("--rules", "most", type=click.IntRange(1, 100), default=12, show_default=True, help="Most rules to show.")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def why(
    file: str,
    values: tuple[str, ...],
    out: str | None,
    svg_text: bool,
    most: int,
    form: str,
    choice: Choice,
) -> int:
    """Say why a system gives what it gives at a point.

    Prints the rules that act, the highest activation first, with what each contributes, and the slopes of the outputs.

    \b
    fuzzyctl why ais_reaction sigma=0.01 dsigma=0.3
    fuzzyctl why tipper service=7 food=8 -o why.svg
    """
    from fuzzyctl.display.traces import text
    from fuzzyctl.explain.trace import trace

    system = load_checked(file, choice)
    given = point_of(system, values, "why")
    found = trace(system, given)
    warnings = outside_range(system, given)
    if form == "json":
        data = {
            "system": system.name,
            "semantics": system.method.semantics.profile,
            **plain(found.as_dict()),
        }
        data["diagnostics"] = [w.as_dict() for w in warnings]
        write_json(data)
    else:
        show(warnings)
        report(text(found, most))
    if out is not None:
        _draw(system, found, out, svg_text, most)
        say(f"wrote {out}", err=form == "json")
    return DONE


def _draw(system: FuzzySystem, found: Trace, out: str, svg_text: bool, most: int) -> None:
    from fuzzyctl.cli.plot import picture_file
    from fuzzyctl.plot.rule_viewer import draw_rules
    from fuzzyctl.plot.style import saved

    with saved(picture_file(out, out), svg_text=svg_text) as figure:
        draw_rules(figure, system, found, most)
