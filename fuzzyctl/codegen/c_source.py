"""A unit as C99: header and source, without heap, and without <math.h> where nothing in it is needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_text import INDENT, CText, bare
from fuzzyctl.codegen.comments import argument_notes, result_notes, table_notes, value_notes
from fuzzyctl.codegen.unit import Unit, described, printable
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.kernels.program.program import Program, Refuse


def header(unit: Unit) -> str:
    """Return the text of NAME.h."""
    layout = CLayout(unit)
    about = [*described(unit), "", *_promises(unit)]
    return header_text(layout.name, about, [*_types(layout), *broken(_prototypes(layout), INDENT)])


def header_text(name: str, about: Sequence[str], declared: Sequence[str], included: Sequence[str] = ()) -> str:
    """Return the text of a header.

    Args:
        name: What its file is called.
        about: Its comment.
        declared: What it declares.
        included: Headers that this needs.
    """
    guard = f"{name.upper()}_H"
    lines = [*comment(about), f"#ifndef {guard}", f"#define {guard}", "", *(f"#include <{h}.h>" for h in included)]
    lines += [*([""] if included else []), "#ifdef __cplusplus", 'extern "C" {', "#endif", "", *declared]
    lines += ["#ifdef __cplusplus", "}", "#endif", "", f"#endif // {guard}"]
    return "\n".join(lines) + "\n"


def _promises(unit: Unit) -> list[str]:
    lines = ["An input that is NaN makes every output NaN; infinite inputs count as the ends of the range."]
    if unit.plan.held:
        lines.append("Where no rule fires a held output keeps its previous value, which stands in the state.")
    if unit.refusals:
        lines.append(f"Where no rule fires for {', '.join(unit.refusals)}, the status says so and every output is NaN.")
    if unit.precision == "float":
        lines.append("The bounds are proved for double; single precision keeps them to rounding.")
        lines.append("Activations below 1e-38 are 0 in single precision, as if no rule fired.")
    return lines


def as_comments(notes: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return notes by name as lines of comment."""
    return {name: comment(list(folded([printable(text) for text in own]))) for name, own in notes.items()}


def comment(lines: Sequence[str]) -> list[str]:
    """Return lines as comments, which text between `/*` could end."""
    return [f"// {line.replace('/*', '/ *')}".rstrip() for line in lines]


def _types(layout: CLayout) -> Iterator[str]:
    unit, name = layout.unit, layout.name
    if layout.many:
        yield "typedef struct {"
        for member, declared in zip(layout.outputs, unit.system.outputs, strict=True):
            note = f"  // {printable(declared.unit)}" if declared.unit else ""
            yield f"{INDENT}{layout.real} {member};{note}"
        yield from (f"}} {name}_outputs;", "")
    if layout.states:
        yield "typedef struct {"
        if unit.plan.states:
            yield f"{INDENT}{layout.real} consequent[{len(unit.plan.states)}]; // of adaptive outputs, rule by rule"
        for o in unit.plan.held:
            yield f"{INDENT}{layout.real} held_{layout.outputs[o]}; // kept where no rule fires"
        yield from (f"}} {name}_state;", "")
    if unit.refusals:
        yield from status_type(name, [layout.status(), *(layout.status(o) for o in dict.fromkeys(unit.refusals))])


def status_type(name: str, codes: Sequence[str]) -> Iterator[str]:
    """Yield the type of a status."""
    yield "typedef enum {"
    yield ",\n".join(f"{INDENT}{c} = {k}" for k, c in enumerate(codes))
    yield from (f"}} {name}_status;", "")


def _about(layout: CLayout) -> Iterator[str]:
    """Yield what stands at the prototype: what it computes, each parameter, and what it returns."""
    unit = layout.unit
    results = result_notes(unit)
    names = ", ".join(o.name for o in unit.plan.outputs)
    yield f"Evaluate {unit.system.name}: {names} of {', '.join(i.name for i in unit.plan.inputs)}."
    yield from (f"  {name}: {note}" for name, note in zip(layout.inputs, argument_notes(unit), strict=True))
    if layout.states:
        change = "what outputs hold is changed" if unit.plan.held else "is read only"
        yield f"  state: begun by {layout.name}_init; {change}"
    if layout.many:
        yield "  outputs: where the results go, NaN where an input is NaN or there is no value"
        yield from (f"    {name}: {note}" for name, note in zip(layout.outputs, results, strict=True))
    if unit.refusals:
        yield f"  status: {layout.status()}, or which output has no rule that fires"
    if not layout.many:
        yield f"Returns {names}: {results[0]}; NaN where an input is NaN or there is no value."


