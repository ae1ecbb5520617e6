"""Whether any rule fires for an output at a point, by evaluation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any

from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.work import Work, compilation, evaluation
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import HeldPlan, Otherwise, OutputPlan, Plan
from fuzzyctl.kernels.program.program import Program


class Silence:
    """Tells where kernels fall back on the `else` of an output, or activate none of its rules.

    Args:
        flat: The system.
        name: The output.
        work: What may be computed; what takes more raises `SpentError`.
    """

    def __init__(self, flat: Plan, name: str, work: Work) -> None:
        self.system, self.work = flat, work
        self.position = next(k for k, o in enumerate(flat.outputs) if o.name == name)
        #: Whether no output reads another one, so that all may be silent at once.
        self.apart = not any(o.reads for o in flat.outputs)
        self.flat = replace(
            flat, outputs=tuple(_nan_where_silent(o, own=self.apart or o.name == name) for o in flat.outputs)
        )
        self.state: list[Any] = [self.flat.initial_state] if self.flat.initial_state else []

    def of(self, name: str, work: Work) -> Silence:
        """Return the same for another output, without compiling anew where that can be spared."""
        if not self.apart:
            return Silence(self.system, name, work)
        other = copy(self)
        other.work, other.position = work, next(k for k, o in enumerate(self.flat.outputs) if o.name == name)
        return other

    @cached_property
    def units(self) -> float:
        """What an evaluation takes."""
        return 2 + evaluation(self.flat)

    @cached_property
    def value(self) -> Callable[..., Any]:
        """The outputs, NaN where they are silent."""
        self.work.spend(compilation(self.flat))
        return _compiled(self.flat, inference.evaluation(self.flat))

    @cached_property
    def strength(self) -> Callable[..., Any]:
        """The largest activation of each output."""
        self.work.spend(compilation(self.flat))
        return _compiled(self.flat, inference.largest_activations(self.flat))

    def holds_at(self, point: Sequence[float]) -> bool:
        """Return whether the output is silent at a point, the values of the inputs in order."""
        self.work.spend(self.units)
        if math.isnan(self._own(self.value(*point, *self.state))):
            return True
        return not self.state and self.activation(point) == 0.0

    def activation(self, point: Sequence[float]) -> float:
        """Return the largest activation among the rules of an output without states at a point."""
        self.work.spend(self.units)
        return self._own(self.strength(*point))

    def confirms(self, hole: Hole) -> bool:
        """Return whether the output is silent at the witness of a hole."""
        return self.holds_at(list(hole.witness.values()))

    def _own(self, found: Any) -> float:
        return float(found[self.position] if isinstance(found, tuple) else found)


def unclear_at(hole: Hole) -> str:
    """Return why a hole that is not confirmed decides nothing."""
    at = ", ".join(f"{n} = {x:.12g}" for n, x in hole.witness.items())
    return f"some rule moves it at {at}, but so little that it is not known whether one does nearby"


def at(flat: Plan, point: Sequence[float]) -> str:
    """Return a point in words, with as many digits as it has."""
    return ", ".join(f"{i.name} = {_digits(x)}" for i, x in zip(flat.inputs, point, strict=True))


def _digits(x: float) -> str:
    short = f"{x:.12g}"
    return short if float(short) == x else repr(x)


def _nan_where_silent(output: OutputPlan, *, own: bool) -> OutputPlan:
    """Return an output with an `else` of NaN, for the one asked about and for others that raise."""
    known: Otherwise = output.otherwise.start if isinstance(output.otherwise, HeldPlan) else output.otherwise
    return replace(output, otherwise=math.nan if own or not isinstance(known, float) else known)


def _compiled(flat: Plan, program: Program) -> Callable[..., Any]:
    names = [i.name for i in flat.inputs]
    return python_backend.compile_source(python_backend.evaluation_source(program), program, names)
