"""Self-test of a step in C: makes the steps of the test sequence, twice, and prints the largest error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from fuzzyctl.codegen.c_selftest import comparison, head, literal, report, worst
from fuzzyctl.codegen.c_source import nan_lines
from fuzzyctl.codegen.c_text import INDENT, wrapped
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.sequence import Steps
from fuzzyctl.codegen.steps.unit import StepUnit
from fuzzyctl.codegen.vectors import Vector


def selftest(unit: StepUnit, steps: Steps) -> str:
    """Return the text of NAME_selftest.c."""
    layout = StepLayout(unit)
    name = layout.name
    about = f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every step agrees."
    lines = [*head(name, about), ""]
    if unit.precision == "double":
        lines += ["#if DBL_MANT_DIG < 53", '#error "double must have 64 bits; generate single precision"', "#endif", ""]
    lines += [f"#define VECTORS {len(steps.vectors)}", ""]
    lines += [*nan_lines(unit.precision, f"{name}_selftest", makes=False), "", *_tables(layout, steps), ""]
    return "\n".join([*lines, *_main(layout)]) + "\n"


def _tables(layout: StepLayout, steps: Steps) -> Iterator[str]:
    real, precision = layout.real, layout.unit.precision

    def row(numbers: Sequence[float]) -> str:
        return f"{{{', '.join(literal(x, precision) for x in numbers)}}}"

    def table(declaration: str, text: Callable[[Vector], str]) -> Iterator[str]:
        yield f"static const {declaration} = {{"
        yield from wrapped([text(v) + "," for v in steps.vectors], INDENT, between="")
        yield "};"

    if layout.arguments:
        yield from table(f"{real} inputs[VECTORS][{len(layout.arguments)}]", lambda v: row(v.inputs))
    yield from table(f"{real} expected[VECTORS][{len(layout.outputs)}]", lambda v: row(v.outputs))
    if layout.unit.refusals:
        yield from table(f"{layout.name}_status refused[VECTORS]", lambda v: layout.status(v.refused))
    allowed = [steps.tolerance(k, precision) for k in range(len(layout.outputs))]
    yield f"static const {real} tolerance[{len(allowed)}] = {row(allowed)};"


def _main(layout: StepLayout) -> Iterator[str]:
    name = layout.name
    yield f"int main(void)\n{{\n{INDENT}int failures = 0;"
    yield worst(layout.outputs, layout.real)
    # The second time shows that the state begins anew.
    yield f"{INDENT}for (size_t turn = 0U; turn < 2U; ++turn) {{"
    if layout.members:
        yield from (f"{INDENT * 2}{name}_state state;", f"{INDENT * 2}{name}_init(&state);")
    if layout.numbers:
        yield from (f"{INDENT * 2}{name}_params params;", f"{INDENT * 2}{name}_params_init(&params);")
    yield from (INDENT * 2 + line for line in comparison(layout, _call(layout)))
    yield f"{INDENT}}}"
    yield from report(layout)


def _call(layout: StepLayout) -> Iterator[str]:
    """Yield lines that make step `v` and put its results into `found`."""
    name = layout.name
    arguments = [*(["&state"] if layout.members else []), *(["&params"] if layout.numbers else [])]
    arguments += [f"inputs[v][{k}]" for k in range(len(layout.arguments))]
    if layout.many:
        yield f"{name}_outputs outputs;"
        arguments.append("&outputs")
    if layout.unit.refusals:
        yield f"{name}_status status;"
        arguments.append("&status")
    call = f"{name}_step({', '.join(arguments)})"
    if layout.many:
        yield f"{call};"
        call = ", ".join(f"outputs.{o}" for o in layout.outputs)
    yield f"const {layout.real} found[{len(layout.outputs)}] = {{{call}}};"
