"""A compiled loop that can be run: one function for all samples."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, final, get_args

import numpy as np

from fuzzyctl.diagnostics.diagnostic import (
    ArgumentError,
    BackendUnavailableError,
    Diagnostic,
    DiagnosticError,
    UnknownNameError,
)
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.kernels.algorithms.select import AlgorithmName
from fuzzyctl.kernels.backends.arguments import float_array, writable
from fuzzyctl.kernels.compile import MOST_BRANCHES, MOST_OPERATIONS, branches, numba_is_missing, operations
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.loop import Loop
from fuzzyctl.operations import Displayed
from fuzzyctl.simulation.columns import columns
from fuzzyctl.simulation.dead_times import DeadTimes, dead_times
from fuzzyctl.simulation.equations import LoopEquations, with_calls
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.fmu_plant import FmuPlant, require_fixed
from fuzzyctl.simulation.judgement import Judgement
from fuzzyctl.simulation.loop_params import Ranges, block_params, settable_of
from fuzzyctl.simulation.python_plant import PythonPlant
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.runge_kutta import (
    External,
    LoopPrograms,
    compiled,
    external_plant,
    interpreted,
    printed,
    programs,
    refused,
)
from fuzzyctl.simulation.stops import first_without_value, interrupted, left, without_value

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Steps of integration that machine code, and generated Python, takes before it can be interrupted.
CHUNK: Final = 50_000
FEW: Final = 500
#: Most states of controllers, such as those of a long `delay`, that "auto" compiles.
MOST_STATES: Final = 40
#: Backends of runs.
LoopBackend = Literal["auto", "numba", "python"]
BACKENDS: Final = get_args(LoopBackend)

#: Called with the number of samples that are done, and all of them.
Progress = Callable[[int, int], None]


@final
class Experiment(Displayed):
    """A compiled loop; `run()` simulates it.

    Args:
        loop: A well-formed loop.
        backend: "numba"; "python" for generated Python; "auto" for numba where it can be imported, but for loops that
            take it longer than most programs run.
        free: Numbers whose values are arguments of `run`: params, as `BLOCK.PARAM`, or `PARAM` of the loop, or
            `BLOCK.INSTANCE.PARAM` if a controller has controllers inside; starts of states, as `BLOCK.STATE`;
            disturbances, which are then constant.
        algorithm: How systems are computed, see `compile`.
        record_calls: Whether runs record the inputs of systems, too, as `BLOCK.SYSTEM.INPUT`.

    Raises:
        DiagnosticError: For an algebraic loop, sample times that do not fit together, files that cannot be used.
        UnknownNameError: For a free param that there is not, and another backend.
        ArgumentError: For a free param that something needs as a constant, such as the start of a state, or is twice.
    """

    def __init__(
        self,
        loop: Loop,
        backend: LoopBackend = "auto",
        *,
        free: Sequence[str] = (),
        algorithm: AlgorithmName = "auto",
        record_calls: bool = False,
    ) -> None:
        if not isinstance(loop, Loop):
            raise ArgumentError(f"expected a Loop, got {type(loop).__name__}")
        loop = with_instance_params(loop, free)
        self.loop, self.backend = loop, _backend(backend, loop)
        numbers = settable_of(loop)
        for name in free:
            if name not in numbers:
                raise UnknownNameError("param", name, tuple(numbers))
            if list(free).count(name) > 1:
                raise ArgumentError(f"'{name}' cannot be free: it is given twice")
        #: The free numbers with their values in the file.
        self.nominal = {name: numbers[name] for name in free}
        require_fixed(loop, free)
        self._ranges = Ranges(loop, tuple(self.nominal))
        self.judgement = Judgement(loop)
        equations = loop_equations(loop, self.judgement.signals, tuple(free))
        self.equations = with_calls(equations) if record_calls else equations
        self.programs = programs(self.equations, algorithm)
        if backend == "auto" and _takes_long(self.equations, self.programs):
            self.backend = "python"
        self.step, self.samples = self.equations.step, self.equations.samples
        self._lags: dict[int, DeadTimes] = {}
        #: Columns of the record by name.
        self.positions = {name: k for k, name in enumerate(self.equations.signals)}
        states = [[s.name for s in self.equations.plant_states], [s.name for s in self.equations.states]]
        #: Free starts by their positions in the vector of free numbers, and among the states of plants, of controllers.
        self._starts = [
            [(list(free).index(name), k) for k, name in enumerate(names) if name in free] for names in states
        ]
        self._arguments = [k for k, name in enumerate(free) if name in self.equations.free]
        plants = {p.name: p.results for p in loop.plants}
        #: Columns of the outputs of plants.
        self._outputs = [
            self.positions[f"{i.name}.{r.name}"] for i in loop.instances for r in plants.get(i.controller, ())
        ]

    def __repr__(self) -> str:
        return printable(f"Experiment({self.loop.name}; {self.samples:,} samples, {self.backend})")

    @cached_property
    def times(self) -> FloatArray:
        """Times of the samples, shape (samples,) [s]."""
        return np.arange(self.samples, dtype=np.float64) * self.step

    @cached_property
    def given(self) -> FloatArray:
        """Noise and tables, known before a run, shape (samples, columns)."""
        return self._columns(None)

    def _columns(self, seed: int | None) -> FloatArray:
        return columns(self.equations.given.values(), self.times, Path(self.loop.path).parent, seed)

    @cached_property
    def _kernel(self) -> Callable[..., int]:
        if self.backend == "numba":
            try:
                return compiled(self.equations, self.programs)
            except RecursionError:
                message = f"loop '{self.loop.name}' has too many branches for numba"
                raise ArgumentError(f"{message}: take backend 'python', or 'auto', which chooses it") from None
        text, tables = printed(self.equations, self.programs)
        if self._isolated:
            from fuzzyctl.simulation.fmu_process import IsolatedKernel

            return IsolatedKernel(text, tables, self._externals, len(self.positions))
        return interpreted(text, tables, self.external_plants)

    @property
    def _externals(self) -> list[External]:
        params = {i.name: block_params(self.loop, i) for i in self.loop.instances}
        return [(e.plant, e.block, e.span, params[e.block]) for e in self.equations.externals]

    @cached_property
    def external_plants(self) -> list[PythonPlant | FmuPlant]:
        """The plants in Python, and FMUs, in this process; their code is executed."""
        return [external_plant(*e) for e in self._externals]

    @cached_property
    def _isolated(self) -> bool:
        """Whether runs take another process, as those of FMUs do; functions of the caller exist in this one only."""
        plants = [e.plant for e in self.equations.externals]
        can_start = os.name == "posix" and sys.executable and not getattr(sys, "frozen", False)
        return bool(can_start) and any(p.fmu for p in plants) and not any(p.calls for p in plants)

    def run(
        self, values: Any = None, *, substeps: int = 1, progress: Progress | None = None, seed: int | None = None
    ) -> Run:
        """Simulate the loop.

        Args:
            values: Those of the free numbers in order, shape (free,); None for the values of the file.
            substeps: Steps of integration between two samples; more where a dead time is shorter than one.
            progress: Called now and then in a long run.
            seed: Draws each noise anew, from this and the seed of the noise; None for the draws of the file.

        Returns:
            The run; one that was stopped, or interrupted, has the data up to there and says why.

        Raises:
            ArgumentError: For another number of values, a number of substeps that is not a positive integer, and a seed
                that is negative or no integer.
            ValueOutOfBoundsError: For a value that is not finite, or outside the range of its param.
        """
        lags = self._dead_times(substeps)
        if seed is not None and not (type(seed) is int and seed >= 0):
            raise ArgumentError(f"'seed' must be an integer >= 0, got {seed!r}")
        columns = self.given if seed is None else self._columns(seed)
        free = self._values(values)
        record = np.empty((self.samples, len(self.positions)))
        done, stopped = self._advance(record, free, columns, lags, progress)
        if self._isolated:
            kernel: Any = self._kernel
            try:
                freed = kernel.free()
            except KeyboardInterrupt:
                freed = interrupted(self.loop, done * self.step)
            stopped = stopped or freed
        return self.result(record[:done], free, lags.steps, stopped)

    def result(
        self, record: FloatArray, free: FloatArray, substeps: int, stopped: Diagnostic | None, solver: str = "RK4"
    ) -> Run:
        """Return a run of its record, shape (samples, signals), and of the values of the free params, shape (free,)."""
        params = dict(zip(self.nominal, free.tolist(), strict=True))
        names = tuple(s.name for s in self.equations.plant_states)
        broken = first_without_value(record, self._outputs)
        if broken is not None:
            k, column = broken
            stopped = without_value(self.loop, list(self.positions)[column], self.positions, record[k], k * self.step)
            record = record[:k]
        t = self.times[: len(record)]
        return Run(self.loop, t, record, self.positions, self.judgement, names, params, substeps, stopped, solver)

    def _values(self, values: Any) -> FloatArray:
        vector = np.array(list(self.nominal.values())) if values is None else float_array(values, "values")
        if vector.shape != (len(self.nominal),):
            names = ", ".join(self.nominal) or "none"
            raise ArgumentError(f"expected {len(self.nominal)} values ({names}), got the shape {vector.shape}")
        numbers = vector.tolist()
        if not self._ranges.surely_hold(numbers):
            self._ranges.require(numbers)
        return writable(vector)

    def _advance(
        self, record: FloatArray, free: FloatArray, given: FloatArray, lags: DeadTimes, progress: Progress | None
    ) -> tuple[int, Diagnostic | None]:
        """Fill the record and return how many samples it has, and why the run was stopped."""
        substeps = lags.steps
        chunk = max((CHUNK if self.backend == "numba" else FEW) // substeps, 1)
        kernel: Any = self._kernel
        if self._isolated:
            kernel.start()
        elif self.equations.externals:
            chunk = 1  # so that all samples before a mistake are kept
        x, c, columns, buffers = self._state(given, lags)
        for state, starts in zip((x, c), self._starts, strict=True):
            for position, k in starts:
                state[k] = float(free[position])
        free = free[self._arguments]
        done = 0
        try:
            while done < self.samples:
                count = min(chunk, self.samples - done)
                part = record[done : done + count].reshape(-1)
                target: Any = part if self.backend == "numba" or self._isolated else [0.0] * len(part)
                code = kernel(done, count, self.samples, substeps, self.step, x, c, free, columns, target, *buffers)
                if target is not part:
                    part[:] = target
                if code >= 0:
                    return self._stopped(code, x, record)
                done = kernel.done if self._isolated else done + count
                if progress is not None:
                    progress(done, self.samples)
        except DiagnosticError as error:  # of a plant in Python, or an FMU
            return kernel.done if self._isolated else done, error.diagnostics[0]
        except KeyboardInterrupt:
            done = kernel.done if self._isolated else done
            return done, interrupted(self.loop, done * self.step)
        return done, None

    def _dead_times(self, substeps: int) -> DeadTimes:
        """Return the steps of integration and the lags of dead times, computed once."""
        if substeps not in self._lags:
            self._lags[substeps] = dead_times(self.equations, substeps)
        return self._lags[substeps]

    def _state(self, given: FloatArray, lags: DeadTimes) -> tuple[Any, Any, Any, tuple[Any, Any, Any]]:
        """Return the start of a run: arrays, or lists for generated Python."""
        equations = self.equations
        x = np.array([s.start for s in equations.plant_states], dtype=np.float64)
        c = np.array([s.start for s in equations.states] * 2, dtype=np.float64)
        if self.backend == "numba":
            integers, weights = np.array(lags.integers, dtype=np.int64), np.array(lags.weights, dtype=np.float64)
            return x, c, given.reshape(-1), (np.zeros(lags.size), integers, weights)
        buffers = ([0.0] * lags.size, lags.integers, lags.weights)
        return x.tolist(), c.tolist(), given.reshape(-1).tolist(), buffers

    def _stopped(self, code: int, x: Any, record: FloatArray) -> tuple[int, Diagnostic]:
        states = self.equations.plant_states
        outputs = refused(self.programs)
        sample, kind = divmod(code, max(len(states) + len(outputs), 1))
        if kind >= len(states):
            message = f"no rule fires for output '{outputs[kind - len(states)]}' at t = {sample * self.step:.6g} s"
            help_text = "add rules, or an 'else' to the output"
            return sample, Diagnostic("FZ701", message, self.loop.span, help=help_text)
        time, memory = sample * self.step, self.equations.states
        return sample, left(states[kind], float(x[kind]), time, self.loop, self.positions, record[:sample], memory)


@final
class Stepper:
    """A run of a loop sample by sample, with values of its free params that are held from one sample to the next.

    Args:
        experiment: The loop; without plants in Python the same machine code, or generated Python, computes `run`.
        substeps: Steps of integration between two samples.
        seed: As for `Experiment.run`.
        start: Values of states of plants at the begin, by name; others start as the file says.

    Attributes:
        sample: The number of the present sample; the last one is `experiment.samples - 1`.

    Raises:
        UnknownNameError: For a name of no state.
    """

    def __init__(
        self,
        experiment: Experiment,
        substeps: int = 1,
        seed: int | None = None,
        start: Mapping[str, float] | None = None,
    ) -> None:
        self.experiment, self.sample = experiment, 0
        lags = experiment._dead_times(substeps)
        self._substeps = lags.steps
        columns = experiment.given if seed is None else experiment._columns(seed)
        self._x, self._c, self._given, self._lags = experiment._state(columns, lags)
        self._before = np.zeros(len(experiment.positions))
        names = [s.name for s in experiment.equations.plant_states]
        for name, value in (start or {}).items():
            if name not in names:
                raise UnknownNameError("state", name, names)
            self._x[names.index(name)] = value

    def look(self, values: Any) -> FloatArray | Diagnostic:
        """Return the signals at the present sample, shape (signals,), without going on.

        Args:
            values: Those of the free numbers in order, shape (free,); starts come with `start`.

        Returns:
            The signals; a diagnostic if a state has left its range, or a plant in Python cannot be used.
        """
        return self._made(values, self._x.copy(), self._c.copy(), self.sample + 1)

    def advance(self, values: Any) -> FloatArray | Diagnostic:
        """Do the same, and go on to the next sample."""
        signals = self._made(values, self._x, self._c, self.sample + 2)
        self.sample += 1
        return signals

    def _made(self, values: Any, x: Any, c: Any, total: int) -> FloatArray | Diagnostic:
        experiment, k = self.experiment, self.sample
        free, width = experiment._values(values)[experiment._arguments], len(experiment.positions)
        record: Any = np.empty(width) if experiment.backend == "numba" else [0.0] * width
        try:
            code = experiment._kernel(
                k, 1, total, self._substeps, experiment.step, x, c, free, self._given, record, *self._lags
            )
        except DiagnosticError as error:  # of a plant in Python
            return error.diagnostics[0]
        if code >= 0:
            past = np.zeros((k, width))
            past[-1:] = self._before
            return experiment._stopped(code, x, past)[1]
        signals = np.asarray(record)
        if total == k + 2:
            self._before = signals
        return signals


def _backend(name: str, loop: Loop) -> str:
    """Return the backend of runs: numba if it can be imported; generated Python for plants in Python and FMUs."""
    if name not in BACKENDS:
        raise UnknownNameError("backend", name, BACKENDS)
    called = next((p for p in loop.plants if p.external), None)
    if called is not None and name != "numba":
        return "python"
    if called is not None:
        what = "in Python" if called.python else "an FMU"
        raise ArgumentError(f"plant '{called.name}' is {what}, and called by generated Python: backend 'python'")
    missing = numba_is_missing() if name != "python" else None
    if name == "numba" and missing is not None:
        raise BackendUnavailableError(name, missing)
    return "python" if name == "python" or missing is not None else "numba"


def _takes_long(equations: LoopEquations, programs: LoopPrograms) -> bool:
    """Return whether numba takes so long over a loop that "auto" leaves it alone."""
    count = operations(programs.sample) + operations(programs.derivative)
    choices = branches(programs.sample) + branches(programs.derivative) + len(equations.plant_states)
    return len(equations.states) > MOST_STATES or count > MOST_OPERATIONS or choices > MOST_BRANCHES
