"""Preparation of units: systems are planned, controllers expanded, their states laid out."""

from __future__ import annotations

import hashlib
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.verdicts import Verdict
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.simplify import lean, quotient, with_state
from fuzzyctl.codegen.table import tabulated
from fuzzyctl.codegen.unit import Evaluated, Precision, Slot, Unit
from fuzzyctl.expr import Binary, Expr, Name, Negate, Number, walk
from fuzzyctl.expr import replace as replace_in
from fuzzyctl.kernels.algorithms.select import Algorithm, algorithm_of
from fuzzyctl.kernels.free_values import free_program
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equation, Equations, Evaluation, KeptState
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.kernels.program.builder import is_atom
from fuzzyctl.kernels.program.program import STATE, Assign, Item, Program, Statement
from fuzzyctl.kernels.program.traversal import expressions, map_expressions, rebuilt
from fuzzyctl.kernels.step_form import named_step
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.system import FuzzySystem

#: Most numbers of the tables of rules that can act where memory is small: 32 kB in double precision.
MOST_NUMBERS: Final = 4096
#: Most coefficients of all cells, 2^n for each of n inputs, where memory is small: 4 kB in double precision.
MOST_COEFFICIENTS: Final = 512
#: Fewest numbers of a ring buffer; shorter chains of states are shifted.
LEAST_RING: Final = 4


def prepare(
    block: FuzzySystem | Controller,
    text: str,
    *,
    settings: Mapping[str, float] | None = None,
    algorithm: str = "auto",
    precision: Precision = "double",
    table: int | None = None,
    small: bool = False,
    guarded: bool = False,
    free: Sequence[str] = (),
    verdicts: Sequence[Verdict] = (),
) -> Unit:
    """Plan a system, or expand a controller, for code generation.

    Args:
        block: A checked system or controller with its params set.
        text: The text of its rule file.
        settings: Params that were set, for the record.
        algorithm: How systems are evaluated, one of `kernels.algorithm.ALGORITHMS`.
        precision: Type of its numbers.
        table: Points along each input of a lookup table to write instead of a system.
        small: Whether the target has little memory, so that large tables are left out under "auto", and values are
            stored instead of the coefficients of many cells.
        guarded: Whether quotients of equations are to be functions, which the target calls where they have a value.
        free: Names of the numbers of a controller that the caller gives, see `compile`.
        verdicts: On its guarantees, for the record.

    Raises:
        ArgumentError: For an algorithm that a system does not allow, and for a number that cannot be free.
        UnknownNameError: For a free number that the controller does not have.
        CodegenError: For a lookup table of a system that has none, or whose error has no bound; for a system that no
            target can print; if a start depends on a free number.
    """
    if isinstance(block, Controller):
        unit = _of_controller(block, algorithm, small, guarded, free)
    else:
        unit = _of_system(block, algorithm, table, small)
    digest = hashlib.sha256(text.encode("utf-8")).hexdigest()
    pairs = tuple((settings or {}).items())
    return replace(unit, digest=digest, settings=pairs, precision=precision, verdicts=tuple(verdicts))


def _of_system(system: FuzzySystem, algorithm: str, table: int | None, small: bool) -> Unit:
    chosen = algorithm_of(plan(system), algorithm)
    chosen = for_small(chosen, algorithm) if small else chosen
    result = tabulated(chosen, table) if table is not None else None
    if result is not None:
        most = chosen.most_coefficients
        chosen = Algorithm(chosen.plan, result.grid, f"a table of {table} points along each input")
        chosen = replace(chosen, most_coefficients=most)
    flat = chosen.plan
    starts = zip(flat.held, flat.initial_state[len(flat.states) :], strict=True)
    return Unit(
        block=system,
        written=chosen.printed,
        systems=(Evaluated(system, chosen, result),),
        slots=tuple(Slot(f"held_{flat.outputs[o].name}", start) for o, start in starts),
        bounds=output_bounds(system),
    )


