"""A unit as C99: header and source, without heap and globals, with <math.h> only if it is needed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_text import INDENT, CText, bare
from fuzzyctl.codegen.comments import (
    argument_notes,
    described,
    number_notes,
    printable,
    result_notes,
    slot_notes,
    table_notes,
    value_notes,
)
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.expr import Name, Number
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.program.traversal import read


def header(unit: Unit) -> str:
    """Return the text of NAME.h."""
    layout = CLayout(unit)
    about = [*described(unit), "", *folded(list(_promises(unit)))]
    declared = [*period(layout), *_types(layout), *broken(prototypes(layout), INDENT)]
    return header_text(layout.name, about, declared, ["stddef"] if any(k for _, k in layout.members) else [])


def header_text(name: str, about: Sequence[str], declared: Sequence[str], included: Sequence[str] = ()) -> str:
    """Return the text of a header.

    Args:
        name: The name of its file.
        about: Its comment.
        declared: Its declarations.
        included: Headers that this needs.
    """
    guard = f"{name.upper()}_H"
    lines = [*comment(about), f"#ifndef {guard}", f"#define {guard}", "", *(f"#include <{h}.h>" for h in included)]
    lines += [*([""] if included else []), "#ifdef __cplusplus", 'extern "C" {', "#endif", "", *declared]
    lines += ["#ifdef __cplusplus", "}", "#endif", "", f"#endif // {guard}"]
    return "\n".join(lines) + "\n"


def _promises(unit: Unit) -> Iterator[str]:
    if unit.is_step:
        positive = ", or a dt that is not positive," if unit.takes_time else ""
        state = ", and the state stays as it is" if unit.slots else ""
        yield f"An input that is NaN{positive} makes every output NaN{state}."
        if unit.refusals:
            yield f"So it is where no rule fires for {', '.join(unit.refusals)}; the status says which."
        return
    yield "An input that is NaN makes every output NaN; infinite inputs count as the ends of the range."
    if unit.slots:
        yield "Where no rule fires a held output keeps its previous value, which stands in the state."
    if unit.refusals:
        yield f"Where no rule fires for {', '.join(unit.refusals)}, the status says so and every output is NaN."
    if unit.precision == "float":
        yield "The bounds are proved for double; single precision keeps them to rounding."
        yield "Activations below 1e-38 are 0 in single precision, as if no rule fired."


def as_comments(notes: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return notes by name as lines of comment."""
    return {name: comment(list(folded([printable(text) for text in texts]))) for name, texts in notes.items()}


def comment(lines: Sequence[str]) -> list[str]:
    """Return lines as comments, which text between `/*` could end."""
    return [f"// {line.replace('/*', '/ *')}".rstrip() for line in lines]


def period(layout: CLayout) -> Iterator[str]:
    """Yield the macro of the sample time, where there is one."""
    if layout.unit.period is not None:
        number = CText(layout.unit.precision, layout.name, {}).number(layout.unit.period)
        yield from (f"#define {layout.name.upper()}_PERIOD {number} // [s]", "")


def _types(layout: CLayout) -> Iterator[str]:
    unit, name, real = layout.unit, layout.name, layout.real
    if layout.many:
        notes = result_notes(unit) if unit.is_step else [v.unit for v in unit.system.outputs]
        yield from struct(f"{name}_outputs", [(f"{real} {o};", n) for o, n in zip(layout.outputs, notes, strict=True)])
    if layout.numbers:
        numbers = zip(layout.numbers, number_notes(unit), strict=True)
        yield from struct(f"{name}_params", [(f"{real} {member};", note) for member, note in numbers])
    if unit.has_state:
        count = len(unit.consequents)
        consequents = [(f"{real} consequent[{count}];", "of adaptive outputs, rule by rule")] if count else []
        yield from struct(f"{name}_state", [*consequents, *state_members(layout, real, slot_notes(unit))])
    if unit.refusals:
        codes = [layout.status(), *map(layout.status, unit.refusals)]
        yield "typedef enum {"
        yield ",\n".join(f"{INDENT}{c} = {k}" for k, c in enumerate(codes))
        yield from (f"}} {name}_status;", "")


