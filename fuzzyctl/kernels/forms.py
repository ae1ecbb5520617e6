"""Forms: names and programs of a kernel for each kind of block, and the refusals that it promises."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, FuzzyctlError, NoRuleFiresError, UnknownNameError
from fuzzyctl.expr import Expr, Name, names_in, replace_names
from fuzzyctl.kernels.algorithms.select import Algorithm, algorithm_of
from fuzzyctl.kernels.backends.arguments import NO_STATE, point_array, row_array, state_argument
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import CallPlan, Plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.program.scalar import point_text, scalar_function

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from fuzzyctl.model.system import FuzzySystem

    FloatArray = npt.NDArray[np.float64]

#: Why a kernel has no plan.
NO_RULES: Final = "a controller has no rules of its own; compile the systems that it calls"


class Form:
    """Names and programs of a kernel.

    Args:
        input_names: Of the inputs.
        output_names: Of the outputs.
        state_names: Of the entries of the state; free numbers are the last ones.
        free_names: Of the free numbers.
    """

    #: Whether its program gives the next state after the outputs.
    moves: ClassVar[bool] = False
    #: Whether each step depends on a time that the caller gives.
    needs_time: bool = False
    #: The sample time [s] of a block that moves, None where each step takes `dt`.
    period: float | None = None
    #: How it finds the rules that act; None for a block without rules of its own.
    algorithm: Algorithm | None = None
    #: Promises of its outputs; None if their programs refuse.
    promises: Promises | None = None

    def __init__(
        self,
        input_names: Sequence[str],
        output_names: Sequence[str],
        state_names: Sequence[str],
        free_names: Sequence[str] = (),
    ) -> None:
        self.input_names, self.output_names = tuple(input_names), tuple(output_names)
        self.state_names, self.free_names = tuple(state_names), tuple(free_names)
        #: Of the arguments of its programs.
        self.argument_names = self.input_names
        self.n_states = len(self.state_names)
        #: How many numbers its programs give.
        self.width = len(self.output_names) + (self.n_states if self.moves else 0)

    @property
    def plan(self) -> Plan:
        """The rules.

        Raises:
            FuzzyctlError: For a block without rules of its own.
        """
        raise FuzzyctlError(NO_RULES)

    def point(self, backend: str) -> Program:
        """Return the program for one point."""
        raise NotImplementedError

    def many(self, backend: str) -> Program:
        """Return the program for many points."""
        return self.point(backend)

    def view(self, what: str) -> Program:
        """Return the program of the "degrees" or the "activations" of the rules."""
        write = {"degrees": inference.degrees, "activations": inference.activations}
        return write[what](self.plan)

    def named(self) -> tuple[Program, tuple[str, ...]]:
        """Return the program of all rules with the state as its last arguments, and their names."""
        raise NotImplementedError

    def start(self, changed: Mapping[str, Any]) -> Sequence[float] | FloatArray:
        """Return the state to begin with, with some free numbers changed."""
        for name in changed:
            raise UnknownNameError("free number", name, self.free_names)
        return self._start()

    def _start(self) -> Sequence[float]:
        raise NotImplementedError

    @property
    def free_bounds(self) -> Sequence[tuple[float, float]]:
        """The ends of the range of each free number."""
        return ()

    def argument(self, state: Any, *, compiled: bool) -> Any:
        """Return the state at one point as the function of a backend takes it."""
        return state_argument(state, self.state_names, compiled=compiled)

    def rows(self, state: Any) -> FloatArray | None:
        """Return states of shape (..., states), those to begin with for None; None for a block without state.

        Raises:
            ArgumentError: For an array of another shape.
        """
        import numpy as np

        if state is None:
            return np.array(self._start(), dtype=np.float64) if self.n_states else None
        if not self.n_states and not self.moves:
            if np.size(state):
                raise ArgumentError(f"{NO_STATE}, so it takes none")
            return None
        array = row_array(self.state_names, state, "states")
        if array.ndim == 0 or array.shape[-1] != self.n_states:
            raise ArgumentError(f"the state must have the shape (..., {self.n_states}), got {array.shape}")
        return array if self.n_states else None

    def times(self, dt: Any) -> list[float]:
        """Return the time of one step as an argument of the programs, or no argument."""
        return []

    def points(self, points: Any, dt: Any, *, in_rows: bool = False) -> Any:
        """Return points of shape (..., arguments), from points of shape (..., inputs) and times.

        Args:
            points: For one input also without the last axis; or columns by name.
            dt: Times since the step before [s], for a block that takes them.
            in_rows: Whether there must be one axis of points.

        Raises:
            ArgumentError: For an array of another shape.
        """
        array = point_array(self.input_names, points)
        width = len(self.input_names)
        if in_rows and width == 1 and array.ndim == 1:
            array = array.reshape(-1, 1)
        if in_rows and array.ndim != 2:
            wanted = f"(n, {width}) for {', '.join(self.input_names)}"
            raise ArgumentError(f"points must have the shape {wanted}, got {array.shape}")
        whole = self.with_times(array, dt)
        if in_rows and whole.shape[:-1] != array.shape[:-1]:
            raise ArgumentError(f"'dt' must be one number or have the shape {array.shape[:-1]}")
        return whole

    def with_times(self, points: Any, dt: Any) -> Any:
        """Return points with the times of the steps as a last column, for a block that takes them."""
        if dt is not None:
            raise ArgumentError("a system has no time, so that 'dt' is not given")
        return points


class SystemForm(Form):
    """A system: rules that give the outputs.

    Args:
        plan: The plan of the system.
        wanted: One of `select.ALGORITHMS`.

    Raises:
        UnknownNameError: For another algorithm.
        ArgumentError: For an algorithm that the system does not allow.
    """

    def __init__(self, plan: Plan, wanted: str = "auto") -> None:
        consequents = [f"{plan.outputs[o].name}[{k + 1}]" for o, k in plan.states]
        holding = [plan.outputs[o].name for o in plan.held]
        super().__init__([i.name for i in plan.inputs], [o.name for o in plan.outputs], consequents + holding)
        self._plan, self._wanted = plan, wanted
        self.algorithm: Algorithm = algorithm_of(plan, wanted)
        self.promises = Promises(plan, known=self.algorithm.is_defined)

    def __reduce__(self) -> tuple[Any, ...]:
        return SystemForm, (self._plan, self._wanted)

    @property
    def plan(self) -> Plan:
        """The rules."""
        return self._plan

    def point(self, backend: str) -> Program:
        """Return the program for one point."""
        return self.algorithm.point if backend == "numba" else self.algorithm.interpreted

    def many(self, backend: str) -> Program:
        """Return the program for many points."""
        return self.algorithm.arrays if backend == "numpy" else self.algorithm.many

    def named(self) -> tuple[Program, tuple[str, ...]]:
        """Return the program of all rules with the state as its last arguments, and their names."""
        from fuzzyctl.kernels.free_values import with_named_state

        return with_named_state(inference.evaluation(self._plan))

    def _start(self) -> Sequence[float]:
        return self._plan.initial_state


class FreeForm(Form):
    """A system some of whose numbers are free: they are its state, which does not move.

    Args:
        system: A well-formed system without state.
        names: Of the free numbers, see `model.free_numbers`.

    Raises:
        UnknownNameError: For a name that the system does not have.
        ArgumentError: For a name given twice, a number that must be known beforehand, and a system with a state.
    """

    def __init__(self, system: FuzzySystem, names: Sequence[str]) -> None:
        from fuzzyctl.kernels.free_values import FreeValues
        from fuzzyctl.kernels.plan.free import free_plan

        self._origin = system, tuple(names)
        self._free = free = free_plan(system, names)
        if free.plan.initial_state:
            raise ArgumentError("a system with adaptive outputs, or outputs that say 'else hold', has no free numbers")
        outputs = [o.name for o in free.plan.outputs]
        super().__init__([i.name for i in free.plan.inputs], outputs, free.names, free.names)
        self.algorithm = Algorithm(free.plan, None, "it takes free numbers")
        self.promises = Promises(free.plan, known=False)
        self._values = FreeValues(free)
        self._evaluation = self._over_values(inference.evaluation)

    def __reduce__(self) -> tuple[Any, ...]:
        return FreeForm, self._origin

    @property
    def plan(self) -> Plan:
        """The rules; their numbers are traced where they depend on free ones."""
        return self._free.plan

    def point(self, backend: str) -> Program:
        """Return the program for one point."""
        return self._evaluation

    def view(self, what: str) -> Program:
        """Return the program of the degrees or the activations."""
        return self._over_values(lambda _: super(FreeForm, self).view(what))

    def named(self) -> tuple[Program, tuple[str, ...]]:
        """Return the program of all rules with the state as its last arguments, and their names."""
        from fuzzyctl.kernels.free_values import free_program

        return free_program(self._free), tuple(a.name for a in self._free.trace.arguments)

    def start(self, changed: Mapping[str, Any]) -> FloatArray:
        """Return the values of the free numbers, some of them changed."""
        return self._values.of(changed)

    @property
    def free_bounds(self) -> Sequence[tuple[float, float]]:
        """The ends of the range of each free number."""
        return self._values.bounds

    def _start(self) -> Sequence[float]:
        return self._free.values

    def argument(self, state: Any, *, compiled: bool) -> Any:
        """Return the values of the free numbers, checked, as the function of a backend takes them."""
        return super().argument(self._values.of(state), compiled=compiled)

    def rows(self, state: Any) -> FloatArray:
        """Return values of the free numbers, checked, shape (..., free)."""
        return self._values.of({} if state is None else state)

    def _over_values(self, write: Callable[[Plan], Program]) -> Program:
        from fuzzyctl.kernels.free_values import free_program, with_values_as_array

        names = [a.name for a in self._free.trace.arguments]
        return with_values_as_array(free_program(self._free, write), names)


class Refusals:
    """Points that a program refuses, as exceptions that name the output and the point.

    Args:
        program: The program.
        names: Of its arguments.
    """

    def __init__(self, program: Program, names: Sequence[str]) -> None:
        refusals = [s for s in program.body if isinstance(s, Refuse)]
        self._outputs = {s.message: s.output for s in refusals}
        self._kinds, self._names = [s.output for s in refusals], tuple(names)

    def translated(self, error: ArithmeticError, point: Sequence[Any]) -> ArithmeticError:
        """Return the exception for an error of compiled code at a point; another error is returned unchanged."""
        output = self._outputs.get(str(error))
        return error if output is None else NoRuleFiresError(output, point_text(self._names, point))

    def place(self, code: int) -> tuple[int, str]:
        """Return the index of the point and the output of the code that a compiled loop returned for a refusal."""
        point, kind = divmod(code, len(self._kinds))
        return point, self._kinds[kind]


class Promises:
    """The promises of the outputs of a system.

    Args:
        plan: The system.
        known: Whether it is known beforehand that all of them are kept.
    """

    def __init__(self, plan: Plan, *, known: bool) -> None:
        self._plan = plan
        self._outputs = () if known else tuple(k for k, o in enumerate(plan.outputs) if o.otherwise is None)

    def check(self, arguments: Sequence[Any], result: float | tuple[float, ...]) -> None:
        """Check the result of one point.

        Args:
            arguments: The inputs, and the state if there is one.
            result: Result of the function.

        Raises:
            NoRuleFiresError: Where an output without `else` is NaN though nothing that it reads is.
        """
        plan = self._plan
        values = result if isinstance(result, tuple) else (result,)
        point = [float(a) for a in arguments[: len(plan.inputs)]]
        # What is held may be NaN at first: an output that reads it is NaN, too, and others promise what they promised.
        consequents = arguments[-1] if plan.states and len(arguments) > len(point) else ()
        if any(x != x for x in point) or any(c != c for c in consequents) or self._lacks_let(point):
            return
        for k in self._outputs:
            if values[k] != values[k] and all(values[r] == values[r] for r in plan.outputs[k].reads):
                raise NoRuleFiresError(plan.outputs[k].name, self.text_of(point))

    def check_block(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Check the results of many points; the first one that breaks a promise is named.

        Args:
            points: Shape (n, inputs).
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs).

        Raises:
            NoRuleFiresError: As `check` does.
        """
        import numpy as np

        # The least number is NaN if any is, and takes no memory; only then is it worth looking closer.
        if not self._outputs or not np.isnan(np.min(results, initial=np.inf)):
            return
        missing, bad = np.isnan(results), np.zeros(len(points), dtype=bool)
        for k in self._outputs:
            bad |= missing[:, k] & ~missing[:, list(self._plan.outputs[k].reads)].any(axis=1)
        bad &= ~np.isnan(points).any(axis=1)
        if states is not None:
            bad &= ~np.isnan(states[:, : len(self._plan.states)]).any(axis=1)
        for row in np.flatnonzero(bad):
            self.check(points[row].tolist(), tuple(results[row].tolist()))

    def check_run(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        """Check the results of points along time, from the state before the first one, if no block of them was."""

    def _lacks_let(self, point: Sequence[float]) -> bool:
        """Return whether a let has no value at a point, so that no output has one."""
        values = known_at(self._plan, point) if self._plan.lets else {}
        return any(values[let.name] != values[let.name] for let in self._plan.lets)

    def text_of(self, point: Sequence[float]) -> str:
        """Return a point for people."""
        return point_text([i.name for i in self._plan.inputs], point)


def known_at(plan: Plan, point: Sequence[float]) -> dict[str, float]:
    """Return the inputs as consequents see them, and the lets, by name."""
    values = {
        i.name: x if i.extrapolate else min(max(x, i.lower), i.upper) for i, x in zip(plan.inputs, point, strict=True)
    }
    for let in plan.lets:
        for call in let.calls:
            values[call.name] = _called(call, [value_of(a, values) for a in call.arguments])
        values[let.name] = value_of(let.value, values)
    return values


def value_of(expr: Expr, values: Mapping[str, float]) -> float:
    """Return the value of an expression over known names."""
    names = list(dict.fromkeys(n.name for n in names_in(expr)))
    # Names of calls are not Python names.
    places = {name: f"x{k}" for k, name in enumerate(names)}
    function = scalar_function(replace_names(expr, {n: Name(place) for n, place in places.items()}))
    return float(function(**{places[n]: values[n] for n in names}))


def _called(call: CallPlan, arguments: Sequence[float]) -> float:
    """Return an output of another system, NaN where it has none."""
    names = [i.name for i in call.system.inputs]
    program = inference.evaluation(call.system)
    function = scalar.compile_source(scalar.evaluation_source(program), program, names)
    try:
        outputs = function(*arguments)
    except NoRuleFiresError:
        return math.nan
    return float(outputs[call.output] if isinstance(outputs, tuple) else outputs)