def _prototypes(layout: CLayout) -> Iterator[str]:
    yield from comment(list(folded([printable(line) for line in _about(layout)])))
    yield from (f"{layout.evaluation};", "")
    if layout.states:
        yield from ("// Begin with the values of the rule file.", f"{layout.init};", "")
    if layout.unit.plan.states:
        yield from ("// dC/dt of each adaptive consequent, 0 where it would leave the range of its output.",)
        yield from (f"{layout.rates};", "")
        yield from ("// One Euler step of dt seconds, held within the range; what has no rate stays.",)
        yield from (f"{layout.adapt};", "")


def source(unit: Unit) -> str:
    """Return the text of NAME.c."""
    layout = CLayout(unit)
    text = CText(unit.precision, layout.name, layout.arguments, layout.states)
    text.notes = as_comments(value_notes(unit))
    functions = list(_evaluation(layout, text))
    text.notes = {}  # rates have other values of these names
    if layout.states:
        functions += ["", *_init(layout, text)]
    if unit.rates is not None:
        functions += ["", *_rates(layout, text, unit.rates), "", *_adapt(layout, text)]
    return source_text(layout.name, text, functions)


def source_text(name: str, text: CText, functions: Sequence[str]) -> str:
    """Return the text of a source.

    Args:
        name: What its file is called.
        text: What wrote the functions.
        functions: Lines of the functions.
    """
    lines = [*comment([f"{name}.c: see {name}.h."]), f'#include "{name}.h"', ""]
    lines += [f"#include <{h}.h>" for h in ("float", *(["math"] if text.libm else []), "stdbool", "stddef", "stdint")]
    tests = any(f"{name}_is_nan(" in line for line in functions)
    lines += ["#include <string.h>", "", *nan_lines(text.precision, name, tests=tests), "", *text.helper_lines()]
    lines += functions
    return "\n".join(broken(lines, INDENT)) + "\n"


def nan_lines(precision: str, prefix: str, *, makes: bool = True, tests: bool = True) -> Iterator[str]:
    """Yield functions that recognise NaN by its bits, since compiler options may assume that there is none.

    Args:
        precision: Type of numbers.
        prefix: Begin of their names.
        makes: Whether NaN is made.
        tests: Whether there are tests for NaN.
    """
    digits = "FLT_MANT_DIG" if precision == "float" else "DBL_MANT_DIG"
    yield f"#if {digits} == 53"
    yield from _bits(prefix, 64, "7FFFFFFFFFFFFFFF", "7FF0000000000000", "7FF8000000000000")
    yield f"#elif {digits} == 24"
    yield from _bits(prefix, 32, "7FFFFFFF", "7F800000", "7FC00000")
    yield from ("#else", '#error "numbers must be those of IEEE 754"', "#endif", "")
    if tests:
        yield f"static bool {prefix}_is_nan({precision} x)\n{{"
        yield f"{INDENT}{prefix}_bits bits = 0U;"
        yield f"{INDENT}(void)memcpy(&bits, &x, sizeof bits);"
        yield f"{INDENT}return (bits & {prefix.upper()}_MAGNITUDE) > {prefix.upper()}_INFINITE;\n}}"
    if makes:
        yield f"{chr(10) if tests else ''}static {precision} {prefix}_no_number(void)\n{{"
        yield f"{INDENT}const {prefix}_bits bits = {prefix.upper()}_NAN;"
        yield f"{INDENT}{precision} x;"
        yield f"{INDENT}(void)memcpy(&x, &bits, sizeof x);"
        yield f"{INDENT}return x;\n}}"


def _bits(prefix: str, size: int, magnitude: str, infinite: str, nan: str) -> Iterator[str]:
    yield f"typedef uint{size}_t {prefix}_bits;"
    for what, bits in (("MAGNITUDE", magnitude), ("INFINITE", infinite), ("NAN", nan)):
        yield f"#define {prefix.upper()}_{what} UINT{size}_C(0x{bits})"


