"""The kernel: a plan printed for a backend, and what its callers need around it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, final, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, FuzzyctlError, UnknownNameError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.displayed import Displayed
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.backends import states
from fuzzyctl.kernels.backends.arguments import argument_error, as_floats, float_array, in_order, overflows, too_large
from fuzzyctl.kernels.backends.labels import labelled
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.promises import Promises, Refusals
from fuzzyctl.support.signatures import InputSignature

if TYPE_CHECKING:
    import pandas as pd

    from fuzzyctl.annotations import FloatArray, Frames, Labelled, Numbers, Outputs, Points, Scalar, Vector
    from fuzzyctl.kernels.arrays import Arrays
    from fuzzyctl.kernels.backends.blocks import Fill

_BACKENDS: Final = ("numba", "numpy", "python")
#: What a function raises for arguments that it does not take, and where no rule fires.
_REFUSALS: Final = (TypeError, ValueError, ArithmeticError)


@final
class Kernel(Displayed):
    """A compiled system: numbers in, numbers out, and no state of its own.

    `kernel(x0, x1, ...)` takes real numbers in the order of the inputs and gives a float, or a tuple for several
    outputs. A system with a state takes it last, `kernel(x0, ..., C)`: the consequents of adaptive outputs, one for
    each of their rules, then the previous values of outputs that say `else hold`, in the order they are computed in.
    The state is the caller's: `initial_state` gives it, `next_state` puts the outputs into it, `jit_rates` tells how
    the consequents change.

    Where an input is NaN all outputs are NaN. Where no rule fires an output is what its `else` says; one without `else`
    promises that this never happens. Where it happens all the same, calls from Python raise `NoRuleFiresError`, and
    `jit`, which has no room for the test, gives NaN: check such a system before (`fuzzyctl.check` proves the promise).

    Args:
        plan: What it computes.
        backend: "numba", "numpy" or "python".
        algorithm: One of `algorithm.ALGORITHMS`.

    Raises:
        UnknownNameError: For another backend or algorithm.
        ArgumentError: For interpolation of a system that does not interpolate.
    """

    # What each call reads has a slot, which is found faster than an entry of the dictionary.
    __slots__ = ("__dict__", "__weakref__", "_function", "_is_single")

    __signature__ = InputSignature(lambda kernel: kernel._argument_names())

    def __init__(self, plan: Plan, backend: str, algorithm: str = "auto") -> None:
        if backend not in _BACKENDS:
            raise UnknownNameError("backend", backend, _BACKENDS)
        self.plan, self.backend, self._wanted = plan, backend, algorithm
        self.input_names = tuple(i.name for i in plan.inputs)
        self.output_names = tuple(o.name for o in plan.outputs)
        self.n_rules = len(plan.rules)
        self.n_states = len(plan.initial_state)
        self.algorithm = algorithm_of(plan, algorithm)
        self._program = self.algorithm.point if backend == "numba" else self.algorithm.interpreted
        self._refusals = Refusals(self._program, self.input_names)
        self._promises = Promises(plan, known=self.algorithm.is_defined)
        self._n_arguments = len(plan.inputs) + (1 if self.n_states else 0)
        #: What calls from Python call.
        self._function: Callable[..., Outputs] = self._first_call if backend == "numba" else self.jit
        #: Whether a result that equals itself can be returned as it is, since it is one number.
        self._is_single = not self.n_states and len(plan.outputs) == 1

    def __reduce__(self) -> tuple[Any, ...]:
        """A kernel in another process is made anew there, from the cache where it can be."""
        return Kernel, (self.plan, self.backend, self._wanted)

    def __repr__(self) -> str:
        return printable(f"Kernel({', '.join(self.input_names)} -> {', '.join(self.output_names)}; {self.backend})")

    def __call__(self, *arguments: Scalar | Vector, **named: Scalar | Vector) -> Outputs:
        """Evaluate at one point.

        Arguments may be given by the name of their input, which takes longer; the state is called `state`.

        Raises:
            ArgumentError: For a wrong number of arguments, one given twice, or one that is no real number.
            UnknownNameError: For a name that is no input.
            NoRuleFiresError: Where no rule fires for an output that says `else error` or has no `else`.
        """
        if self._is_single and not named:
            try:
                result = self._function(*arguments)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._careful(arguments, named)

    def _first_call(self, *arguments: Any) -> Outputs:
        """Compile the function and call it."""
        self._function = function = self.jit
        result: Outputs = function(*arguments)
        return result

    def _careful(self, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> Outputs:
        if named:
            arguments = in_order(self._argument_names(), arguments, named)
        if self.n_states and len(arguments) == self._n_arguments:  # the function itself refuses another number
            state = states.argument(arguments[-1], self.n_states, compiled=self.backend == "numba")
            arguments = (*arguments[:-1], state)
        try:
            try:
                result = self._function(*arguments)
            except (TypeError, ValueError, OverflowError):
                # Compiled code takes fewer types of numbers than there are; it never comes here with floats.
                result = self._function(*as_floats(arguments, len(self.input_names), self._n_arguments))
            if result != result or len(self.output_names) > 1:
                self._promises.check(arguments, result)
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

    @overload
    def batch(self, points: Frames, state: Numbers | None = None, *, parallel: bool = True) -> Labelled: ...
    @overload
    def batch(
        self,
        points: Points | Frames,
        state: Numbers | None = None,
        *,
        out: FloatArray | None = None,
        parallel: bool = True,
    ) -> FloatArray: ...
    def batch(
        self,
        points: Points | Frames,
        state: Numbers | None = None,
        *,
        out: FloatArray | None = None,
        parallel: bool = True,
    ) -> FloatArray | Labelled:
        """Evaluate at many points.

        Args:
            points: Shape (..., inputs), in the order of the inputs; or what has named columns, such as a data frame, a
                structured array or a dict of arrays, or what has labels along its last axis, such as a DataArray of
                xarray. The names must be exactly those of the inputs, in any order.
            state: The state, shape (..., states), for each point its own. Of shape (states,) it is the state before
                the first point: adaptive consequents stay as they are, and an output that says `else hold` holds, point
                after point in the order of indices, the last value before that is no NaN. Left out, it is the initial
                state of a system without adaptive outputs.
            out: A contiguous array of float64 of the result's shape to write to; None for a new one.
            parallel: Whether all cores may be used; they are where the work is worth it.

        Returns:
            Shape (...) for one output, (..., outputs) for several. Of a data frame of pandas, or a dict of Series, the
            results are a Series, for several outputs a DataFrame, with the same index, unless `out` is given.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers, and for columns of other names.
            NoRuleFiresError: For the first point where no rule fires for an output that says `else error` or has no
                `else`.
        """
        from fuzzyctl.kernels.batch import Batch

        run = Batch(self.plan, self._fill, self._promises, is_compiled=self.backend == "numba")
        results: FloatArray | Labelled = run(points, state, out, parallel=parallel)
        return results if out is not None else labelled(results, self.output_names, points)

    @cached_property
    def _fill(self) -> Fill:
        """Fill the results of a block of points."""
        from fuzzyctl.kernels.batch import fill_by_calls, fill_of

        if self.backend == "python":
            return fill_by_calls(self.jit)
        program = self.algorithm.arrays if self.backend == "numpy" else self.algorithm.many
        return fill_of(program, self.backend, self.input_names, self._promises)

    @overload
    def degrees(self, points: Frames, state: Numbers | None = None) -> dict[str, dict[str, pd.Series[float]]]: ...
    @overload
    def degrees(self, points: Points, state: Numbers | None = None) -> dict[str, dict[str, FloatArray]]: ...
    def degrees(
        self, points: Points | Frames, state: Numbers | None = None
    ) -> dict[str, dict[str, FloatArray]] | dict[str, dict[str, pd.Series[float]]]:
        """Compute the degrees of all terms that rules read.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: As for `batch`; only outputs that rules read may need it.

        Returns:
            By variable and term, each of shape (...); NaN where the variable is NaN. Of pandas each is a Series with
            the index of the points.
        """
        from fuzzyctl.kernels.arrays import by_name

        return by_name(self.plan, self._view("degrees", points, state), points)

    @overload
    def strengths(self, points: Frames, state: Numbers | None = None) -> pd.DataFrame: ...
    @overload
    def strengths(self, points: Points, state: Numbers | None = None) -> FloatArray: ...
    def strengths(self, points: Points | Frames, state: Numbers | None = None) -> FloatArray | pd.DataFrame:
        """Compute how far each rule is active: its firing strength times its weight, after the activation method.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: As for `degrees`.

        Returns:
            Shape (..., rules), in the order of `FuzzySystem.rules`; NaN where an input is NaN. Of pandas a DataFrame
            with the index of the points and a column for each rule, from 0.
        """
        return labelled(self._view("activations", points, state), range(self.n_rules), points)

    @overload
    def gradient(self, points: Frames, state: Numbers | None = None) -> pd.DataFrame | FloatArray: ...
    @overload
    def gradient(self, points: Points, state: Numbers | None = None) -> FloatArray: ...
    def gradient(self, points: Points | Frames, state: Numbers | None = None) -> FloatArray | pd.DataFrame:
        """Compute the derivatives of the outputs by the inputs, exact but for rounding.

        Args:
            points: Shape (..., inputs), as `batch` takes them.
            state: Shape (states,) or (..., states), for a system with a state.

        Returns:
            Shape (..., inputs) for one output, (..., outputs, inputs) for several. At a kink it is the derivative of
            the branches that the program takes there; where several kinks meet it need not lie between the slopes of
            both sides. Beyond the range of an input, which is clamped, it is 0. That of a bisector in a gap between
            sets, where it jumps, is NaN. For one output of pandas a DataFrame with the index of the points.

        Raises:
            ArgumentError: For arrays of another shape.
        """
        from fuzzyctl.kernels.arrays import jacobian

        found = jacobian(self._view("gradient", points, state), len(self.output_names))
        return labelled(found, self.input_names, points)

    def _view(self, what: str, points: Any, state: Any) -> FloatArray:
        """Evaluate one of the programs that show what is behind the outputs."""
        from fuzzyctl.kernels.arrays import Arrays, input_gradient

        if what not in self._views:
            write = {"degrees": inference.degrees, "activations": inference.activations, "gradient": input_gradient}
            self._views[what] = Arrays(write[what](self.plan), self.backend, self.input_names)
        view = self._views[what]
        if state is not None and not self.plan.initial_state:
            raise ArgumentError(states.NO_STATE)
        if not view.takes_rows:
            return view(points)
        return view(points, states.last_axis(self.plan, state))

    @cached_property
    def _views(self) -> dict[str, Arrays]:
        return {}

    def initial_state(self) -> FloatArray:
        """Return the state to begin with: the peak of the term of each adaptive rule, then what is held at first."""
        import numpy as np

        return np.array(self.plan.initial_state, dtype=np.float64)

    def next_state(self, state: Vector, results: Outputs | Numbers) -> FloatArray:
        """Return the state after an evaluation: outputs that say `else hold` put in, those that are NaN left out.

        Args:
            state: The state before, shape (states,).
            results: What `kernel(...)` or `kernel.batch(...)` gave.

        Raises:
            FuzzyctlError: For a system without a state.
            ArgumentError: For a state or results of another shape.
        """
        if not self.n_states:
            raise FuzzyctlError(states.NO_STATE)
        before = states.first_state(self.plan, state)
        outputs = float_array(results, "results")
        if outputs.size % len(self.output_names):
            raise ArgumentError(f"the results must have the shape (..., {len(self.output_names)}), got {outputs.shape}")
        return states.state_after(self.plan, before, outputs.reshape(-1, len(self.output_names)))

    @cached_property
    def value(self) -> Callable[..., Any]:
        """The function as a value for compiled code: of the type that its signature says, whatever the system.

        It computes what `jit` does. Code that takes it as an argument is compiled once for all systems, and so is its
        own code for all systems that differ in numbers only; `jit` is the faster one where a system stays as it is.
        Without numba it is `jit`.
        """
        if self.backend != "numba":
            return self.jit
        from fuzzyctl.kernels.backends.numba import typed_kernels

        return typed_kernels.value(self._program, self, (self, "value"))

    @cached_property
    def rates_value(self) -> Callable[..., Any]:
        """What `jit_rates` does as a value for compiled code, as `value` is one."""
        self._require_adaptive()
        if self.backend != "numba":
            return self.jit_rates
        from fuzzyctl.kernels.backends.numba import typed_kernels

        return typed_kernels.storing_value(inference.rates(self.plan), self._rates, (self, "rates_value"))

    @cached_property
    def jit_rates(self) -> Callable[..., Any]:
        """The function (x0, ..., C, C_dot) that writes dC_k/dt = rate · ξ_k into C_dot.

        It is zero where C_k would leave the range; the rate takes the inputs as they are, ξ the clamped ones.
        """
        self._require_adaptive()
        return self._storing(inference.rates(self.plan))

    def _rates(self, *arguments: Any) -> None:
        self.jit_rates(*arguments)

    @cached_property
    def jit_strengths(self) -> Callable[..., Any]:
        """The function (x0, ..., xi) that writes the normalised firing strengths, 0 where no rule fires."""
        self._require_adaptive()
        return self._storing(inference.strengths(self.plan))

    @property
    def source(self) -> str:
        """The text of the function as this backend prints it."""
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba import source as numba_backend

            return numba_backend.evaluation_source(self._program)
        return python_backend.evaluation_source(self._program)

    @property
    def raises(self) -> bool:
        """Whether its function raises where no rule fires."""
        return any(isinstance(s, Refuse) for s in self._program.body)

    @cached_property
    def jit(self) -> Callable[..., Any]:
        """The function itself: plain Python, or compiled for use inside other compiled code.

        numba's is float64(float64, ...), with a last float64[::1] for the state; several outputs come as a tuple of
        float64. It raises ArithmeticError where no rule fires for an output that says `else error`, and does not check
        the length of the state.
        """
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba import source as numba_backend

            return numba_backend.compile_source(numba_backend.evaluation_source(self._program))
        source = python_backend.evaluation_source(self._program)
        return python_backend.compile_source(source, self._program, self.input_names)

    def _storing(self, program: Program) -> Callable[..., Any]:
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba import source as numba_backend

            return numba_backend.compile_source(numba_backend.storing_source(program))
        return python_backend.compile_source(python_backend.storing_source(program), program, self.input_names)

    def _require_adaptive(self) -> None:
        if not self.plan.states:
            raise FuzzyctlError("the system has no adaptive output, so it has no rates")

    def _argument_names(self) -> list[str]:
        return [*self.input_names, *(["state"] if self.n_states else [])]
