"""Unit of code generation: a system, or the step of a controller, as a program with names, bounds and source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, Literal, cast

from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.analysis.verdicts import Verdict
from fuzzyctl.codegen.simplify import lean, with_named_state
from fuzzyctl.codegen.table import Tabulated
from fuzzyctl.expr import Expr
from fuzzyctl.kernels.algorithms.select import Algorithm
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.plan.equations import DT, Equations
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem

Precision = Literal["float", "double"]

#: Largest error that self-tests allow, in parts of an output's largest magnitude. Of `float` it is an allowance, not a
#: proof: rounding may add up.
TOLERANCE: Final[Mapping[Precision, float]] = {"double": 1e-12, "float": 1e-4}


@dataclass(frozen=True)
class Evaluated:
    """A system that generated text evaluates.

    Args:
        system: The system, its params set.
        algorithm: How it is evaluated; for a table, interpolation of the table.
        table: The lookup table that takes its place, None for the system itself.
    """

    system: FuzzySystem
    algorithm: Algorithm
    table: Tabulated | None = None

    @property
    def plan(self) -> Plan:
        """The plan of the system."""
        return self.algorithm.plan


@dataclass(frozen=True)
class Slot:
    """A part of the state.

    Args:
        name: That of its state, or of the delay.
        start: Its value before the first step.
        length: The numbers that it holds; more than one for a delay line, whose oldest number is read.
    """

    name: str
    start: float
    length: int = 1


@dataclass(frozen=True)
class Unit:
    """A block to be written: a system, or a controller, which is written as its step.

    A system is a step without time. Its slots are outputs that hold their value where no rule fires; adaptive
    consequents are read, and change by their rates.

    Args:
        block: The block, its params set.
        written: The step of a controller as `program` has it; of a system its evaluation, with tests for NaN.
        systems: The systems that it evaluates, each with other params separately; a system itself.
        slots: The state.
        numbers: Free numbers, which the caller gives; their starts are those of the file.
        step: The step of a controller, None for a system.
        bounds: Proved bounds of the outputs of a system, by name; those of a table hold for the table too.
        digest: SHA-256 of the text of its rule file.
        settings: Params that were set by hand.
        precision: Type of its numbers.
        values: Names of equations by the names of their values in the program.
        verdicts: On its guarantees.
    """

    block: FuzzySystem | Controller
    written: Program
    systems: tuple[Evaluated, ...]
    slots: tuple[Slot, ...] = ()
    numbers: tuple[Slot, ...] = ()
    step: Equations | None = None
    bounds: Mapping[str, OutputBound] = field(default_factory=dict, hash=False)
    digest: str = ""
    settings: tuple[tuple[str, float], ...] = ()
    precision: Precision = "double"
    values: Mapping[str, str] = field(default_factory=dict, hash=False)
    verdicts: Sequence[Verdict] = field(default=(), hash=False)

    @cached_property
    def program(self) -> Program:
        """The step for inputs that are no NaN.

        Arguments are the inputs, `dt` without a period, the adaptive consequents, the values of the slots and the
        free numbers; results are the outputs and the new values of the slots of a controller.
        """
        return self.written if self.is_step else with_named_state(lean(self.written))

    @cached_property
    def rates(self) -> Program | None:
        """The program for dC/dt of adaptive consequents, None without any."""
        return with_named_state(lean(inference.rates(self.plan))) if self.consequents else None

    @property
    def system(self) -> FuzzySystem:
        """The system that is written."""
        return self.systems[0].system

    @property
    def controller(self) -> Controller:
        """The controller that is written."""
        return cast("Controller", self.block)

    @property
    def equations(self) -> Equations:
        """The step of the controller."""
        return cast("Equations", self.step)

    @property
    def algorithm(self) -> Algorithm:
        """How the system is evaluated."""
        return self.systems[0].algorithm

    @property
    def plan(self) -> Plan:
        """The plan of the system."""
        return self.systems[0].plan

    @property
    def table(self) -> Tabulated | None:
        """The lookup table that takes the place of the system."""
        return self.systems[0].table if self.step is None else None

    @property
    def is_step(self) -> bool:
        """Whether it is the step of a controller."""
        return self.step is not None

    @property
    def period(self) -> float | None:
        """The sample time of a controller [s]."""
        return self.step.period if self.step is not None else None

    @property
    def takes_time(self) -> bool:
        """Whether the time since the step before is an argument."""
        return self.step is not None and self.step.period is None

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs."""
        return self.step.inputs if self.step is not None else tuple(i.name for i in self.plan.inputs)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The names of the arguments of a step: the inputs, and `dt` without a period."""
        return (*self.inputs, *((DT,) if self.takes_time else ()))

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs."""
        named = self.plan.outputs if self.step is None else self.controller.results
        return tuple(o.name for o in named)

    @property
    def consequents(self) -> tuple[float, ...]:
        """The start of the adaptive consequents of a system."""
        return () if self.is_step else tuple(self.plan.initial_state[: len(self.plan.states)])

    @property
    def has_state(self) -> bool:
        """Whether it keeps a state."""
        return bool(self.slots or self.consequents)

    @property
    def results(self) -> tuple[Expr, ...]:
        """The outputs."""
        return self.program.results[: len(self.outputs)]

    @property
    def taken(self) -> tuple[Expr, ...]:
        """The new values of the slots of a controller."""
        return self.program.results[len(self.outputs) :]

    @cached_property
    def refusals(self) -> tuple[str, ...]:
        """Outputs of systems that refuse where no rule fires: those with `else error`."""
        return tuple(dict.fromkeys(s.output for s in self.program.body if isinstance(s, Refuse)))

    def scale(self, position: int) -> float:
        """Return the largest magnitude of an output, to which tolerances are relative."""
        output = self.plan.outputs[position]
        bound = self.bounds[output.name]
        ends = [abs(e) for e in (output.lower, output.upper, bound.lo, bound.hi) if abs(e) < 1e300]
        return max([*ends, 1e-300])

    def tolerance(self, position: int) -> float:
        """Return the largest error of an output of a system that the self-test allows: what rounding may make of it."""
        return TOLERANCE[self.precision] * self.scale(position)
