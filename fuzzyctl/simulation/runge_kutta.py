"""Programs of a loop, and the function of a whole run that they are printed as: samples, and steps of RK4 between."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, Name, Number, replace_names
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equation, Evaluation
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, Dialect, block, number, store_lines, text
from fuzzyctl.kernels.program.program import STATE, Item, Program, Refuse
from fuzzyctl.kernels.program.scalar import RUNTIME, execute
from fuzzyctl.kernels.step_form import evaluated, numeric, system_program
from fuzzyctl.model.discrete_plant import BEFORE
from fuzzyctl.model.loop import TIME
from fuzzyctl.model.plant import Plant
from fuzzyctl.records import record
from fuzzyctl.simulation.dead_times import PARTS, varies
from fuzzyctl.simulation.equations import LARGEST, LoopEquations, PlantState, reached
from fuzzyctl.simulation.expansion import free_name
from fuzzyctl.simulation.fmu_plant import FmuPlant
from fuzzyctl.simulation.python_plant import PythonPlant


@record(frozen=True)
class LoopPrograms:
    """A loop as two programs, with distinct names and tables.

    Args:
        sample: From the time, the plants' states, delayed signals, free params, outputs of external plants, columns
            known before and flags of slow controllers to what is recorded, what is held, and the controllers' next
            states.
        derivative: From the time, the plants' states, delayed signals, free params, outputs of external plants
            and what is held to `LoopEquations.integrated`.
        held: Names of held signals.
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
    between, held_names = reached(equations, wanted)
    state_of = {s.name: Item(STATE, k) for k, s in enumerate(equations.states)}
    shared = [TIME, *(s.name for s in equations.plant_states), *(d.name for d in equations.delays)]
    shared += [*map(free_name, equations.free), *(n for e in equations.externals for n in e.outputs)]
    columns = [n for names in equations.given for n in names]

    env: dict[str, Expr] = {n: Name(f"a{k}") for k, n in enumerate([*shared, *columns, *equations.rates])}
    arguments = [a for a in env.values() if isinstance(a, Name)]
    env |= state_of
    _write(builder, equations, equations.body, env, algorithm)
    values = [*equations.signals.values(), *map(Name, held_names), *equations.updates]
    results = [builder.let(numeric(replace_names(v, env))) for v in values]
    sample = builder.program(arguments, results, state=len(equations.states))

    inner = builder.inner()
    inner_env: dict[str, Expr] = {n: Name(f"b{k}") for k, n in enumerate([*shared, *held_names])}
    arguments = [a for a in inner_env.values() if isinstance(a, Name)]
    _write(inner, equations, between, inner_env, algorithm)
    results = [inner.let(numeric(replace_names(v, inner_env))) for v in wanted]
    derivative = inner.program(arguments, results)
    return LoopPrograms(sample, derivative, tuple(held_names))


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
            inputs = (*item.arguments, *(value for _, value in item.free))
            values = [builder.let(numeric(replace_names(a, env))) for a in inputs]
            before = [env[s] for s in item.states]
            block = item.states[0].partition(".")[0] if item.states else ""
            dt = Number(equations.periods.get(block, equations.step))
            outputs = evaluated(builder, plan(item.system), system_program(item, algorithm), values, before, dt)
            env |= dict(zip(item.defined, outputs, strict=True))
        else:
            env[item.name] = builder.let(numeric(replace_names(item.value, env)))


#: Arguments of a run: counts; the step; arrays of plant states, controller states, free params, known columns and the
#: record; those of dead times.
ARGUMENTS: Final = "first, count, total, substeps, h, X, C, F, G, R, D, I, W"
_SIGNATURE: Final = (
    f"int64({', '.join(['int64'] * 4)}, float64, {', '.join(['float64[::1]'] * 6)}, int64[::1], float64[::1])"
)
#: Parts of a step, by their positions in `PARTS`, that the stages are at: after those of RK4 delayed signals that vary
#: are computed anew from states at the end and from cubic ones in between.
_STAGES: Final = (0, 1, 1, 2)
_STAGES_OF_DELAYS: Final = (*_STAGES, 2, 1, 3)


