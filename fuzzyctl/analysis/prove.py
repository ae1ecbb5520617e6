"""Proofs of guarantees by the cheapest method that decides each: bounds, corners of cells, branch and bound."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Set
from contextlib import suppress
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, Final

from fuzzyctl.analysis import sampling
from fuzzyctl.analysis.affine import Reader
from fuzzyctl.analysis.bounds import OutputBound, output_bounds
from fuzzyctl.analysis.claims import (
    ALWAYS,
    Bound,
    Claim,
    Denied,
    Every,
    Slope,
    Some,
    Total,
    Truth,
    claim_of,
    outputs_in,
    outside,
    speaks_of_all_points,
)
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.box_search import Undecided as Unclear
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.analysis.coverage.silence import Silence, silent_point, unclear_at
from fuzzyctl.analysis.multilinear import pointwise, slopes
from fuzzyctl.analysis.multilinear.surface import Surface, surface_of
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Verdicts, Witness
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.analysis.work import COVERAGE, SEARCH, SPENT, SpentError, Work
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import Binary, Expr, span_of, to_text, walk
from fuzzyctl.kernels.forms import known_at
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.model.block import Block, Guarantee
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.inlined_lets import inlined, named_lets
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import dataclass
from fuzzyctl.simulation.equations import Chip
from fuzzyctl.support import arguments

#: Seconds that one guarantee may take.
TIMEOUT: Final = 10.0
#: Most products of corners and rules without a time limit.
QUICK: Final = 10_000
#: Units of work for the slopes at a corner.
_CORNER: Final = 100
#: Units of work for reading an operation of a guarantee.
_GUARANTEE: Final = 60
#: Seconds spent on points at which a guarantee divides by 0, without a time limit.
LOOKED: Final = 1.0

#: Seconds that a claim may take in a command that does more than prove.
CLAIM_SECONDS: Final = 1.0

#: Reason of a verdict on a claim that depends on a state.
_AT_FIRST: Final = "no point is found that breaks the claim with what is at first"

#: Why claims that subdivision cannot decide, such as equalities, stay open for systems that do not interpolate.
_EXACTLY: Final = "of a system that interpolates ('and product', 'center_average') it is decided exactly"

#: Why such a claim is not decided exactly although all else interpolates.
_LETS: Final = "where rules read a let, here '{}', no claim is decided exactly"

#: Why a claim is open that quick methods leave so.
UNDIVIDED: Final = "it takes subdivision, for which no time is given"

#: Why `total` of an output is undecided for lack of work in a proof, which no time limit changes.
_TOO_MUCH: Final = f"it takes more than {COVERAGE:,} units of work, the most for the coverage of an output"

#: Progress callback of a long proof: the claim, boxes settled, boxes open.
Progress = Callable[[str, int, int], None]


def prove(
    path: str | os.PathLike[str] | FuzzySystem | Controller | Loop,
    *,
    block: str | None = None,
    timeout: float = TIMEOUT,
    progress: Progress | None = None,
) -> Verdicts:
    """Prove the guarantees of a rule file, a system or a controller for all inputs in their ranges, or of a loop.

    Inputs that extrapolate run over all real numbers. Others are clamped, so that a claim that names outputs at the
    inputs as they are, and no inputs, also holds for all real numbers; a claim or a condition that names an input is
    about values in its range. A claim is about the points where the outputs it names have a value; `total(f)` says that
    they do everywhere. If no point of the ranges meets a condition, the verdict notes it.

    Claims of a controller are about every step that a run from its start may come to; ranges of its states and outputs
    are claims, too. A range of a state is proved by induction: it holds the start, and no step leaves it.

    Claims of a loop are about every instant of every member of its family, the plants solved exactly. A refuted one has
    a member as its witness, whose run breaks it.

    Args:
        path: The `.fz` file, the system, the controller, or the loop.
        block: Name of the system, controller or loop; None for the only one of the first kind that the file has.
        timeout: Seconds that one guarantee may take.
        progress: Called now and then during a long proof.

    Returns:
        One verdict for each guarantee, of a controller for each range of a state or an output as well, in the order
        written.

    Raises:
        DiagnosticError: For a file with mistakes.
        ArgumentError: For an object that is not a path, system, controller or loop, and for other arguments of another
            type.
        ValueOutOfBoundsError: For a negative timeout.
    """
    timeout = arguments.seconds("'timeout'", timeout)
    if progress is not None and not callable(progress):
        raise arguments.wrong("'progress'", "a function, or None", progress)
    if not isinstance(path, Block):
        from fuzzyctl.loading.load import block_name, chosen, opened

        kinds: tuple[type[Any], ...] = (FuzzySystem, Controller, Loop)
        return prove(chosen(opened(path), block_name(block), *kinds), timeout=timeout, progress=progress)
    prover = prover_of(path, timeout, progress)
    verdicts = Verdicts(prover.verdict(claim) for claim in prover.own)
    verdicts.tube = getattr(prover, "tube", None)
    return verdicts


def prover_of(
    block: Block,
    timeout: float = TIMEOUT,
    progress: Progress | None = None,
    chip: Chip | None = None,
    noise: float | None = None,
) -> Any:
    """Return the prover of a system, a controller or a loop: `verdict` decides each claim in `own`.

    Args:
        block: The block.
        timeout: Seconds that a claim may take.
        progress: Called now and then.
        chip: The integers of the controllers of a loop.
        noise: How many standard deviations the noise of a loop has at most; None for that of its seeds.

    Raises:
        ArgumentError: For another block.
    """
    if isinstance(block, FuzzySystem):
        return Prover(block, timeout, progress)
    if isinstance(block, Loop):
        from fuzzyctl.analysis.reach.prover import LoopProver

        return LoopProver(block, timeout, progress, chip, noise)
    from fuzzyctl.analysis.induction.prover import ControllerProver

    controller = arguments.instance("the block", Controller, "a FuzzySystem, a Controller or a Loop", block)
    return ControllerProver(controller, timeout, progress)


@dataclass
class Prover:
    """Proves guarantees of one system; the parts that several need are computed once.

    Args:
        system: The system.
        timeout: Seconds that one guarantee may take; 0 for the quick methods only.
        progress: Called now and then.
        work: The work that the quick methods may spend on all guarantees; None for no limit.
    """

    system: FuzzySystem
    timeout: float = TIMEOUT
    progress: Progress | None = None
    work: Work | None = None
    _boxed: Any = field(default=None, init=False, repr=False)

    @property
    def own(self) -> tuple[Guarantee, ...]:
        """The claims of the system."""
        return self.system.guarantees

    @cached_property
    def plan(self) -> Plan:
        """The system as numbers."""
        return plan(self.system)

    @cached_property
    def surface(self) -> Surface | None:
        """The outputs in rational arithmetic, None if they do not interpolate."""
        return self._surface_of(self.plan)

    @cached_property
    def surfaces(self) -> tuple[Surface | None, ...]:
        """The own outputs and those of the compared systems."""
        return self.surface, *(self._surface_of(plan(c)) for c in self.system.compared)

    def _surface_of(self, flat: Plan) -> Surface | None:
        return surface_of(flat) if self.timeout > 0.0 else surface_of(flat, most=QUICK)

    @cached_property
    def _lets_of_rules(self) -> list[str]:
        """The lets that rules read, so that no output is a surface over the inputs that interpolates."""
        read = {d.variable - len(self.plan.inputs) - len(self.plan.outputs) for d in self.plan.degrees}
        return [let.name for k, let in enumerate(self.plan.lets) if k in read]

    @cached_property
    def bounds(self) -> Mapping[str, OutputBound]:
        """Bounds of the outputs by their consequents alone."""
        return output_bounds(self.system)

    @cached_property
    def judge(self) -> Judge:
        """Evaluates witnesses."""
        return Judge(self.system, self.work)

    def verdict(self, guarantee: Guarantee) -> Verdict:
        """Return the verdict on a guarantee."""
        claim = claim_of(self.system, guarantee)
        result = self._settled(claim)
        if isinstance(result, Undecided):
            part = self._part_without_value(guarantee, claim)
            if part is not None:
                reason = f"it {_lacks(*part)}; 'when' can leave such points out"
                result = replace(result, reason=reason, boxes=(), remaining=0)
            elif result.remaining and (reason := self._state_of(claim)):
                result = replace(result, reason=reason, boxes=(), remaining=0)
            elif self._lets_of_rules:
                result = replace(result, reason=f"{result.reason}; {_LETS.format(self._lets_of_rules[0])}")
            elif result.remaining and self.surface is None:
                result = replace(result, reason=f"{result.reason}; {_EXACTLY}")
        if isinstance(result, Refuted) and (lets := named_lets(self.system, guarantee)):
            result = replace(result, witness=self._with_lets(result.witness, lets))
        if not isinstance(result, Refuted) and self._is_void(guarantee):
            result = Proved(claim.text, note="the claim is void: no point of the ranges is in the region")
        return replace(result, claim=claim.text, span=guarantee.span)

    def _with_lets(self, witness: Witness, lets: Set[str]) -> Witness:
        """Return a witness with the values of the lets of its claim."""
        numbers = known_at(self.plan, list(witness.point.values()))
        values = tuple((let.name, numbers[let.name]) for let in self.plan.lets if let.name in lets)
        return replace(witness, sides=(*values, *witness.sides))

    def _state_of(self, claim: Claim) -> str:
        """Return the state that a claim depends on besides the inputs, an empty text for no state."""
        spoken = outputs_in(claim.truth)
        for k, output in enumerate(self.plan.outputs):
            if output.name in spoken and k in {o for o, _ in self.plan.states}:
                ends = f"from {output.lower:.6g} to {output.upper:.6g}"
                return f"'{output.name}' is adaptive: its consequents may become anything {ends}; {_AT_FIRST}"
            if output.name in spoken and k in self.plan.held:
                return f"'{output.name}' holds what it was before where no rule fires; {_AT_FIRST}"
        return ""

    def _is_void(self, guarantee: Guarantee) -> bool:
        """Return whether the region of a guarantee is proved to hold no point, if it has one and there is time."""
        region, nowhere = claim_of(self.system, guarantee).region, outside(self.system, guarantee)
        if nowhere is None or self.timeout <= 0.0:
            return False
        if any(self.judge.lies_in(region, point) for point in sampling.points(self.plan)):
            return False
        brief = replace(self, timeout=min(self.timeout, LOOKED), progress=None)
        return isinstance(brief._pointwise(nowhere), Proved)

    def without_value(self, guarantee: Guarantee) -> Diagnostic | None:
        """Report a guarantee that has no value at some point of its region, such as one that divides by 0."""
        part = self._part_without_value(guarantee, claim_of(self.system, guarantee))
        if part is None:
            return None
        culprit, help_text = part[0], "leave such points out with 'when'"
        if isinstance(culprit, Binary) and culprit.op == "/":
            culprit, help_text = culprit.right, f"{help_text}, or multiply both sides"
        message = f"the guarantee {_lacks(*part)}"
        return Diagnostic("FZ307", message, span_of(culprit) or guarantee.span, help=help_text, witness=part[1])

    def _part_without_value(self, guarantee: Guarantee, claim: Claim) -> tuple[Expr, dict[str, float]] | None:
        return sampling.without_value(inlined(self.system, guarantee), claim, self.plan, self.judge)

    def _settled(self, claim: Claim) -> Verdict:
        match claim.truth:
            case Slope():
                return self._slope(claim, claim.truth)
            case Total(output=output):
                return self._total(claim, output)
            case Denied(part=part):
                return _denied(self._settled(replace(claim, truth=part)))
            case Every(parts=parts) | Some(parts=parts) if speaks_of_all_points(claim.truth):
                verdicts = [self._settled(replace(claim, truth=p)) for p in parts]
                return _joined(claim, verdicts, every=isinstance(claim.truth, Every))
        return self._pointwise(claim)

    def _pointwise(self, claim: Claim) -> Verdict:
        if self._follows_from_bounds(claim.truth):
            return Proved(claim.text)
        result = pointwise.decide(self.system, self.surfaces, claim, self.judge)
        return self._divided(claim) if result is None else result

    def _follows_from_bounds(self, truth: Truth) -> bool:
        if isinstance(truth, Bound):
            return self._is_bounded(truth)
        assert isinstance(truth, Every | Some)
        return (all if isinstance(truth, Every) else any)(self._follows_from_bounds(p) for p in truth.parts)

    def _is_bounded(self, bound: Bound) -> bool:
        """Return whether one output and numbers are compared, and the bounds of the output say enough."""
        reader = Reader(self.system)
        left, right = reader.read(bound.left), reader.read(bound.right)
        if left is None or right is None:
            return False
        difference = left.plus(right, Fraction(-1))
        if difference.inputs or len(difference.outputs) != 1:
            return False
        ((operand, factor),) = difference.outputs.items()
        system = (self.system, *self.system.compared)[operand.system]
        limits = (self.bounds if not operand.system else output_bounds(system))[system.outputs[operand.output].name]
        if not all(abs(e) < float("inf") for e in (limits.lo, limits.hi)):
            return False
        least = min(difference.number + factor * Fraction(e) for e in (limits.lo, limits.hi)) + bound.tolerance
        return least > 0 or (least == 0 and not bound.strict)

    def _total(self, claim: Claim, output: str) -> Verdict:
        result = uncovered_of(self.plan, self.work)[output]
        if result is None:
            return Proved(claim.text)
        silence = Silence(self.plan, output, Work(SEARCH) if self.work is None else self.work.part(SEARCH))
        if isinstance(result, Hole):
            coordinates = list(result.witness.values())
            with suppress(SpentError):
                if self.judge.lies_in(claim.region, coordinates) and silence.holds_at(coordinates):
                    return Refuted(claim.text, self.judge.silent(output, coordinates))
        point = silent_point(self.plan, silence, partial(self.judge.lies_in, claim.region))
        if point is not None:
            return Refuted(claim.text, self.judge.silent(output, point))
        if isinstance(result, Unclear):
            is_proof = result.spent and self.work is None
            return Undecided(claim.text, _TOO_MUCH if is_proof else result.reason)
        if claim.region == ALWAYS:
            return Undecided(claim.text, unclear_at(result))
        return Undecided(claim.text, f"no rule fires where {result}; no point of the region is found there")

    def _slope(self, claim: Claim, slope: Slope) -> Verdict:
        result: Verdict | None = None
        surface = self.surface
        if surface is not None and (self.work is None or self.work.takes(_CORNER * len(surface.indices))):
            result = slopes.decide_slope(self.system, surface, claim, slope, self.judge)
        if result is None:
            result = self._divided(claim)
        if isinstance(result, Refuted) and claim.region != ALWAYS:
            return Undecided(claim.text, "slopes are proved for all inputs only, and for some of them it is broken")
        return result

    def _divided(self, claim: Claim) -> Verdict:
        """Decide a claim by subdivision, which needs numpy."""
        if self.timeout <= 0.0:
            witness = sampling.witness_of(claim, self.plan, self.judge)
            if witness is not None:
                return Refuted(claim.text, witness)
            return Undecided(claim.text, UNDIVIDED)
        from fuzzyctl.analysis.branch_and_bound import pointwise as branching
        from fuzzyctl.analysis.branch_and_bound import slope as box_slopes
        from fuzzyctl.analysis.branch_and_bound.boxed_system import System

        if self._boxed is None:
            self._boxed = System(self.system, self.plan)
        progress = None if self.progress is None else partial(self.progress, claim.text)
        if isinstance(claim.truth, Slope):
            return box_slopes.decide_slope(self._boxed, claim, claim.truth, self.judge, self.timeout, progress)
        return branching.decide(self._boxed, claim, self.judge, self.timeout, progress)


def diagnostics(system: FuzzySystem) -> list[Diagnostic]:
    """Report the guarantees that quick methods refute; the undecided ones are not reported."""
    return quickly(system)[1]


def quickly(system: FuzzySystem, work: Work | None = None) -> tuple[list[Verdict], list[Diagnostic]]:
    """Return what quick methods say of guarantees, and report those that are refuted or somewhere have no value.

    Args:
        system: The system.
        work: The work that is allowed for all of them.
    """
    work = Work() if work is None else work
    prover = Prover(system, timeout=0.0, work=work)
    verdicts: list[Verdict] = []
    results: list[Diagnostic] = []
    for guarantee in system.guarantees:
        written = inlined(system, guarantee)
        if not work.takes(_GUARANTEE * sum(1 for e in (written.claim, written.when) if e for _ in walk(e))):
            verdicts.append(Undecided(to_text(guarantee.claim), SPENT, span=guarantee.span))
            continue
        lacking = prover.without_value(guarantee)
        if lacking is not None:
            results.append(lacking)
        verdict = prover.verdict(guarantee)
        verdicts.append(verdict)
        if isinstance(verdict, Refuted) and lacking is None:
            results.append(refutation(verdict))
    return verdicts, results


def refutation(verdict: Refuted) -> Diagnostic:
    """Report a claim that does not hold, with the point that shows it."""
    message, witness = f"the guarantee '{verdict.claim}' does not hold", verdict.witness
    help_text = "change the rules, or claim what holds"
    facts = (str(witness), *([verdict.note] if verdict.note else []))
    return Diagnostic("FZ402", message, verdict.span, facts=facts, help=help_text, witness=witness.point)


def _lacks(part: Expr, point: Mapping[str, float]) -> str:
    """Return what part of a guarantee has no value at a point."""
    at = ", ".join(f"{n} = {x:.6g}" for n, x in point.items())
    if isinstance(part, Binary) and part.op == "/":
        return f"divides by '{to_text(part.right)}', which is 0 at {at}"
    return f"takes '{to_text(part)}', which has no value at {at}"


def _denied(verdict: Verdict) -> Verdict:
    match verdict:
        case Refuted():
            return Proved(verdict.claim)
        case Proved():
            return Undecided(verdict.claim, "it is false, since what 'not' denies is proved; no single point shows it")
    return verdict


def _joined(claim: Claim, verdicts: list[Verdict], *, every: bool) -> Verdict:
    """Join verdicts of parts that speak of all points."""
    refuted = [v for v in verdicts if isinstance(v, Refuted)]
    open_ones = [v for v in verdicts if isinstance(v, Undecided)]
    proved = [v for v in verdicts if isinstance(v, Proved)]
    if every:
        order: list[Verdict] = [*refuted, *open_ones]
        noted = [v for v in proved if v.note]
        return (order or [*noted, Proved(claim.text)])[0]
    if proved:
        return proved[0]
    if len(refuted) == len(verdicts) and all(not isinstance(p, Bound | Every | Some) for p in _parts(claim.truth)):
        return refuted[0]
    return Undecided(claim.text, "no part of 'or' is proved by itself")


def _parts(truth: Truth) -> tuple[Truth, ...]:
    return truth.parts if isinstance(truth, Every | Some) else (truth,)
