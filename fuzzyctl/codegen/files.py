"""Files of a target, from a unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fuzzyctl.codegen import c_source, javascript_source, python_source, st_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Number
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.equations import Chip, Integers
from fuzzyctl.simulation.loop_params import block_params
from fuzzyctl.support.writing import folder_for, write_together

if TYPE_CHECKING:
    from fuzzyctl.codegen.fixed.fixed_step import FixedStep
    from fuzzyctl.codegen.fixed.fixed_system import Fixed
    from fuzzyctl.codegen.vectors import Expected

#: Targets of code generation.
TARGETS: Final = ("c", "st", "python", "javascript")
#: Longest name of a file, in bytes, with room for the suffix of a temporary one.
LONGEST: Final = 200


@dataclass(frozen=True)
class Generated:
    """Files by name, and the proofs about them.

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
        target: One of `TARGETS`.
        fixed: Fixed-point arithmetic for C, None for floating point.

    Raises:
        CodegenError: For a block that the target cannot express.
    """
    from fuzzyctl.codegen.selftests import c_selftest, javascript_selftest  # numpy, which sources do without

    if fixed is not None:
        from fuzzyctl.codegen.fixed.c_fixed_step import files

        return Generated(files(unit, fixed), dict(zip(unit.outputs, fixed.errors, strict=True)))
    texts = sources(unit, target)
    if target == "javascript":
        texts[f"{JavaScriptLayout(unit).name}.test.mjs"] = javascript_selftest(unit, expected_of(unit))
    if target == "c":
        texts[f"{CLayout(unit).name}_selftest.c"] = c_selftest(unit, expected_of(unit))
    return Generated(texts, dict(zip(unit.outputs, unit.table.errors, strict=True)) if unit.table else {})


def sources(unit: Unit, target: str) -> dict[str, str]:
    """Return the text of each file by its name.

    Args:
        unit: What to write.
        target: One of `TARGETS`.

    Raises:
        CodegenError: For a block that the target cannot express.
    """
    if target == "python":
        return {f"{python_source.module_name(unit)}.py": python_source.module(unit)}
    if target == "st":
        return {f"{st_source.block_name(unit)}.st": st_source.function_block(unit)}
    if target == "javascript":
        return {f"{JavaScriptLayout(unit).name}.mjs": javascript_source.module(unit)}
    name = CLayout(unit).name
    return {f"{name}.h": c_source.header(unit), f"{name}.c": c_source.source(unit)}


def expected_of(unit: Unit) -> Expected:
    """Return the expected values of a self-test: of a system at points, of a controller along a sequence."""
    from fuzzyctl.codegen.sequence import sequence
    from fuzzyctl.codegen.vectors import Expected, in_parts

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


def chip_of(loop: Loop, text: str) -> Chip:
    """Return the integers of the controllers of a loop in a format such as Q3.12.

    Raises:
        ValueError: For an unreadable format.
    """
    from fuzzyctl.codegen.fixed.fixed_format import to_format
    from fuzzyctl.codegen.fixed.fixed_program import refused
    from fuzzyctl.codegen.fixed.fixed_step import fixed_step
    from fuzzyctl.codegen.prepare import prepare

    form = to_format(text)
    blocks: dict[str, Integers] = {}
    for instance in loop.instances:
        controller = loop.callee(instance)
        if not isinstance(controller, Controller):
            continue
        params = block_params(loop, instance)
        # A param of the loop may be one of the controller, too.
        varied = [v.name for v in loop.varied if v.name.startswith(f"{instance.name}.") or "." not in v.name]
        numbers = tuple(replace(p, expression=Number(params[p.name])) for p in controller.params)
        try:
            if varied:
                raise refused(f"'{varied[0]}' varies, and integers are those of one number", None)
            step = fixed_step(prepare(replace(controller, params=numbers), "", algorithm="interpolation"), form)
        except (DiagnosticError, CodegenError) as error:
            mistakes = error.diagnostics if isinstance(error, DiagnosticError) else ()
            what = "; ".join([d.message for d in mistakes]) or str(error)
            return Chip(str(form), {}, f"block '{instance.name}' has no integers in {form}: {what}")
        unit = 2.0**-form.fraction
        inputs = {
            signal.name: (least * unit, most * unit, 0.5 * unit)
            for signal, (least, most) in zip(controller.inputs, step.inputs, strict=True)
        }
        outputs = {r.name: e for r, e in zip(controller.results, step.errors, strict=True)}
        blocks[instance.name] = Integers(inputs, outputs)
    return Chip(str(form), blocks)
