"""Proofs of loops: claims about every instant of every member of the family that a loop declares."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from fuzzyctl.analysis.coverage.box_search import Side
from fuzzyctl.analysis.reach import stability
from fuzzyctl.analysis.reach.flow import NoTubeError
from fuzzyctl.analysis.reach.forms import DomainError, Form, Mask, ends
from fuzzyctl.analysis.reach.reach import LeavesRangeError, ReachableSets, Record, Step, within
from fuzzyctl.analysis.reach.sets import Dimension, Parallelotope, halves, modes, widest, with_symbols
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.work import clock
from fuzzyctl.expr import Number, names_in
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import Always, Loop, Stable
from fuzzyctl.simulation.dead_times import kept_samples, without_idle_samples
from fuzzyctl.simulation.equations import Chip, on_chip, with_any_noise, without_adaptation
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.families import why_not_alike
from fuzzyctl.simulation.judgement import KEPT, Requirement, loosened
from fuzzyctl.simulation.loop_params import starts_of
from fuzzyctl.simulation.members import (
    Member,
    Tube,
    can_be_free,
    hull,
    intersection,
    is_broken,
    members,
    replayed,
    runs,
)  # fmt: skip
from fuzzyctl.simulation.sample_times import ALIGNED, sample_times

#: Most boxes that a family is cut into, and boxes that are enclosed at once.
MOST_BOXES: Final = 600
_TOGETHER: Final = 8
#: Most boxes for a claim about all times.
_MOST_PARTS: Final = 32
#: The part of the time in which parts of the ranges of params are tried at the start only.
_QUICK: Final = 0.3
#: Most open boxes that a verdict shows.
_SHOWN: Final = 3
#: Numbers of periods at which a set is replaced by a parallelotope that later sets may lie in.
ANCHORS: Final = frozenset(round(100 * 1.6**k) for k in range(24))

#: Members that are run to refute claims, and their time as a part of that of the proofs.
DRAWN: Final = 64
_RUNS: Final = 0.3
#: Numbers of periods at which it is tried whether a set contracts.
LOOKS: Final = frozenset({0, 2, 6, 14, *(round(30 * 1.5**k) for k in range(30))})

Progress = Callable[[str, int, int], None]


@dataclass
class _Claim:
    """A claim, its times, and the boxes for which it is open."""

    claim: Always
    begin: float
    end: float
    #: Boxes that are proved, and ends of boxes for which it is open, with the time and the reason.
    proved: int = 0
    open: list[tuple[Form, Form, float, str]] = field(default_factory=list)

    def speaks_of(self, step: Step) -> bool:
        """Whether a step has an instant that the claim is about."""
        slack = 1e-9 * step.length if step.length else 1e-9 * (1.0 + step.time)
        ends = step.time + step.length > self.begin + slack if step.length else step.time >= self.begin - slack
        return ends and step.time <= self.end + slack


class LoopProver:
    """Proves the claims of a loop.

    Args:
        loop: The loop.
        timeout: Seconds that the claims about finite times may take together, and each other claim.
        progress: Called now and then with a text and the numbers of settled and of open boxes.
        chip: The integers of its controllers, None for double precision.
        noise: How many standard deviations noise has at most; None for the numbers that its seeds draw.
    """

    def __init__(
        self,
        loop: Loop,
        timeout: float,
        progress: Progress | None = None,
        chip: Chip | None = None,
        noise: float | None = None,
    ) -> None:
        self.loop, self.timeout, self.progress, self.chip, self.noise = loop, timeout, progress, chip, noise
        self.own = loop.guarantees
        #: Enclosure of the outputs of the plants for the claims decided so far; None before the first.
        self.tube: Tube | None = None
        #: `NAME=VALUE` by which the loop differs from that of its file.
        self.settings: Sequence[str] = ()
        self._verdicts: dict[int, Verdict] = {}
        #: From when on all members are in balls that are proved to contract.
        self._settled = math.inf

    @cached_property
    def dimensions(self) -> list[Dimension]:
        """The numbers in which members differ: params, then starts."""
        number, starts = self.loop.number, starts_of(self.loop)
        dimensions = [
            Dimension(v.name, number(v.bounds.lower), number(v.bounds.upper), v.name if v.name in starts else "")
            for v in self.loop.varied
        ]
        return sorted(dimensions, key=lambda d: d.state != "")

    @cached_property
    def _outputs(self) -> list[str]:
        """Names of the outputs of plants."""
        results = {p.name: p.results for p in self.loop.plants}
        return [f"{i.name}.{r.name}" for i in self.loop.instances for r in results.get(i.controller, ())]

    def sets(self, claims: Sequence[Always], end: float) -> ReachableSets:
        """Return the sets for some claims up to a time, infinite for all times."""
        params = [d.name for d in self.dimensions if not d.state]
        number = self.loop.number
        conditions = [loosened(c.claim, 0.0 if c.within is None else number(c.within)) for c in claims]
        # Up to the sample at the end, or the next one, which a run may not have.
        step = sample_times(self.loop)[0]
        loop = self.loop
        if math.isfinite(end):
            loop = replace(loop, duration=Number(math.ceil(end / step - ALIGNED) * step))
        equations = without_idle_samples(loop, conditions, params, self._outputs)
        if not isinstance(equations, str) and equations.samples - 1 < end / equations.step - ALIGNED < math.inf:
            # The values that are given end with the run.
            again = kept_samples(loop_equations(loop, conditions, params)) if equations.given else equations
            equations = again if equations.given else replace(equations, samples=equations.samples + 1)
        if isinstance(equations, str):
            raise DomainError(equations)
        equations = with_any_noise(on_chip(equations, self.chip.blocks if self.chip else {}), self.noise)
        columns = np.zeros((equations.samples, 0))
        if equations.given:
            from fuzzyctl.simulation.experiment import Experiment

            columns = Experiment(loop, "python").given[:: round(equations.step / step)]
        return ReachableSets(equations, len(conditions), columns, self._outputs)

    def verdict(self, claim: Always | Stable) -> Verdict:
        """Return the verdict on one of the claims in `own`."""
        position = next(k for k, c in enumerate(self.own) if c is claim)
        if reason := self._of_integers(claim):
            return Undecided(guarantee_text(claim), reason, span=claim.span)
        if position in self._refuted:
            refuted = self._refuted[position]
            if not self._assumed:
                return refuted
            kinds = ((self.chip, "in double precision"), (self.noise, "with the noise of its seeds"))
            where = " and ".join(text for kind, text in kinds if kind is not None)
            return Undecided(refuted.claim, f"{where} a member breaks it: {refuted.note}", span=claim.span)
        if position not in self._verdicts:
            if reason := self._unsuited or why_not_alike(self.loop, claim):
                self._verdicts[position] = Undecided(guarantee_text(claim), reason)
            elif isinstance(claim, Stable):
                self._verdicts[position] = self._stable()
            elif claim.forever:
                self._verdicts[position] = self._forever(claim)
            else:
                asked = {k: c for k, c in enumerate(self.own) if k not in self._refuted}
                asked = {k: c for k, c in asked.items() if not why_not_alike(self.loop, c)}
                finite = {k: c for k, c in asked.items() if isinstance(c, Always) and not c.forever}
                self._verdicts |= dict(zip(finite, self._for_a_time(list(finite.values())), strict=True))
        verdict = self._verdicts[position]
        if self._assumed and isinstance(verdict, Proved):
            verdict = replace(verdict, note="; ".join([verdict.note, *self._assumed]))
        return replace(verdict, span=claim.span)

    @cached_property
    def _assumed(self) -> list[str]:
        """Text of the differences between the loop that is enclosed and the one that runs."""
        chip = [] if self.chip is None else [f"the controllers in {self.chip.form}"]
        return [*chip, *([] if self.noise is None else [f"noise up to {self.noise:g} standard deviations"])]

    def _of_integers(self, claim: Always | Stable) -> str:
        """Why a claim in fixed point is not decided: a block has no integers, or they round a state that it reads."""
        if self.chip is None or self.chip.reason:
            return self.chip.reason if self.chip else ""
        pairs = [(i.name, self.loop.callee(i)) for i in self.loop.instances]
        states = {f"{block}.{s.name}" for block, c in pairs if isinstance(c, Controller) for s in c.states}
        name = next((n.name for n in names_in(claim.claim) if n.name in states), "")
        return f"the claim reads '{name}', which integers round" if name else ""

    @cached_property
    def _unsuited(self) -> str:
        """Why no set of the loop is enclosed, an empty text if it may be."""
        if any(p.external for p in self.loop.plants):
            return "a plant is a program, which cannot be enclosed"
        params = [d.name for d in self.dimensions if not d.state]
        fixed = [name for name in params if not can_be_free(self.loop, name)]
        if fixed:
            return f"'{fixed[0]}' cannot vary in a proof: a constant such as the start of a state depends on it"
        equations = kept_samples(loop_equations(self.loop, free=params))
        if isinstance(equations, str):
            return equations
        return next(
            (
                f"system '{item.system.name}' keeps a state, which cannot be enclosed yet"
                for item in without_adaptation(equations).body
                if isinstance(item, Evaluation) and item.states
            ),
            "",
        )

    @cached_property
    def _refuted(self) -> dict[int, Refuted]:
        """Claims that a drawn member breaks at a sample of its run, by position."""
        until = clock.used() + _RUNS * self.timeout
        order = [k for k, c in enumerate(self.own) if isinstance(c, Always)]
        refuted: dict[int, Refuted] = {}
        drawn = members(self.loop, DRAWN) if order else []
        for member, run in zip(drawn, runs(self.loop, drawn), strict=True):
            judged = run.requirements[len(self.loop.requirements) :]
            for k, requirement in zip(order, judged, strict=True):
                if requirement.verdict == KEPT[False] and k not in refuted:
                    claim = self.own[k]
                    assert isinstance(claim, Always)
                    if is_broken(claim, self.loop, member, run):
                        refuted[k] = self._refutation(k, member, requirement)
            if len(refuted) == len(order) or clock.used() > until:
                break
        return refuted

    def _refutation(self, position: int, member: Member, requirement: Requirement) -> Refuted:
        claim = self.own[position]
        note = ", ".join(requirement.facts)
        note += f"; fuzzyctl simulate {replay} shows it" if (replay := replayed(member, self.settings)) else ""
        return Refuted(guarantee_text(claim), Witness(dict(member), ()), span=claim.span, note=note)

    def _for_a_time(self, claims: Sequence[Always]) -> list[Verdict]:
        """Return the verdicts on claims about finite times."""
        number = self.loop.number
        duration = number(self.loop.duration)
        asked = [
            _Claim(c, 0.0 if c.begin is None else number(c.begin), duration if c.end is None else number(c.end))
            for c in claims
        ]
        sets = self.sets(claims, max(c.end for c in asked))
        until = clock.used() + self.timeout
        boxes = [(*self._family(), list(range(len(asked))))]
        tubes: list[Tube] = []
        settled = 0
        while boxes:
            batch, boxes = boxes[:_TOGETHER], boxes[_TOGETHER:]
            low, high = np.array([b[0] for b in batch]), np.array([b[1] for b in batch])
            due = [b[2] for b in batch]
            record = Record(self._outputs)
            broken = self._enclosed(sets, asked, low, high, due, until, record)
            settling = []
            for box in range(len(batch)):
                failed = [k for k in due[box] if broken[k][box][1]]
                for k in due[box]:
                    asked[k].proved += k not in failed
                cut = max((broken[k][box][2] for k in failed), key=lambda b: b[1], default=(-1, 0.0))[0]
                cut = cut if cut >= 0 else widest(low[box], high[box])
                room = settled + len(boxes) + len(batch) < MOST_BOXES and clock.used() < until
                if failed and cut >= 0 and room:
                    # In the halves only the claims that are open in the whole are examined.
                    boxes += [(*half, failed) for half in halves(low[box], high[box], cut)]
                    continue
                settled += 1
                settling.append(box)
                for k in failed:
                    time, reason, _ = broken[k][box]
                    asked[k].open.append((low[box], high[box], time, reason))
            tubes += [record.tube(settling)] if settling else []
            if self.progress is not None:
                self.progress("reachable sets", settled, len(boxes))
        self._keep(hull(tubes))
        return [self._judged(c) for c in asked]

    def _keep(self, tube: Tube) -> None:
        self.tube = tube if self.tube is None else intersection([self.tube, tube])

    def _family(self) -> tuple[Form, Form]:
        return np.array([d.low for d in self.dimensions]), np.array([d.high for d in self.dimensions])

    def _begin(self, sets: ReachableSets, low: Form, high: Form) -> tuple[list[Form], list[Form], list[Form]]:
        """Return forms of plants' states, controllers' states and free params over some boxes."""
        count, width = low.shape
        forms = np.zeros((width, count, 2 + width))
        for k in range(width):
            forms[k, :, 0], forms[k, :, 2 + k] = 0.5 * (low[:, k] + high[:, k]), 0.5 * (high[:, k] - low[:, k])
            forms[k, :, 1] = 2e-16 * (np.abs(low[:, k]) + np.abs(high[:, k]))
        at = {d.state: forms[k] for k, d in enumerate(self.dimensions) if d.state}
        constant = np.zeros((count, 2 + width))

        def of(name: str, start: float) -> Form:
            return at[name] if name in at else constant + start * np.eye(1, 2 + width)

        plant = [of(s.name, s.start) for s in sets.equations.plant_states]
        memory = [of(s.name, s.start) for s in sets.equations.states]
        return plant, memory, [forms[k] for k, d in enumerate(self.dimensions) if not d.state]

    def _enclosed(
        self,
        sets: ReachableSets,
        claims: Sequence[_Claim],
        low: Form,
        high: Form,
        due: Sequence[Sequence[int]],
        until: float,
        record: Record,
    ) -> list[list[tuple[float, str, tuple[int, float]]]]:
        """Return for each claim and box the time at which it is open, the reason, and where to cut the box.

        Args:
            sets, claims: The sets, and the claims about them.
            low, high: Ends of the boxes, shape (boxes, dimensions).
            due: Positions of the claims to examine in each box.
            until: Processor seconds at which the time is over.
            record: Takes the outputs over the steps.
        """
        nothing, idle = (0.0, "", (-1, 0.0)), (0.0, "not due", (-1, 0.0))
        broken = [[nothing if k in positions else idle for positions in due] for k in range(len(claims))]
        time = 0.0
        try:
            for step in sets.run(*self._begin(sets, low, high), len(self.dimensions)):
                time = step.time
                record.add(step)
                self._look(sets, claims, step, broken)
                if clock.used() > until:
                    raise DomainError(f"the time of {self.timeout:g} s is over")
                if all(row[1] for rows in broken for row in rows):
                    break
        except (NoTubeError, DomainError) as error:
            what = str(error) or "no enclosure of the solutions is proved: a state may grow without limit"
            for rows, claim in zip(broken, claims, strict=True):
                if claim.end >= time:
                    cut = (int(np.argmax(np.max(high - low, 0))), 0.0) if low.shape[1] else (-1, 0.0)
                    rows[:] = [row if row[1] else (time, what, cut) for row in rows]
        return broken

    def _look(
        self,
        sets: ReachableSets,
        claims: Sequence[_Claim],
        step: Step,
        broken: list[list[tuple[float, str, tuple[int, float]]]],
    ) -> None:
        """Note the boxes in which a claim is open over a step, or a state may leave its range."""
        count = len(broken[0])
        for k, claim in enumerate(claims):
            if step.time > claim.end + ALIGNED * sets.equations.step:
                continue
            # At the last time of the claim it is about this instant alone.
            last = step.begin is not None and step.time >= claim.end - 1e-9 * step.length
            place = step.begin() if step.begin is not None and last else step
            checks = self._left(sets, place)
            if claim.speaks_of(place):
                checks.append(("the enclosure is too wide", ~place.truths[k][0]))
            for text, mask in checks:
                for box in np.flatnonzero(np.broadcast_to(mask, count)):
                    if not broken[k][box][1]:
                        broken[k][box] = (step.time, text, self._cut(step, int(box)))

    def _left(self, sets: ReachableSets, step: Step) -> list[tuple[str, Mask]]:
        """Return which states may leave their ranges over a step, in words, and in which boxes."""
        left: list[tuple[str, Mask]] = []
        for state, form in zip(sets.equations.plant_states, step.states, strict=True):
            if math.isfinite(state.low) or math.isfinite(state.high):
                low, high = ends(form)
                outside = ~within(state, low, high)
                if outside.any():
                    text = f"state '{state.name}' may leave its range: it lies in [{low.min():.4g}, {high.max():.4g}]"
                    left.append((text, outside))
        return left

    def _cut(self, step: Step, box: int) -> tuple[int, float]:
        """Return which side of a box to cut, and its share in the widths of the states."""
        width = len(self.dimensions)
        if not width or not step.states:
            return -1, 0.0
        shares = np.zeros(width)
        for form in step.states:
            row = form[box]
            total = np.abs(row[1:]).sum()
            shares += np.abs(row[2 : 2 + width]) / total if total else 0.0
        return (int(np.argmax(shares)), float(np.max(shares))) if shares.any() else (-1, 0.0)

    def _judged(self, claim: _Claim) -> Verdict:
        text = guarantee_text(claim.claim)
        if not claim.open:
            boxes = "1 box" if claim.proved == 1 else f"{claim.proved} boxes"
            return Proved(text, note=f"for all members, in {boxes}")
        first = min(claim.open, key=lambda o: o[2])
        reason = f"at t = {first[2]:.6g} s {first[3]}"
        if not self.dimensions:
            return Undecided(text, reason)
        sides = [self._sides(low, high) for low, high, _, _ in claim.open[:_SHOWN]]
        return Undecided(text, reason, tuple(sides), len(claim.open))

    def _sides(self, low: Form, high: Form) -> dict[str, Side]:
        return {d.name: Side(float(a), float(b)) for d, a, b in zip(self.dimensions, low, high, strict=True)}

    def _forever(self, claim: Always) -> Verdict:
        """Return the verdict on a claim about all times: a set that later lies in itself is invariant."""
        text = guarantee_text(claim)
        sets = self.sets([claim], math.inf)
        if reason := sets.why_aperiodic():
            return Undecided(text, reason)
        for stable in (c for c in self.own if isinstance(c, Stable)):
            self.verdict(stable)
        return self._cut_up(lambda low, high, until: self._forever_in(claim, sets, low[None], high[None], until))

    def _cut_up(
        self, proved: Callable[[Form, Form, float], tuple[Proved | Undecided, int]], share: float = 1.0
    ) -> Proved | Undecided:
        """Return the verdict on a claim that holds if it does in all parts of the family.

        Args:
            proved: Returns the verdict for a box, given its ends and the processor time at which to stop; and the side
                along which to cut the box, -1 to leave it.
            share: The part of the time that it may take.
        """
        boxes, results = [self._family()], list[Proved]()
        until = clock.used() + share * self.timeout
        while boxes:
            low, high = boxes.pop()
            verdict, side = proved(low, high, until)
            if isinstance(verdict, Proved):
                results.append(verdict)
            elif side >= 0 and len(boxes) + len(results) < _MOST_PARTS and clock.used() < until:
                boxes += halves(low, high, side)[::-1]
            else:
                boxes_open = (self._sides(low, high),) if len(low) else ()
                return replace(verdict, boxes=boxes_open, remaining=len(boxes_open))
            if self.progress is not None:
                self.progress("parts of the family", len(results), len(boxes))
        if len(results) == 1:
            return results[0]
        note = f"in each of {len(results)} boxes; in the first: {results[0].note}"
        return replace(results[0], note=note, data=tuple(r.data for r in results))

    def _forever_in(
        self, claim: Always, sets: ReachableSets, low: Form, high: Form, until: float
    ) -> tuple[Proved | Undecided, int]:
        """Return the verdict on a claim about all times for a box of the family, and where to cut it."""
        text = guarantee_text(claim)
        begin = 0.0 if claim.begin is None else self.loop.number(claim.begin)
        longest = widest(low[0], high[0])
        asked = _Claim(claim, begin, math.inf)
        params = sum(not d.state for d in self.dimensions)
        plant, memory, free = self._begin(sets, low, high)
        anchor: list[Parallelotope] = []
        previous: list[list[Form]] = []
        notes: list[str] = []
        length, rate = sets.equations.step, sets.cycle

        def look(period: int, rows: list[Form]) -> list[Form] | None:
            if period % rate:
                return rows
            if anchor and anchor[0].holds(rows):
                notes.append(f"the set at t = {period * length:.6g} s lies in an earlier one")
                return None
            motion = modes(previous[0], rows) if previous else None
            previous[:] = [rows]
            if (
                period // rate in LOOKS
                and period * length >= max(begin, self._settled - 0.5 * length)
                and in_ball(rows, motion)
            ):
                notes.append(f"from t = {period * length:.6g} s on in a ball that a period maps into itself")
                return None
            if period // rate in ANCHORS and period * length >= begin:
                anchor[:] = [Parallelotope(rows, params, motion)]
                previous.clear()
                return anchor[0].rows
            return rows

        def in_ball(rows: list[Form], motion: tuple[Form, Form] | None) -> bool:
            try:
                ball = stability.contraction(sets, rows, free, motion, until)
                if ball is None:
                    return False
                first, during, n = ball.rows(params), [[(0.0, "", (-1, 0.0))]], len(sets.plant)
                for step in sets.run(first[:n], first[n:], free, params, lambda k, r: r if k < rate else None):
                    self._look(sets, [_Claim(claim, 0.0, math.inf)], step, during)
            except (NoTubeError, DomainError, LeavesRangeError):
                return False
            return not during[0][0][1]

        broken: list[list[tuple[float, str, tuple[int, float]]]] = [[(0.0, "", (-1, 0.0))]]
        record = Record(self._outputs)
        try:
            for step in sets.run(plant, memory, free, len(self.dimensions), look):
                record.add(step)
                self._look(sets, [asked], step, broken)
                time, reason, (side, _) = broken[0][0]
                if reason:
                    return Undecided(text, f"at t = {time:.6g} s {reason}"), side
                if clock.used() > until:
                    reason = f"no set of t <= {step.time:.6g} s lies in an earlier one: more time may help"
                    return Undecided(text, reason), -1
        except (NoTubeError, DomainError) as error:
            return Undecided(text, str(error) or "no enclosure of the solutions is proved"), longest
        finally:
            if all(map(np.array_equal, (low[0], high[0]), self._family())):  # the tube of a part is not kept
                self._keep(record.tube([0]))
        return Proved(text, note=notes[0]), -1

    def _stable(self) -> Verdict:
        """Return the verdict on convergence: the members come into a ball that a period contracts."""
        text = "stable"
        sets = self.sets([], math.inf)
        if reason := sets.why_aperiodic():
            return Undecided(text, reason)
        if sets.equations.errors:
            cause = "rounding and noise keep a loop from a point" if self._assumed else "consequents settle anywhere"
            return Undecided(text, f"{cause}: claim a range with 'require always ... from'")
        if sets.spread:
            return Undecided(text, "with a disturbance nothing converges: claim a range with 'require always ... from'")
        if sets.cycle > (most := stability.MOST_CYCLE):
            return Undecided(text, f"controllers sample together every {sets.cycle} samples, not {most} or fewer")
        if not (sets.plant or sets.memory):
            return Undecided(text, "the loop has no state that could converge")
        share = 1.0
        if any(not d.state for d in self.dimensions):
            # Each member has one value of a param: parts of the range may have functions that the whole has not.
            share -= _QUICK
            quick = self._cut_up(lambda *box: self._stable_in(sets, *box, at_start=True), _QUICK)
            if isinstance(quick, Proved):
                return quick
        return self._cut_up(lambda *box: self._stable_in(sets, *box), share)

    def _stable_in(
        self, sets: ReachableSets, low: Form, high: Form, until: float, *, at_start: bool = False
    ) -> tuple[Proved | Undecided, int]:
        """Return the verdict on convergence for a box of the family, and where to cut it.

        Args:
            sets: The loop.
            low, high: The ends of the box.
            until: Processor seconds at which to stop.
            at_start: Whether to look at the start only.
        """
        params = sum(not d.state for d in self.dimensions)
        text, longest = "stable", widest(low[: params or None], high[: params or None])
        plant, memory, free = self._begin(sets, low[None], high[None])
        balls: list[stability.Contraction] = []
        reasons: list[str] = []
        previous: list[list[Form]] = []

        def look(period: int, rows: list[Form]) -> list[Form] | None:
            if period % sets.cycle:
                return rows
            motion = modes(previous[0], rows) if previous else None
            previous[:] = [rows]
            if period // sets.cycle in LOOKS:
                try:
                    ball = stability.contraction(sets, rows, free, motion, until)
                except (NoTubeError, DomainError, LeavesRangeError) as error:
                    ball = None
                    reasons[:] = [str(error)]
                if ball is not None:
                    balls.append(ball)
                    return None
            return rows

        time = 0.0
        boxes = max(len(a) for a in (*plant, *memory))
        begin = with_symbols([np.broadcast_to(a, (boxes, a.shape[-1])) for a in (*plant, *memory)])
        if look(0, begin) is None:
            return self._converges(sets, free, balls[0], 0.0), -1
        if at_start:
            return Undecided(text, "no set contracts at the start"), longest
        try:
            for step in sets.run(plant, memory, free, len(self.dimensions), look):
                time = step.time
                if left := self._left(sets, step):
                    return Undecided(text, f"at t = {time:.6g} s {left[0][0]}"), self._cut(step, 0)[0]
                if clock.used() > until:
                    break
        except (NoTubeError, DomainError) as error:
            reasons[:] = [str(error) or "no enclosure of the solutions is proved"]
        if balls:
            return self._converges(sets, free, balls[0], time + sets.equations.step), -1
        why = f": {reasons[0]}" if reasons and reasons[0] else ""
        return Undecided(text, f"no set of t <= {time:.6g} s is proved to contract{why}"), longest

    def _converges(self, sets: ReachableSets, free: Sequence[Form], ball: stability.Contraction, time: float) -> Proved:
        self._settled = time if self._settled == math.inf else max(self._settled, time)
        what = "distances to the point of rest shrink" if ball.to_rest else "distances shrink"
        note = f"from t = {time:.6g} s on {what} by {ball.rate:.6g} each {sets.cycle * sets.equations.step:g} s"
        facts = stability.sectors(sets, free, ball) if ball.to_rest else []
        return Proved("stable", note="; ".join([note, *facts]), data=ball)
