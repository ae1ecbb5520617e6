"""`fuzzyctl codegen`: a rule file as source text for machines without Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import ALGORITHM, DONE, FORMAT, QUIET, answers_with_diagnostics, assignments, show
from fuzzyctl.cli.loading import Choice, checked, chooses, open_block
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.fixed.fixed_format import Format
    from fuzzyctl.codegen.fixed.fixed_step import FixedStep
    from fuzzyctl.codegen.fixed.fixed_system import Fixed
    from fuzzyctl.codegen.fmu.model import Model
    from fuzzyctl.codegen.unit import Precision, Unit
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller

#: Names of the targets that are languages.
LANGUAGES: Final = {"c": "C", "st": "Structured Text", "python": "Python", "javascript": "JavaScript"}


@dataclass(frozen=True)
class Options:
    """The options that say how a block is written, by name as on the command line."""

    target: str
    out: str
    fmi: str | None
    algorithm: str
    precision: Precision | None
    fixed: str | None
    table: int | None
    free: tuple[str, ...]
    step: float | None
    substeps: int


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
    help="Floating-point type in C and Structured Text.  [default: double]",
)
@click.option("--fixed", "fixed", metavar="Qm.n", help="Fixed-point integers, such as Q3.12; with --target c.")
@click.option(
    "--table", "table", type=click.IntRange(2, 4096), metavar="N", help="A lookup table with N points for each input."
)
@click.option(
    "--free",
    "free",
    metavar="NAME",
    multiple=True,
    help="A number of a controller that its caller sets; may be repeated.",
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
@click.option("--unproved", is_flag=True, help="Write it even if a guarantee does not hold.")
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def codegen(file: str, form: str, choice: Choice, unproved: bool, **options: Any) -> int:
    """Write a system, controller or plant as C, Structured Text, Python, JavaScript or an FMU.

    C is C99, Structured Text follows IEC 61131-3, and an FMU is for co-simulation and contains the C. If the file has a
    controller, the controller is written. A plant is written as difference equations: Runge-Kutta steps, as in loops,
    with inputs held for --step seconds.

    \b
    fuzzyctl codegen ais_reaction --target c -o build
    fuzzyctl codegen ais_reaction --target c --fixed Q3.12 -o build
    fuzzyctl codegen tipper --target st --float float
    fuzzyctl codegen tipper --target fmu -o tipper.fmu
    fuzzyctl codegen water_tank --block tank --target c --step 0.05 -o build

    C comes with a self-test to compile and run on the target. The errors of fixed point and of tables are bounded by a
    proof, and the bounds are printed at the head of the file; a system without a proved bound is refused. A block with
    a refuted guarantee is refused, too, unless '--unproved' is given.
    """
    o = Options(**options)
    fixed = _fixed_format(o)
    _refuse(
        (
            o.target in ("python", "javascript") and o.precision == "float",
            "--float",
            f"{LANGUAGES.get(o.target)} has double precision only",
        ),
        (o.fmi is not None and o.target != "fmu", "--fmi", f"an FMU is written with --target fmu, not {o.target}"),
    )
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.plant import Plant
    from fuzzyctl.model.system import FuzzySystem

    kinds: list[Any] = [Controller, FuzzySystem, Plant]
    block, examined, _ = open_block(file, choice.name, *kinds)
    is_fmu, is_plant = o.target == "fmu", block.kind == "plant"
    step = "an importer of an FMU chooses the step" if o.step else f"give the sample time of plant '{block.name}'"
    _refuse(
        (
            not is_plant and (o.step is not None or o.substeps != 1),
            "--step",
            f"'{block.name}' is a {block.kind}; only plants take a step",
        ),
        (is_plant and (o.step is None) != is_fmu, "--step", step),
    )
    choice = replace(choice, unproved=unproved)
    data = _write_fmu(examined, block, choice, o) if is_fmu else _write_files(examined, block, choice, o, fixed)
    if form == "json":
        write_json(data)
    else:
        say("\n".join(_reported(data)))
    return DONE


def _refuse(*mistakes: tuple[bool, str, str]) -> None:
    """Raise BadParameter for the first mistake: whether it is one, the option, the message."""
    for is_one, option, message in mistakes:
        if is_one:
            raise click.BadParameter(message, param_hint=option)


def _unit(
    examined: Examined, block: Any, choice: Choice, o: Options, **options: Any
) -> tuple[Unit, Block, Sequence[Verdict]]:
    """Return a block prepared for its writers, the block with params set, and the verdicts on its guarantees."""
    from fuzzyctl.codegen.prepare import prepare

    block, verdicts = checked(examined, block, choice)
    if o.target == "fmu" and block.kind == "controller" and not o.free:
        from fuzzyctl.codegen.fmu.calls import tunable

        options["free"] = tunable(block)
    unit = prepare(
        block if o.step is None else _discretised(block, o.step, o.substeps),
        examined.source.text,
        settings=assignments(choice.settings, block.settable, "param"),
        algorithm=o.algorithm,
        precision=o.precision or "double",
        table=o.table,
        verdicts=verdicts,
        **{"free": o.free, **options},
    )
    return unit, block, verdicts


def _write_files(examined: Examined, block: Any, choice: Choice, o: Options, fixed: Format | None) -> dict[str, Any]:
    """Write the files of a block in a language, and return the report.

    Raises:
        BadParameter: For options that do not go with the block.
        DiagnosticError: With all that `fuzzyctl check` finds, and if the target cannot express the block.
    """
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.files import generate, write

    is_system = block.kind == "system"
    no_table = f"'{block.name}' is a {block.kind}, whose steps no table holds; name a system with --block"
    no_algorithm = f"fixed point interpolates: drop --algorithm {o.algorithm}"
    is_free, is_fixed = bool(o.free), fixed is not None and not is_system
    _refuse(
        (is_system and is_free, "--free", "only controllers take numbers from their caller"),
        (not is_system and o.table is not None, "--table", no_table),
        (is_fixed and is_free, "--fixed", "fixed point takes the numbers of the file: drop --free"),
        (is_fixed and o.algorithm not in ("auto", "interpolation"), "--fixed", no_algorithm),
    )
    try:
        small, guarded = o.target not in ("python", "javascript"), o.target == "st"
        unit, block, verdicts = _unit(examined, block, choice, o, small=small, guarded=guarded)
        integers = _integers(unit, fixed) if fixed else None
        generated = generate(unit, o.target, integers)
    except CodegenError as error:
        raise DiagnosticError([_refused(block, o.target, error)]) from None
    names = {u.system.name: u.algorithm.name for u in getattr(integers, "unit", unit).systems}
    return {
        **block.identity,
        "target": o.target,
        **({"algorithms": names} if unit.is_step else {"algorithm": unit.algorithm.name}),
        "files": [str(p) for p in write(generated, Path(o.out))],
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


def _reported(data: dict[str, Any]) -> Iterator[str]:
    """Yield the written files and the proved errors, line by line."""
    from fuzzyctl.codegen.table import at_most

    yield from (f"wrote {path}" for path in data["files"])
    yield from (f"proved: {output} is off by {at_most(error)} at most" for output, error in data["errors"].items())


def _fixed_format(o: Options) -> Format | None:
    """Return the format of fixed point.

    Raises:
        BadParameter: For another target than C, with --float, or for an unreadable format.
    """
    if o.fixed is None:
        return None
    from fuzzyctl.codegen.fixed.fixed_format import to_format

    _refuse(
        (o.target != "c", "--fixed", f"fixed point is written in C only, not for --target {o.target}"),
        (o.precision is not None, "--fixed", "fixed point has no floating-point numbers: drop --float"),
    )
    try:
        return to_format(o.fixed)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fixed") from None


def _write_fmu(examined: Examined, block: Any, choice: Choice, o: Options) -> dict[str, Any]:
    """Write the FMU of a block and return the report; an FMU without a binary is a warning.

    Raises:
        BadParameter: For options that do not go with the block.
        DiagnosticError: For a file that does not pass `fuzzyctl check`, and an FMU that cannot be written.
        CodegenError: For a block that has no FMU, and if the compiler fails.
    """
    from fuzzyctl.codegen.fmu.archive import fmu
    from fuzzyctl.support.writing import folder_for, written_whole

    model = _model(examined, block, choice, o)
    archive = fmu(model, int(o.fmi or 3))
    path = Path(o.out) if o.out.endswith(".fmu") else Path(o.out) / f"{model.name}.fmu"
    with folder_for(path.parent), written_whole(path) as temporary:
        temporary.write_bytes(archive.data)
    if archive.missing:
        help_text = "install a C compiler (cc, gcc or clang), or name yours in the environment variable CC"
        show([Diagnostic("FZ712", archive.missing, severity="warning", file=str(path), help=help_text)])
    return {
        block.kind: model.block,
        "target": "fmu",
        "fmi": f"{o.fmi or 3}.0",
        "files": [str(path)],
        "binary": archive.binary or None,
        "errors": {},
    }


def _model(examined: Examined, block: Any, choice: Choice, o: Options) -> Model:
    from fuzzyctl.codegen.fmu.calls import block_model
    from fuzzyctl.codegen.fmu.plants import plant_model

    is_system, is_plant = block.kind == "system", block.kind == "plant"
    no_free = "only controllers and plants have parameters in an FMU"
    _refuse(
        (not is_system and o.table is not None, "--table", "a lookup table holds a system only; name one with --block"),
        (is_plant and o.precision == "float", "--float", "a plant is integrated in double precision"),
        (is_system and bool(o.free), "--free", no_free),
    )
    if is_plant:
        return plant_model(checked(examined, block, choice)[0], examined.source.text, o.free)
    return block_model(_unit(examined, block, choice, o, small=True)[0])
