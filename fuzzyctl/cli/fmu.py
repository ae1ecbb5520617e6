"""Target fmu of `fuzzyctl codegen`: a system, controller or plant as a Functional Mock-up Unit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.checked import checked
from fuzzyctl.cli.common import assignments, show
from fuzzyctl.cli.loading import Choice
from fuzzyctl.diagnostics.diagnostic import Diagnostic

if TYPE_CHECKING:
    from fuzzyctl.codegen.fmu.model import Model
    from fuzzyctl.codegen.unit import Precision
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.block import Block


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
    made = fmu(model, version)
    path = Path(out) if out.endswith(".fmu") else Path(out) / f"{model.name}.fmu"
    _write(path, made.data)
    if made.missing:
        help_text = "install a C compiler (cc, gcc or clang), or name yours in the environment variable CC"
        show([Diagnostic("FZ712", made.missing, severity="warning", file=str(path), help=help_text)])
    return {
        block.kind: model.block,
        "target": "fmu",
        "fmi": f"{version}.0",
        "files": [str(path)],
        "binary": made.binary or None,
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
