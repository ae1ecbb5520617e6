"""`fuzzyctl eval`: one point from the command line, or many from a CSV; `fuzzyctl why`: the rules behind a point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import (
    DONE,
    FORMAT,
    QUIET,
    STATE,
    SVG_TEXT,
    answers_with_diagnostics,
    outside_range,
    plain,
    point_of,
    report,
    show,
    state_of,
)
from fuzzyctl.cli.loading import Choice, chooses, load_evaluable
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from fuzzyctl.explain.trace import Trace
    from fuzzyctl.model.system import FuzzySystem


@click.command("eval")
@click.argument("file")
@click.argument("values", nargs=-1, metavar="[INPUT=VALUE]...")
@click.option("--points", metavar="CSV", help="Evaluate every row of a CSV file ('-' is standard input).")
@STATE
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def evaluate(
    file: str,
    values: tuple[str, ...],
    points: str | None,
    state: tuple[str, ...],
    form: str,
    choice: Choice,
) -> int:
    """Evaluate a system or a step of a controller at a point, or at all points of a CSV.

    \b
    fuzzyctl eval tipper service=7 food=8
    fuzzyctl eval water_tank --block fuzzy_pi reference=1 level=0.6
    printf "service,food\\n7,8\\n" | fuzzyctl eval tipper --points -

    FILE may be '-', standard input. The CSV has a header with the names of the inputs, in any order; other columns are
    kept, the outputs are appended. A value outside the range of an input is clamped to it, with a warning. A
    state begins at its initial value; the rows of a CSV follow each other in time. A controller without 'every' takes
    dt=SECONDS.
    """
    system = load_evaluable(file, choice)
    if points is not None:
        if values:
            raise click.UsageError("give INPUT=VALUE or --points, not both")
        from fuzzyctl.cli.csv_points import evaluate_rows

        show(evaluate_rows(system, points, state, form))
        return DONE
    point = point_of(system, values, "eval")
    warnings = outside_range(system, point)
    results, after = _results(system, point, state)
    if form == "json":
        data: dict[str, Any] = {
            **system.identity,
            "inputs": plain(point),
            "outputs": plain(results),
            **({"next_state": plain(after)} if after else {}),
        }
        data["diagnostics"] = [w.as_dict() for w in warnings]
        write_json(data)
        return DONE
    show(warnings)
    for output in system.outputs:
        unit = f" {output.unit}" if output.unit else ""
        say(f"{output.name} = {results[output.name]!r}{unit}")
    for name, value in after.items():
        say(f"next {name} = {value!r}")
    return DONE


def _results(block: Any, values: dict[str, float], state: Sequence[str]) -> tuple[dict[str, float], dict[str, float]]:
    """Return the outputs, and the next state of a controller, by name."""
    names = [o.name for o in block.outputs]
    if block.kind == "system" and not state:
        result = block(**values)
        return ({names[0]: result} if len(names) == 1 else dict(result)), {}
    from fuzzyctl.kernels.compile import compile

    kernel = compile(block, "python")
    before = state_of(kernel, state)
    point = [values[n] for n in kernel.input_names]
    if not kernel.form.moves:
        outputs, after = kernel(*point, list(before.values())), {}
    else:
        outputs, following = kernel(*point, list(before.values()), dt=values.get("dt"))
        after = dict(zip(kernel.state_names, following.tolist(), strict=True))
    return dict(zip(names, (outputs,) if len(names) == 1 else outputs, strict=True)), after


@click.command()
@click.argument("file")
@click.argument("values", nargs=-1, metavar="INPUT=VALUE...")
@click.option(
    "-o", "--output", "out", metavar="FILE", help="Draw the rules that act and their cut sets: PNG, SVG or PDF."
)
@SVG_TEXT
@click.option("--rules", "most", type=click.IntRange(1, 100), default=12, show_default=True, help="Most rules to show.")
@STATE
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
    state: tuple[str, ...],
    form: str,
    choice: Choice,
) -> int:
    """Explain the outputs of a system, or of a step of a controller, at a point.

    Prints the rules that act, the highest activation first, with what each contributes, and the slopes of the outputs.

    \b
    fuzzyctl why ais_reaction sigma=0.01 dsigma=0.3
    fuzzyctl why tipper service=7 food=8 -o why.svg
    fuzzyctl why water_tank --block fuzzy_pi reference=1 level=0.6

    For a controller it prints the values of its definitions and states, and explains each system that it calls.
    """
    from fuzzyctl.display.traces import trace_text
    from fuzzyctl.explain.block_trace import BlockTrace, trace_block
    from fuzzyctl.explain.trace import Trace, trace
    from fuzzyctl.kernels.compile import compile

    block = load_evaluable(file, choice)
    if out is not None and block.kind != "system":
        raise click.UsageError("-o draws the rules of a system; name one with --block")
    target = None
    if out is not None:
        from fuzzyctl.cli.plot import picture_file

        target = picture_file(out, out)
    point = point_of(block, values, "why")
    before = state_of(compile(block, "python"), state) if state else None
    if block.kind == "system":
        explained: Trace | BlockTrace = trace(block, point, None if before is None else list(before.values()))
    else:
        explained = trace_block(block, point, before)
    warnings = outside_range(block, point)
    if form == "json":
        data = {
            **block.identity,
            **plain(explained.as_dict()),
        }
        data["diagnostics"] = [w.as_dict() for w in warnings]
        write_json(data)
    else:
        show(warnings)
        report(trace_text(explained, most))
    if target is not None:
        assert isinstance(explained, Trace)
        _draw(block, explained, target, svg_text, most)
        say(f"wrote {out}", err=form == "json")
    return DONE


def _draw(system: FuzzySystem, explained: Trace, target: Path, svg_text: bool, most: int) -> None:
    from fuzzyctl.plot.rule_viewer import draw_rules
    from fuzzyctl.plot.style import saved

    with saved(target, svg_text=svg_text) as figure:
        draw_rules(figure, system, explained, most)
