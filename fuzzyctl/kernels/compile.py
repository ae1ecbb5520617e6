"""From a system to a kernel: plan it, choose an algorithm, and let a backend print it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from numbers import Real
from typing import TYPE_CHECKING, Any, Final, Literal, get_args, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, BackendUnavailableError, UnknownNameError
from fuzzyctl.expr import Logic, Where, walk
from fuzzyctl.kernels.algorithms.select import ALGORITHMS, AlgorithmName, algorithm_of
from fuzzyctl.kernels.backends.arguments import float_array, labelled, stacked
from fuzzyctl.kernels.forms import FreeForm, SystemForm
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.plan.build import Plan, plan, planned_set
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.printer import MOST_COUNTED
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Between,
    Fold,
    Locate,
    Program,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import expressions, parts, statements
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Term

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from fuzzyctl.annotations import ControllerKernel, SystemKernel
    from fuzzyctl.kernels.forms import Form
    from fuzzyctl.model.controller import Controller

    FloatArray = npt.NDArray[np.float64]

__all__ = [
    "ALGORITHMS",
    "BACKENDS",
    "AlgorithmName",
    "Backend",
    "ByName",
    "Kernel",
    "compile",
    "degree_function",
    "degrees",
]

#: What `compile` takes as a backend.
Backend = Literal["auto", "numba", "numpy", "python"]
BACKENDS: Final = get_args(Backend)


@overload
def compile(
    block: FuzzySystem,
    backend: Backend = "auto",
    *,
    algorithm: AlgorithmName = "auto",
    free: Sequence[str] | None = None,
) -> SystemKernel: ...


@overload
def compile(
    block: Controller,
    backend: Backend = "auto",
    *,
    algorithm: AlgorithmName = "auto",
    free: Sequence[str] | None = None,
) -> ControllerKernel: ...


def compile(
    block: FuzzySystem | Controller,
    backend: Backend = "auto",
    *,
    algorithm: AlgorithmName = "auto",
    free: Sequence[str] | None = None,
) -> Kernel:
    """Compile a system or a controller.

    Args:
        block: A well-formed system or controller.
        backend: "numba"; "numpy", which evaluates arrays with numpy and single points with generated Python; "python",
            which loops over the points of an array with the same Python; or "auto", which is numba where it can be
            imported, else numpy, and a warning says so once. Of systems that numba would take longer over than most
            programs run, "auto" is numpy too (`operations`). numba compiles at the first call, and at the first
            batch.
        algorithm: "interpolation", "active" or "rules", which compute the same, up to rounding; or "auto",
            which takes the fastest that the system allows. For a controller, that of all systems that it calls.
        free: Names of numbers that become arguments, such as params, "e.PS.peak" and "force.weights"; see
            `model.free_numbers`. All rules are then evaluated: no algorithm looks up values with free numbers. A
            controller has its params and numbers of its systems, as "SYSTEM.e.PS.peak". They are the last entries of
            the state.

    Raises:
        UnknownNameError: For another backend or algorithm, and for a free number that the system does not have.
        ArgumentError: For an algorithm that the system does not allow, and for a number that cannot be free.
        BackendUnavailableError: For a backend whose package cannot be imported.
        DiagnosticError: For a defuzzifier that the terms do not suit.
    """
    for what, given, known in (("backend", backend, BACKENDS), ("algorithm", algorithm, ALGORITHMS)):
        if not isinstance(given, str):
            raise ArgumentError(f"the {what} must be one of {', '.join(known)}, got {type(given).__name__}")
        if given not in known:
            raise UnknownNameError(what, given, known)
    if isinstance(free, str) or not isinstance(free, Sequence | None):
        raise ArgumentError(f"free must be a list of names, got {type(free).__name__}")
    chosen = _resolve(backend)
    if not isinstance(block, FuzzySystem):
        return Kernel(_controller_form(block, algorithm, free or ()), chosen)
    if free:
        if algorithm not in ("auto", "rules"):
            reason = "tabulates numbers beforehand, so that none of them is free"
            raise ArgumentError(f"the algorithm '{algorithm}' {reason}")
        return Kernel(FreeForm(block, free), chosen)
    planned = plan(block)
    if backend == "auto" and chosen == "numba" and takes_long(planned, algorithm):
        chosen = "numpy"  # which has no wait
    return Kernel(SystemForm(planned, algorithm), chosen)


def _controller_form(controller: Controller, algorithm: str, free: Sequence[str]) -> Form:
    from fuzzyctl.kernels.plan.expansion import equations_of
    from fuzzyctl.kernels.step_form import StepForm, StepValues
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.instance_params import with_instance_params

    if not isinstance(controller, Controller):
        raise ArgumentError(f"compile takes a FuzzySystem or a Controller, got {type(controller).__name__}")
    controller = with_instance_params(controller, free)
    equations = equations_of(controller, free)
    return StepForm(equations, algorithm, StepValues(controller, equations) if free else None, checked=True)


def takes_long(planned: Plan, algorithm: str = "auto") -> bool:
    """Return whether numba takes so long over a system that "auto" leaves it alone."""
    return operations(algorithm_of(planned, algorithm).point) > MOST_OPERATIONS


def _resolve(backend: str) -> str:
    if backend in ("numpy", "python"):
        return backend
    reason = numba_is_missing()
    if reason is None:
        return "numba"
    if backend == "numba":
        raise BackendUnavailableError(backend, reason)
    _say_once(reason)
    return "numpy"


@cache
def numba_is_missing() -> str | None:
    """Return why numba cannot be used, None where it can."""
    try:
        import fuzzyctl.kernels.backends.numba.source  # noqa: F401 - whether it can be imported is the question
    except Exception as error:  # noqa: BLE001 - a broken installation may raise anything; the error is reported
        return f"{type(error).__name__}: {error}" if not isinstance(error, ImportError) else str(error)
    return None


@cache
def _say_once(reason: str) -> None:
    warnings.warn(
        f"numba cannot be used ({reason}); points take generated Python, arrays numpy, which is slower",
        RuntimeWarning,
        stacklevel=4,
    )


def degrees(system: FuzzySystem, variable: LinguisticVariable, term: Term, x: Any) -> FloatArray | None:
    """Compute the degrees of one term, as plots draw them.

    Args:
        system: The system.
        variable: One of its variables.
        term: One of the variable's terms.
        x: Values of the variable, one axis.

    Returns:
        A degree for each value; None for a consequent that is a function of the inputs.
    """
    import numpy as np

    from fuzzyctl.kernels.backends import numpy_backend

    term_set = planned_set(system, variable, term)
    if term_set is None:
        return None
    fill = numpy_backend.compile_batch(inference.term_degree(term_set), [variable.name])
    points = float_array(x, variable.name).reshape(-1, 1)
    results = np.empty_like(points)
    fill(points, None, results)
    return results[:, 0]


def degree_function(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> Callable[[float], float] | None:
    """Return the degree of one term as a function of a number, without numpy; for the arguments see `degrees`."""
    term_set = planned_set(system, variable, term)
    if term_set is None:
        return None
    program = inference.term_degree(term_set)
    return scalar.compile_source(scalar.evaluation_source(program), program, [variable.name])


class ByName:
    """Evaluates a system for numbers or arrays given by name; what `FuzzySystem.__call__` does.

    Numbers go through generated Python, so that neither numpy nor numba is imported; arrays through numpy. Adaptive
    outputs are evaluated with their initial consequents.

    Args:
        system: A well-formed system.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system, self._kernel = system, compile(system, "python")

    @cached_property
    def _arrays(self) -> Kernel:
        return compile(self._system, "numpy")

    def __call__(self, values: Mapping[str, Any]) -> Any:
        """Evaluate the system.

        Args:
            values: A number or an array for every input; arrays broadcast against each other.

        Returns:
            A float, or an array of the broadcast shape; a Series with their index where Series of pandas are given; for
            several outputs a dict by name.

        Raises:
            UnknownNameError: For a name that is not an input.
            ArgumentError: When an input is missing or no number, or arrays do not broadcast.
            NoRuleFiresError: Where no rule fires for an output that says `else error`.
        """
        kernel = self._kernel
        names = kernel.input_names
        if len(values) == len(names) and not kernel.n_states and len(kernel.output_names) == 1:
            # The usual case; asking each value what kind of number it is costs more than all the rest.
            ordered = []
            for name in names:
                value = values.get(name)
                if type(value) is not float and type(value) is not int:
                    break
                ordered.append(value)
            else:
                return kernel(*ordered)
        return self._carefully({self._system.as_declared(name): value for name, value in values.items()})

    def _carefully(self, values: Mapping[str, Any]) -> Any:
        kernel = self._kernel
        names = kernel.input_names
        for name in values:
            if name not in names:
                raise UnknownNameError("input", name, names)
        missing = [name for name in names if name not in values]
        if missing:
            raise ArgumentError(f"a value is missing for: {', '.join(missing)}")
        ordered = [values[name] for name in names]
        if not all(isinstance(value, Real) for value in ordered):
            return self._of_arrays(ordered)
        state = (kernel.plan.initial_state,) if kernel.n_states else ()
        result = kernel(*ordered, *state)
        return result if len(kernel.output_names) == 1 else dict(zip(kernel.output_names, result, strict=True))

    def _of_arrays(self, ordered: Sequence[Any]) -> Any:
        kernel = self._arrays
        points = stacked(kernel.input_names, ordered)
        results = kernel.batch(points)
        names, columns = kernel.output_names, dict(zip(kernel.input_names, ordered, strict=True))
        if len(names) == 1:
            return labelled(results, names, columns)
        return {name: labelled(results[..., k], [name], columns) for k, name in enumerate(names)}