class RunSource:
    """Prints the run of a loop.

    Args:
        equations: The loop.
        programs: The same as programs.
        dialect: Of the target.
    """

    def __init__(self, equations: LoopEquations, programs: LoopPrograms, dialect: Dialect) -> None:
        self.equations, self.programs, self.dialect = equations, programs, dialect
        self.states = range(len(equations.plant_states))
        self.outputs = refused(programs)
        #: How many values are kept of each delayed signal in a step.
        self.nodes = len(PARTS) if varies(equations) else 1
        #: How many ways there are to stop: each state, each output that says `else error`.
        self.kinds = max(len(equations.plant_states) + len(self.outputs), 1)

    def lines(self) -> list[str]:
        """Return the function `kernel`.

        It returns -1 at the end; else `kinds` times the sample where it stopped plus the position of the state that
        left its range, which `X` then holds, or of the output that has no value behind the states.
        """
        lines = [f"def kernel({ARGUMENTS}):", *_in(1, [f"x{k} = X[{k}]" for k in self.states])]
        lines += _in(1, [f"f{k} = F[{k}]" for k in range(len(self.equations.free))])
        lines += _in(1, ["step = h / substeps", "for k in range(first, first + count):"])
        lines += _in(2, self._sample())
        lines += _in(2, ["if k == total - 1:", f"{INDENT}break"])
        if self.states or self.equations.delays:
            lines += _in(2, ["for s in range(substeps):"])
            lines += _in(3, self._step())
        lines += _in(2, self._advances())
        lines += _in(1, [*(f"X[{k}] = x{k}" for k in self.states), "return -1"])
        return lines

    def _refusal(self, condition: str, output: str) -> list[str]:
        kind = len(self.states) + self.outputs.index(output)
        return [f"if {condition}:", f"{INDENT}return {self.kinds} * k + {kind}"]

    def _sample(self) -> Iterator[str]:
        equations, program = self.equations, self.programs.sample
        columns = [n for names in equations.given for n in names]
        columns_now = [f"G[{len(columns)} * k + {j}]" for j in range(len(columns))]
        flags = [f"(1.0 if k % {n} == 0 else 0.0)" for n in equations.rates.values()]
        yield "t = k * h"
        for position, state in enumerate(equations.plant_states):
            yield f"if not ({_inside(state, f'x{position}')}):"
            yield from _in(1, [f"X[{position}] = x{position}", f"return {self.kinds} * k + {position}"])
        yield from self._delayed("0", "0")
        yield from self._external("t", "x")
        values = ["t", *(f"x{k}" for k in self.states), *self._shared(), *columns_now, *flags]
        yield from (f"{a} = {v}" for a, v in zip(program.arguments, values, strict=True))
        yield from self._block(program)
        width, input_count = len(equations.signals), len(self.programs.held)
        results = [text(r, self.dialect) for r in program.results[: width + input_count]]
        yield from (f"R[{width} * (k - first) + {j}] = {r}" for j, r in enumerate(results[:width]))
        yield from (f"h{j} = {r}" for j, r in enumerate(results[width : width + input_count]))
        updates = program.results[width + input_count :]
        # The next states go behind the present ones, and replace them when all are computed.
        yield from store_lines(updates, self.dialect, lambda k: f"C[{len(updates)} + {k}]")
        if updates:
            yield from (f"for n in range({len(updates)}):", f"{INDENT}C[n] = C[{len(updates)} + n]")

    def _step(self) -> Iterator[str]:
        """Yield a step of the classical method of fourth order; its stages are a loop, so they are printed once."""
        program, count = self.programs.derivative, len(self.equations.delays)
        stages = _STAGES_OF_DELAYS if self.nodes > 1 else _STAGES
        begin = "s"
        if count:
            begin = "c"
            yield from (f"c = W[{count} + 2 * s]", f"step = W[{count + 1} + 2 * s]", "m = k * substeps + s")
        yield from (f"y{k} = x{k}" for k in self.states)
        yield from (f"z{k} = x{k}" for k in self.states)
        yield f"for stage in range({len(stages)}):"
        inner: list[str] = [
            f"p = {stages}[stage]" if self.nodes > 1 else "p = (stage + 1) // 2",
            f"u = t + ({begin} + {f'{PARTS}[p]' if self.nodes > 1 else '0.5 * p'}) * step",
            "if p == 2:",
            f"{INDENT}u = u * {BEFORE!r}",
            *self._delayed("s", "p"),
        ]
        inner += self._external("u", "y")
        values = ["u", *(f"y{k}" for k in self.states), *self._shared()]
        values += [f"h{j}" for j in range(len(self.programs.held))]
        inner += [f"{a} = {v}" for a, v in zip(program.arguments, values, strict=True)]
        inner += self._block(program)
        results = [text(r, self.dialect) for r in program.results]
        inner += self._derivatives(results)
        for j, value in enumerate(results[len(results) - count :]):
            part = " + p" if self.nodes > 1 else ""
            inner.append(f"D[I[{2 * j}] + {self.nodes} * (m % I[{2 * j + 1}]){part}] = {value}")
        advance = ["w = step / 6.0 if p != 1 else step / 3.0", "v = 0.5 * step if stage < 2 else step"]
        advance += [f"z{k} = z{k} + w * d{k}" for k in self.states]
        advance += [f"y{k} = x{k} + v * d{k}" for k in self.states]
        inner += self._between(advance) if self.nodes > 1 else advance
        yield from _in(1, inner)
        yield from (f"x{k} = z{k}" for k in self.states)

    def _between(self, advance: list[str]) -> Iterator[str]:
        """Yield lines behind a stage: after those of RK4 states are on the cubic polynomial through both ends."""
        yield from ("if stage == 0:", *_in(1, [f"e{k} = d{k}" for k in self.states] or ["pass"]))
        yield from ("if stage < 4:", *_in(1, advance))
        yield from ("if stage == 3:", *_in(1, [f"y{k} = z{k}" for k in self.states] or ["pass"]))
        yield from ("if stage == 4:", *_in(1, [f"g{k} = d{k}" for k in self.states] or ["pass"]))
        yield from ("if stage > 3:", f"{INDENT}v = 0.5 if stage == 4 else 0.25")
        cubic = "x{0} + v * v * (3.0 - 2.0 * v) * (z{0} - x{0}) + step * v * (1.0 - v) * ((1.0 - v) * e{0} - v * g{0})"
        yield from _in(1, [f"y{k} = {cubic.format(k)}" for k in self.states])

    def _derivatives(self, results: Sequence[str]) -> Iterator[str]:
        """Yield lines that give each state its derivative; those of plants in Python come from calls."""
        external = [k for e in self.equations.externals for k in e.states]
        positions = [k for k in self.states if k not in external]
        yield from (f"d{k} = {value}" for k, value in zip(positions, results, strict=False))
        first = len(positions)
        for j, e in enumerate(self.equations.externals):
            if e.plant.fmu:
                continue
            inputs = results[first : first + len(e.inputs)]
            first += len(e.inputs)
            call = f"derivative{j}(u, {_tuple([f'y{k}' for k in e.states])}, {_tuple(inputs)})"
            yield f"{', '.join(f'd{k}' for k in e.states)}, = {call}" if e.states else call

    def _advances(self) -> Iterator[str]:
        """Yield lines that step FMUs to the next sample, with the inputs of this one."""
        width = len(self.equations.signals)
        column = {name: k for k, name in enumerate(self.equations.signals)}
        for j, e in enumerate(self.equations.externals):
            if e.plant.fmu:
                yield f"advance{j}(k, h, {_tuple([f'R[{width} * (k - first) + {column[n]}]' for n in e.inputs])})"

    def _external(self, time: str, state: str) -> Iterator[str]:
        """Yield lines that compute the outputs of plants in Python, and read those of FMUs."""
        for j, e in enumerate(self.equations.externals):
            call = f"output{j}({time}, {_tuple([f'{state}{k}' for k in e.states])})"
            yield f"{', '.join(f'o{j}_{k}' for k in range(len(e.outputs)))}, = {call}" if e.outputs else call

    def _shared(self) -> list[str]:
        """Return what both programs take: delayed signals, free params, outputs of plants in Python."""
        equations = self.equations
        outputs = [f"o{j}_{k}" for j, e in enumerate(equations.externals) for k in range(len(e.outputs))]
        delayed = [f"q{k}" for k in range(len(equations.delays))]
        return [*delayed, *(f"f{k}" for k in range(len(equations.free))), *outputs]

    def _delayed(self, step: str, part: str) -> Iterator[str]:
        """Yield lines that look up each delayed signal at a part of a step between two samples."""
        count = len(self.equations.delays)
        for j in range(count):
            row = f"4 * ({j} * substeps + {step}) + {part}"
            yield f"i = k * substeps + {step} - I[{2 * count} + {row}]"
            yield f"q{j} = W[{j}]"
            yield "if i >= 0:"
            yield f"{INDENT}i = I[{2 * j}] + {self.nodes} * (i % I[{2 * j + 1}])"
            weights = [f"W[o + {r}] * D[i + {r}]" for r in range(self.nodes)]
            if self.nodes > 1:
                yield f"{INDENT}o = {count} + 2 * substeps + 4 * ({row})"
            yield f"{INDENT}q{j} = {' + '.join(weights) if self.nodes > 1 else 'D[i]'}"

    def _block(self, program: Program) -> Iterator[str]:
        return block(program.body, self.dialect, self._refusal, 0)


