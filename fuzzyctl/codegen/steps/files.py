"""Files of a target, from the step of a controller."""

from __future__ import annotations

from fuzzyctl.codegen.files import Generated
from fuzzyctl.codegen.steps import c_fixed_source, c_selftest, javascript_selftest
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.fixed_step import FixedStep
from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.sequence import sequence
from fuzzyctl.codegen.steps.sources import step_sources
from fuzzyctl.codegen.steps.unit import StepUnit


def generate_step(unit: StepUnit, target: str, fixed: FixedStep | None = None) -> Generated:
    """Return the files of a target.

    Args:
        unit: What to write.
        target: One of `sources.TARGETS`.
        fixed: Fixed-point arithmetic for C, None for floating point.

    Raises:
        CodegenError: For a controller that the target cannot express.
    """
    if fixed is not None:
        return Generated(c_fixed_source.files(fixed), dict(zip(unit.outputs, fixed.errors, strict=True)))
    files = step_sources(unit, target)
    if target == "javascript":
        name = f"{StepJavaScriptLayout(unit).name}.test.mjs"
        files[name] = javascript_selftest.selftest(unit, sequence(unit))
    if target == "c":
        files[f"{StepLayout(unit).name}_selftest.c"] = c_selftest.selftest(unit, sequence(unit))
    return Generated(files, {})
