"""Files that compute a block in a target, without those that test them."""

from __future__ import annotations

from typing import Final

from fuzzyctl.codegen import c_source, javascript_source, python_source, st_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.unit import Unit

#: Targets of code generation.
TARGETS: Final = ("c", "st", "python", "javascript")


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