def refused(programs: LoopPrograms) -> list[str]:
    """Return the outputs that stop a run where no rule fires."""
    bodies = (*programs.sample.body, *programs.derivative.body)
    return list(dict.fromkeys(s.output for s in bodies if isinstance(s, Refuse)))


def _in(depth: int, lines: Iterator[str] | Sequence[str]) -> list[str]:
    return [INDENT * depth + line for line in lines]


def _tuple(texts: Sequence[str]) -> str:
    return f"({', '.join(texts)},)" if texts else "()"


def _inside(state: PlantState, x: str) -> str:
    """Return the text of whether a state is finite and in its range."""
    low = (
        f"{x} {'>' if state.without_low else '>='} {number(state.low)}" if state.low > -LARGEST else f"{x} > {-LARGEST}"
    )
    high = (
        f"{x} {'<' if state.without_high else '<='} {number(state.high)}"
        if state.high < LARGEST
        else f"{x} < {LARGEST}"
    )
    return f"{low} and {high}"


def joined(programs: LoopPrograms) -> Program:
    """Return the tables and statements of both programs as one."""
    sample, derivative = programs.sample, programs.derivative
    return replace(sample, tables=derivative.tables, body=(*sample.body, *derivative.body))


def compiled(equations: LoopEquations, programs: LoopPrograms) -> Callable[..., int]:
    """Return the run as machine code."""
    from fuzzyctl.kernels.backends.numba import source as numba_backend

    lines = RunSource(equations, programs, numba_backend.COMPILED).lines()
    text_of = numba_backend.module_source(joined(programs), _SIGNATURE, lines)
    return numba_backend.compile_source(text_of)


