"""Target fmu of `fuzzyctl codegen`: a system, controller or plant as a Functional Mock-up Unit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.checked import checked_block, checked_system
from fuzzyctl.cli.common import assignments, show
from fuzzyctl.cli.loading import Choice
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.codegen.fmu.model import Model
    from fuzzyctl.codegen.unit import Precision
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.plant import Plant


def write_fmu(
    examined: Examined,
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
        choice: The block, and its params.
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

    kind, model = _model(examined, choice, algorithm, precision, table, free)
    made = fmu(model, version)
    path = Path(out) if out.endswith(".fmu") else Path(out) / f"{model.name}.fmu"
    _write(path, made.data)
    if made.missing:
        help_text = "install a C compiler (cc, gcc or clang), or name yours in the environment variable CC"
        show([Diagnostic("FZ712", made.missing, severity="warning", file=str(path), help=help_text)])
    return {
        kind: model.block,
        "target": "fmu",
        "fmi": f"{version}.0",
        "files": [str(path)],
        "binary": made.binary or None,
        "errors": {},
    }


def _model(
    examined: Examined,
    choice: Choice,
    algorithm: str,
    precision: Precision,
    table: int | None,
    free: tuple[str, ...],
) -> tuple[str, Model]:
    """Return what a file is meant as: 'system', 'controller' or 'plant', and its model."""
    from fuzzyctl.codegen.fmu.calls import block_model, tunable
    from fuzzyctl.codegen.fmu.plants import plant_model
    from fuzzyctl.codegen.prepare import prepare
    from fuzzyctl.loading.choice import choose_controller

    text = examined.source.text
    plant = _chosen_plant(examined, choice.name)
    controller = None if plant is not None else choose_controller(examined, choice.name)
    if table is not None and (plant or controller) is not None:
        raise click.BadParameter("a lookup table holds a system only; name one with --system", param_hint="--table")
    if plant is not None:
        if precision == "float":
            raise click.BadParameter("a plant is integrated in double precision", param_hint="--float")
        return "plant", plant_model(checked_block(examined, plant, choice)[0], text, free)
    if controller is not None:
        controller, verdicts = checked_block(examined, controller, choice)
        settings = assignments(choice.settings, [p.name for p in controller.params], "param")
        free = free or tunable(controller)
        options: dict[str, Any] = {"algorithm": algorithm, "precision": precision, "small": True, "free": free}
        options["verdicts"] = verdicts
        return "controller", block_model(prepare(controller, text, settings=settings, **options))
    if free:
        raise click.BadParameter("only controllers and plants have parameters in an FMU", param_hint="--free")
    system, verdicts = checked_system(examined, choice)
    settings = assignments(choice.settings, [p.name for p in system.params], "param")
    options = {"algorithm": algorithm, "precision": precision, "table": table, "small": True, "verdicts": verdicts}
    return "system", block_model(prepare(system, text, settings=settings, **options))


def _chosen_plant(examined: Examined, name: str | None) -> Plant | None:
    """Return the plant that is named, or the only block of a file without systems and controllers."""
    from fuzzyctl.loading.choice import chosen_block

    if name is not None:
        return next((p for p in examined.plants if p.name == name), None)
    if examined.controllers or examined.systems or not examined.plants:
        return None
    found = chosen_block(examined.source, examined.plants, "plant", None)
    if isinstance(found, Diagnostic):
        raise DiagnosticError([found])
    return found


def _write(path: Path, data: bytes) -> None:
    from fuzzyctl.support.writing import folder_for, written_whole

    with folder_for(path.parent), written_whole(path) as temporary:
        temporary.write_bytes(data)