#: More operations than this take numba longer than most programs run: it compiles about a thousand in a second, and as
#: many again for arrays.
MOST_OPERATIONS: Final = 20_000
#: More branches than this take numba longer, too: 120 about 10 seconds, 240 45, and more than about 300 none at all.
MOST_BRANCHES: Final = 100
#: Operations for each knot that is compared: it is read, compared and counted.
_COUNTED: Final = 12
#: Operations of a search among more knots, and of a loop that integrates.
_LOOP: Final = 200


def operations(program: Program) -> int:
    """Return how many operations a compiler sees in a program, one second for about a thousand with numba.

    Loops count once, however often they run; so do constant tables, which stand in memory.
    """
    return sum(map(_own, statements(program.body))) + sum(1 for value in program.results for _ in walk(value))


def branches(program: Program) -> int:
    """Return how many branches a compiler sees in a program."""
    choices = sum(isinstance(node, Where | Logic) for value in expressions(program) for node in walk(value))
    return choices + sum(isinstance(statement, Refuse) for statement in statements(program.body))


def _own(statement: Statement) -> int:
    """Return the operations of a statement without those of statements inside it."""
    if isinstance(statement, Locate):
        return _COUNTED * len(statement.knots) if len(statement.knots) <= MOST_COUNTED else _LOOP
    nodes = sum(1 for value in parts(statement).values for _ in walk(value))
    return nodes + (_LOOP if isinstance(statement, Accumulate | Fold | Between | Quadrature) else 0)
