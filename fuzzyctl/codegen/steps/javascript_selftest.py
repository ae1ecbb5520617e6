"""Self-test of a step in JavaScript: makes the steps of the test sequence, twice, and prints the largest error."""

from __future__ import annotations

from fuzzyctl.codegen.javascript_selftest import selftest_text, turn
from fuzzyctl.codegen.steps.javascript_source import StepJavaScriptLayout
from fuzzyctl.codegen.steps.sequence import Steps
from fuzzyctl.codegen.steps.unit import StepUnit
from fuzzyctl.kernels.program.printer import INDENT


def selftest(unit: StepUnit, steps: Steps) -> str:
    """Return the text of NAME.test.mjs."""
    layout = StepJavaScriptLayout(unit)
    name, refuses = layout.name, bool(unit.refusals)
    state = ["state"] if layout.has_state else []
    call = f"{name}_step({', '.join([*state, '...vector[0]'])})"
    # The second time shows that the state begins anew.
    run = ["for (let round = 0; round < 2; ++round) {"]
    run += [f"{INDENT}const state = {name}_init();"] if layout.has_state else []
    run += [f"{INDENT}for (const vector of vectors) {{", *(INDENT + line for line in turn(call, refuses))]
    run += [f"{INDENT}}}", "}"]
    imported = [*([f"{name}_init"] if layout.has_state else []), f"{name}_step"]
    allowed = [steps.tolerance(k, unit.precision) for k in range(len(unit.outputs))]
    return selftest_text(name, imported, refuses, steps.vectors, allowed, run)
