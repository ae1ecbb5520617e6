"""`fuzzyctl eval`: one point from the command line, or many from a CSV."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
    from fuzzyctl.model.system import FuzzySystem


@click.command("eval")
@click.argument("file")
@click.argument("values", nargs=-1, metavar="[INPUT=VALUE]...")
@click.option("--points", metavar="CSV", help="Evaluate every row of a CSV file ('-' is standard input).")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def evaluate(
    file: str,
    values: tuple[str, ...],
    points: str | None,
    form: str,
    choice: Choice,
) -> int:
    """Evaluate a rule file at a point, or at all points of a CSV.

    \b
    fuzzyctl eval tipper service=7 food=8
    printf "service,food\\n7,8\\n" | fuzzyctl eval tipper --points -

    FILE may be '-', standard input. The CSV has a header with the names of the inputs, in any order; other columns are
    kept, the outputs are appended. A value outside an input's range is clamped to it, with a warning. An adaptive
    output is evaluated at its initial consequents.
    """
    system = load_checked(file, choice)
    if points is not None:
        if values:
            raise click.UsageError("give INPUT=VALUE or --points, not both")
        from fuzzyctl.cli.csv_points import evaluate_rows

        show(evaluate_rows(system, points, form))
        return DONE
    given = point_of(system, values, "eval")
    warnings = outside_range(system, given)
    results = _results(system, given)
    if form == "json":
        data: dict[str, Any] = {
            "system": system.name,
            "semantics": system.method.semantics.profile,
            "inputs": plain(given),
            "outputs": plain(results),
        }
        data["diagnostics"] = [w.as_dict() for w in warnings]
        write_json(data)
        return DONE
    show(warnings)
    for output in system.outputs:
        unit = f" {output.unit}" if output.unit else ""
        say(f"{output.name} = {results[output.name]!r}{unit}")
    return DONE


def _results(system: FuzzySystem, given: dict[str, float]) -> dict[str, float]:
    result = system(**given)
    return {system.outputs[0].name: result} if len(system.outputs) == 1 else dict(result)
