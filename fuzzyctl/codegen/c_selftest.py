"""A program in C that runs the vectors on the target and says how far it is off."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import comment, nan_lines
from fuzzyctl.codegen.c_text import INDENT, wrapped
from fuzzyctl.codegen.unit import Precision, Unit
from fuzzyctl.codegen.vectors import STEP, Vector


def selftest(unit: Unit, found: Sequence[Vector]) -> str:
    """Return the text of NAME_selftest.c."""
    layout = CLayout(unit)
    name = layout.name
    about = f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every vector agrees."
    lines = [*comment([about, "Prints the worst error of each output."]), f'#include "{name}.h"', ""]
    lines += [f"#include <{h}.h>" for h in ("float", "math", "stdbool", "stddef", "stdint", "stdio", "string")]
    lines += ["", f"#define VECTORS {len(found)}", ""]
    lines += [*nan_lines(unit.precision, f"{name}_selftest", makes=False), "", *_tables(layout, found)]
    lines += ["", *_main(layout)]
    return "\n".join(lines) + "\n"


def _tables(layout: CLayout, found: Sequence[Vector]) -> Iterator[str]:
    unit, real = layout.unit, layout.real
    for what, width, rows in (
        ("inputs", len(layout.inputs), [v.inputs for v in found]),
        ("expected", len(layout.outputs), [v.outputs for v in found]),
    ):
        yield f"static const {real} {what}[VECTORS][{width}] = {{"
        yield from wrapped([f"{{{', '.join(literal(x, unit.precision) for x in row)}}}" for row in rows], INDENT)
        yield "};"
    if unit.refusals:
        yield f"static const {layout.name}_status refused[VECTORS] = {{"
        yield from wrapped([layout.status(v.refused) for v in found], INDENT)
        yield "};"
    if unit.precision == "double":  # of 32 bits on small targets, such as an AVR
        yield "#if DBL_MANT_DIG < 53"
        yield _tolerances(layout, "float")
        yield "#else"
    yield _tolerances(layout, unit.precision)
    if unit.precision == "double":
        yield "#endif"


def _tolerances(layout: CLayout, precision: Precision) -> str:
    unit, count = layout.unit, len(layout.outputs)
    tolerances = ", ".join(literal(unit.tolerance(k, precision), unit.precision) for k in range(count))
    return f"static const {layout.real} tolerance[{count}] = {{{tolerances}}};"


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
    unit, name, real = layout.unit, layout.name, layout.real
    count = len(layout.outputs)
    yield f"int main(void)\n{{\n{INDENT}int failures = 0;"
    zeros = ", ".join([_zero(real)] * count)
    yield f"{INDENT}{real} worst[{count}] = {{{zeros}}};"
    if layout.states:
        yield from (f"{INDENT}{name}_state state;", f"{INDENT}{name}_init(&state);")
    yield f"{INDENT}for (size_t v = 0U; v < (size_t)VECTORS; ++v) {{"
    yield from (f"{INDENT * 2}{line}" for line in _call(layout))
    yield f"{INDENT * 2}for (size_t k = 0U; k < {count}U; ++k) {{"
    yield f"{INDENT * 3}const {real} wanted = expected[v][k];"
    yield f"{INDENT * 3}const bool none = {name}_selftest_is_nan(wanted);"
    yield f"{INDENT * 3}const {real} off = (found[k] > wanted) ? (found[k] - wanted) : (wanted - found[k]);"
    yield f"{INDENT * 3}if (none || {name}_selftest_is_nan(found[k])) {{"
    yield f"{INDENT * 4}failures += (none && {name}_selftest_is_nan(found[k])) ? 0 : 1;"
    yield f"{INDENT * 3}}} else {{"
    yield f"{INDENT * 4}worst[k] = (off > worst[k]) ? off : worst[k];"
    yield f"{INDENT * 4}failures += (off <= tolerance[k]) ? 0 : 1;"
    yield from (f"{INDENT * 3}}}", f"{INDENT * 2}}}")
    if unit.refusals:
        yield f"{INDENT * 2}failures += (status == refused[v]) ? 0 : 1;"
    yield f"{INDENT}}}"
    for k, o in enumerate(layout.outputs):
        numbers = f"(double)worst[{k}], (double)tolerance[{k}]"
        yield f'{INDENT}(void)printf("{name}: {o}: worst error %g, allowed %g\\n", {numbers});'
    yield f'{INDENT}(void)printf("{name}: %d vectors, %d failures\\n", VECTORS, failures);'
    yield from (f"{INDENT}return (failures == 0) ? 0 : 1;", "}")


def _zero(real: str) -> str:
    return "0.0F" if real == "float" else "0.0"


def _call(layout: CLayout) -> Iterator[str]:
    """Yield lines that evaluate vector `v` into `found`."""
    name, many = layout.name, layout.many
    inputs = [f"inputs[v][{k}]" for k in range(len(layout.inputs))]
    arguments = [*inputs, *(["&state"] if layout.states else [])]
    if many:
        yield f"{name}_outputs outputs;"
        arguments.append("&outputs")
    if layout.unit.refusals:
        yield f"{name}_status status;"
        arguments.append("&status")
    if many:
        yield f"{name}({', '.join(arguments)});"
        values = ", ".join(f"outputs.{o}" for o in layout.outputs)
    else:
        values = f"{name}({', '.join(arguments)})"
    yield f"const {layout.real} found[{len(layout.outputs)}] = {{{values}}};"
    if layout.unit.plan.states:
        yield f"{name}_adapt(&state, {', '.join(inputs)}, {'(float)' if layout.real == 'float' else ''}{STEP!r});"
