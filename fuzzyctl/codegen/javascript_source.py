"""A unit as one ES module without dependencies, which pages and node import; a state is a plain object."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.analysis.work import NUMBERS, written
from fuzzyctl.codegen.c_layout import member_name
from fuzzyctl.codegen.comments import described, ends, number_notes, printable, table_notes, value_notes
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.javascript_text import (
    DIALECT,
    NO_RULE_FIRES,
    REQUIRE_NUMBER,
    block,
    comment,
    comments,
    file_text,
    helpers,
    list_lines,
    literal,
    quoted,
    record,
    tables,
    value_text,
)
from fuzzyctl.codegen.names import JAVASCRIPT_FUNCTION_RESERVED, JAVASCRIPT_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, renamed, with_prefix
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import broken
from fuzzyctl.kernels.compile import operations
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.printer import INDENT
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.model.controller import Signal
from fuzzyctl.model.variable import LinguisticVariable

#: Most operations of a program; a text of more is megabytes, which a browser is slow to read.
MOST_OPERATIONS: Final = 50_000
#: The variable for numbers of the caller that replace those of the rule file.
_GIVEN = """for (const [key, value] of Object.entries(given)) {
    if (!Object.hasOwn(params, key)) {
        throw new RangeError("there is no free number '" + key + "', only: " + Object.keys(params).join(", "));
    }
    if (!Number.isFinite(value)) {
        throw new TypeError("a finite number is expected for '" + key + "', not " + String(value));
    }
}"""


@dataclass(frozen=True)
class JavaScriptLayout:
    """Names in JavaScript; the state, which includes free numbers, is the first parameter of a step."""

    unit: Unit

    @cached_property
    def name(self) -> str:
        """Name of the module; a system's function has it, the functions of a controller begin with it."""
        return Names(JAVASCRIPT_FUNCTION_RESERVED).claim(self.unit.block.name)

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Identifiers of the inputs, then `dt` where there is no period."""
        names = Names([*JAVASCRIPT_RESERVED, *([] if self.unit.is_step else [self.name])])
        inputs = [names.claim(i, apart_from=(f"{self.name}_",)) for i in self.unit.inputs]
        return (*inputs, *((DT,) if self.unit.takes_time else ()))

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
        results = []
        for slot in self.unit.slots:
            member = names.claim(member_name(slot.name))
            results.append((member, names.claim(f"{member}_oldest") if slot.length > 1 else ""))
        return tuple(results), numbers

    @property
    def slots(self) -> tuple[str, ...]:
        """The value that is read of each slot."""
        return tuple(f"state.{member}[state.{k}]" if k else f"state.{member}" for member, k in self.members)

    @property
    def read(self) -> tuple[str, ...]:
        """The parts of the state that are read: adaptive consequents as one array, slots, free numbers."""
        consequents = (f"state.consequent[{k}]" for k in range(len(self.unit.consequents)))
        return (*consequents, *self.slots, *(f"state.{n}" for n in self.numbers))

    @property
    def has_state(self) -> bool:
        """Whether there is a state, which includes free numbers."""
        return bool(self.read)

    def call(self, *inputs: str) -> str:
        """Return the parameters of the function: the state, if there is one, and inputs."""
        state = ["state"] if self.has_state else []
        return ", ".join([*state, *inputs] if self.unit.is_step else [*inputs, *state])

    @property
    def function(self) -> str:
        """The name of the function that evaluates a system, or makes a step."""
        return f"{self.name}_step" if self.unit.is_step else self.name


def require_size(size: int) -> None:
    """Refuse a program of too many operations.

    Raises:
        CodegenError: If there are more than `MOST_OPERATIONS`.
    """
    if size > MOST_OPERATIONS:
        raise CodegenError(f"it takes about {size:,} operations, more than {MOST_OPERATIONS:,}")


def size_of(program: Program) -> int:
    """Return the operations of a program, its tables included."""
    return operations(program) + sum(len(values) for _, values in program.tables) // NUMBERS


def module(unit: Unit) -> str:
    """Return the text of NAME.mjs.

    For a system it exports `NAME(inputs)`, which returns a number, or an array for several outputs; with a state
    `NAME(inputs, state)`, and `NAME_rates(inputs, state)` and `NAME_adapt(state, inputs, dt)` where something adapts.
    For a controller it exports `NAME_step(state, inputs)`, with `dt` last where there is no period, which puts the next
    state into the object that it is given; `params` with the free numbers of the rule file, and `period` [s].

    `NAME_init()` returns the first state, and takes free numbers by name; `inputs` and `outputs` have names, units and
    ranges. Where no rule fires for an output that says `else error`, NoRuleFiresError is thrown, and the state stays.
    """
    layout = JavaScriptLayout(unit)
    if not unit.is_step:
        require_size(written(unit.plan) if unit.algorithm.name == "rules" else 0)
    require_size(size_of(unit.program))
    rates = with_prefix(unit.rates, "r") if unit.rates is not None else None
    programs = [unit.program, *([rates] if rates is not None else [])]
    lines = [*comment(described(unit)), "", *_signals(unit)]
    if layout.numbers:
        starts = {key: n.start for key, n in zip(layout.numbers, unit.numbers, strict=True)}
        notes = zip(layout.numbers, number_notes(unit), strict=True)
        lines += comment([printable(f"{key}: {note}") for key, note in notes])
        lines.append(f"export const params = {record(starts)};")
    if unit.period is not None:
        lines.append(f"export const period = {literal(unit.period)}; // [s]")
    for program in programs:
        lines += ["", *tables(program, comments(table_notes(unit, program)))]
    calls, body = set().union(*map(functions, programs)), [s for p in programs for s in p.body]
    lines += ["", *helpers(calls, body), *([REQUIRE_NUMBER] if layout.arguments else []), ""]
    lines += [NO_RULE_FIRES, ""] if unit.refusals else []
    begin = [*_init(layout), ""] if layout.has_state else []
    evaluation = [*broken(_evaluation(layout), INDENT), ""]
    lines += [*begin, *evaluation] if unit.is_step else [*evaluation, *begin]
    if rates is not None:
        lines += [*broken(_rates(layout, rates), INDENT), "", *broken(_adapt(layout), INDENT)]
    return file_text(lines)


def _signals(unit: Unit) -> Iterator[str]:
    """Yield the facts of inputs and outputs that pages show; without a range they go to infinity."""

    def shown(of: Signal | LinguisticVariable, lower: float, upper: float, more: Mapping[str, bool]) -> str:
        fields = {"name": of.name, "label": of.label, "unit": of.unit, "lower": lower, "upper": upper}
        return record({**fields, **more})

    if unit.is_step:
        inputs = [shown(s, *ends(unit, s.bounds), {}) for s in unit.controller.inputs]
        outputs = [shown(s, *ends(unit, s.bounds), {}) for s in unit.controller.results]
    else:
        planned = zip(unit.system.inputs, unit.plan.inputs, strict=True)
        inputs = [shown(v, p.lower, p.upper, {"extrapolate": p.extrapolate}) for v, p in planned]
        results = zip(unit.system.outputs, unit.plan.outputs, strict=True)
        outputs = [shown(v, p.lower, p.upper, {}) for v, p in results]
    yield from list_lines("export const inputs", inputs)
    yield from list_lines("export const outputs", outputs)


def _begin(layout: JavaScriptLayout, nothing: str) -> Iterator[str]:
    """Yield lines that functions of the inputs begin with: where one of them is NaN, there is nothing to compute."""
    for argument, name in zip(layout.arguments, layout.unit.arguments, strict=True):
        yield f"{INDENT}require_number({quoted(name)}, {argument});"
    tests = [f"{a} !== {a}" for a in layout.arguments] + ([f"!({DT} > 0.0)"] if layout.unit.takes_time else [])
    if tests:
        yield f"{INDENT}if ({' || '.join(tests)}) {{"
        yield from (f"{INDENT * 2}return {nothing};", f"{INDENT}}}")


def _returned(results: Sequence[str]) -> str:
    """Return the result of a function: a number, or an array for several."""
    return f"[{', '.join(results)}]" if len(results) != 1 else results[0]


def _evaluation(layout: JavaScriptLayout) -> Iterator[str]:
    unit, read = layout.unit, layout.read
    yield f"export function {layout.function}({layout.call(*layout.arguments)}) {{"
    yield from _begin(layout, _returned(["NaN"] * len(unit.outputs)))
    if unit.is_step:  # a stored value may be read by another slot
        places, read = read, unit.program.arguments[len(layout.arguments) :]
        yield from (f"{INDENT}const {name} = {place};" for name, place in zip(read, places, strict=True))
    program = renamed(unit.program, [*layout.arguments, *read])
    yield from block(program.body, DIALECT, _refusal, comments(value_notes(unit)))
    results = [value_text(r, DIALECT) for r in program.results]
    outputs, values = results[: len(unit.outputs)], results[len(unit.outputs) :]
    if unit.is_step:
        yield from _stores(layout, values)
    else:
        for o, place in zip(unit.plan.held, layout.slots, strict=True):
            yield f"{INDENT}const result{o} = {outputs[o]};"
            outputs[o] = f"result{o}"
            yield f"{INDENT}{place} = result{o} === result{o} ? result{o} : {place};"
    yield from (f"{INDENT}return {_returned(outputs)};", "}")


def _refusal(output: str) -> str:
    """Return the line that throws where no rule fires for an output."""
    return f"throw new NoRuleFiresError({quoted(output)});"


def _stores(layout: JavaScriptLayout, values: Sequence[str]) -> Iterator[str]:
    """Yield lines that store the state, which was read before."""
    for (_, oldest), slot, place, value in zip(layout.members, layout.unit.slots, layout.slots, values, strict=True):
        yield f"{INDENT}{place} = {value};"
        if oldest:
            yield f"{INDENT}state.{oldest} = state.{oldest} < {slot.length - 1} ? state.{oldest} + 1 : 0;"


def _init(layout: JavaScriptLayout) -> Iterator[str]:
    """Yield the function that gives the state before the first step."""
    yield f"export function {layout.name}_init({'given = {}' if layout.numbers else ''}) {{"
    yield from (INDENT + line for line in (_GIVEN.split("\n") if layout.numbers else []))
    yield f"{INDENT}return {{"
    if layout.unit.consequents:
        yield f"{INDENT * 2}consequent: [{', '.join(map(literal, layout.unit.consequents))}],"
    for (member, oldest), slot in zip(layout.members, layout.unit.slots, strict=True):
        start = literal(slot.start)
        yield f"{INDENT * 2}{member}: {f'Array({slot.length}).fill({start})' if oldest else start},"
        if oldest:
            yield f"{INDENT * 2}{oldest}: 0,"
    if layout.numbers:
        yield from (f"{INDENT * 2}...params,", f"{INDENT * 2}...given,")
    yield from (f"{INDENT}}};", "}")


def _rates(layout: JavaScriptLayout, program: Program) -> Iterator[str]:
    """Yield the function that returns dC/dt; NaN if an input is NaN or the rates have no value."""
    changed = renamed(program, [*layout.arguments, *layout.read])
    nothing = f"[{', '.join(['NaN'] * len(changed.results))}]"
    yield f"export function {layout.name}_rates({layout.call(*layout.arguments)}) {{"
    yield from _begin(layout, nothing)
    yield from block(changed.body, DIALECT, lambda _: f"return {nothing};", {})
    yield from (f"{INDENT}return [{', '.join(value_text(r, DIALECT) for r in changed.results)}];", "}")


def _adapt(layout: JavaScriptLayout) -> Iterator[str]:
    """Yield the function that makes an Euler step, clamped to the range; a value without a rate stays."""
    ends = [layout.unit.plan.outputs[o] for o, _ in layout.unit.plan.states]
    arguments = ", ".join(layout.arguments)
    yield f"export function {layout.name}_adapt(state, {arguments}, dt) {{"
    yield f"{INDENT}const rate = {layout.name}_rates({arguments}, state);"
    for k, end in enumerate(ends):
        low, high = literal(end.lower), literal(end.upper)
        yield f"{INDENT}const u{k} = state.consequent[{k}] + dt * rate[{k}];"
        value = f"u{k} < {low} ? {low} : u{k} > {high} ? {high} : u{k}"
        yield f"{INDENT}state.consequent[{k}] = u{k} === u{k} ? ({value}) : state.consequent[{k}];"
    yield "}"
