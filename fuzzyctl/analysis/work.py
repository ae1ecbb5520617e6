"""Work budget of a check, counted in operations, and the clocks of time limits.

A budget is the same on every machine. A unit is about a microsecond of plain Python. A clock would give a file other
diagnostics on a slow machine.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

from fuzzyctl.expr import Binary, Call, Expr, walk
from fuzzyctl.kernels.plan.build import OutputPlan, Plan
from fuzzyctl.kernels.program.program import Accumulate, Assign, Program

#: Units for a second of one core.
SECOND: Final = 1_000_000
#: Units for all proofs and searches of one check, whatever the number of systems and outputs.
CHECK: Final = 1_500_000
#: Units for the coverage of one output.
COVERAGE: Final = 1_200_000
#: Units for the turning points of own hedges.
ISOLATION: Final = 750_000
#: Units for the search of a silent point of one output.
SEARCH: Final = 400_000

#: Reason of a verdict if there is no work left.
SPENT: Final = "it takes more work than a check does"

#: Units for an operand or operator of an expression that intervals are computed of.
_ENCLOSED: Final = 1.5
#: Units for compiling an operation of a kernel.
_COMPILED: Final = 20
#: Units for an operation of a kernel, or a term at a sample.
_EVALUATED: Final = 0.2
#: Units for a node of a program over many boxes, and for each number of its arrays: ends of values and slopes.
_NODE, _NUMBER = 8, 0.0023
#: Numbers of tables that take as much of a text as an operation, and operations for a parameter of an exact centroid.
NUMBERS: Final = 20
_CORNER: Final = 64
#: Units for each box of an operation that is enclosed box by box, and the functions that are.
_SCALAR: Final = 8
_BY_SCALARS: Final = frozenset({"log", "sin", "cos", "tan", "atan2", "floor", "ceil", "round", "mod", "fmod"})
#: Samples that stand for those of an adaptive integral, whose intervals begin at the breakpoints of its terms: in all,
#: and for each term where there are many.
_ADAPTIVE: Final = 500
_ADAPTIVE_TERM: Final = 100


class Clock:
    """The clocks of time limits.

    Attributes:
        now: Returns the seconds since some moment; tests set a clock that other processes do not move.
        used: Returns the processor seconds of this process, which a busy machine does not use up.
    """

    def __init__(self) -> None:
        self.now: Callable[[], float] = time.monotonic
        self.used: Callable[[], float] = time.process_time
        self._until: ContextVar[float] = ContextVar("until", default=math.inf)

    @contextmanager
    def limited(self, seconds: float) -> Iterator[None]:
        """End the searches of a block after some processor seconds, whatever work is left."""
        token = self._until.set(min(self._until.get(), self.used() + seconds))
        try:
            yield
        finally:
            self._until.reset(token)

    def is_over(self, more: float = 0.0) -> bool:
        """Return whether the limit is reached within some more seconds; without a limit no clock is read."""
        until = self._until.get()
        return until < math.inf and self.used() + more > until


clock: Final = Clock()


class SpentError(Exception):
    """Raised when there is no work left."""


class Work:
    """The work that is left.

    Args:
        left: Units.
        whole: The work that this is a part of.
    """

    def __init__(self, left: float = CHECK, whole: Work | None = None) -> None:
        self.left, self.whole = left, whole

    def part(self, most: float) -> Work:
        """Return a part of the work that is left; work that is spent of it is spent of the whole, too."""
        return Work(min(most, self.left), self)

    def spend(self, units: float) -> None:
        """Count some units.

        Raises:
            SpentError: When fewer are left; then none is left afterwards.
        """
        if not self.takes(units):
            raise SpentError

    def takes(self, units: float) -> bool:
        """Count some units, and return whether there were as many, and time for them."""
        if clock.is_over(min(units, self.left) / SECOND):
            self.left = 0.0
        spent = min(units, self.left)
        self.left -= spent
        if self.whole is not None:
            self.whole.takes(spent)
        return spent == units


def units_of(expr: Expr) -> float:
    """Return the work of computing intervals of an expression."""
    return 5 + _ENCLOSED * sum(1 for _ in walk(expr))


def sizes_of(program: Program) -> tuple[int, int, int]:
    """Return how many nodes a program has, how many they are with their repetitions, and those box by box."""
    nodes = entries = scalars = 0
    for statement in program.body:
        if isinstance(statement, Assign | Accumulate):
            parts = [statement] if isinstance(statement, Assign) else [*statement.body, *statement.sums]
            count = sum(1 for part in parts for _ in walk(part.value))
            times = 1 if isinstance(statement, Assign) else statement.count
            nodes += count
            entries += count * times
            scalars += times * sum(1 for part in parts for e in walk(part.value) if _is_scalar(e))
    return nodes, entries, scalars


def enclosing(sizes: tuple[int, int, int], inputs: int, boxes: int) -> float:
    """Return the work of enclosing a program and its slopes along the inputs over some boxes, all at once."""
    nodes, entries, scalars = sizes
    return _NODE * nodes + (_NUMBER * entries * (1 + 2 * inputs) + _SCALAR * scalars) * boxes


def _is_scalar(expr: Expr) -> bool:
    """Return whether an operation is enclosed box by box."""
    return (isinstance(expr, Binary) and expr.op == "^") or (isinstance(expr, Call) and expr.function in _BY_SCALARS)


def sampling(output: OutputPlan, terms: int) -> float:
    """Return the work of computing the degrees of some terms of an output at its samples."""
    return _EVALUATED * (output.resolution or 0) * (terms + 1)


def evaluation(flat: Plan) -> float:
    """Return the work of one evaluation of a kernel."""
    return _EVALUATED * (_operations(flat) + sum(_samples(o) * len(o.terms) for o in flat.outputs if not o.over_rules))


def compilation(flat: Plan) -> float:
    """Return the work of writing and compiling a kernel in plain Python."""
    sampled = sum(sampling(o, len(o.terms)) for o in flat.outputs if not o.over_rules)
    return _COMPILED * _operations(flat) + sampled


def compiling(flat: Plan) -> float:
    """Return about how many seconds it takes to write and compile a kernel."""
    return compilation(flat) / SECOND


def written(flat: Plan) -> int:
    """Return about how many operations a program has that is written out, without writing it."""
    lets = sum(1 for let in flat.lets for _ in walk(let.value))
    sets = [*(d.set for d in flat.degrees), *(t for o in flat.outputs for t in o.terms)]
    read = sum(6 * len(s.parameters) + (sum(1 for _ in walk(s.expression)) if s.expression else 0) for s in sets)
    shapes = [o for o in flat.outputs if not o.over_rules]
    corners = sum(_CORNER * len(t.parameters) for o in shapes if o.resolution is None for t in o.terms)
    samples = sum((o.resolution or 0) * len(o.terms) for o in shapes)
    return _operations(flat) + lets + read + corners + samples // NUMBERS


def _operations(flat: Plan) -> int:
    read = sum(1 for e in (*flat.steps, *flat.strengths) for _ in walk(e))
    return 8 * len(flat.degrees) + read + 4 * sum(len(o.implied) for o in flat.outputs)


def _samples(output: OutputPlan) -> int:
    if output.resolution is not None:
        return output.resolution
    return max(_ADAPTIVE, _ADAPTIVE_TERM * len(output.terms)) if _is_curved(output) else 20


def _is_curved(output: OutputPlan) -> bool:
    return any(not t.vertices for t in output.terms)
