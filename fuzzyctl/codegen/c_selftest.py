"""Self-test in C: runs the test vectors on the target and prints the largest error."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import comment, nan_lines
from fuzzyctl.codegen.c_text import INDENT, wrapped
from fuzzyctl.codegen.unit import Precision, Unit
from fuzzyctl.codegen.vectors import STEP, Vector

if TYPE_CHECKING:
    from fuzzyctl.codegen.steps.c_layout import StepLayout

#: Where `double` has 64 bits; on small targets, such as an AVR, it may have 32.
_WIDE: Final = "#if DBL_MANT_DIG >= 53"


def selftest(unit: Unit, anywhere: Sequence[Vector], here: Sequence[Vector]) -> str:
    """Return the text of NAME_selftest.c.

    Args:
        unit: What is tested.
        anywhere: Vectors that hold wherever `double` has 32 bits only, too.
        here: Further ones.
    """
    layout = CLayout(unit)
    name = layout.name
    about = f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every vector agrees."
    lines = [*head(name, about), "", *_count(unit, len(anywhere), len(here)), ""]
    lines += [*nan_lines(unit.precision, f"{name}_selftest", makes=False), "", *_tables(layout, anywhere, here)]
    lines += ["", *_main(layout)]
    return "\n".join(lines) + "\n"


def head(name: str, about: str) -> list[str]:
    """Return the comment and the headers of a self-test."""
    lines = [*comment([about, "Prints the worst error of each output."]), f'#include "{name}.h"', ""]
    return lines + [f"#include <{h}.h>" for h in ("float", "math", "stdbool", "stddef", "stdint", "stdio", "string")]


def _count(unit: Unit, anywhere: int, here: int) -> Iterator[str]:
    if not here:
        yield f"#define VECTORS {anywhere}"
        return
    yield from (_WIDE, f"#define VECTORS {anywhere + here}", "#else")
    if anywhere:
        yield f"#define VECTORS {anywhere}"
    else:
        yield '#error "double must have 64 bits for the numbers of this system"'
    yield "#endif"


def _tables(layout: CLayout, anywhere: Sequence[Vector], here: Sequence[Vector]) -> Iterator[str]:
    unit, real = layout.unit, layout.real

    def row(numbers: Sequence[float]) -> str:
        return f"{{{', '.join(literal(x, unit.precision) for x in numbers)}}}"

    def table(declaration: str, text: Callable[[Vector], str]) -> Iterator[str]:
        yield f"static const {declaration} = {{"
        yield from wrapped([text(v) + "," for v in anywhere], INDENT, between="")
        if here:
            yield from (_WIDE, *wrapped([text(v) + "," for v in here], INDENT, between=""), "#endif")
        yield "};"

    yield from table(f"{real} inputs[VECTORS][{len(layout.inputs)}]", lambda v: row(v.inputs))
    yield from table(f"{real} expected[VECTORS][{len(layout.outputs)}]", lambda v: row(v.outputs))
    if unit.refusals:
        yield from table(f"{layout.name}_status refused[VECTORS]", lambda v: layout.status(v.refused))
    if unit.precision == "double":
        yield from (_WIDE, _tolerances(layout, "double"), "#else", _tolerances(layout, "float"), "#endif")
    else:
        yield _tolerances(layout, "float")


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
    name = layout.name
    begin = [f"{name}_state state;", f"{name}_init(&state);"] if layout.states else []
    yield f"int main(void)\n{{\n{INDENT}int failures = 0;"
    yield worst(layout.outputs, layout.real)
    yield from (INDENT + line for line in begin)
    yield from (INDENT + line for line in comparison(layout, _call(layout)))
    yield from report(layout)


def worst(outputs: Sequence[str], real: str) -> str:
    """Return the line that declares the largest error of each output."""
    return f"{INDENT}{real} worst[{len(outputs)}] = {{{', '.join([_zero(real)] * len(outputs))}}};"


def comparison(layout: CLayout | StepLayout, call: Iterable[str]) -> Iterator[str]:
    """Yield the loop that evaluates each vector and compares what is found with what is expected.

    Args:
        layout: What C calls things.
        call: Lines that evaluate vector `v` into `found`, and `status` where it may refuse.
    """
    name, real = layout.name, layout.real
    yield "for (size_t v = 0U; v < (size_t)VECTORS; ++v) {"
    yield from (INDENT + line for line in call)
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


def report(layout: CLayout | StepLayout) -> Iterator[str]:
    """Yield lines that print the errors and end the program."""
    name = layout.name
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