def state_members(layout: CLayout, real: str, notes: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the members of the state, numbers of type `real`, with the note of each slot."""
    for (member, oldest), slot, note in zip(layout.members, layout.unit.slots, notes, strict=True):
        yield f"{real} {member}{f'[{slot.length}]' if oldest else ''};", note
        if oldest:
            yield f"size_t {oldest};", "position of its oldest number"


def struct(name: str, members: Iterable[tuple[str, str]]) -> Iterator[str]:
    """Yield a type with its members, each with a note."""
    yield "typedef struct {"
    for text, note in members:
        yield f"{INDENT}{text}{f' {comment([printable(note)])[0]}' if note else ''}"
    yield from (f"}} {name};", "")


def prototypes(layout: CLayout) -> Iterator[str]:
    """Yield the declared functions, each with its parameters and its result."""
    unit, begins = layout.unit, list[str]()
    if unit.has_state:
        state = "state before the first step" if unit.is_step else "values of the rule file"
        begins += [f"// Begin with the {state}.", f"{layout.init};", ""]
    if layout.numbers:
        begins += ["// Begin with the numbers of the rule file.", f"{layout.params_init};", ""]
    evaluation = comment(list(folded([printable(line) for line in _about(layout)])))
    evaluation += [f"{layout.evaluation};", ""]
    yield from (*begins, *evaluation) if unit.is_step else (*evaluation, *begins)
    if unit.rates is not None:
        yield "// dC/dt of each adaptive consequent, 0 where it would leave the range of its output."
        yield from (f"{layout.rates};", "")
        yield "// One Euler step of dt seconds, held within the range; what has no rate stays."
        yield from (f"{layout.adapt};", "")


def _about(layout: CLayout) -> Iterator[str]:
    """Yield the lines above the prototype: the computation, each parameter, and the result."""
    unit, results, names = layout.unit, result_notes(layout.unit), ", ".join(layout.unit.outputs)
    change = "what outputs hold is changed" if unit.slots else "is read only"
    change = "becomes that after the step" if unit.is_step else change
    state = f"  state: begun by {layout.name}_init; {change}"
    notes = zip(layout.arguments, argument_notes(unit), strict=True)
    lines = [f"  {name}: {note}" if note else f"  {name}" for name, note in notes]
    none = "" if unit.is_step else "NaN where an input is NaN or there is no value"
    computed = f"Make a step of {unit.block.name}: {names}"
    yield f"{computed}." if unit.is_step else f"Evaluate {unit.block.name}: {names} of {', '.join(unit.inputs)}."
    yield from layout.call(state, "  params: finite numbers, see their ranges", lines)
    if layout.many:
        yield f"  outputs: where the results go{f', {none}' if none else ''}"
        if not unit.is_step:
            yield from (f"    {name}: {note}" for name, note in zip(layout.outputs, results, strict=True))
    if unit.refusals:
        yield f"  status: {layout.status()}, or which output has no rule that fires"
    if not layout.many:
        yield f"Returns {names}{f': {results[0]}' if results[0] else ''}{f'; {none}' if none else ''}."


def source(unit: Unit) -> str:
    """Return the text of NAME.c."""
    layout = CLayout(unit)
    text = CText(unit.precision, layout.name, layout.names, as_comments(value_notes(unit)))
    functions = [[*_evaluation(layout, text)]]
    text.notes = {}  # rates have other values of these names
    begins = [[*init(layout, [bare(text.number(s.start)) for s in unit.slots], text)]] if unit.has_state else []
    begins += [[*_params_init(layout, text)]] if layout.numbers else []
    functions = [*begins, *functions] if unit.is_step else [*functions, *begins]
    if unit.rates is not None:
        functions += [[*_rates(layout, text, unit.rates)], [*_adapt(layout, text)]]
    return source_text(layout.name, text, [line for function in functions for line in (*function, "")][:-1])


def source_text(name: str, text: CText, functions: Sequence[str]) -> str:
    """Return the text of a source.

    Args:
        name: The name of its file.
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
    """Yield functions that recognise NaN by its bits, since compiler options may assume that NaN does not occur.

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


def _params_init(layout: CLayout, text: CText) -> Iterator[str]:
    yield f"{layout.params_init}\n{{"
    for member, number in zip(layout.numbers, layout.unit.numbers, strict=True):
        yield f"{INDENT}params->{member} = {bare(text.number(number.start))};"
    yield "}"


def init(layout: CLayout, starts: Sequence[str], text: CText | None = None) -> Iterator[str]:
    """Yield the function that begins a state.

    Args:
        layout: What C calls things.
        starts: The start of each slot.
        text: Writes the consequents of a system.
    """
    yield f"{layout.init}\n{{"
    if text is not None:
        consequents = zip(layout.consequents, layout.unit.consequents, strict=True)
        yield from (f"{INDENT}{entry} = {bare(text.number(value))};" for entry, value in consequents)
    for (member, oldest), slot, start in zip(layout.members, layout.unit.slots, starts, strict=True):
        if oldest:
            yield f"{INDENT}for (size_t k = 0U; k < {slot.length}U; ++k) {{"
            yield from (f"{INDENT * 2}state->{member}[k] = {start};", f"{INDENT}}}")
            yield f"{INDENT}state->{oldest} = 0U;"
        else:
            yield f"{INDENT}state->{member} = {start};"
    yield "}"


def _evaluation(layout: CLayout, text: CText) -> Iterator[str]:
    unit, pad = layout.unit, INDENT
    results = [f"outputs->{o}" for o in layout.outputs] if layout.many else ["result"]
    yield f"{layout.evaluation}\n{{"
    yield from text.tables(unit.program, as_comments(table_notes(unit, unit.program)))
    if unit.refusals:
        yield f"{pad}{layout.name}_status found = {layout.status()};"
    declared = "" if layout.many else f"{layout.real} "
    yield from (f"{pad}{declared}{r} = {layout.name}_no_number();" for r in results)
    guard = _guard(layout, text)
    yield from ("", f"{pad}if ({guard}) {{" if guard else f"{pad}{{")
    refusals = {o: f"found = (found == {layout.status()}) ? {layout.status(o)} : found;" for o in unit.refusals}
    yield from text.block(unit.program.body, refusals, 2)
    depth = 2
    if unit.refusals:
        yield f"{pad * 2}if (found == {layout.status()}) {{"
        depth = 3
    yield from (pad * depth + line for line in _stores(layout, text, results))
    yield from (f"{pad * k}}}" for k in range(depth - 1, 0, -1))
    if unit.refusals:
        yield f"{pad}*status = found;"
    if not layout.many:
        yield f"{pad}return result;"
    yield "}"


def _guard(layout: CLayout, text: CText) -> str:
    """Return the condition under which a step is made."""
    tests = [f"(!{layout.name}_is_nan({a}))" for a in layout.arguments]
    tests += [f"({DT} > {text.number(0.0)})"] if layout.unit.takes_time else []
    return bare(" && ".join(tests))


def _stores(layout: CLayout, text: CText, results: Sequence[str]) -> Iterator[str]:
    """Yield lines that store the outputs, then the state; earlier lines have read it."""
    unit = layout.unit
    yield from (f"{r} = {bare(text.text(v))};" for r, v in zip(results, unit.results, strict=True))
    if not unit.is_step:
        for place, o in zip(layout.slots, unit.plan.held, strict=True):
            yield f"if (!{layout.name}_is_nan({results[o]})) {{"
            yield from (f"{INDENT}{place} = {results[o]};", "}")
        return
    slots = set(unit.program.arguments[len(layout.arguments) :])
    stores: list[str] = []
    for k, (value, place) in enumerate(zip(unit.taken, layout.slots, strict=True)):
        expression = bare(text.text(value))
        if read(value) & slots or not isinstance(value, Name | Number):
            yield f"const {layout.real} u{k} = {expression};"
            expression = f"u{k}"
        stores.append(f"{place} = {expression};")
    for (_, oldest), slot, store in zip(layout.members, unit.slots, stores, strict=True):
        yield store
        yield from next_oldest(oldest, slot.length)


def next_oldest(oldest: str, length: int) -> Iterator[str]:
    """Yield the line that moves the position of the oldest number of a delay; none for other slots."""
    if oldest:
        yield f"state->{oldest} = (state->{oldest} < {length - 1}U) ? (state->{oldest} + 1U) : 0U;"


def _rates(layout: CLayout, text: CText, program: Program) -> Iterator[str]:
    """Yield the function that writes dC/dt; NaN if an input is NaN or the rates have no value."""
    count, refusals = len(program.results), [s.output for s in program.body if isinstance(s, Refuse)]
    yield f"{layout.rates}\n{{"
    yield from text.tables(program, as_comments(table_notes(layout.unit, program)))
    for k in range(count):
        yield f"{INDENT}rate[{k}] = {layout.name}_no_number();"
    if refusals:
        yield f"{INDENT}bool refused = false;"
    if not any(entry in text.text(r) for r in program.results for entry in (*layout.consequents, *layout.slots)):
        yield f"{INDENT}(void)state;"
    yield f"{INDENT}if ({_guard(layout, text)}) {{"
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
    unit, real, count = layout.unit, layout.real, len(layout.consequents)
    ends = [unit.plan.outputs[o] for o, _ in unit.plan.states]
    yield f"{layout.adapt}\n{{"
    for what, values in (("lower", [o.lower for o in ends]), ("upper", [o.upper for o in ends])):
        yield f"{INDENT}static const {real} {what}[{count}] = {{{', '.join(bare(text.number(v)) for v in values)}}};"
    yield f"{INDENT}{real} rate[{count}];"
    yield f"{INDENT}{layout.name}_rates({', '.join(layout.arguments)}, state, rate);"
    yield f"{INDENT}for (size_t k = 0U; k < {count}U; ++k) {{"
    yield f"{INDENT * 2}const {real} next = state->consequent[k] + (dt * rate[k]);"
    yield f"{INDENT * 2}if (!{layout.name}_is_nan(next)) {{"
    value = "(next < lower[k]) ? lower[k] : ((next > upper[k]) ? upper[k] : next)"
    yield f"{INDENT * 3}state->consequent[k] = {value};"
    yield from (f"{INDENT * 2}}}", f"{INDENT}}}", "}")
