"""Proofs about controllers: ranges of states by induction, then claims about the steps that these ranges allow."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import product
from typing import Final

from fuzzyctl.analysis.bounds import SPENT
from fuzzyctl.analysis.branch_and_bound.pointwise import decide, holds_in
from fuzzyctl.analysis.claims import Claim, bounds_in
from fuzzyctl.analysis.induction.claims import Claims, StepClaim, loosened, names_in_claim, tolerance_of
from fuzzyctl.analysis.induction.ranges import ends_of, ranges_of
from fuzzyctl.analysis.induction.replay import Judge, Reached, Replay, Runs
from fuzzyctl.analysis.induction.step_model import FAR, BoxedStep, Ends, StepModel
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Verdicts
from fuzzyctl.analysis.work import clock
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Number
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.model.block import Bounds
from fuzzyctl.model.controller import Controller

#: Least and longest time between two steps that proofs begin with, for a controller without period [s].
_TIMES: Final = (1e-30, FAR)
#: The least positive and the largest number.
_LEAST, _MOST = math.ulp(0.0), sys.float_info.max
#: Sizes of inputs that may break a claim which is proved up to `FAR`.
_FAR_OUT: Final = (1e32, 1e100, 1e300)
#: Most cells of a proof without subdivision.
_CELLS: Final = 2_000
#: Seconds that runs from the start may take, as a part of the time of a claim.
_RUNS: Final = 0.2
#: Notes on a witness in the state at the start, and on a range that is kept up to rounding only.
_FIRST: Final = "at the first step"
_ROUNDED: Final = "up to 1e-9 of its ends; kernels round"

Progress = Callable[[str, int, int], None]


class ControllerProver:
    """Proves claims of one controller.

    Args:
        controller: The controller.
        timeout: Seconds that one claim may take.
        progress: Called now and then.
        free: Params that may have any value in their ranges; no system, start or range depends on them.
        until: When all proofs end, on the clock of proofs [s].
    """

    def __init__(
        self,
        controller: Controller,
        timeout: float,
        progress: Progress | None = None,
        free: Sequence[str] = (),
        until: float = math.inf,
    ) -> None:
        self.controller, self.timeout, self.progress, self.until = controller, timeout, progress, until
        self.claims = Claims(controller, tuple(free))
        self.model = StepModel(self.claims.equations)
        #: Ranges of the inputs; those without an end are first taken up to `FAR`.
        self.inputs = {s.name: ends_of(self._computed(s.bounds), FAR) for s in controller.inputs}
        self.inputs |= {p.name: ends_of(self._computed(p.bounds), FAR) for p in controller.params if p.name in free}
        every = [*self.claims.own, *self.claims.inner]
        bounds = [b for c in every for b in bounds_in(c.claim.truth) if not b.tolerance]
        self.replay = Replay(self.claims, frozenset(b for b in bounds if not self.model.is_limit(b)))
        #: The ranges of states that have been decided, by state.
        self._verdicts: dict[str, Verdict] = {}

    @property
    def own(self) -> list[StepClaim]:
        """The claims of the controller."""
        return self.claims.own

    def _computed(self, bounds: Bounds | None) -> Bounds | None:
        if bounds is None:
            return None
        lower, upper = (Number(self.controller.number(e)) for e in (bounds.lower, bounds.upper))
        return replace(bounds, lower=lower, upper=upper)

    def verdict(self, claim: StepClaim) -> Verdict:
        """Return the verdict on one of the claims in `claims.own`."""
        if claim.state:
            _ = self.ranges  # which decides the ranges of states
            result = self._verdicts[claim.state]
        else:
            result = self._of_step(claim)
        if isinstance(result, Proved):
            tried = _as_proved(claim, result).claim
            if assumption := self.assumption(tried):
                result = self._far_out(tried) or replace(
                    result, note="; ".join(filter(None, (result.note, assumption)))
                )
        elif isinstance(result, Refuted):
            result = self._replayed(claim, result)
        return replace(result, span=claim.span)

    def _replayed(self, claim: StepClaim, refutation: Refuted) -> Verdict:
        """Return a refutation whose witness breaks the claim with the digits that it shows, as many as this takes."""
        tried = (loosened(claim) if claim.is_range else claim).claim
        witness = refutation.witness
        if not self.replay.breaks(tried, witness.point):
            return Undecided(refutation.claim, f"it is false {witness}, but not in a step from these numbers")
        rounded = {n: float(f"{x:.12g}") for n, x in witness.point.items()}
        return (
            refutation
            if self.replay.breaks(tried, rounded)
            else replace(refutation, witness=replace(witness, in_full=True))
        )

    @cached_property
    def _positions(self) -> dict[int, int]:
        """Positions of the own claims by their identities, as comparing thousands of them takes long."""
        return {id(c): k for k, c in enumerate(self.claims.own)}

    @cached_property
    def _reached(self) -> dict[int, Reached]:
        """Steps of runs from the start at which claims are false, by position among the own ones."""
        ranges = self.inputs | {DT: (1e-6, 1.0)}
        claims = [loosened(c) if c.is_range else c for c in self.claims.own]
        return Runs(self.replay, ranges, min(clock.now() + _RUNS * self.timeout, self.until)).search(claims)

    @cached_property
    def ranges(self) -> dict[str, Ends]:
        """Ranges that no run leaves: of the inputs, by declaration; of the states, proved by induction."""
        claims = {c.state: c for c in (*self.claims.own, *self.claims.inner) if c.state}
        tried: dict[str, Verdict] = {}
        while True:
            ranges = self._ranges_with(claims.values(), self._times(*_TIMES))
            failed = {n: v for n, c in claims.items() if not isinstance(v := self._range(c, ranges), Proved)}
            if not failed:
                break
            for name, verdict in failed.items():
                wider = loosened(claims[name])
                first = tried.setdefault(name, self._by_run(claims[name]) or verdict)
                is_last = clock.now() > self.until or tolerance_of(wider) == tolerance_of(claims[name])
                if isinstance(first, Refuted) or is_last:
                    self._verdicts[name] = first
                    del claims[name]
                else:
                    claims[name] = wider
        for name, claim in claims.items():
            self._verdicts[name] = Proved(claim.claim.text, note=_ROUNDED if tolerance_of(claim) else "")
        return ranges

    def _ranges_with(self, held: Iterable[StepClaim], inputs: Mapping[str, Ends]) -> dict[str, Ends]:
        """Return ranges of all arguments where some states keep their ranges."""
        caps = {}
        declared = {s.name: s.bounds for s in self.model.equations.states}
        for claim in held:
            bounds = declared[claim.state]
            assert bounds is not None
            low, high = ends_of(bounds, math.inf)
            slack = 1.001 * tolerance_of(claim)
            if low > -math.inf or high < math.inf:
                caps[claim.state] = (
                    low if bounds.without_lower else low - slack,
                    high if bounds.without_upper else high + slack,
                )
        return ranges_of(self.model, inputs, caps, self.until)

    def _times(self, shortest: float, longest: float) -> dict[str, Ends]:
        """Return the ranges of the inputs, with that of `dt` for a controller without period."""
        return self.inputs | ({DT: (shortest, longest)} if self.model.equations.period is None else {})

    @cached_property
    def widest(self) -> dict[str, Ends]:
        """Ranges as `ranges` for inputs without an end, and a `dt`, of any size."""
        ends = {n: (-_MOST if a == -FAR else a, _MOST if b == FAR else b) for n, (a, b) in self.inputs.items()}
        _ = self.ranges
        claims = [c for c in (*self.claims.own, *self.claims.inner) if c.state and self._is_kept(c.state)]
        candidates = [_as_proved(c, self._verdicts[c.state]) for c in claims]
        while True:
            ranges = self._ranges_with(candidates, self._times(_LEAST, _MOST) | ends)
            rest = [c for c in candidates if clock.now() <= self.until and self.holds_at_once(c.claim, ranges)]
            if len(rest) == len(candidates):
                return ranges
            candidates = rest

    def _far_out(self, claim: Claim) -> Refuted | None:
        """Return a refutation in the first step by inputs beyond those of a proof, if one is found."""
        names = self.model.slice(names_in_claim(claim)).shown
        ends = [self.inputs.get(n, (1.0, 1.0)) for n in self.replay.arguments]
        for size, sign in product(_FAR_OUT, (1.0, -1.0)):
            arguments = [sign * size if abs(e) == FAR else e for e in (high if sign > 0 else low for low, high in ends)]
            witness = self.replay.witness(claim, arguments, self.replay.start, names)
            if witness is not None:
                return Refuted(claim.text, witness, note=_FIRST if set(names) & set(self.replay.states) else "")
        return None

    def holds_at_once(self, claim: Claim, ranges: Mapping[str, Ends]) -> bool:
        """Return whether enclosures over all values, or over cells, show a claim."""
        boxed = BoxedStep(self.model, ranges, list(dict.fromkeys(names_in_claim(claim))))
        if holds_in(boxed, claim, *boxed.box):
            return True
        cells = boxed.cells([claim.truth, claim.region])
        return cells is not None and cells[0].shape[1] <= _CELLS and holds_in(boxed, claim, *cells)

    def assumption(self, claim: Claim) -> str:
        """Return up to which inputs and `dt` a claim is proved; an empty text for all."""
        large = [n for n, (low, high) in self.inputs.items() if low == -FAR or high == FAR]
        names = self.model.origins(names_in_claim(claim)) if large or self.model.equations.period is None else set()
        large = [n for n in large if n in names]
        if not (large or DT in names) or (clock.now() <= self.until and self.holds_at_once(claim, self.widest)):
            return ""
        parts = [f"{', '.join(large)} up to {_text(FAR)} in magnitude"] if large else []
        parts += ["dt from {} s to {} s".format(*map(_text, _TIMES))] if DT in names else []
        return f"for {' and '.join(parts)}"

    def _range(self, claim: StepClaim, ranges: dict[str, Ends]) -> Verdict:
        """Return whether a step keeps a value in its range; a range that is left by rounding only is not refuted."""
        return self._decided(claim.claim, ranges, 0.5 * self.timeout, loosened(claim).claim)

    def _of_step(self, claim: StepClaim) -> Verdict:
        """Return the verdict on a claim that is not a range of a state."""
        if not claim.is_range:
            result = self._decided(claim.claim, self.ranges, self.timeout)
        else:
            result = self._range(claim, self.ranges)
            if isinstance(result, Undecided) and isinstance(self._range(loosened(claim), self.ranges), Proved):
                result = Proved(claim.claim.text, note=_ROUNDED)
        if isinstance(result, Proved) and claim.nowhere is not None:
            void = self._decided(claim.nowhere, self.ranges, 0.1 * self.timeout)
            if isinstance(void, Proved):
                return replace(result, note="nothing is claimed: no step is in the region")
        # A claim that is proved is false in no run.
        return result if isinstance(result, Proved) else self._by_run(claim) or self._with_reason(result, claim)

    def _with_reason(self, verdict: Verdict, claim: StepClaim) -> Verdict:
        """Name the ranges of states that are not proved if a claim is undecided."""
        if not isinstance(verdict, Undecided):
            return verdict
        read = self.model.slice(names_in_claim(claim.claim)).arguments
        lost = [n for n, v in self._verdicts.items() if n in read and not isinstance(v, Proved)]
        if not lost:
            return verdict
        names = " and ".join(f"'{n}'" for n in lost)
        return replace(verdict, reason=f"{verdict.reason}; the range of {names} is not proved, so it is not used")

    def _by_run(self, claim: StepClaim) -> Refuted | None:
        """Return a refutation by a run from the start, if one is found."""
        position = self._positions.get(id(claim))
        reached = None if position is None else self._reached.get(position)
        if reached is None:
            return None
        tried = loosened(claim) if claim.is_range else claim
        names = self.model.slice(names_in_claim(claim.claim)).shown
        witness = self.replay.witness(tried.claim, reached.given, reached.state, names)
        if witness is None:
            return None
        if not set(names) & set(self.replay.states):
            return Refuted(claim.claim.text, witness)
        steps = f"reached from the start after {counted(reached.steps, 'step')}" if reached.steps else _FIRST
        return Refuted(claim.claim.text, witness, note=steps)

    def _decided(self, claim: Claim, ranges: dict[str, Ends], timeout: float, broken: Claim | None = None) -> Verdict:
        """Decide a claim by branch and bound over the inputs and the states in their ranges.

        Args:
            claim: The claim.
            ranges: Ranges of the inputs and states.
            timeout: Seconds that it may take.
            broken: The claim that a refutation has to break; None for the claim itself.
        """
        if clock.now() > self.until:
            return Undecided(claim.text, SPENT)
        boxed = BoxedStep(self.model, ranges, list(dict.fromkeys(names_in_claim(claim))))
        if timeout > 0.0 and holds_in(boxed, claim, *boxed.box):  # as most ranges do
            return Proved(claim.text)
        progress = None if self.progress is None else partial(self.progress, claim.text)
        timeout = min(timeout, max(self.until - clock.now(), 0.0))
        result = decide(boxed, claim, Judge(self.replay, boxed.inputs, boxed.slice.shown, broken), timeout, progress)
        if not isinstance(result, Refuted):
            return result
        declared = {s.name for s in self.model.equations.states if s.bounds is not None}
        states = [n for n in boxed.slice.shown if n in self.replay.states]
        if all(result.witness.point[n] == self._start[n] for n in states):
            return replace(result, note=_FIRST if states else "")
        if all(n in declared and self._is_kept(n) for n in states if result.witness.point[n] != self._start[n]):
            return replace(result, note="the state is in its range; no run that reaches it was found")
        return Undecided(result.claim, f"it is false {result.witness}, but no run was found that reaches this state")

    def _is_kept(self, state: str) -> bool:
        return isinstance(self._verdicts.get(state, Proved("")), Proved)

    @cached_property
    def _start(self) -> dict[str, float]:
        return {s.name: s.start for s in self.model.equations.states}


def _as_proved(claim: StepClaim, verdict: Verdict) -> StepClaim:
    """Return a claim with room for rounding where it is proved with that only."""
    return loosened(claim) if isinstance(verdict, Proved) and verdict.note == _ROUNDED else claim


def _text(number: float) -> str:
    return f"{number:g}".replace("e+", "e")


def verdicts(
    controller: Controller, timeout: float, progress: Progress | None = None, free: Sequence[str] = ()
) -> Verdicts:
    """Return the verdict on each claim of a controller, in the order written; see `ControllerProver`."""
    prover = ControllerProver(controller, timeout, progress, free)
    return Verdicts(prover.verdict(c) for c in prover.claims.own)
