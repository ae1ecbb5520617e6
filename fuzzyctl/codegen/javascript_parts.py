"""Functions of pages besides the outputs of a system: degrees of its sets, activations of its rules, implied sets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.javascript_text import DIALECT, block, file_text, helpers, tables, value_text
from fuzzyctl.codegen.simplify import functions, lean, renamed, with_named_state, with_prefix
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import broken
from fuzzyctl.expr import Expr, Name, replace_names
from fuzzyctl.formulas import aggregation, conjunction
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import SetPlan
from fuzzyctl.kernels.plan.sets import ITSELF
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.printer import INDENT
from fuzzyctl.kernels.program.program import Program

_A, _B = Name("a"), Name("b")


@dataclass(frozen=True)
class Shown:
    """The values of a system besides its outputs.

    Args:
        sets: Fuzzy sets of each variable: inputs, then lets, then outputs.
        implications: Pairs of an implication and the largest difference of degrees that count as equal.
        values: Functions of the inputs that consequents are, over the names of inputs.
    """

    sets: Sequence[Sequence[SetPlan]]
    implications: Sequence[tuple[str, float]]
    values: Sequence[Expr]


def module(unit: Unit, shown: Shown) -> str:
    """Return the text of an ES module beside that of the system.

    It exports `activity(inputs, state)`, an array: the degree of each antecedent's term, the activation of each rule,
    then the activation of each consequent, output by output; `values(inputs)`; and arrays of functions: `sets`,
    which return the degrees of all sets of a variable at a value, `implications` of an activation and a degree, and
    `aggregations` of two degrees, one for each output.
    """
    layout = JavaScriptLayout(unit)
    activity = with_named_state(lean(inference.activity(unit.plan)))
    activity = with_prefix(renamed(activity, [*layout.arguments, *layout.read]), "t")
    values = with_prefix(renamed(_values(unit, shown.values), layout.arguments), "v")
    degrees = [with_prefix(_degrees(sets), f"s{k}_") for k, sets in enumerate(shown.sets)]
    implied = [_norm(conjunction(name, equal)(_A, _B)) for name, equal in shown.implications]
    joined = [_norm(aggregation(o.aggregation, o.equal)(_A, _B)) for o in unit.plan.outputs]
    programs = [activity, values, *degrees, *implied, *joined]
    lines: list[str] = []
    for program in programs:
        lines += [*tables(program, {name: () for name, _ in program.tables}), ""]
    calls, body = set().union(*map(functions, programs)), [s for p in programs for s in p.body]
    lines += [*helpers(calls, body), ""]
    arguments = ", ".join(layout.arguments)
    lines += [*_function("export function activity", layout.call(*layout.arguments), activity), ""]
    lines += [*_function("export function values", arguments, values), ""]
    lines += _functions("sets", "x", degrees)
    lines += _functions("implications", "a, b", implied, single=True)
    lines += _functions("aggregations", "a, b", joined, single=True)
    return file_text(broken(lines, INDENT))


def _values(unit: Unit, expressions: Sequence[Expr]) -> Program:
    """Return the program of functions of the inputs, which read them within their ranges."""
    builder, raw = Builder(), inference.raw_names(unit.plan)
    values: dict[str, Expr] = {}
    for planned, x in zip(unit.plan.inputs, raw, strict=True):
        values[planned.name] = x if planned.extrapolate else builder.let(clip(x, planned.lower, planned.upper))
    for let in unit.plan.lets:
        if not let.calls:
            values[let.name] = builder.let(replace_names(let.value, values))
    return lean(builder.program(raw, [builder.let(replace_names(e, values)) for e in expressions]))


def _degrees(sets: Sequence[SetPlan]) -> Program:
    builder, x = Builder(), Name("x")
    degrees = []
    for plan in sets:
        degree = builder.let(replace(plan, changes=()).degree(x))
        for change in plan.changes:  # each names the degree more than once: 90 of them would double it 90 times
            degree = builder.let(replace_names(change, {ITSELF: degree}))
        degrees.append(degree)
    return lean(builder.program([x], degrees))


def _norm(value: Expr) -> Program:
    return lean(Builder().program([_A, _B], [value]))


def _functions(name: str, arguments: str, programs: Sequence[Program], *, single: bool = False) -> Iterator[str]:
    yield f"export const {name} = ["
    for program in programs:
        lines = list(_function("function", arguments, program, single=single))
        yield from (INDENT + line for line in lines[:-1])
        yield f"{INDENT}{lines[-1]},"
    yield from ("];", "")


def _function(head: str, arguments: str, program: Program, *, single: bool = False) -> Iterator[str]:
    """Yield the lines of a function that returns all results, or the only one."""
    yield f"{head} ({arguments}) {{" if head == "function" else f"{head}({arguments}) {{"
    yield from block(program.body, DIALECT, lambda _: "", {})
    results = [value_text(r, DIALECT) for r in program.results]
    returned = results[0] if single else f"[{', '.join(results)}]"
    yield f"{INDENT}return {returned};"
    yield "}"