def _evaluation(layout: CLayout, text: CText) -> Iterator[str]:
    unit, pad = layout.unit, INDENT
    results = [f"outputs->{o}" for o in layout.outputs] if layout.many else ["result"]
    yield f"{layout.evaluation}\n{{"
    yield from text.tables(unit.evaluation, as_comments(table_notes(unit, unit.evaluation)))
    if unit.refusals:
        yield f"{pad}{layout.name}_status found = {layout.status()};"
    if not layout.many:
        yield f"{pad}{layout.real} result = {layout.name}_no_number();"
    else:
        yield from (f"{pad}{r} = {layout.name}_no_number();" for r in results)
    yield from ("", f"{pad}if ({_numbers(layout)}) {{")
    refusals = {o: f"found = (found == {layout.status()}) ? {layout.status(o)} : found;" for o in unit.refusals}
    yield from text.block(unit.evaluation.body, refusals, 2)
    yield from _stores(layout, text, results)
    yield f"{pad}}}"
    if unit.refusals:
        yield f"{pad}*status = found;"
    if not layout.many:
        yield f"{pad}return result;"
    yield "}"


def _stores(layout: CLayout, text: CText, results: Sequence[str]) -> Iterator[str]:
    """Yield lines that store the outputs, and what is held, unless the evaluation was refused."""
    pad = INDENT * 2
    if layout.unit.refusals:
        yield f"{pad}if (found == {layout.status()}) {{"
        pad += INDENT
    for result, value in zip(results, layout.unit.evaluation.results, strict=True):
        yield f"{pad}{result} = {bare(text.text(value))};"
    for o in layout.unit.plan.held:
        yield f"{pad}if (!{layout.name}_is_nan({results[o]})) {{"
        yield f"{pad}{INDENT}state->held_{layout.outputs[o]} = {results[o]};"
        yield f"{pad}}}"
    if layout.unit.refusals:
        yield f"{INDENT * 2}}}"


def _numbers(layout: CLayout) -> str:
    tests = [f"(!{layout.name}_is_nan({i}))" for i in layout.inputs]
    return bare(" && ".join(tests))


def _init(layout: CLayout, text: CText) -> Iterator[str]:
    yield f"{layout.init}\n{{"
    for entry, value in zip(layout.states, layout.unit.plan.initial_state, strict=True):
        yield f"{INDENT}{entry} = {bare(text.number(value))};"
    yield "}"


def _rates(layout: CLayout, text: CText, program: Program) -> Iterator[str]:
    """Yield the function that writes dC/dt; NaN where an input is NaN or nothing can be computed."""
    count, refusals = len(program.results), [s.output for s in program.body if isinstance(s, Refuse)]
    yield f"{layout.rates}\n{{"
    yield from text.tables(program, as_comments(table_notes(layout.unit, program)))
    for k in range(count):
        yield f"{INDENT}rate[{k}] = {layout.name}_no_number();"
    if refusals:
        yield f"{INDENT}bool refused = false;"
    if not any(layout.states[k] in text.text(r) for r in program.results for k in range(len(layout.states))):
        yield f"{INDENT}(void)state;"
    yield f"{INDENT}if ({_numbers(layout)}) {{"
    yield from text.block(program.body, dict.fromkeys(refusals, "refused = true;"), 2)
    pad = INDENT * 2
    if refusals:
        yield f"{pad}if (!refused) {{"
        pad += INDENT
    for k, value in enumerate(program.results):
        yield f"{pad}rate[{k}] = {bare(text.text(value))};"
    if refusals:
        yield f"{INDENT * 2}}}"
    yield from (f"{INDENT}}}", "}")


def _adapt(layout: CLayout, text: CText) -> Iterator[str]:
    unit, real = layout.unit, layout.real
    count = len(unit.plan.states)
    ends = [unit.plan.outputs[o] for o, _ in unit.plan.states]
    yield f"{layout.adapt}\n{{"
    for what, values in (("lower", [o.lower for o in ends]), ("upper", [o.upper for o in ends])):
        yield f"{INDENT}static const {real} {what}[{count}] = {{{', '.join(bare(text.number(v)) for v in values)}}};"
    yield f"{INDENT}{real} rate[{count}];"
    yield f"{INDENT}{layout.name}_rates({', '.join(layout.inputs)}, state, rate);"
    yield f"{INDENT}for (size_t k = 0U; k < {count}U; ++k) {{"
    yield f"{INDENT * 2}const {real} next = state->consequent[k] + (dt * rate[k]);"
    yield f"{INDENT * 2}if (!{layout.name}_is_nan(next)) {{"
    held = "(next < lower[k]) ? lower[k] : ((next > upper[k]) ? upper[k] : next)"
    yield f"{INDENT * 3}state->consequent[k] = {held};"
    yield from (f"{INDENT * 2}}}", f"{INDENT}}}", "}")
