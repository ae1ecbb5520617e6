"""A step as one ES module without dependencies: a state that is a plain object, and a function that makes steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from fuzzyctl.codegen.javascript_source import refusal, require_size, requirements, results_text, size_of
from fuzzyctl.codegen.javascript_text import (
    NO_RULE_FIRES,
    REQUIRE_NUMBER,
    block,
    comment,
    comments,
    dialect,
    file_text,
    helpers,
    list_lines,
    literal,
    record,
    tables,
    value_text,
)
from fuzzyctl.codegen.names import JAVASCRIPT_FUNCTION_RESERVED, JAVASCRIPT_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, renamed
from fuzzyctl.codegen.steps.c_layout import member_name
from fuzzyctl.codegen.steps.unit import StepUnit, described_step, ends, number_notes, step_table_notes
from fuzzyctl.codegen.unit import printable
from fuzzyctl.codegen.wrapping import broken
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.printer import INDENT
from fuzzyctl.model.controller import Signal

#: What takes the numbers that a caller gives in place of those of the rule file.
_GIVEN = """for (const [key, value] of Object.entries(given)) {
    if (!Object.hasOwn(params, key)) {
        throw new RangeError("there is no free number '" + key + "', only: " + Object.keys(params).join(", "));
    }
    if (!Number.isFinite(value)) {
        throw new TypeError("a finite number is expected for '" + key + "', not " + String(value));
    }
}"""


@dataclass(frozen=True)
class StepJavaScriptLayout:
    """What JavaScript calls things; the first parameter is the state, in which free numbers stand, too."""

    unit: StepUnit

    @cached_property
    def name(self) -> str:
        """Begin of the names of the functions, and name of the module."""
        return Names(JAVASCRIPT_FUNCTION_RESERVED).claim(self.unit.controller.name)

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Identifiers of the inputs, then `dt` where there is no period."""
        names = Names(JAVASCRIPT_RESERVED)
        inputs = [names.claim(i, apart_from=(f"{self.name}_",)) for i in self.unit.equations.inputs]
        return (*inputs, *(() if self.unit.equations.period is not None else (DT,)))

    @cached_property
    def members(self) -> tuple[tuple[str, str], ...]:
        """For each slot its member of the state, and the member with the position of the oldest number of a delay."""
        return self._members[0]

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Members of the state that hold the free numbers."""
        return self._members[1]

    @cached_property
    def _members(self) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
        names = Names(())
        numbers = tuple(names.claim(member_name(n.name)) for n in self.unit.numbers)
        found = []
        for slot in self.unit.slots:
            own = names.claim(member_name(slot.name))
            found.append((own, names.claim(f"{own}_oldest") if slot.length > 1 else ""))
        return tuple(found), numbers

    @property
    def slots(self) -> tuple[str, ...]:
        """What is read of each slot."""
        return tuple(f"state.{own}[state.{k}]" if k else f"state.{own}" for own, k in self.members)

    @property
    def has_state(self) -> bool:
        """Whether a step takes a state, in which free numbers stand, too."""
        return bool(self.members or self.numbers)


def module(unit: StepUnit) -> str:
    """Return the text of NAME.mjs.

    It exports `NAME_step(state, inputs)`, with `dt` last where there is no period, which returns a number, or an array
    for several outputs, and puts the next state into the object that it is given; `NAME_init()`, the state before the
    first step, which takes free numbers by name; `inputs`, `outputs`, `params` with the free numbers of the rule file,
    and `period` [s]. Where no rule fires for an output that says `else error`, a step throws NoRuleFiresError, and the
    state stays.
    """
    layout = StepJavaScriptLayout(unit)
    require_size(size_of(unit.program))
    lines = [*comment(described_step(unit)), "", *_signals(unit)]
    if layout.numbers:
        starts = {key: n.start for key, n in zip(layout.numbers, unit.numbers, strict=True)}
        notes = zip(layout.numbers, number_notes(unit), strict=True)
        lines += comment([printable(f"{key}: {note}") for key, note in notes])
        lines.append(f"export const params = {record(starts)};")
    if unit.equations.period is not None:
        lines.append(f"export const period = {literal(unit.equations.period)}; // [s]")
    lines += ["", *tables(unit.program, comments(step_table_notes(unit))), ""]
    lines += [*helpers(functions(unit.program), unit.program.body), *([REQUIRE_NUMBER] if layout.arguments else []), ""]
    lines += [NO_RULE_FIRES, ""] if unit.refusals else []
    lines += [*_init(layout), ""] if layout.has_state else []
    return file_text([*lines, *broken(_step(layout), INDENT)])


def _signals(unit: StepUnit) -> Iterator[str]:
    """Yield what pages show of inputs and outputs; without a range they go to infinity."""

    def shown(signal: Signal) -> str:
        lower, upper = ends(unit, signal.bounds)
        own = {"name": signal.name, "label": signal.label, "unit": signal.unit, "lower": lower, "upper": upper}
        return record(own)

    yield from list_lines("export const inputs", map(shown, unit.controller.inputs))
    yield from list_lines("export const outputs", map(shown, unit.controller.results))


def _init(layout: StepJavaScriptLayout) -> Iterator[str]:
    """Yield the function that gives the state before the first step."""
    yield f"export function {layout.name}_init({'given = {}' if layout.numbers else ''}) {{"
    yield from (INDENT + line for line in (_GIVEN.split("\n") if layout.numbers else []))
    yield f"{INDENT}return {{"
    for (own, oldest), slot in zip(layout.members, layout.unit.slots, strict=True):
        start = literal(slot.start)
        yield f"{INDENT * 2}{own}: {f'Array({slot.length}).fill({start})' if oldest else start},"
        if oldest:
            yield f"{INDENT * 2}{oldest}: 0,"
    if layout.numbers:
        yield from (f"{INDENT * 2}...params,", f"{INDENT * 2}...given,")
    yield from (f"{INDENT}}};", "}")


def _step(layout: StepJavaScriptLayout) -> Iterator[str]:
    unit, own = layout.unit, dialect()
    parameters = [*(["state"] if layout.has_state else []), *layout.arguments]
    yield f"export function {layout.name}_step({', '.join(parameters)}) {{"
    yield from requirements(layout.arguments, unit.arguments)
    tests = [f"{a} !== {a}" for a in layout.arguments]
    tests += [f"!({DT} > 0.0)"] if unit.equations.period is None else []
    if tests:
        yield f"{INDENT}if ({' || '.join(tests)}) {{"
        yield from (f"{INDENT * 2}return {results_text(['NaN'] * len(unit.outputs))};", f"{INDENT}}}")
    reads = [*layout.slots, *(f"state.{n}" for n in layout.numbers)]
    read = unit.program.arguments[len(layout.arguments) :]
    yield from (f"{INDENT}const {name} = {place};" for name, place in zip(read, reads, strict=True))
    program = renamed(unit.program, [*layout.arguments, *read])
    notes = comments({value: [name] for value, name in unit.values.items()})
    yield from block(program.body, own, refusal, notes)
    results = [value_text(r, own) for r in program.results]
    yield from _stores(layout, results[len(unit.outputs) :])
    yield from (f"{INDENT}return {results_text(results[: len(unit.outputs)])};", "}")


def _stores(layout: StepJavaScriptLayout, taken: Sequence[str]) -> Iterator[str]:
    """Yield lines that store the state, which was read before."""
    for (_, oldest), slot, place, value in zip(layout.members, layout.unit.slots, layout.slots, taken, strict=True):
        yield f"{INDENT}{place} = {value};"
        if oldest:
            yield f"{INDENT}state.{oldest} = state.{oldest} < {slot.length - 1} ? state.{oldest} + 1 : 0;"