def printed(equations: LoopEquations, programs: LoopPrograms) -> tuple[str, dict[str, Any]]:
    """Return the run as text in Python, which takes lists in place of arrays, and the tables that it reads."""
    lines = RunSource(equations, programs, IEEE_SCALAR).lines()
    return "\n".join(lines) + "\n", dict(joined(programs).tables)


#: Arguments of `external_plant`: a plant, its block and where that is, and the values of its params.
External = tuple[Plant, str, Span | None, Mapping[str, float]]


def external_plant(plant: Plant, block: str, span: Span | None, params: Mapping[str, float]) -> PythonPlant | FmuPlant:
    """Return the code of a plant in Python, or of an FMU, ready to be called."""
    return PythonPlant(plant, block, span) if plant.python else FmuPlant(plant, block, span, params)


def interpreted(
    text: str, tables: Mapping[str, Any], plants: Sequence[PythonPlant | FmuPlant] = ()
) -> Callable[..., int]:
    """Return the function of a text that `printed` returned."""
    namespace: dict[str, Any] = {**RUNTIME, **tables}
    for k, plant in enumerate(plants):
        namespace[f"output{k}"] = plant.output
        namespace |= (
            {f"advance{k}": plant.advance} if isinstance(plant, FmuPlant) else {f"derivative{k}": plant.derivative}
        )
    return execute(text, namespace)
