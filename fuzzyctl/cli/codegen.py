"""`fuzzyctl codegen`: a rule file as source text for machines without Python."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import (
    ALGORITHM,
    DONE,
    FORMAT,
    QUIET,
    answers_with_diagnostics,
    assignments,
    show,
)
from fuzzyctl.cli.loading import Choice, chooses, source_of
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.codegen.fixed_format import Format
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.model.system import FuzzySystem


@click.command("codegen")
@click.argument("file")
@click.option(
    "--target",
    type=click.Choice(["c", "st", "python"]),
    required=True,
    help="C99, Structured Text or one Python module.",
)
@click.option("-o", "--output", "out", metavar="DIR", default=".", help="The folder to write to.  [default: this one]")
@ALGORITHM
@click.option(
    "--float",
    "precision",
    type=click.Choice(["float", "double"]),
    help="Numbers of C and Structured Text.  [default: double]",
)
@click.option("--fixed", "fixed", metavar="Qm.n", help="Integers instead, such as Q3.12; with --target c.")
@click.option("--table", "table", type=click.IntRange(2, 4096), metavar="N", help="A lookup table, N points an input.")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def codegen(
    file: str,
    target: str,
    out: str,
    algorithm: str,
    precision: str | None,
    fixed: str | None,
    table: int | None,
    form: str,
    choice: Choice,
) -> int:
    """Write a system as C, Structured Text or Python.

    C is C99, Structured Text that of IEC 61131-3.

    \b
    fuzzyctl codegen rules/ais_reaction.fz --target c -o build
    fuzzyctl codegen rules/ais_reaction.fz --target c --fixed Q3.12 -o build
    fuzzyctl codegen rules/tipper.fz --target st --float float

    C comes with a self-test to compile and run on the target. Errors of fixed point and of tables are proved, and stand
    at the head of the file; where none can be proved the system is refused.
    """
    chosen = _format(fixed, target, precision)
    if target == "python" and precision == "float":
        raise click.BadParameter("Python has double precision only", param_hint="--float")
    source = source_of(file)
    system, verdicts = _passed(source, Path(file).parent, choice)
    from fuzzyctl.codegen.files import generate, write
    from fuzzyctl.codegen.fixed import fixed_point
    from fuzzyctl.codegen.unit import prepare

    unit = prepare(
        system,
        source.text,
        settings=assignments(choice.settings, [p.name for p in system.params], "param"),
        algorithm=algorithm,
        precision="float" if precision == "float" else "double",
        table=table,
        small=target != "python",
        verdicts=verdicts,
    )
    generated = generate(unit, target, fixed_point(unit, chosen) if chosen else None)
    data = {
        "system": system.name,
        "semantics": system.method.semantics.profile,
        "target": target,
        "algorithm": unit.algorithm.name,
        "files": [str(p) for p in write(generated, Path(out))],
        "errors": dict(generated.errors),
        "guarantees": {v.claim: type(v).__name__.lower() for v in verdicts},
    }
    if form == "json":
        write_json(data)
    else:
        say("\n".join(_told(data)))
    return DONE


def _told(data: dict[str, Any]) -> Iterator[str]:
    """Yield what was written and proved, line by line."""
    from fuzzyctl.codegen.rounding_text import at_most

    yield from (f"wrote {path}" for path in data["files"])
    yield from (f"proved: {output} is off by {at_most(error)} at most" for output, error in data["errors"].items())


def _passed(source: SourceText, folder: Path, choice: Choice) -> tuple[FuzzySystem, tuple[Verdict, ...]]:
    """Return a system that passes `fuzzyctl check` with its params set and under the profile; warnings are printed.

    Raises:
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error.
    """
    from fuzzyctl.analysis.check import check_changed

    checked = check_changed(source, choice.changed, folder=folder, system=choice.name)
    if checked.system is None:
        raise DiagnosticError(checked.diagnostics)
    show([*checked.diagnostics, *_undecided(checked.verdicts)])
    return checked.system, checked.verdicts


def _undecided(verdicts: tuple[Verdict, ...]) -> list[Diagnostic]:
    """Warn of guarantees that quick methods leave open."""
    from fuzzyctl.analysis.verdicts import Undecided

    help_text = "'fuzzyctl prove' takes the time to decide more"
    return [
        Diagnostic("FZ402", f"the guarantee '{v.claim}' is undecided", v.span, "warning", (v.reason,), help_text)
        for v in verdicts
        if isinstance(v, Undecided)
    ]


def _format(fixed: str | None, target: str, precision: str | None) -> Format | None:
    """Read the format of fixed point; what does not go with it is wrong usage."""
    if fixed is None:
        return None
    from fuzzyctl.codegen.fixed_format import to_format

    if target != "c":
        raise click.BadParameter(f"fixed point is written in C only, not for --target {target}", param_hint="--fixed")
    if precision is not None:
        raise click.BadParameter("fixed point has no floating-point numbers: drop --float", param_hint="--fixed")
    try:
        return to_format(fixed)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fixed") from None
