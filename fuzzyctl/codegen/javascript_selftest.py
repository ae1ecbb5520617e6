"""Self-test in JavaScript: compares outputs with the test vectors and prints the largest error of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.codegen.c_text import bare
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.javascript_text import comment, file_text, list_lines, literal, quoted
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.vectors import STEP, Expected
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


def selftest(unit: Unit, expected: Expected) -> str:
    """Return the text of NAME.test.mjs, which makes steps twice: the second time shows that the state begins anew."""
    layout, name = JavaScriptLayout(unit), JavaScriptLayout(unit).name
    call = f"{layout.function}({layout.call('...vector[0]')})"
    begin = [f"const state = {name}_init();"] if layout.has_state else []
    adapt = [f"{INDENT}{name}_adapt(state, ...vector[0], {STEP!r});"] if unit.rates is not None else []
    run = [*begin, "for (const vector of vectors) {", *_turn(call, bool(unit.refusals)), *adapt, "}"]
    if unit.is_step:
        run = ["for (let round = 0; round < 2; ++round) {", *(INDENT + line for line in run), "}"]
    own = [f"{name}_init"] if layout.has_state else []
    imported = [*own, layout.function] if unit.is_step else [layout.function, *own]
    imported += [f"{name}_adapt"] if adapt else []
    about = [f"Self-test of {name}: run with node {name}.test.mjs; exits with 0 if every vector agrees."]
    about.append("A vector has the inputs, the outputs, and the output for which no rule fires.")
    names = ", ".join(["outputs", *imported, *(["NoRuleFiresError"] if unit.refusals else [])])
    rows = [f"[{_numbers(v.inputs)}, {_numbers(v.outputs)}, {quoted(v.refused)}]" for v in expected.vectors]
    tolerances = _numbers([expected.tolerance(k, unit.precision) for k in range(len(unit.outputs))])
    lines = [*comment(about), f'import {{ {names} }} from "./{name}.mjs";', ""]
    lines += [*list_lines("const vectors", rows), f"const tolerance = {tolerances};", _MAIN]
    return file_text([*lines, *run, _REPORT.replace("NAME", quoted(name))])


def _turn(call: str, refuses: bool) -> Iterator[str]:
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


def _numbers(values: Sequence[float]) -> str:
    return f"[{', '.join(bare(literal(v)) for v in values)}]"
