"""`fuzzyctl eval`: one point from the command line, or many from a CSV."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import (
    DONE,
    FORMAT,
    QUIET,
    STATE,
    answers_with_diagnostics,
    outside_range,
    plain,
    point_of,
    show,
    state_of,
)
from fuzzyctl.cli.loading import Choice, chooses, load_evaluable
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from collections.abc import Sequence


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
    kept, the outputs are appended. A value outside an input's range of a system is clamped to it, with a warning. A
    state begins with that of the start: the rows of a CSV follow each other in time. A controller without 'every'
    takes dt=SECONDS.
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
