"""Unit of code generation of a controller: its step as a program, its names, and what the generated text says of it."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from fuzzyctl import __version__
from fuzzyctl.analysis.verdicts import Verdict
from fuzzyctl.codegen.comments import table_notes
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.simplify import lean, quotient
from fuzzyctl.codegen.steps.slots import Slot, with_slots
from fuzzyctl.codegen.unit import Precision, Unit, for_small, guarantees, printable
from fuzzyctl.codegen.wrapping import folded
from fuzzyctl.expr import Binary, Expr, Name, Negate, Number, evaluate, number_text
from fuzzyctl.expr import replace as replace_in
from fuzzyctl.kernels.algorithms.select import Algorithm, algorithm_of
from fuzzyctl.kernels.inference.free import free_program
from fuzzyctl.kernels.inference.inference import evaluation_with_rates
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import DT, Equation, Equations, Evaluation
from fuzzyctl.kernels.plan.expansion import STARTED, equations_of
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.kernels.program.builder import is_atom
from fuzzyctl.kernels.program.program import Assign, Program, Refuse, Statement
from fuzzyctl.kernels.program.traversal import map_expressions, rebuilt
from fuzzyctl.kernels.steps.program import named_step
from fuzzyctl.model.controller import Controller, Signal
from fuzzyctl.model.guarantee import Bounds
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True)
class StepUnit:
    """One controller to be written.

    Args:
        controller: The controller, its params set.
        digest: SHA-256 of the text of its rule file.
        settings: Params that were set by hand.
        equations: What it computes.
        program: Its step for inputs that are no NaN. Arguments are the inputs, `dt` where there is no period, what the
            slots give and the free numbers; results are the outputs and what the slots take.
        slots: The state.
        numbers: Free numbers, which the caller gives; their starts are what the file says.
        systems: The systems that it calls, each with other params on its own, in the order of the calls.
        precision: Type of its numbers.
        values: Names of equations by the names of their values in the program.
        verdicts: What is known of its guarantees.
    """

    controller: Controller
    digest: str
    settings: tuple[tuple[str, float], ...]
    equations: Equations
    program: Program
    slots: tuple[Slot, ...]
    systems: tuple[Unit, ...]
    numbers: tuple[Slot, ...] = ()
    precision: Precision = "double"
    values: Mapping[str, str] = field(default_factory=dict, hash=False)
    verdicts: Sequence[Verdict] = field(default=(), hash=False)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The names of what a step takes: the inputs, and `dt` where there is no period."""
        return (*self.equations.inputs, *(() if self.equations.period is not None else (DT,)))

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs."""
        return tuple(name for name, _ in self.equations.outputs)

    @property
    def results(self) -> tuple[Expr, ...]:
        """What the outputs are."""
        return self.program.results[: len(self.outputs)]

    @property
    def taken(self) -> tuple[Expr, ...]:
        """What the slots take."""
        return self.program.results[len(self.outputs) :]

    @cached_property
    def refusals(self) -> tuple[str, ...]:
        """Outputs of systems that refuse where no rule fires: those with `else error`."""
        return tuple(dict.fromkeys(s.output for s in self.program.body if isinstance(s, Refuse)))


def prepare_step(
    controller: Controller,
    text: str,
    *,
    settings: Mapping[str, float] | None = None,
    algorithm: str = "auto",
    precision: Precision = "double",
    small: bool = False,
    guarded: bool = False,
    free: Sequence[str] = (),
    verdicts: Sequence[Verdict] = (),
) -> StepUnit:
    """Expand a controller for code generation.

    Args:
        controller: A checked controller with its params set.
        text: The text of its rule file.
        settings: Params that were set, for the record.
        algorithm: How systems are evaluated, one of `kernels.algorithm.ALGORITHMS`.
        precision: Type of its numbers.
        small: Whether the target has little memory, see `unit.prepare`.
        guarded: Whether quotients of equations are to be functions, which the target calls where they have a value.
        free: Names of the numbers that the caller gives, see `compile`.
        verdicts: What is known of its guarantees, for the record.

    Raises:
        ArgumentError: For an algorithm that a system does not allow, and for a number that cannot be free.
        UnknownNameError: For a free number that the controller does not have.
        CodegenError: For a system that no target can print, and where a start depends on a free number.
    """
    controller = with_instance_params(controller, free)
    equations = equations_of(controller, free)
    if equations.starts_vary:
        raise CodegenError(f"the start of a state depends on a free number, one of {', '.join(equations.free)}")
    systems: dict[FuzzySystem, Unit] = {}

    def point(call: Evaluation) -> Program:
        chosen, program = _algorithm_and_program(call, algorithm, small, guarded)
        systems[call.system] = Unit(call.system, "", (), chosen, {})
        return program

    written, values = named_step(_with_guards(equations) if guarded else equations, point)
    outputs = len(equations.outputs)
    program, slots = with_slots(lean(tidy(written)), equations.states, outputs)
    kept = len(slots) - len(equations.free)
    return StepUnit(
        controller=controller,
        digest=hashlib.sha256(text.encode("utf-8")).hexdigest(),
        settings=tuple((settings or {}).items()),
        equations=equations,
        program=replace(program, results=program.results[: outputs + kept]),
        slots=slots[:kept],
        numbers=slots[kept:],
        systems=tuple(systems.values()),
        precision=precision,
        values={v.name: n for n, v in reversed(values.items()) if isinstance(v, Name) and "#" not in n},
        verdicts=tuple(verdicts),
    )


def _algorithm_and_program(call: Evaluation, algorithm: str, small: bool, guarded: bool) -> tuple[Algorithm, Program]:
    """Return how the system of a call is evaluated, and the program of one evaluation."""
    planned = plan(call.system)
    if not (call.free or call.states):
        chosen = algorithm_of(planned, algorithm)
        chosen = for_small(chosen, algorithm) if small else chosen
        return chosen, chosen.printed
    if call.free:
        reason, program = (
            "numbers of it are free",
            free_program(free_plan(call.system, [name for name, _ in call.free])),
        )
    else:
        reason, program = "it has a state", evaluation_with_rates(planned)
    return Algorithm(planned, None, reason), map_expressions(program, quotient) if guarded else program


def _with_guards(equations: Equations) -> Equations:
    """Take quotients of equations for such that may have no value."""

    def guarded(value: Expr) -> Expr:
        return replace_in(replace_in(value, _computed), quotient)

    body = [
        replace(item, value=guarded(item.value))
        if isinstance(item, Equation)
        else replace(item, arguments=tuple(map(guarded, item.arguments)))
        for item in equations.body
    ]
    return replace(equations, body=tuple(body), updates=tuple(map(guarded, equations.updates)))


def tidy(program: Program) -> Program:
    """Return a program without copies and arithmetic of numbers, which computes the same."""
    known: dict[str, Expr] = {}

    def change(node: Expr) -> Expr:
        return known.get(node.name, node) if isinstance(node, Name) else _computed(node)

    def changed(value: Expr) -> Expr:
        return replace_in(value, change)

    body: list[Statement] = []
    for statement in program.body:
        own = rebuilt(statement, changed)
        if isinstance(own, Assign) and is_atom(own.value):
            known[own.name] = own.value
        else:
            body.append(own)
    return replace(program, body=tuple(body), results=tuple(map(changed, program.results)))


def _computed(node: Expr) -> Expr:
    """Return the number that an operation on numbers gives, as a target would compute it, or the node as it is."""
    match node:
        case Negate(operand=Number(value=value)):
            return Number(-value)
        case Binary(op="+" | "-" | "*" | "/" as op, left=Number(value=a), right=Number(value=b)) if op != "/" or b:
            value = {"+": a + b, "-": a - b, "*": a * b, "/": a / (b or 1.0)}[op]
            return Number(value) if math.isfinite(value) else node
    return node


def described_step(unit: StepUnit, taken: str = "neither clamped nor checked") -> list[str]:
    """Return the head of generated text, line by line, in the characters of a comment.

    Args:
        unit: What is written.
        taken: How inputs are taken.
    """
    controller, equations = unit.controller, unit.equations
    lines = [f"{controller.name}: {controller.title}" if controller.title else controller.name]
    if controller.citation:
        lines.append(f"Source: {controller.citation}")
    lines += ["", f"Generated by fuzzyctl {__version__}; change the rule file, not this file."]
    lines.append(f"Rule file: SHA-256 {unit.digest}")
    lines += [f"Param set: {name} = {value!r}" for name, value in unit.settings]
    set_ = dict(unit.settings)
    calls = [f"Calls {u.system.name}: {u.algorithm.name}; {u.algorithm.reason}" for u in unit.systems]
    lines += dict.fromkeys(calls)
    set_ |= {number.name: number.start for number in unit.numbers}
    lines += [f"Param {name} = {value!r}" for name, value in controller.param_values.values.items() if name not in set_]
    lines += [f"Free: {number.name}, {number.start!r} in the rule file" for number in unit.numbers]
    lines += ["", f"Inputs, which are {taken}:"]
    lines += [f"  {s.name}{_noted(note)}" for s, note in zip(controller.inputs, input_notes(unit), strict=False)]
    lines.append("Outputs:")
    lines += [f"  {s.name}{_noted(signal_note(unit, s))}" for s in controller.results]
    time = "dt seconds after the step before" if equations.period is None else f"every {equations.period!r} s"
    lines.append(f"A step is made {time}.")
    lines += guarantees(unit.verdicts, "controller with these params, before rounding")
    return list(folded([printable(line) for line in lines]))


def input_notes(unit: StepUnit) -> list[str]:
    """Return for each argument of a step what it is."""
    notes = [signal_note(unit, s) for s in unit.controller.inputs]
    return notes if unit.equations.period is not None else [*notes, "time since the step before, positive [s]"]


def signal_note(unit: StepUnit, signal: Signal) -> str:
    """Return the label, range and unit of an input, output or state."""
    label = signal.label or (signal.name if not signal.name.isascii() else "")
    ends = range_text(unit, signal.bounds)
    amount = " ".join(part for part in (ends, signal.unit) if part)
    return ", ".join(part for part in (label, amount) if part)


def slot_notes(unit: StepUnit) -> list[str]:
    """Return for each slot the state that it holds."""
    known = {s.name: signal_note(unit, s) for s in unit.controller.states} | {STARTED: "1 from the first step on"}
    return [known.get(slot.name, slot.name) for slot in unit.slots]


def number_notes(unit: StepUnit) -> list[str]:
    """Return for each free number the range and unit of its param."""
    params = {p.name: p for p in unit.controller.params}
    found = []
    for number in unit.numbers:
        param = params.get(number.name)
        parts = (range_text(unit, param.bounds), param.unit) if param is not None else (number.name,)
        found.append(" ".join(part for part in parts if part))
    return found


def range_text(unit: StepUnit, bounds: Bounds | None) -> str:
    """Return a range as a file would write it, or an empty string for none."""
    if bounds is None:
        return ""
    lower, upper = map(number_text, ends(unit, bounds))
    return f"{'(' if bounds.without_lower else '['}{lower}, {upper}{')' if bounds.without_upper else ']'}"


def ends(unit: StepUnit, bounds: Bounds | None) -> tuple[float, float]:
    """Return the ends of a range, infinite where there is none."""
    if bounds is None:
        return -math.inf, math.inf
    values = unit.controller.param_values.values
    return evaluate(bounds.lower, values), evaluate(bounds.upper, values)


def ends_of(unit: StepUnit, bounds: Bounds | None) -> tuple[float, float]:
    """Return a finite range to draw numbers from: the range itself, or a part of it where it has no end."""
    low, high = ends(unit, bounds)
    if math.isinf(low) and math.isinf(high):
        return -1.0, 1.0
    if math.isinf(high):
        return low, low + max(1.0, abs(low))
    return (high - max(1.0, abs(high)) if math.isinf(low) else low), high


def step_table_notes(unit: StepUnit) -> dict[str, list[str]]:
    """Return what each table of the step holds, by its name; tables are known by their numbers."""
    known: dict[tuple[float, ...], list[str]] = {}
    for own in unit.systems:
        program = own.algorithm.printed
        notes = table_notes(own, program)
        for table, values in program.tables:
            known.setdefault(tuple(values), []).extend(f"{own.system.name}: {note}" for note in notes[table])
    return {table: list(dict.fromkeys(known.get(tuple(values), ()))) for table, values in unit.program.tables}


def _noted(note: str) -> str:
    return f": {note}" if note else ""
