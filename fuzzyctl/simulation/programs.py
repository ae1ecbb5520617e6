"""The two programs of a loop: what happens at a sample, and the derivatives between two samples."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyctl.expr import Expr, Name, Number, replace_names
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equation, Evaluation
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import STATE, Item, Program
from fuzzyctl.kernels.step_program import evaluated, numeric, system_program
from fuzzyctl.model.loop import TIME
from fuzzyctl.records import record
from fuzzyctl.simulation.equations import LoopEquations, reached
from fuzzyctl.simulation.expansion import free_name


@record(frozen=True)
class LoopPrograms:
    """A loop as two programs, with distinct names and tables.

    Args:
        sample: From the time, the plants' states, delayed signals, free params, outputs of external plants, columns
            known before and flags of slow controllers to what is recorded, what is held, and the controllers' next
            states.
        derivative: From the time, the plants' states, delayed signals, free params, outputs of external plants
            and what is held to `LoopEquations.integrated`.
        held: Names of what is held.
    """

    sample: Program
    derivative: Program
    held: tuple[str, ...]


def programs(equations: LoopEquations, algorithm: str = "auto") -> LoopPrograms:
    """Write the programs of a loop.

    Args:
        equations: The loop.
        algorithm: How systems are computed, see `select.ALGORITHMS`.
    """
    builder = Builder()
    wanted = equations.integrated
    between, held = reached(equations, wanted)
    state_of = {s.name: Item(STATE, k) for k, s in enumerate(equations.states)}
    shared = [TIME, *(s.name for s in equations.plant_states), *(d.name for d in equations.delays)]
    shared += [*map(free_name, equations.free), *(n for e in equations.externals for n in e.outputs)]
    columns = [n for names in equations.given for n in names]

    env: dict[str, Expr] = {n: Name(f"a{k}") for k, n in enumerate([*shared, *columns, *equations.rates])}
    arguments = [a for a in env.values() if isinstance(a, Name)]
    env |= state_of
    _write(builder, equations, equations.body, env, algorithm)
    values = [*equations.signals.values(), *map(Name, held), *equations.updates]
    results = [builder.let(numeric(replace_names(v, env))) for v in values]
    sample = builder.program(arguments, results, state=len(equations.states))

    inner = builder.inner()
    own: dict[str, Expr] = {n: Name(f"b{k}") for k, n in enumerate([*shared, *held])}
    arguments = [a for a in own.values() if isinstance(a, Name)]
    _write(inner, equations, between, own, algorithm)
    results = [inner.let(numeric(replace_names(v, own))) for v in wanted]
    derivative = inner.program(arguments, results)
    return LoopPrograms(sample, derivative, tuple(held))


def _write(
    builder: Builder,
    equations: LoopEquations,
    body: Sequence[Equation | Evaluation],
    env: dict[str, Expr],
    algorithm: str,
) -> None:
    """Write equations, and enter what their names are into `env`."""
    for item in body:
        if isinstance(item, Evaluation):
            given = (*item.arguments, *(value for _, value in item.free))
            values = [builder.let(numeric(replace_names(a, env))) for a in given]
            before = [env[s] for s in item.states]
            block = item.states[0].partition(".")[0] if item.states else ""
            dt = Number(equations.periods.get(block, equations.step))
            found = evaluated(builder, plan(item.system), system_program(item, algorithm), values, before, dt)
            env |= dict(zip(item.defined, found, strict=True))
        else:
            env[item.name] = builder.let(numeric(replace_names(item.value, env)))
