"""Self-tests in C and JavaScript: run the test vectors on the target and print the largest error of each output."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import comment, nan_lines
from fuzzyctl.codegen.c_text import INDENT, bare, wrapped
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.javascript_text import comment as javascript_comment
from fuzzyctl.codegen.javascript_text import file_text, list_lines, quoted
from fuzzyctl.codegen.javascript_text import literal as javascript_literal
from fuzzyctl.codegen.unit import Precision, Unit
from fuzzyctl.codegen.vectors import STEP, Expected, Vector

#: Where `double` has 64 bits; on small targets, such as an AVR, it may have 32.
_WIDE: Final = "#if DBL_MANT_DIG >= 53"


#: The text that compares and reports, after the function `evaluate` that makes one turn.
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


def c_selftest(unit: Unit, expected: Expected) -> str:
    """Return the text of NAME_selftest.c, which makes steps twice: the second time shows that the state begins anew."""
    layout = CLayout(unit)
    name, one = layout.name, "step" if unit.is_step else "vector"
    about = f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every {one} agrees."
    lines = [*comment([about, "Prints the worst error of each output."]), f'#include "{name}.h"', ""]
    lines += [f"#include <{h}.h>" for h in ("float", "math", "stdbool", "stddef", "stdint", "stdio", "string")]
    lines += ["", *_count(unit, len(expected.anywhere), len(expected.here)), ""]
    lines += [*nan_lines(unit.precision, f"{name}_selftest", makes=False), "", *_tables(layout, expected), ""]
    return "\n".join([*lines, *_main(layout)]) + "\n"


def _count(unit: Unit, anywhere: int, here: int) -> Iterator[str]:
    if unit.is_step and unit.precision == "double":
        message = '#error "double must have 64 bits; generate single precision"'
        yield from ("#if DBL_MANT_DIG < 53", message, "#endif", "", f"#define VECTORS {anywhere}")
    elif not here:
        yield f"#define VECTORS {anywhere}"
    else:
        yield from (_WIDE, f"#define VECTORS {anywhere + here}", "#else")
        if anywhere:
            yield f"#define VECTORS {anywhere}"
        else:
            yield '#error "double must have 64 bits for the numbers of this system"'
        yield "#endif"


def _tables(layout: CLayout, expected: Expected) -> Iterator[str]:
    unit, real, anywhere, here = layout.unit, layout.real, expected.anywhere, expected.here

    def row(numbers: Sequence[float]) -> str:
        return f"{{{', '.join(literal(x, unit.precision) for x in numbers)}}}"

    def table(declaration: str, text: Callable[[Vector], str]) -> Iterator[str]:
        yield f"static const {declaration} = {{"
        yield from wrapped([text(v) + "," for v in anywhere], INDENT, between="")
        if here:
            yield from (_WIDE, *wrapped([text(v) + "," for v in here], INDENT, between=""), "#endif")
        yield "};"

    def tolerances(precision: Precision) -> str:
        allowed = [expected.tolerance(k, precision) for k in range(len(layout.outputs))]
        return f"static const {real} tolerance[{len(allowed)}] = {row(allowed)};"

    if layout.arguments:
        yield from table(f"{real} inputs[VECTORS][{len(layout.arguments)}]", lambda v: row(v.inputs))
    yield from table(f"{real} expected[VECTORS][{len(layout.outputs)}]", lambda v: row(v.outputs))
    if unit.refusals:
        yield from table(f"{layout.name}_status refused[VECTORS]", lambda v: layout.status(v.refused))
    if unit.precision == "double" and not unit.is_step:
        yield from (_WIDE, tolerances("double"), "#else", tolerances("float"), "#endif")
    else:
        yield tolerances(unit.precision)


def literal(value: float, precision: str) -> str:
    """Return a number for a static table, where NaN and infinity must be constants."""
    cast = "(float)" if precision == "float" else "(double)"
    if math.isnan(value):
        return f"{cast}NAN"
    if math.isinf(value):
        return f"{cast}INFINITY" if value > 0 else f"-{cast}INFINITY"
    # Expected values are rounded by the compiler: those below the smallest number of single precision to zero.
    return f"(float){value!r}" if precision == "float" else repr(value)


def _main(layout: CLayout) -> Iterator[str]:
    name, depth = layout.name, 2 if layout.unit.is_step else 1
    yield f"int main(void)\n{{\n{INDENT}int failures = 0;"
    zeros = ", ".join(["0.0F" if layout.real == "float" else "0.0"] * len(layout.outputs))
    yield f"{INDENT}{layout.real} worst[{len(layout.outputs)}] = {{{zeros}}};"
    if layout.unit.is_step:
        yield f"{INDENT}for (size_t turn = 0U; turn < 2U; ++turn) {{"
    begin = [f"{name}_state state;", f"{name}_init(&state);"] if layout.unit.has_state else []
    begin += [f"{name}_params params;", f"{name}_params_init(&params);"] if layout.numbers else []
    yield from (INDENT * depth + line for line in (*begin, *_comparison(layout)))
    if layout.unit.is_step:
        yield f"{INDENT}}}"
    for k, o in enumerate(layout.outputs):
        numbers = f"(double)worst[{k}], (double)tolerance[{k}]"
        yield f'{INDENT}(void)printf("{name}: {o}: worst error %g, allowed %g\\n", {numbers});'
    yield f'{INDENT}(void)printf("{name}: %d vectors, %d failures\\n", VECTORS, failures);'
    yield from (f"{INDENT}return (failures == 0) ? 0 : 1;", "}")


def _comparison(layout: CLayout) -> Iterator[str]:
    """Yield the loop that evaluates each vector and compares the results with the expected ones."""
    name, real = layout.name, layout.real
    yield "for (size_t v = 0U; v < (size_t)VECTORS; ++v) {"
    yield from (INDENT + line for line in _call(layout))
    yield f"{INDENT}for (size_t k = 0U; k < {len(layout.outputs)}U; ++k) {{"
    yield f"{INDENT * 2}const {real} wanted = expected[v][k];"
    yield f"{INDENT * 2}const bool none = {name}_selftest_is_nan(wanted);"
    yield f"{INDENT * 2}const {real} off = (found[k] > wanted) ? (found[k] - wanted) : (wanted - found[k]);"
    yield f"{INDENT * 2}if (none || {name}_selftest_is_nan(found[k])) {{"
    yield f"{INDENT * 3}failures += (none && {name}_selftest_is_nan(found[k])) ? 0 : 1;"
    yield f"{INDENT * 2}}} else {{"
    yield f"{INDENT * 3}worst[k] = (off > worst[k]) ? off : worst[k];"
    yield f"{INDENT * 3}failures += (off <= tolerance[k]) ? 0 : 1;"
    yield from (f"{INDENT * 2}}}", f"{INDENT}}}")
    if layout.unit.refusals:
        yield f"{INDENT}failures += (status == refused[v]) ? 0 : 1;"
    yield "}"


def _call(layout: CLayout) -> Iterator[str]:
    """Yield lines that evaluate vector `v` into `found`."""
    name, inputs = layout.name, [f"inputs[v][{k}]" for k in range(len(layout.arguments))]
    yield from call_lines(layout, layout.call("&state", "&params", inputs))
    if layout.unit.rates is not None:
        cast = "(float)" if layout.real == "float" else ""
        yield f"{name}_adapt(&state, {', '.join(inputs)}, {cast}{STEP!r});"


def call_lines(layout: CLayout, arguments: Sequence[str]) -> Iterator[str]:
    """Yield lines that evaluate a unit into `found`, and `status` where it may refuse."""
    name, texts = layout.name, [*arguments]
    if layout.many:
        yield f"{name}_outputs outputs;"
        texts.append("&outputs")
    if layout.unit.refusals:
        yield f"{name}_status status;"
        texts.append("&status")
    call = f"{layout.function}({', '.join(texts)})"
    if layout.many:
        yield f"{call};"
        call = ", ".join(f"outputs.{o}" for o in layout.outputs)
    yield f"const {layout.real} found[{len(layout.outputs)}] = {{{call}}};"


def javascript_selftest(unit: Unit, expected: Expected) -> str:
    """Return the text of NAME.test.mjs, which makes steps twice: the second time shows that the state begins anew."""
    layout, name = JavaScriptLayout(unit), JavaScriptLayout(unit).name
    call = f"{layout.function}({layout.call('...vector[0]')})"
    begin = [f"const state = {name}_init();"] if layout.has_state else []
    adapt = [f"{INDENT}{name}_adapt(state, ...vector[0], {STEP!r});"] if unit.rates is not None else []
    run = [*begin, "for (const vector of vectors) {", *_turn(call, bool(unit.refusals)), *adapt, "}"]
    if unit.is_step:
        run = ["for (let round = 0; round < 2; ++round) {", *(INDENT + line for line in run), "}"]
    init = [f"{name}_init"] if layout.has_state else []
    imported = [*init, layout.function] if unit.is_step else [layout.function, *init]
    imported += [f"{name}_adapt"] if adapt else []
    about = [f"Self-test of {name}: run with node {name}.test.mjs; exits with 0 if every vector agrees."]
    about.append("A vector has the inputs, the outputs, and the output for which no rule fires.")
    names = ", ".join(["outputs", *imported, *(["NoRuleFiresError"] if unit.refusals else [])])
    rows = [f"[{_row_text(v.inputs)}, {_row_text(v.outputs)}, {quoted(v.refused)}]" for v in expected.vectors]
    tolerances = _row_text([expected.tolerance(k, unit.precision) for k in range(len(unit.outputs))])
    lines = [*javascript_comment(about), f'import {{ {names} }} from "./{name}.mjs";', ""]
    lines += [*list_lines("const vectors", rows), f"const tolerance = {tolerances};", _MAIN]
    return file_text([*lines, *run, _REPORT.replace("NAME", quoted(name))])


def _turn(call: str, refuses: bool) -> Iterator[str]:
    """Yield lines that evaluate a vector and compare.

    Args:
        call: The call that gives the outputs.
        refuses: Whether it may throw where no rule fires.
    """
    if not refuses:
        yield f'{INDENT}compare([{call}].flat(), "", vector);'
        return
    yield from (f"{INDENT}try {{", f'{INDENT * 2}compare([{call}].flat(), "", vector);', f"{INDENT}}} catch (error) {{")
    yield from (f"{INDENT * 2}if (!(error instanceof NoRuleFiresError)) {{", f"{INDENT * 3}throw error;")
    yield from (f"{INDENT * 2}}}", f"{INDENT * 2}compare(tolerance.map(() => NaN), error.output, vector);")
    yield f"{INDENT}}}"


def _row_text(values: Sequence[float]) -> str:
    return f"[{', '.join(bare(javascript_literal(v)) for v in values)}]"
