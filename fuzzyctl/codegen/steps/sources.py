"""Files that compute the step of a controller in a target, without those that test them."""

from __future__ import annotations

from fuzzyctl.codegen.steps import c_source, javascript_source, python_source, st_source
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.unit import StepUnit


def step_sources(unit: StepUnit, target: str) -> dict[str, str]:
    """Return the text of each file by its name.

    Args:
        unit: What to write.
        target: One of `codegen.sources.TARGETS`.

    Raises:
        CodegenError: For a controller that the target cannot express.
    """
    if target == "python":
        return {f"{python_source.module_name(unit)}.py": python_source.module(unit)}
    if target == "st":
        return {f"{st_source.block_name(unit)}.st": st_source.function_block(unit)}
    if target == "javascript":
        return {f"{StepJavaScriptLayout(unit).name}.mjs": javascript_source.module(unit)}
    name = StepLayout(unit).name
    return {f"{name}.h": c_source.header(unit), f"{name}.c": c_source.source(unit)}
