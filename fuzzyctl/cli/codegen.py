"""`fuzzyctl codegen`: a rule file as source text for machines without Python."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.checked import checked
from fuzzyctl.cli.common import (
    ALGORITHM,
    DONE,
    FORMAT,
    QUIET,
    answers_with_diagnostics,
    assignments,
)
from fuzzyctl.cli.loading import Choice, chooses, open_block
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.fixed.fixed_format import Format
    from fuzzyctl.codegen.fixed.fixed_step import FixedStep
    from fuzzyctl.codegen.fixed.fixed_system import Fixed
    from fuzzyctl.codegen.unit import Precision, Unit
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem

#: Names of the targets that are languages.
LANGUAGES: Final = {"c": "C", "st": "Structured Text", "python": "Python", "javascript": "JavaScript"}


@click.command("codegen")
@click.argument("file")
@click.option(
    "--target",
    type=click.Choice(["c", "st", "python", "javascript", "fmu"]),
    required=True,
    help="C99, Structured Text, one Python module, one ES module, or a Functional Mock-up Unit.",
)
@click.option("-o", "--output", "out", metavar="DIR", default=".", help="The folder to write to.  [default: this one]")
@click.option("--fmi", type=click.Choice(["2", "3"]), help="Version of FMI of an FMU.  [default: 3]")
@ALGORITHM
@click.option(
    "--float",
    "precision",
    type=click.Choice(["float", "double"]),
    help="Numbers of C and Structured Text.  [default: double]",
)
@click.option("--fixed", "fixed", metavar="Qm.n", help="Integers instead, such as Q3.12; with --target c.")
@click.option("--table", "table", type=click.IntRange(2, 4096), metavar="N", help="A lookup table, N points an input.")
@click.option(
    "--free",
    "free",
    metavar="NAME",
    multiple=True,
    help="A number of a controller that its caller gives; may be repeated.",
)
@click.option("--unproved", is_flag=True, help="Write it although a guarantee of it does not hold.")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def codegen(
    file: str,
    target: str,
    out: str,
    fmi: str | None,
    algorithm: str,
    precision: str | None,
    fixed: str | None,
    table: int | None,
    free: tuple[str, ...],
    unproved: bool,
    form: str,
    choice: Choice,
) -> int:
    """Write a system or a controller as C, Structured Text, Python, JavaScript or an FMU.

    C is C99, Structured Text that of IEC 61131-3, an FMU one for co-simulation around the C; of a plant, too. A file
    with a controller is written as its controller.

    \b
    fuzzyctl codegen ais_reaction --target c -o build
    fuzzyctl codegen ais_reaction --target c --fixed Q3.12 -o build
    fuzzyctl codegen tipper --target st --float float
    fuzzyctl codegen tipper --target fmu -o tipper.fmu

    C comes with a self-test to compile and run on the target. Errors of fixed point and of tables are proved, and stand
    at the head of the file; where none can be proved the system is refused. So is a
    block whose guarantee is refuted, unless '--unproved' is given.
    """
    chosen = _format(fixed, target, precision)
    if target in ("python", "javascript") and precision == "float":
        raise click.BadParameter(f"{LANGUAGES[target]} has double precision only", param_hint="--float")
    if fmi is not None and target != "fmu":
        raise click.BadParameter(f"an FMU is written with --target fmu, not {target}", param_hint="--fmi")
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.plant import Plant
    from fuzzyctl.model.system import FuzzySystem

    kinds: list[Any] = [Controller, FuzzySystem, *([Plant] if target == "fmu" else [])]
    block, examined, _ = open_block(file, choice.name, *kinds)
    choice = replace(choice, unproved=unproved)
    numbers: Precision = "float" if precision == "float" else "double"
    if target == "fmu":
        from fuzzyctl.cli.fmu import write_fmu

        version = int(fmi or 3)
        data = write_fmu(
            examined,
            block,
            choice,
            out,
            version=version,
            algorithm=algorithm,
            precision=numbers,
            table=table,
            free=free,
        )
    else:
        data = _written(examined, block, choice, target, Path(out), algorithm, numbers, free, chosen, table)
    if form == "json":
        write_json(data)
    else:
        say("\n".join(_reported(data)))
    return DONE


def _written(
    examined: Examined,
    block: FuzzySystem | Controller,
    choice: Choice,
    target: str,
    out: Path,
    algorithm: str,
    precision: Precision,
    free: tuple[str, ...],
    fixed: Format | None,
    table: int | None,
) -> dict[str, Any]:
    """Write the files of a controller or system and return what is reported.

    Raises:
        BadParameter: For options that do not go with it.
        DiagnosticError: With all that `fuzzyctl check` finds, and where the target cannot express it.
    """
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.files import generate, write
    from fuzzyctl.codegen.prepare import prepare

    _refuse_options(block, fixed, table, free, algorithm)
    try:
        block, verdicts = checked(examined, block, choice)
        unit = prepare(
            block,
            examined.source.text,
            settings=assignments(choice.settings, block.settable, "param"),
            algorithm=algorithm,
            precision=precision,
            table=table,
            small=target not in ("python", "javascript"),
            guarded=target == "st",
            free=free,
            verdicts=verdicts,
        )
        integers = _integers(unit, fixed) if fixed else None
        generated = generate(unit, target, integers)
    except CodegenError as error:
        raise DiagnosticError([_refused(block, target, error)]) from None
    names = {u.system.name: u.algorithm.name for u in getattr(integers, "unit", unit).systems}
    return {
        **block.identity,
        "target": target,
        **({"algorithms": names} if unit.is_step else {"algorithm": unit.algorithm.name}),
        "files": [str(p) for p in write(generated, out)],
        "errors": dict(generated.errors),
        "guarantees": {v.claim: type(v).__name__.lower() for v in verdicts},
    }


def _refused(block: Block, target: str, error: CodegenError) -> Diagnostic:
    """Return why a system or controller is not written, at the call of a function that the target has not."""
    from fuzzyctl.expr import Call, walk

    parts = (*block.definitions, *block.changes, *block.outputs)
    values = [part.value for part in parts if part.value is not None]
    calls = (e for value in values for e in walk(value) if isinstance(e, Call))
    place = next((call.span for call in calls if call.function == error.function and call.span is not None), block.span)
    return Diagnostic("FZ608", f"'{block.name}' cannot be written in {LANGUAGES[target]}", place, facts=(str(error),))


def _integers(unit: Unit, fixed: Format) -> Fixed | FixedStep:
    from fuzzyctl.codegen.fixed.fixed_step import fixed_step
    from fuzzyctl.codegen.fixed.fixed_system import fixed_point

    return fixed_step(unit, fixed) if unit.is_step else fixed_point(unit, fixed)


def _refuse_options(
    block: Block, fixed: Format | None, table: int | None, free: tuple[str, ...], algorithm: str
) -> None:
    """Refuse options that do not go with a block, or with fixed point.

    Raises:
        BadParameter: For free numbers of a system; for a lookup table of a controller, in fixed point for free numbers
            and for another algorithm than interpolation.
    """
    if block.kind == "system":
        if free:
            raise click.BadParameter("only controllers take numbers from their caller", param_hint="--free")
        return
    if table is not None:
        message = f"'{block.name}' is a controller, whose steps no table holds; name a system with --block"
        raise click.BadParameter(message, param_hint="--table")
    if fixed is not None and free:
        raise click.BadParameter("fixed point takes the numbers of the file: drop --free", param_hint="--fixed")
    if fixed is not None and algorithm not in ("auto", "interpolation"):
        raise click.BadParameter(f"fixed point interpolates: drop --algorithm {algorithm}", param_hint="--fixed")


def _reported(data: dict[str, Any]) -> Iterator[str]:
    """Yield what was written and proved, line by line."""
    from fuzzyctl.codegen.table import at_most

    yield from (f"wrote {path}" for path in data["files"])
    yield from (f"proved: {output} is off by {at_most(error)} at most" for output, error in data["errors"].items())


def _format(fixed: str | None, target: str, precision: str | None) -> Format | None:
    """Read the format of fixed point; what does not go with it is wrong usage."""
    if fixed is None:
        return None
    from fuzzyctl.codegen.fixed.fixed_format import to_format

    if target != "c":
        raise click.BadParameter(f"fixed point is written in C only, not for --target {target}", param_hint="--fixed")
    if precision is not None:
        raise click.BadParameter("fixed point has no floating-point numbers: drop --float", param_hint="--fixed")
    try:
        return to_format(fixed)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fixed") from None
