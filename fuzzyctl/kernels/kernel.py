"""The kernel: a form printed for a backend, with calls, batches and derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, FuzzyctlError, UnknownNameError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.kernels.backends.arguments import (
    NO_STATE,
    argument_error,
    as_floats,
    float_array,
    in_order,
    input_number,
    labelled,
    overflows,
    require_same_index,
    state_after,
    too_large,
)
from fuzzyctl.kernels.forms import NO_RULES, Form, Refusals
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.operations import Displayed
from fuzzyctl.support.arguments import InputSignature

if TYPE_CHECKING:
    from fuzzyctl.annotations import By, FloatArray, Frames, Numbers, Outputs, Points, Scalar, State, Vector
    from fuzzyctl.kernels.algorithms.select import Algorithm
    from fuzzyctl.kernels.backends.blocks import Fill
    from fuzzyctl.kernels.batch import Arrays

_BACKENDS: Final = ("numba", "numpy", "python")
#: Exceptions of a function for bad arguments, and if no rule fires.
_REFUSALS: Final = (TypeError, ValueError, ArithmeticError)
#: What `gradient` takes derivatives by.
_BY: Final = ("inputs", "state", "all")


class Kernel(Displayed):
    """A compiled block: numbers in, numbers out, and no state of its own.

    `kernel(x0, x1, ...)` takes real numbers in the order of the inputs and gives a float, or a tuple for several
    outputs. A block with a state takes it last: the state is the caller's, and `start` gives the one to begin with.

    The state of a system holds the consequents of adaptive outputs, one for each of their rules, then the previous
    values of outputs that say `else hold`, in the order they are computed in; `next_state` puts the outputs of a call
    into it, `run` does so along time, and `jit_rates` tells how the consequents change. Free numbers are the state of a
    system that has them, as an array or a mapping by name.

    The kernel of a controller moves: a call makes a step, and gives the outputs and the next state. A controller
    without period takes `dt=` [s] as well. Free numbers are the last entries of its state. Without any state it can be
    called with its inputs alone, and gives the outputs.

    A state may also be a mapping by name, or a Series of pandas.

    Where an input is NaN all outputs are NaN, and a state stays as it is. Where no rule fires an output is what its
    `else` says; one without `else` promises that this never happens. Where it happens all the same, calls from Python
    raise `NoRuleFiresError`, and `jit`, which has no room for the test, gives NaN: check such a system before
    (`fuzzyctl.check` proves the promise).

    Args:
        form: Its names and programs.
        backend: "numba", "numpy" or "python".

    Raises:
        UnknownNameError: For another backend.
    """

    # The attributes that each call reads have slots, which are faster than entries of the dictionary.
    __slots__ = ("__dict__", "__weakref__", "_function", "_is_single")

    __signature__ = InputSignature(
        lambda kernel: kernel._argument_names(),
        named=lambda kernel: [DT] if kernel.form.moves and kernel.period is None else [],
    )

    def __init__(self, form: Form, backend: str) -> None:
        if backend not in _BACKENDS:
            raise UnknownNameError("backend", backend, _BACKENDS)
        self.form, self.backend = form, backend
        self.input_names, self.output_names = form.input_names, form.output_names
        self.state_names, self.free_names = form.state_names, form.free_names
        self.n_states, self.period = form.n_states, form.period
        self._program = form.point(backend)
        self._refusals = Refusals(self._program, form.argument_names)
        self._n_arguments = len(self._argument_names())
        #: The function behind calls from Python.
        self._function: Callable[..., Outputs] = self._first_call if backend == "numba" else self.jit
        #: Whether a result that equals itself can be returned as it is, since it is one number.
        self._is_single = not self.n_states and not form.moves and len(form.output_names) == 1

    def __reduce__(self) -> tuple[Any, ...]:
        """A kernel in another process is made anew there, from the cache where it can be."""
        return Kernel, (self.form, self.backend)

    def __repr__(self) -> str:
        free = f"{len(self.free_names)} free; " if self.free_names else ""
        names = f"{', '.join(self.input_names)} -> {', '.join(self.output_names)}"
        return printable(f"Kernel({names}; {free}{self.backend})")

    @property
    def plan(self) -> Plan:
        """The rules.

        Raises:
            FuzzyctlError: For a controller.
        """
        return self.form.plan

    @property
    def n_rules(self) -> int:
        """How many rules there are."""
        return len(self.plan.rules)

    @property
    def algorithm(self) -> Algorithm:
        """How the rules that act are found.

        Raises:
            FuzzyctlError: For a controller.
        """
        if self.form.algorithm is None:
            raise FuzzyctlError(NO_RULES)
        return self.form.algorithm

    def __call__(self, *arguments: Scalar | State, **named: Scalar | State | None) -> Any:
        """Evaluate at one point, or make one step.

        Args:
            arguments: The inputs in order, then the state of a block that has one, shape (states,).
            named: The same by name, which takes longer; the state is called `state`. And `dt` [s], the time since the
                step before, for a controller without period.

        Returns:
            The outputs, a float or a tuple of floats; of a controller a pair of them and the next state, shape
            (states,).

        Raises:
            ArgumentError: For a wrong number of arguments, one given twice, or one that is not a real number.
            UnknownNameError: For a name that is not an input.
            ValueOutOfBoundsError: For values of free numbers outside their bounds or that the system cannot have, a
                `dt` that is not positive and finite, and numbers beyond floats.
            NoRuleFiresError: Where no rule fires for an output that says `else error` or has no `else`.
        """
        if self._is_single and not named:
            try:
                result = self._function(*arguments)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._step(arguments, named) if self.form.moves else self._careful(arguments, named)

    def _first_call(self, *arguments: Any) -> Outputs:
        """Compile the function and call it."""
        self._function = function = self.jit
        result: Outputs = function(*arguments)
        return result

    def _careful(self, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> Outputs:
        if named:
            arguments = in_order(self._argument_names(), arguments, named)
        if self.n_states and len(arguments) == self._n_arguments:  # the function itself refuses another number
            state = self.form.argument(arguments[-1], compiled=self.backend == "numba")
            arguments = (*arguments[:-1], state)
        try:
            try:
                result = self._function(*arguments)
            except (TypeError, ValueError, OverflowError):
                # Compiled code takes fewer types of numbers than there are; it never comes here with floats.
                result = self._function(*as_floats(arguments, len(self.input_names), self._n_arguments))
            if (result != result or len(self.output_names) > 1) and self.form.promises is not None:
                self.form.promises.check(arguments, result)
            return result
        except OverflowError:
            raise too_large(self.input_names, arguments) from None
        except ArithmeticError as error:
            raise self._refusals.translated(error, arguments[: len(self.input_names)]) from None
        except (TypeError, ValueError) as error:
            # Compiled code refuses integers beyond 64 bits in its own words.
            if len(arguments) == self._n_arguments and any(overflows(a) for a in arguments):
                raise too_large(self.input_names, arguments) from None
            raise argument_error(self._argument_names(), self.n_states, arguments, error) from error

    def _step(self, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        import numpy as np

        dt, inputs = named.pop(DT, None), len(self.input_names)
        if named:
            has_state = self.n_states or "state" in named
            arguments = in_order((*self.input_names, "state") if has_state else self.input_names, arguments, named)
        is_short = not self.n_states and len(arguments) == inputs
        if len(arguments) != inputs + 1 and not is_short:
            names = ", ".join((*self.input_names, "state"))
            raise ArgumentError(f"expected {inputs + 1} arguments ({names}), got {len(arguments)}")
        numbers = zip(self.input_names, arguments, strict=False)
        point = [x if type(x) is float else input_number(name, x) for name, x in numbers] + self.form.times(dt)
        before = [] if is_short else self.form.argument(arguments[-1], compiled=self.backend == "numba")
        results = np.empty(self.form.width)
        try:
            self._function(*point, *([before] if self.n_states else []), results)
        except ArithmeticError as error:
            raise self._refusals.translated(error, point) from None
        values = results[: len(self.output_names)].tolist()
        if self.form.promises is not None and any(x != x for x in values):
            self.form.promises.check_block(np.array([point]), np.array([before]), results[np.newaxis])
        outputs = values[0] if len(values) == 1 else tuple(values)
        return outputs if is_short else (outputs, results[len(self.output_names) :])

    def start(self, values: Mapping[str, Numbers] | None = None, /, **named: Numbers) -> FloatArray:
        """Return the state to begin with, shape (states,).

        It holds the peak of the term of each adaptive rule, what is held at first, the start of each state of a
        controller, and the free numbers.

        Args:
            values: Values of free numbers by name; the others are those of the block. `OUTPUT.weights` stands for all
                of them, one number or an array.
            named: The same for names that Python can write.

        Raises:
            UnknownNameError: For a name that is not free.
            ValueOutOfBoundsError: For values outside the bounds of their params, or that a system cannot have.
            ArgumentError: For values under which a param or a let has no value, such as a division by 0.
        """
        import numpy as np

        return np.array(self.form.start({**(values or {}), **named}), dtype=np.float64)

    @property
    def free_bounds(self) -> FloatArray:
        """The least and the largest value of each free number, shape (free, 2), as its param declares them.

        Other numbers have no range: they are infinite here.
        """
        import numpy as np

        return np.array(self.form.free_bounds, dtype=np.float64).reshape(len(self.free_names), 2)

    def batch(
        self,
        points: Points | Frames,
        state: State | Frames | None = None,
        *,
        dt: Numbers | None = None,
        out: FloatArray | None = None,
        parallel: bool = True,
    ) -> Any:
        """Evaluate at many points, or make one step of many copies of a controller.

        Args:
            points: Shape (..., inputs), in the order of the inputs, for one input also without that axis; or what has
                named columns, such as a data frame, a structured array or a dict of arrays, or what has labels along
                its last axis, such as a DataArray of xarray. The names must be exactly those of the inputs, in any
                order.
            state: The state, shape (..., states), which broadcasts with the points: for each its own, or of shape
                (states,) the same for all. None for that of `start`.
            dt: Time since the step before [s], for a controller without period; one number, or an array that broadcasts
                with the points.
            out: A contiguous array of float64 to write to, of the shape of all results, the next states of a controller
                after its outputs; None for a new one.
            parallel: Whether all cores may be used; they are where the work is worth it.

        Returns:
            Shape (...) for one output, (..., outputs) for several; of a controller a pair of them and the next states,
            shape (..., states). Of a data frame of pandas, or a dict of Series, the results are a Series, for several
            outputs a DataFrame, with the same index, unless `out` is given; next states have the index of the states.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers, columns of other names, and points and states
                with different row labels.
            ValueOutOfBoundsError: As for one point.
            NoRuleFiresError: For the first point where no rule fires for an output that says `else error` or has no
                `else`.
        """
        from fuzzyctl.kernels.batch import evaluated

        array, rows = self._given(points, state, dt)
        compiled = self.backend == "numba"
        results = evaluated(self.form, self._checked, array, rows, out, compiled=compiled, parallel=parallel)
        outputs = len(self.output_names)
        if not self.form.moves:
            return results if out is not None else labelled(results, self.output_names, points)
        shape = results.shape if self.form.width == 1 else results.shape[:-1]
        results = results.reshape(*shape, self.form.width)
        first = results[..., 0] if outputs == 1 else results[..., :outputs]
        return labelled(first, self.output_names, points), labelled(results[..., outputs:], self.state_names, state)

    def _given(self, points: Any, state: Any, dt: Any) -> tuple[Any, FloatArray | None]:
        """Return points of shape (..., arguments) and states of shape (..., states)."""
        rows = None if getattr(state, "ndim", 0) == 1 else state  # the labels of one state are names
        require_same_index(("points", "state", DT), (points, rows, dt))
        return self.form.points(points, dt), self.form.rows(state)

    @cached_property
    def _fill(self) -> Fill:
        """Fill the results of a block of points."""
        from fuzzyctl.kernels.batch import fill_by_calls, fill_of

        if self.backend == "python" and not self.form.moves:
            return fill_by_calls(self.jit)
        return fill_of(self.form.many(self.backend), self.backend, self.form.argument_names, self.form.promises)

    @property
    def _checked(self) -> Fill:
        """Fill the results of a block of points, and check the promises of the outputs."""
        fill, promises = self._fill, self.form.promises
        if promises is None:
            return fill

        def checked(points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
            fill(points, states, results)
            promises.check_block(points, states, results)

        return checked

    def run(
        self, points: Points | Frames, state: State | None = None, *, dt: Numbers | None = None
    ) -> tuple[Any, FloatArray]:
        """Evaluate along time: for each row of the points, with the state that the row before left.

        Args:
            points: Shape (n, inputs), for one input also (n,); or columns by name, as `batch` takes them.
            state: The state before the first row, shape (states,); None for that of `start`. Adaptive consequents stay
                as they are; an output that says `else hold` holds the last value before that is not NaN.
            dt: Times since the step before [s], one number or shape (n,), for a controller without period.

        Returns:
            The outputs, shape (n,) for one, (n, outputs) for several, of pandas with the index of the points, and the
            state after the last row.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers.
            ValueOutOfBoundsError: As for one point.
            NoRuleFiresError: At the first row where no rule fires for an output that says `else error` or has no
                `else`.
        """
        import numpy as np

        array = np.ascontiguousarray(float_array(self.form.points(points, dt, in_rows=True), "points"))
        rows = self.form.rows(state)
        state_array = np.zeros(0) if rows is None else rows.copy()
        if state_array.ndim != 1:
            raise ArgumentError(f"the state must have the shape ({self.n_states},), got {state_array.shape}")
        if self.form.moves or self.plan.held:
            results = np.empty((len(array), len(self.output_names)))
            first = state_array.copy()
            self._run(array, state_array, results)
            if self.form.promises is not None:
                self.form.promises.check_run(array, first, results)
            outputs = results[:, 0] if results.shape[1] == 1 else results
        else:
            outputs = self.batch(array, rows)
        return labelled(outputs, self.output_names, points), state_array

    @cached_property
    def _run(self) -> Callable[[Any, FloatArray, FloatArray], None]:
        """Fill the results of points along time, and leave the state in the second argument."""
        from fuzzyctl.kernels import batch

        if not self.form.moves:
            fill, checked, plan = self._fill, self._checked, self.plan
            return lambda points, state, results: batch.fill_in_sequence(plan, fill, checked, points, state, results)
        if self.backend != "numba":
            return self._run_by_calls
        from fuzzyctl.kernels.backends.numba.machine_code import sequence

        loop = sequence(self._program, len(self.output_names))
        return batch.fill_by_loop(loop, self._program, self.form.argument_names)

    def _run_by_calls(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        outputs, values = len(self.output_names), state.tolist()
        row = [0.0] * self.form.width
        for k, point in enumerate(points.tolist()):
            self.jit(*point, *((values,) if values else ()), row)
            results[k], values = row[:outputs], row[outputs:]
        state[:] = values

    def degrees(self, points: Points | Frames, state: State | None = None) -> dict[str, dict[str, Any]]:
        """Compute the degrees of all terms that rules read.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: As for `batch`; only outputs that rules read, and free numbers, may need it.

        Returns:
            By variable and term, each of shape (...); NaN where the variable is NaN. Of pandas each is a Series with
            the index of the points.

        Raises:
            FuzzyctlError: For a controller, which has no rules of its own.
        """
        from fuzzyctl.kernels.batch import by_name

        return by_name(self.plan, self._view("degrees", points, state), points)

    def strengths(self, points: Points | Frames, state: State | None = None) -> Any:
        """Compute how far each rule is active: its firing strength times its weight, after the activation method.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: As for `degrees`.

        Returns:
            Shape (..., rules), in the order of `FuzzySystem.rules`; NaN where an input is NaN. Of pandas a DataFrame
            with the index of the points and a column for each rule, from 0.

        Raises:
            FuzzyctlError: For a controller, which has no rules of its own.
        """
        return labelled(self._view("activations", points, state), range(self.n_rules), points)

    def gradient(
        self,
        points: Points | Frames,
        state: State | None = None,
        *,
        dt: Numbers | None = None,
        by: By = "inputs",
    ) -> Any:
        """Compute the derivatives of the outputs, and of the next state of a controller; exact but for rounding.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: As for `batch`.
            dt: As for `batch`.
            by: Variables of the derivatives: "inputs"; "state", whose last entries are the free numbers; or "all",
                the inputs, then the state.

        Returns:
            Shape (..., arguments) for one output, (..., outputs, arguments) for several; of a controller a pair of them
            and those of the next state, shape (..., states, arguments). At a kink or a jump it is the derivative of the
            branches that the program takes there; where several kinks meet it need not lie between the slopes of both
            sides. Beyond the range of an input, which is clamped, it is 0. That of a bisector in a gap between sets,
            where it jumps, is NaN. For one output of pandas a DataFrame with the index of the points.

        Raises:
            UnknownNameError: For another `by`.
            ArgumentError: For arrays of another shape.
        """
        if not isinstance(by, str):
            raise ArgumentError(f"'by' must be one of {', '.join(_BY)}, got {type(by).__name__}")
        if by not in _BY:
            raise UnknownNameError("derivative by", by, _BY)
        names = {"inputs": self.input_names, "state": self.state_names}
        names["all"] = (*names["inputs"], *names["state"])
        rows = self._view(by, points, state, dt)
        outputs = len(self.output_names)
        rows = rows.reshape(*rows.shape[:-1], self.form.width, len(names[by]))
        first = rows[..., 0, :] if outputs == 1 else rows[..., :outputs, :]
        if self.form.moves:
            return first, rows[..., outputs:, :]
        return labelled(first, names[by], points)

    def _view(self, what: str, points: Any, state: Any, dt: Any = None) -> FloatArray:
        """Evaluate one of the programs for the degrees and strengths behind the outputs."""
        if what not in self._views:
            from fuzzyctl.kernels.batch import Arrays, derivatives

            program = derivatives(self.form, what) if what in _BY else self.form.view(what)
            self._views[what] = Arrays(program, self.backend, self.form.argument_names)
        return self._views[what](*self._given(points, state, dt))

    @cached_property
    def _views(self) -> dict[str, Arrays]:
        return {}

    def next_state(self, state: Vector, results: Outputs | Numbers) -> FloatArray:
        """Return the state of a system after an evaluation: outputs that say `else hold` put in, unless they are NaN.

        Args:
            state: The state before, shape (states,).
            results: What `kernel(...)` gave.

        Raises:
            FuzzyctlError: For a system without a state, and for a controller, whose calls give the next state.
            ArgumentError: For a state or results of another shape.
        """
        plan, before = self.plan, self.form.rows(state) if self.n_states else None
        if before is None:
            raise FuzzyctlError(NO_STATE)
        outputs = float_array(results, "results")
        if outputs.size % len(self.output_names):
            raise ArgumentError(f"the results must have the shape (..., {len(self.output_names)}), got {outputs.shape}")
        return state_after(plan, before, outputs.reshape(-1, len(self.output_names)))

    @cached_property
    def value(self) -> Callable[..., Any]:
        """The function as a value for compiled code: of the type that its signature says, whatever the system.

        It computes what `jit` does. Code that takes it as an argument is compiled once for all systems, and so is its
        own code for all systems that differ in numbers only; `jit` is the faster one where a system stays as it is.
        Without numba it is `jit`.
        """
        if self.backend != "numba":
            return self.jit
        from fuzzyctl.kernels.backends.numba import machine_code

        return machine_code.value(self._program, self, (self, "value"))

    @cached_property
    def rates_value(self) -> Callable[..., Any]:
        """What `jit_rates` does as a value for compiled code, as `value` is one."""
        self._require_adaptive()
        if self.backend != "numba":
            return self.jit_rates
        from fuzzyctl.kernels.backends.numba import machine_code

        return machine_code.storing_value(inference.rates(self.plan), self._rates, (self, "rates_value"))

    @cached_property
    def jit_rates(self) -> Callable[..., Any]:
        """The function (x0, ..., C, C_dot) that writes dC_k/dt = rate · ξ_k into C_dot.

        It is zero where C_k would leave the range; the rate takes the inputs as they are, ξ the clamped ones.
        """
        self._require_adaptive()
        return self._compiled(inference.rates(self.plan), storing=True)

    def _rates(self, *arguments: Any) -> None:
        self.jit_rates(*arguments)

    @cached_property
    def jit_strengths(self) -> Callable[..., Any]:
        """The function (x0, ..., xi) that writes the normalised firing strengths, 0 where no rule fires."""
        self._require_adaptive()
        return self._compiled(inference.strengths(self.plan), storing=True)

    @property
    def source(self) -> str:
        """The text of `jit` as this backend prints it."""
        return self._text(self._program, storing=self.form.moves)

    @property
    def raises(self) -> bool:
        """Whether its function raises where no rule fires."""
        return any(isinstance(s, Refuse) for s in self._program.body)

    @cached_property
    def jit(self) -> Callable[..., Any]:
        """The function itself: plain Python, or compiled for use inside other compiled code.

        Of a system it is (x0, ..., state) -> outputs; numba's is float64(float64, ...), with a last float64[::1] for a
        state, and several outputs come as a tuple of float64. It raises ArithmeticError where no rule fires for an
        output that says `else error`, and checks neither the length of the state nor values of free numbers.

        Of a controller it is (x0, ..., dt, state, results), which stores the outputs, then the next state, into
        `results`, shape (outputs + states,); `dt` is left out for a controller with a period, and `state` for one
        without states.
        """
        return self._compiled(self._program, storing=self.form.moves)

    def _compiled(self, program: Program, *, storing: bool) -> Callable[..., Any]:
        text = self._text(program, storing=storing)
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba.source import compile_source

            return compile_source(text)
        return scalar.compile_source(text, program, self.form.argument_names)

    def _text(self, program: Program, *, storing: bool) -> str:
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba.source import evaluation_source, storing_source

            return storing_source(program) if storing else evaluation_source(program)
        return scalar.storing_source(program) if storing else scalar.evaluation_source(program)

    def _require_adaptive(self) -> None:
        if not self.plan.states:
            raise FuzzyctlError("the system has no adaptive output, so it has no rates")

    def _argument_names(self) -> list[str]:
        return [*self.input_names, *(["state"] if self.n_states else [])]
