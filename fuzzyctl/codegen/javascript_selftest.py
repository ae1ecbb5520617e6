"""Self-test in JavaScript: compares outputs with the test vectors and prints the largest error of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.codegen.c_text import bare
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.javascript_text import comment, file_text, list_lines, literal, quoted
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.vectors import STEP, Vector, vectors
from fuzzyctl.kernels.program.printer import INDENT

#: What compares and reports, behind the function `evaluate` that makes one turn.
_MAIN = """const worst = tolerance.map(() => 0);
let failures = 0;
function compare(found, refused, vector) {
    failures += refused === vector[2] ? 0 : 1;
    vector[1].forEach((wanted, k) => {
        if (!Object.is(found[k], wanted) && found[k] !== wanted) {
            const off = Math.abs(found[k] - wanted);
            worst[k] = Math.max(worst[k], off);
            failures += off <= tolerance[k] ? 0 : 1;
        }
    });
}
"""

_REPORT = """outputs.forEach((output, k) => {
    console.log(NAME + ": " + output.name + ": worst error " + worst[k] + ", allowed " + tolerance[k]);
});
console.log(NAME + ": " + vectors.length + " vectors, " + failures + " failures");
if (failures > 0) {
    process.exitCode = 1;
}
"""


def selftest(unit: Unit) -> str:
    """Return the text of NAME.test.mjs, which compares with the vectors of the self-test in C."""
    layout, flat = JavaScriptLayout(unit), unit.plan
    name = layout.name
    imported = [name, *([f"{name}_init"] if layout.states else []), *([f"{name}_adapt"] if flat.states else [])]
    state = ["state"] if layout.states else []
    call = f"{name}({', '.join(['...vector[0]', *state])})"
    run = [f"const state = {name}_init();"] if layout.states else []
    run += ["for (const vector of vectors) {", *turn(call, bool(unit.refusals))]
    run += [f"{INDENT}{name}_adapt(state, ...vector[0], {STEP!r});"] if flat.states else []
    run += ["}"]
    allowed = [unit.tolerance(k) for k in range(len(flat.outputs))]
    return selftest_text(name, imported, bool(unit.refusals), vectors(unit), allowed, run)


def turn(call: str, refuses: bool) -> Iterator[str]:
    """Yield lines that evaluate a vector and compare.

    Args:
        call: What gives the outputs.
        refuses: Whether it may throw where no rule fires.
    """
    if not refuses:
        yield f'{INDENT}compare([{call}].flat(), "", vector);'
        return
    yield from (f"{INDENT}try {{", f'{INDENT * 2}compare([{call}].flat(), "", vector);', f"{INDENT}}} catch (error) {{")
    yield from (f"{INDENT * 2}if (!(error instanceof NoRuleFiresError)) {{", f"{INDENT * 3}throw error;")
    yield from (f"{INDENT * 2}}}", f"{INDENT * 2}compare(tolerance.map(() => NaN), error.output, vector);")
    yield f"{INDENT}}}"


def selftest_text(
    name: str,
    imported: Sequence[str],
    refuses: bool,
    expected: Sequence[Vector],
    tolerances: Sequence[float],
    run: Sequence[str],
) -> str:
    """Return the text of a self-test.

    Args:
        name: That of the module.
        imported: Functions that it calls.
        refuses: Whether it may throw where no rule fires.
        expected: The vectors.
        tolerances: Largest error of each output.
        run: Lines that evaluate and compare them.
    """
    about = [f"Self-test of {name}: run with node {name}.test.mjs; exits with 0 if every vector agrees."]
    about.append("A vector has the inputs, the outputs, and the output for which no rule fires.")
    names = ", ".join(["outputs", *imported, *(["NoRuleFiresError"] if refuses else [])])
    rows = [f"[{_numbers(v.inputs)}, {_numbers(v.outputs)}, {quoted(v.refused)}]" for v in expected]
    lines = [*comment(about), f'import {{ {names} }} from "./{name}.mjs";', ""]
    lines += [*list_lines("const vectors", rows), f"const tolerance = {_numbers(tolerances)};", _MAIN]
    return file_text([*lines, *run, _REPORT.replace("NAME", quoted(name))])


def _numbers(values: Sequence[float]) -> str:
    return f"[{', '.join(bare(literal(v)) for v in values)}]"
