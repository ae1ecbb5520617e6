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
from fuzzyctl.codegen.sources import sources
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.vectors import in_parts
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


def generate(unit: Unit, target: str, fixed: Fixed | None = None) -> Generated:
    """Return the files of a target.

    Args:
        unit: What to write.
        target: One of `sources.TARGETS`.
        fixed: Fixed-point arithmetic for C, None for floating point.

    Raises:
        CodegenError: For a system that the target cannot express.
    """
    names = [o.name for o in unit.plan.outputs]
    if fixed is not None:
        return Generated(c_fixed_source.files(unit, fixed), dict(zip(names, fixed.errors, strict=True)))
    errors = dict(zip(names, unit.table.errors, strict=True)) if unit.table else {}
    files = sources(unit, target)
    if target == "javascript":
        files[f"{JavaScriptLayout(unit).name}.test.mjs"] = javascript_selftest.selftest(unit)
    if target == "c":
        files[f"{CLayout(unit).name}_selftest.c"] = c_selftest.selftest(unit, *in_parts(unit))
    return Generated(files, errors)


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
