"""A unit as one ES module without dependencies, which pages and node import."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.analysis.work import NUMBERS, written
from fuzzyctl.codegen.comments import table_notes, value_notes
from fuzzyctl.codegen.errors import CodegenError
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
    quoted,
    record,
    tables,
    value_text,
)
from fuzzyctl.codegen.names import JAVASCRIPT_FUNCTION_RESERVED, JAVASCRIPT_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, renamed, with_prefix
from fuzzyctl.codegen.unit import Unit, described
from fuzzyctl.codegen.wrapping import broken
from fuzzyctl.kernels.backends.numba.compile_cost import operations
from fuzzyctl.kernels.program.printer import INDENT
from fuzzyctl.kernels.program.program import Program

#: Most operations of a program; a text of more is megabytes, which a browser is slow to read.
MOST_OPERATIONS: Final = 50_000


@dataclass(frozen=True)
class JavaScriptLayout:
    """What JavaScript calls things."""

    unit: Unit

    @cached_property
    def name(self) -> str:
        """Name of the function, and of the module."""
        return Names(JAVASCRIPT_FUNCTION_RESERVED).claim(self.unit.system.name)

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Identifiers of the inputs."""
        names = Names([*JAVASCRIPT_RESERVED, self.name])
        return tuple(names.claim(i.name, apart_from=(f"{self.name}_",)) for i in self.unit.plan.inputs)

    @cached_property
    def states(self) -> tuple[str, ...]:
        """The entries of the state, those of adaptive consequents as one array."""
        names, flat = Names(()), self.unit.plan
        held = [names.claim(f"held_{flat.outputs[o].name}") for o in flat.held]
        return (*(f"state.consequent[{k}]" for k in range(len(flat.states))), *(f"state.{h}" for h in held))

    @property
    def evaluated(self) -> tuple[str, ...]:
        """What the function takes."""
        return (*self.arguments, *(["state"] if self.states else []))


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

    It exports `NAME(inputs)`, which returns a number, or an array for several outputs; with a state
    `NAME(inputs, state)`, `NAME_init()` that gives the first one, an object, and `NAME_rates(inputs, state)` and
    `NAME_adapt(state, inputs, dt)` where something adapts; `inputs` and `outputs` with names, units and ranges. Where
    no rule fires for an output that says `else error`, the function throws NoRuleFiresError.
    """
    layout = JavaScriptLayout(unit)
    require_size(written(unit.plan) if unit.algorithm.name == "rules" else 0)
    require_size(size_of(unit.evaluation))
    rates = with_prefix(unit.rates, "r") if unit.rates is not None else None
    programs = [unit.evaluation, *([rates] if rates is not None else [])]
    lines = [*comment(described(unit)), "", *_signals(unit), ""]
    for own in programs:
        lines += [*tables(own, comments(table_notes(unit, own))), ""]
    calls, body = set().union(*map(functions, programs)), [s for p in programs for s in p.body]
    lines += [*helpers(calls, body), REQUIRE_NUMBER, ""]
    lines += [NO_RULE_FIRES, ""] if unit.refusals else []
    lines += [*broken(_evaluation(layout), INDENT), ""]
    if layout.states:
        lines += [*_init(layout), ""]
    if rates is not None:
        lines += [*broken(_rates(layout, rates), INDENT), "", *broken(_adapt(layout), INDENT)]
    return file_text(lines)


def _signals(unit: Unit) -> Iterator[str]:
    """Yield what pages show of inputs and outputs."""
    inputs = [
        {"name": v.name, "label": v.label, "unit": v.unit, "lower": p.lower, "upper": p.upper}
        | {"extrapolate": p.extrapolate}
        for v, p in zip(unit.system.inputs, unit.plan.inputs, strict=True)
    ]
    outputs = [
        {"name": v.name, "label": v.label, "unit": v.unit, "lower": p.lower, "upper": p.upper}
        for v, p in zip(unit.system.outputs, unit.plan.outputs, strict=True)
    ]
    yield from list_lines("export const inputs", map(record, inputs))
    yield from list_lines("export const outputs", map(record, outputs))


def results_text(results: Sequence[str]) -> str:
    """Return what a function returns: a number, or an array for several."""
    return f"[{', '.join(results)}]" if len(results) != 1 else results[0]


def requirements(arguments: Sequence[str], names: Sequence[str]) -> Iterator[str]:
    """Yield lines that refuse arguments that are no numbers.

    Args:
        arguments: Their identifiers.
        names: What the rule file calls them.
    """
    for argument, name in zip(arguments, names, strict=True):
        yield f"{INDENT}require_number({quoted(name)}, {argument});"


def refusal(output: str) -> str:
    """Return the line that throws where no rule fires for an output."""
    return f"throw new NoRuleFiresError({quoted(output)});"


def _begin(layout: JavaScriptLayout, nothing: str) -> Iterator[str]:
    """Yield lines that functions of the inputs begin with: where one of them is NaN, there is nothing to compute."""
    yield from requirements(layout.arguments, [i.name for i in layout.unit.plan.inputs])
    yield f"{INDENT}if ({' || '.join(f'{a} !== {a}' for a in layout.arguments)}) {{"
    yield from (f"{INDENT * 2}return {nothing};", f"{INDENT}}}")


def _evaluation(layout: JavaScriptLayout) -> Iterator[str]:
    unit, own = layout.unit, dialect(layout.states)
    program = renamed(unit.evaluation, layout.arguments)
    yield f"export function {layout.name}({', '.join(layout.evaluated)}) {{"
    yield from _begin(layout, results_text(["NaN"] * len(program.results)))
    yield from block(program.body, own, refusal, comments(value_notes(unit)))
    results = [value_text(r, own) for r in program.results]
    for o, entry in zip(unit.plan.held, layout.states[len(unit.plan.states) :], strict=True):
        yield f"{INDENT}const result{o} = {results[o]};"
        results[o] = f"result{o}"
        yield f"{INDENT}{entry} = result{o} === result{o} ? result{o} : {entry};"
    yield from (f"{INDENT}return {results_text(results)};", "}")


def _init(layout: JavaScriptLayout) -> Iterator[str]:
    """Yield the function that gives the first state."""
    flat = layout.unit.plan
    count, starts = len(flat.states), [literal(v) for v in flat.initial_state]
    yield f"export function {layout.name}_init() {{"
    yield f"{INDENT}return {{"
    if count:
        yield f"{INDENT * 2}consequent: [{', '.join(starts[:count])}],"
    for entry, start in zip(layout.states[count:], starts[count:], strict=True):
        yield f"{INDENT * 2}{entry.removeprefix('state.')}: {start},"
    yield from (f"{INDENT}}};", "}")


def _rates(layout: JavaScriptLayout, program: Program) -> Iterator[str]:
    """Yield the function that returns dC/dt; NaN where an input is NaN or nothing can be computed."""
    own, changed = dialect(layout.states), renamed(program, layout.arguments)
    nothing = f"[{', '.join(['NaN'] * len(changed.results))}]"
    yield f"export function {layout.name}_rates({', '.join(layout.evaluated)}) {{"
    yield from _begin(layout, nothing)
    yield from block(changed.body, own, lambda _: f"return {nothing};", {})
    yield from (f"{INDENT}return [{', '.join(value_text(r, own) for r in changed.results)}];", "}")


def _adapt(layout: JavaScriptLayout) -> Iterator[str]:
    """Yield the function that makes an Euler step, held within the range; what has no rate stays."""
    ends = [layout.unit.plan.outputs[o] for o, _ in layout.unit.plan.states]
    arguments = ", ".join(layout.arguments)
    yield f"export function {layout.name}_adapt(state, {arguments}, dt) {{"
    yield f"{INDENT}const rate = {layout.name}_rates({arguments}, state);"
    for k, end in enumerate(ends):
        low, high = literal(end.lower), literal(end.upper)
        yield f"{INDENT}const u{k} = state.consequent[{k}] + dt * rate[{k}];"
        held = f"u{k} < {low} ? {low} : u{k} > {high} ? {high} : u{k}"
        yield f"{INDENT}state.consequent[{k}] = u{k} === u{k} ? ({held}) : state.consequent[{k}];"
    yield "}"
