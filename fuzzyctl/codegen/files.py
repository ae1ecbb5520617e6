"""Files of a target, from a unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fuzzyctl.codegen import c_fixed_source, c_selftest, javascript_selftest
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.fixed import Fixed
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.sequence import sequence
from fuzzyctl.codegen.sources import sources
from fuzzyctl.codegen.steps import c_fixed_source as step_fixed_source
from fuzzyctl.codegen.steps.fixed_step import FixedStep
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.vectors import Expected, in_parts
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.writing import folder_for, write_together

#: Longest name of a file, in bytes, with room for that of a temporary one beside it.
LONGEST: Final = 200


@dataclass(frozen=True)
class Generated:
    """Files by name, and what is proved of them.

    Args:
        files: Text of each file by its name.
        errors: Proved error of each output by its name, for fixed point and tables; empty for the system itself.
    """

    files: Mapping[str, str]
    errors: Mapping[str, float]


def generate(unit: Unit, target: str, fixed: Fixed | FixedStep | None = None) -> Generated:
    """Return the files of a target.

    Args:
        unit: What to write.
        target: One of `sources.TARGETS`.
        fixed: Fixed-point arithmetic for C, None for floating point.

    Raises:
        CodegenError: For a block that the target cannot express.
    """
    if isinstance(fixed, FixedStep):
        return Generated(step_fixed_source.files(fixed), dict(zip(unit.outputs, fixed.errors, strict=True)))
    if fixed is not None:
        return Generated(c_fixed_source.files(unit, fixed), dict(zip(unit.outputs, fixed.errors, strict=True)))
    files = sources(unit, target)
    if target == "javascript":
        files[f"{JavaScriptLayout(unit).name}.test.mjs"] = javascript_selftest.selftest(unit, expected_of(unit))
    if target == "c":
        files[f"{CLayout(unit).name}_selftest.c"] = c_selftest.selftest(unit, expected_of(unit))
    return Generated(files, dict(zip(unit.outputs, unit.table.errors, strict=True)) if unit.table else {})


def expected_of(unit: Unit) -> Expected:
    """Return what a self-test expects: of a system at points, of a controller along a sequence."""
    if unit.is_step:
        return sequence(unit)
    return Expected([unit.scale(k) for k in range(len(unit.outputs))], *in_parts(unit))


def write(generated: Generated, folder: Path) -> list[Path]:
    """Write the files into a folder, which is made if it is not there: all of them, or none.

    Raises:
        DiagnosticError: Where the folder or a file cannot be written.
    """
    written = [folder / name for name in generated.files]
    if any(len(path.name.encode()) > LONGEST for path in written):
        message = f"the files would have names of more than {LONGEST} bytes"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(folder), help="give the system a shorter name")])
    with folder_for(folder):
        write_together(dict(zip(written, generated.files.values(), strict=True)))
    return written
