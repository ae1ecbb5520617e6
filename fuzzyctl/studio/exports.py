"""Files that the studio writes of a block: C, JavaScript, Python, Structured Text, without their self-tests."""

from __future__ import annotations

from typing import Final

from fuzzyctl.codegen import c_source, javascript_source, python_source, st_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.steps import c_source as step_c
from fuzzyctl.codegen.steps import javascript_source as step_javascript
from fuzzyctl.codegen.steps import python_source as step_python
from fuzzyctl.codegen.steps import st_source as step_st
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.unit import StepUnit, prepare_step
from fuzzyctl.codegen.unit import Unit, prepare
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem

#: Languages that are written.
TARGETS: Final = ("c", "javascript", "python", "st")


def exported(block: FuzzySystem | Controller, text: str, target: str) -> dict[str, str]:
    """Return the files of a target, the text of each by its name.

    Args:
        block: What is written, checked before.
        text: The rule file that it is of.
        target: One of `TARGETS`.

    Raises:
        CodegenError: For a block that the target cannot express.
    """
    if isinstance(block, Controller):
        return _of_step(prepare_step(block, text), target)
    return _of_system(prepare(block, text), target)


def _of_system(unit: Unit, target: str) -> dict[str, str]:
    if target == "c":
        name = CLayout(unit).name
        return {f"{name}.h": c_source.header(unit), f"{name}.c": c_source.source(unit)}
    if target == "javascript":
        return {f"{JavaScriptLayout(unit).name}.mjs": javascript_source.module(unit)}
    if target == "python":
        return {f"{python_source.module_name(unit)}.py": python_source.module(unit)}
    return {f"{st_source.block_name(unit)}.st": st_source.function_block(unit)}


def _of_step(unit: StepUnit, target: str) -> dict[str, str]:
    if target == "c":
        name = StepLayout(unit).name
        return {f"{name}.h": step_c.header(unit), f"{name}.c": step_c.source(unit)}
    if target == "javascript":
        return {f"{StepJavaScriptLayout(unit).name}.mjs": step_javascript.module(unit)}
    if target == "python":
        return {f"{step_python.module_name(unit)}.py": step_python.module(unit)}
    return {f"{step_st.block_name(unit)}.st": step_st.function_block(unit)}
