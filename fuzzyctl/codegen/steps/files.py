"""Files of a target, from the step of a controller."""

from __future__ import annotations

from fuzzyctl.codegen.files import Generated
from fuzzyctl.codegen.steps import (
    c_fixed_source,
    c_selftest,
    c_source,
    javascript_selftest,
    javascript_source,
    python_source,
    st_source,
)
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.fixed_step import FixedStep
from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.sequence import sequence
from fuzzyctl.codegen.steps.unit import StepUnit


def generate_step(unit: StepUnit, target: str, fixed: FixedStep | None = None) -> Generated:
    """Return the files of a target.

    Args:
        unit: What to write.
        target: One of `files.TARGETS`.
        fixed: Fixed-point arithmetic for C, None for floating point.

    Raises:
        CodegenError: For a controller that the target cannot express.
    """
    if fixed is not None:
        return Generated(c_fixed_source.files(fixed), dict(zip(unit.outputs, fixed.errors, strict=True)))
    if target == "python":
        return Generated({f"{python_source.module_name(unit)}.py": python_source.module(unit)}, {})
    if target == "st":
        return Generated({f"{st_source.block_name(unit)}.st": st_source.function_block(unit)}, {})
    if target == "javascript":
        name = StepJavaScriptLayout(unit).name
        test = javascript_selftest.selftest(unit, sequence(unit))
        return Generated({f"{name}.mjs": javascript_source.module(unit), f"{name}.test.mjs": test}, {})
    name = StepLayout(unit).name
    files = {f"{name}.h": c_source.header(unit), f"{name}.c": c_source.source(unit)}
    files[f"{name}_selftest.c"] = c_selftest.selftest(unit, sequence(unit))
    return Generated(files, {})
