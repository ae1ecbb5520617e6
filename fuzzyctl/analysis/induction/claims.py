"""Claims about a controller: its `require` lines and the ranges of its outputs and states, over names of a step."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from fuzzyctl.analysis.claims import ALWAYS, Bound, Claim, Every, Some, Truth, bounds_in, claim_of, outside
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Compare, Expr, Name, Number, to_text
from fuzzyctl.kernels.plan.equations import Equations
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.kernels.step_form import numeric
from fuzzyctl.model.block import Bounds
from fuzzyctl.model.controller import Controller, Result
from fuzzyctl.records import record

#: Prefix of the name of a state for its next value.
NEXT: Final = "next "
#: How far a range may be left for rounding, relative to its ends, where it cannot be shown to be kept exactly.
ROUNDING: Final = 1e-9


@record(frozen=True)
class StepClaim:
    """A claim about a step.

    Args:
        claim: What must hold, over names of the step.
        span: Where it is written.
        state: The state whose range it is, an empty string for any other claim.
        is_range: Whether it is the range of a state or of an output, which is kept up to rounding.
        nowhere: The claim that no step is in the region, None for a claim about all steps.
    """

    claim: Claim
    span: Span | None = None
    state: str = ""
    is_range: bool = False
    nowhere: Claim | None = None


@dataclass
class Claims:
    """All claims about a controller.

    Args:
        controller: The controller.
        free: Params that may have any value; they are inputs of its equations.

    Attributes:
        own: Those of its `require` lines and the ranges of its outputs and states, in the order written.
        inner: Ranges of the states of controllers inside it.
        equations: Its equations, with the sides of comparisons as outputs.
        sides: The sides of a comparison as a witness shows them: texts, with the names of their values.
    """

    controller: Controller
    free: tuple[str, ...] = ()
    own: list[StepClaim] = field(init=False)
    inner: list[StepClaim] = field(init=False)
    equations: Equations = field(init=False)
    sides: dict[Bound, tuple[tuple[str, str], ...]] = field(default_factory=dict, init=False)
    _names: dict[Expr, str] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        controller = self.controller
        claims = [self._guarantee(k) for k in range(len(controller.guarantees))]
        extra = tuple(Result(name=name, value=value) for value, name in self._names.items())
        changed = dataclasses.replace(controller, results=(*controller.results, *extra))
        self.equations = _with_inputs(equations_of(changed, self.free))
        declared = {s.name: s for s in controller.states}
        self.inner = []
        for slot in self.equations.states:
            if slot.bounds is not None:
                state = declared.get(slot.name)
                bounds = slot.bounds if state is None or state.bounds is None else state.bounds
                claim = self._range(NEXT + slot.name, slot.name, bounds, state=slot.name)
                if state is None:
                    self.inner.append(claim)
                else:
                    claims.append(dataclasses.replace(claim, span=state.span))
        for result in controller.results:
            if result.bounds is not None:
                claims.append(
                    dataclasses.replace(self._range(result.name, result.name, result.bounds), span=result.span)
                )
        self.own = sorted(claims, key=lambda c: c.span.start if c.span is not None else -1)

    def _guarantee(self, position: int) -> StepClaim:
        guarantee = self.controller.guarantees[position]
        claim = claim_of(self.controller, guarantee)
        nowhere = outside(self.controller, guarantee)
        return StepClaim(
            Claim(claim.text, self._mapped(claim.truth), self._mapped(claim.region)),
            guarantee.span,
            nowhere=None if nowhere is None else Claim(nowhere.text, self._mapped(nowhere.truth), ALWAYS),
        )

    def _mapped(self, truth: Truth) -> Truth:
        """Return a claim whose comparisons name outputs that are added to the controller."""
        if isinstance(truth, Every | Some):
            return type(truth)(tuple(self._mapped(p) for p in truth.parts))
        assert isinstance(truth, Bound)
        bound = dataclasses.replace(truth, left=self._named(truth.left), right=self._named(truth.right))
        origin = truth.origin
        sides = (origin.left, origin.right) if isinstance(origin, Compare) else (truth.left, truth.right)
        named = [(to_text(s), self._named(s)) for s in dict.fromkeys(sides)]
        self.sides[bound] = tuple((text, n.name) for text, n in named if isinstance(n, Name))
        return bound

    def _named(self, expr: Expr) -> Expr:
        if isinstance(expr, Number):
            return expr
        return Name(self._names.setdefault(expr, f"require#{len(self._names)}"))

    def _range(self, name: str, shown: str, bounds: Bounds, state: str = "") -> StepClaim:
        """Return the claim that a value lies in a range; an infinite end is not a limit."""
        text = f"{shown} in {range_text(bounds)}"
        ends = [Number(self.controller.number(e)) for e in (bounds.lower, bounds.upper)]
        sides = ((Name(name), ends[0], bounds.without_lower), (ends[1], Name(name), bounds.without_upper))
        parts = [
            Bound(left, right, Fraction(0), strict, Name(name))
            for (left, right, strict), end in zip(sides, ends, strict=True)
            if abs(end.value) < float("inf")
        ]
        self.sides |= dict.fromkeys(parts, ((name, name),))
        return StepClaim(Claim(text, Every(tuple(parts)), ALWAYS), state=state, is_range=True)


def _with_inputs(equations: Equations) -> Equations:
    """Return equations whose free numbers are inputs instead of states."""
    count = len(equations.states) - len(equations.free)
    return dataclasses.replace(
        equations,
        inputs=(*equations.inputs, *equations.free),
        states=equations.states[:count],
        updates=tuple(map(numeric, equations.updates[:count])),
        free=(),
    )


def range_text(bounds: Bounds) -> str:
    """Return a range as it is written."""
    left, right = "(" if bounds.without_lower else "[", ")" if bounds.without_upper else "]"
    return f"{left}{to_text(bounds.lower)}, {to_text(bounds.upper)}{right}"


def loosened(claim: StepClaim) -> StepClaim:
    """Return the range of a state or an output with room for rounding at the ends that belong to it."""
    bounds = list(bounds_in(claim.claim.truth))
    size = max((abs(e.value) for b in bounds for e in (b.left, b.right) if isinstance(e, Number)), default=0.0)
    tolerance = Fraction(ROUNDING) * Fraction(size)
    parts = tuple(b if b.strict else dataclasses.replace(b, tolerance=tolerance) for b in bounds)
    return dataclasses.replace(claim, claim=dataclasses.replace(claim.claim, truth=Every(parts)))


def tolerance_of(claim: StepClaim) -> float:
    """Return how far the range of a state or an output may be left."""
    return max((float(b.tolerance) for b in bounds_in(claim.claim.truth)), default=0.0)


def names_in_claim(claim: Claim) -> Iterator[str]:
    """Yield the names whose values a claim compares."""
    for truth in (claim.truth, claim.region):
        for bound in bounds_in(truth):
            yield from (e.name for e in (bound.left, bound.right) if isinstance(e, Name))
