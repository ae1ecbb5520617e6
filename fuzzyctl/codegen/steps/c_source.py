"""A step as C99: header and source, without heap and without globals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.codegen.c_source import as_comments, comment, header_text, source_text, status_type
from fuzzyctl.codegen.c_text import INDENT, CText, bare
from fuzzyctl.codegen.steps.c_layout import StepLayout
from fuzzyctl.codegen.steps.unit import (
    StepUnit,
    described_step,
    input_notes,
    number_notes,
    signal_note,
    slot_notes,
    step_table_notes,
)
from fuzzyctl.codegen.unit import printable
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.expr import Name, Number
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.traversal import read


def header(unit: StepUnit) -> str:
    """Return the text of NAME.h."""
    layout = StepLayout(unit)
    about = [*described_step(unit), "", *folded(list(_promises(unit)))]
    declared = [*period(layout), *_types(layout), *broken(prototypes(layout), INDENT)]
    return header_text(layout.name, about, declared, ["stddef"] if any(k for _, k in layout.members) else [])


def _promises(unit: StepUnit) -> Iterator[str]:
    positive = "" if unit.equations.period is not None else ", or a dt that is not positive,"
    state = ", and the state stays as it is" if unit.slots else ""
    yield f"An input that is NaN{positive} makes every output NaN{state}."
    if unit.refusals:
        yield f"So it is where no rule fires for {', '.join(unit.refusals)}; the status says which."


def period(layout: StepLayout) -> Iterator[str]:
    """Yield the macro of the sample time, where there is one."""
    if layout.unit.equations.period is not None:
        number = CText(layout.unit.precision, layout.name, {}).number(layout.unit.equations.period)
        yield from (f"#define {layout.name.upper()}_PERIOD {number} // [s]", "")


def _types(layout: StepLayout) -> Iterator[str]:
    unit, name = layout.unit, layout.name
    if layout.many:
        notes = [signal_note(unit, s) for s in unit.controller.results]
        members = [f"{layout.real} {o};" for o in layout.outputs]
        yield from struct(f"{name}_outputs", [list(pair) for pair in zip(members, notes, strict=True)])
    if layout.numbers:
        members = [f"{layout.real} {n};" for n in layout.numbers]
        yield from struct(f"{name}_params", [list(pair) for pair in zip(members, number_notes(unit), strict=True)])
    if layout.members:
        lines = []
        for (own, oldest), slot, note in zip(layout.members, unit.slots, slot_notes(unit), strict=True):
            length = f"[{slot.length}]" if oldest else ""
            lines.append([f"{layout.real} {own}{length};", note])
            lines += [[f"size_t {oldest};", "position of its oldest number"]] if oldest else []
        yield from struct(f"{name}_state", lines)
    if unit.refusals:
        yield from status_type(name, [layout.status(), *(layout.status(o) for o in unit.refusals)])


def struct(name: str, members: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a type with its members, each with a note."""
    yield "typedef struct {"
    for text, note in members:
        yield f"{INDENT}{text}{f' {comment([printable(note)])[0]}' if note else ''}"
    yield from (f"}} {name};", "")


def prototypes(layout: StepLayout) -> Iterator[str]:
    """Yield the declared functions, each with what it takes and returns."""
    unit = layout.unit
    if layout.members:
        yield from ("// Begin with the state before the first step.", f"{layout.init};", "")
    if layout.numbers:
        yield from ("// Begin with the numbers of the rule file.", f"{layout.params_init};", "")
    about = [f"Make a step of {unit.controller.name}: {', '.join(unit.outputs)}."]
    about += [f"  state: begun by {layout.name}_init; becomes that after the step"] if layout.members else []
    about += ["  params: finite numbers, see their ranges"] if layout.numbers else []
    about += [f"  {a}: {n}" if n else f"  {a}" for a, n in zip(layout.arguments, input_notes(unit), strict=True)]
    about += ["  outputs: where the results go"] if layout.many else []
    about += [f"  status: {layout.status()}, or which output has no rule that fires"] if unit.refusals else []
    if not layout.many:
        note = signal_note(unit, unit.controller.results[0])
        about.append(f"Returns {unit.outputs[0]}{f': {note}' if note else ''}.")
    yield from comment(list(folded([printable(line) for line in about])))
    yield from (f"{layout.step};", "")


def source(unit: StepUnit) -> str:
    """Return the text of NAME.c."""
    layout = StepLayout(unit)
    text = CText(unit.precision, layout.name, layout.names)
    text.notes = as_comments({value: [name] for value, name in unit.values.items()})
    step = [*_step(layout, text)]
    begin = [*(_init(layout, text) if layout.members else ()), *(_params_init(layout, text) if layout.numbers else ())]
    return source_text(layout.name, text, [*begin, *step])


def _params_init(layout: StepLayout, text: CText) -> Iterator[str]:
    yield f"{layout.params_init}\n{{"
    for member, number in zip(layout.numbers, layout.unit.numbers, strict=True):
        yield f"{INDENT}params->{member} = {bare(text.number(number.start))};"
    yield "}\n"


def _init(layout: StepLayout, text: CText) -> Iterator[str]:
    yield f"{layout.init}\n{{"
    for (own, oldest), slot in zip(layout.members, layout.unit.slots, strict=True):
        start = bare(text.number(slot.start))
        if oldest:
            yield f"{INDENT}for (size_t k = 0U; k < {slot.length}U; ++k) {{"
            yield from (f"{INDENT * 2}state->{own}[k] = {start};", f"{INDENT}}}")
            yield f"{INDENT}state->{oldest} = 0U;"
        else:
            yield f"{INDENT}state->{own} = {start};"
    yield "}\n"


def _step(layout: StepLayout, text: CText) -> Iterator[str]:
    unit, pad = layout.unit, INDENT
    results = [f"outputs->{o}" for o in layout.outputs] if layout.many else ["result"]
    yield f"{layout.step}\n{{"
    yield from text.tables(unit.program, as_comments(step_table_notes(unit)))
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


def _guard(layout: StepLayout, text: CText) -> str:
    """Return the condition under which a step is made."""
    tests = [f"(!{layout.name}_is_nan({a}))" for a in layout.arguments]
    tests += [f"({DT} > {text.number(0.0)})"] if layout.unit.equations.period is None else []
    return bare(" && ".join(tests)) if len(tests) < 2 else " && ".join(tests)


def _stores(layout: StepLayout, text: CText, results: Sequence[str]) -> Iterator[str]:
    """Yield lines that store the outputs, then the state; what is read of it is read before."""
    unit = layout.unit
    kept = set(unit.program.arguments[len(layout.arguments) :])
    stores: list[str] = []
    yield from (f"{r} = {bare(text.text(v))};" for r, v in zip(results, unit.results, strict=True))
    for k, (value, place) in enumerate(zip(unit.taken, layout.slots, strict=True)):
        taken = bare(text.text(value))
        if read(value) & kept or not isinstance(value, Name | Number):
            yield f"const {layout.real} u{k} = {taken};"
            taken = f"u{k}"
        stores.append(f"{place} = {taken};")
    for (_, oldest), slot, store in zip(layout.members, unit.slots, stores, strict=True):
        yield store
        if oldest:
            yield f"state->{oldest} = (state->{oldest} < {slot.length - 1}U) ? (state->{oldest} + 1U) : 0U;"
