"""`fuzzyctl codegen`: a rule file as source text for machines without Python."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

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
from fuzzyctl.cli.loading import Choice, checked, chooses, open_block
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.fixed.fixed_format import Format
    from fuzzyctl.codegen.fixed.fixed_step import FixedStep
    from fuzzyctl.codegen.fixed.fixed_system import Fixed
    from fuzzyctl.codegen.fmu.model import Model
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
@click.option(
    "--step", type=click.FloatRange(1e-9, 1e9), metavar="SECONDS", help="Sample time of a plant, not for an FMU."
)
@click.option(
    "--substeps",
    type=click.IntRange(1, 100),
    default=1,
    show_default=True,
    help="Steps of integration of a plant in a sample time.",
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
    step: float | None,
    substeps: int,
    unproved: bool,
    form: str,
    choice: Choice,
) -> int:
    """Write a system, controller or plant as C, Structured Text, Python, JavaScript or an FMU.

    C is C99, Structured Text that of IEC 61131-3, an FMU one for co-simulation around the C. A file with a controller
    is written as its controller. A plant is written as difference equations: steps of Runge and Kutta, as in loops,
    with inputs held for --step seconds.

    \b
    fuzzyctl codegen ais_reaction --target c -o build
    fuzzyctl codegen ais_reaction --target c --fixed Q3.12 -o build
    fuzzyctl codegen tipper --target st --float float
    fuzzyctl codegen tipper --target fmu -o tipper.fmu
    fuzzyctl codegen water_tank --block tank --target c --step 0.05 -o build

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

    kinds: list[Any] = [Controller, FuzzySystem, Plant]
    block, examined, _ = open_block(file, choice.name, *kinds)
    if block.kind != "plant" and (step is not None or substeps != 1):
        raise click.BadParameter(f"'{block.name}' is a {block.kind}; only plants take a step", param_hint="--step")
    if block.kind == "plant" and (step is None) != (target == "fmu"):
        needed = "an importer of an FMU chooses the step" if step else f"give the sample time of plant '{block.name}'"
        raise click.BadParameter(needed, param_hint="--step")
    choice = replace(choice, unproved=unproved)
    numbers: Precision = "float" if precision == "float" else "double"
    if target == "fmu":
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
        times = None if step is None else (step, substeps)
        data = _written(examined, block, choice, target, Path(out), algorithm, numbers, free, chosen, table, times)
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
    times: tuple[float, int] | None,
) -> dict[str, Any]:
    """Write the files of a block, a plant with its sample time and substeps, and return what is reported.

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
            block if times is None else _discretised(block, *times),
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


def _discretised(plant: Any, step: float, substeps: int) -> Controller:
    from fuzzyctl.codegen.fmu.plants import require_equations
    from fuzzyctl.model.discrete_plant import discretised

    require_equations(plant)
    return discretised(plant, step, substeps)


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
        message = f"'{block.name}' is a {block.kind}, whose steps no table holds; name a system with --block"
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


def write_fmu(
    examined: Examined,
    block: Block,
    choice: Choice,
    out: str,
    *,
    version: int,
    algorithm: str,
    precision: Precision,
    table: int | None,
    free: tuple[str, ...],
) -> dict[str, Any]:
    """Write the FMU of a file and return what is reported; one without a binary is a warning.

    Args:
        examined: The file.
        block: The block.
        choice: Its params.
        out: The file to write, or the folder of a file named after the block.
        version: 2 or 3, of FMI.
        algorithm: How systems are evaluated.
        precision: Type of numbers in C.
        table: Points along each input of a lookup table, for systems.
        free: Params that importers may set; none stands for all that can be set.

    Raises:
        DiagnosticError: For a file that does not pass `fuzzyctl check`, and an FMU that cannot be written.
        CodegenError: For a block that has no FMU, and where the compiler fails.
    """
    from fuzzyctl.codegen.fmu.archive import fmu

    model = _model(examined, block, choice, algorithm, precision, table, free)
    archive = fmu(model, version)
    path = Path(out) if out.endswith(".fmu") else Path(out) / f"{model.name}.fmu"
    _write(path, archive.data)
    if archive.missing:
        help_text = "install a C compiler (cc, gcc or clang), or name yours in the environment variable CC"
        show([Diagnostic("FZ712", archive.missing, severity="warning", file=str(path), help=help_text)])
    return {
        block.kind: model.block,
        "target": "fmu",
        "fmi": f"{version}.0",
        "files": [str(path)],
        "binary": archive.binary or None,
        "errors": {},
    }


def _model(
    examined: Examined,
    block: Any,
    choice: Choice,
    algorithm: str,
    precision: Precision,
    table: int | None,
    free: tuple[str, ...],
) -> Model:
    """Return the model of a system, controller or plant."""
    from fuzzyctl.codegen.fmu.calls import block_model, tunable
    from fuzzyctl.codegen.fmu.plants import plant_model
    from fuzzyctl.codegen.prepare import prepare

    text = examined.source.text
    if table is not None and block.kind != "system":
        raise click.BadParameter("a lookup table holds a system only; name one with --block", param_hint="--table")
    if block.kind == "plant":
        if precision == "float":
            raise click.BadParameter("a plant is integrated in double precision", param_hint="--float")
        return plant_model(checked(examined, block, choice)[0], text, free)
    if block.kind == "system" and free:
        raise click.BadParameter("only controllers and plants have parameters in an FMU", param_hint="--free")
    block, verdicts = checked(examined, block, choice)
    unit = prepare(
        block,
        text,
        settings=assignments(choice.settings, block.settable, "param"),
        algorithm=algorithm,
        precision=precision,
        table=table,
        small=True,
        free=free or (tunable(block) if block.kind == "controller" else ()),
        verdicts=verdicts,
    )
    return block_model(unit)


def _write(path: Path, data: bytes) -> None:
    from fuzzyctl.support.writing import folder_for, written_whole

    with folder_for(path.parent), written_whole(path) as temporary:
        temporary.write_bytes(data)