def for_small(chosen: Algorithm, wanted: str) -> Algorithm:
    """Return an algorithm as it is written where memory is small.

    Args:
        chosen: The algorithm.
        wanted: The algorithm that the caller chose; large tables are left out for "auto" only.
    """
    if wanted == "auto" and chosen.name == "active":
        numbers = sum(len(values) for _, values in chosen.printed.tables)
        if numbers > MOST_NUMBERS:
            reason = (
                f"those that can act would take {numbers:,} numbers; algorithm 'active' looks them up, and is faster"
            )
            chosen = Algorithm(chosen.plan, None, reason)
    return replace(chosen, most_coefficients=MOST_COEFFICIENTS)


def _of_controller(controller: Controller, algorithm: str, small: bool, guarded: bool, free: Sequence[str]) -> Unit:
    controller = with_instance_params(controller, free)
    equations = equations_of(controller, free)
    if equations.starts_vary:
        raise CodegenError(f"the start of a state depends on a free number, one of {', '.join(equations.free)}")
    systems: dict[FuzzySystem, Evaluated] = {}

    def point(call: Evaluation) -> Program:
        chosen, program = _algorithm_and_program(call, algorithm, small, guarded)
        systems[call.system] = Evaluated(call.system, chosen)
        return program

    written, values = named_step(_with_guards(equations) if guarded else equations, point)
    outputs = len(equations.outputs)
    program, slots = with_slots(lean(tidy(written)), equations.states, outputs)
    count = len(slots) - len(equations.free)
    return Unit(
        block=controller,
        step=equations,
        written=replace(program, results=program.results[: outputs + count]),
        slots=slots[:count],
        numbers=slots[count:],
        systems=tuple(systems.values()),
        values={v.name: n for n, v in reversed(values.items()) if isinstance(v, Name) and "#" not in n},
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
        reason, program = "it has a state", inference.evaluation_with_rates(planned)
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
    values: dict[str, Expr] = {}

    def change(node: Expr) -> Expr:
        return values.get(node.name, node) if isinstance(node, Name) else _computed(node)

    def changed(value: Expr) -> Expr:
        return replace_in(value, change)

    body: list[Statement] = []
    for statement in program.body:
        result = rebuilt(statement, changed)
        if isinstance(result, Assign) and is_atom(result.value):
            values[result.name] = result.value
        else:
            body.append(result)
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


def with_slots(program: Program, states: Sequence[KeptState], outputs: int) -> tuple[Program, tuple[Slot, ...]]:
    """Return a step whose state is in slots, and the slots.

    Args:
        program: A step; its results are the outputs, then the next value of each state.
        states: The states, in order.
        outputs: Number of outputs.

    Returns:
        The program: its last arguments `s0`, `s1`, ... are the values of the slots, its results the outputs, then the
        new value of each slot.
    """
    runs = _runs(program, states, outputs)
    names = {run[-1]: Name(f"s{k}") for k, run in enumerate(runs)}
    values = tuple(program.results[outputs + run[0]] for run in runs)
    changed = with_state(replace(program, results=(*program.results[:outputs], *values)), names)
    slots = tuple(Slot(_name(states[run[0]], len(run)), states[run[0]].start, len(run)) for run in runs)
    return changed, slots


def _runs(program: Program, states: Sequence[KeptState], outputs: int) -> list[range]:
    """Return the states of each slot: a single one, or a chain in which each takes the value of the one before."""
    reads = Counter(n.index for e in expressions(program) for n in walk(e) if isinstance(n, Item) and n.array == STATE)

    def continues(k: int) -> bool:
        same = repr(states[k].start) == repr(states[k - 1].start)  # repr tells -0.0 from 0.0, and NaN is itself
        return same and reads[k - 1] == 1 and program.results[outputs + k] == Item(STATE, k - 1)

    chains: list[range] = []
    for k in range(len(states)):
        if chains and continues(k):
            chains[-1] = range(chains[-1].start, k + 1)
        else:
            chains.append(range(k, k + 1))
    return [r for c in chains for r in ([c] if len(c) >= LEAST_RING else [range(k, k + 1) for k in c])]


def _name(state: KeptState, length: int) -> str:
    return re.sub(r"\.0$", "", state.name) if length > 1 else state.name
