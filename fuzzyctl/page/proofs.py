"""What is proved of systems and controllers, as the rows that a page shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

from fuzzyctl.analysis import clock
from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.analysis.prove import Prover
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.model.system import FuzzySystem

#: Seconds that all bounds of a controller may take; 'fuzzyctl prove --bounds' takes longer.
BOUND_SECONDS: Final = 0.5
#: Seconds that reading, all claims and all bounds of a page may take together; the least for claims and bounds.
PAGE_SECONDS: Final = 2.5
LEAST_SECONDS: Final = 1.0


def bound_row(bound: OutputBound, unit: str) -> list[str]:
    """Return a name, and between what its value stays."""
    low, high = (f"{end + 0.0:.9g}" for end in (bound.lo, bound.hi))
    tail = f" {unit}" if unit else ""
    if bound.lo == bound.hi:
        return [bound.name, f"always {low}{tail}"]
    if math.isinf(bound.lo) and math.isinf(bound.hi):
        return [bound.name, "no bound is known"]
    if math.isinf(bound.lo):
        return [bound.name, f"at most {high}{tail}"]
    return [bound.name, f"at least {low}{tail}" if math.isinf(bound.hi) else f"from {low} to {high}{tail}"]


def verdict_row(verdict: Verdict) -> list[Any]:
    """Return the verdict, the claim, a note, and of a refuted claim the values by name that show it."""
    match verdict:
        case Proved(note=found):
            text = found
        case Refuted(witness=witness, note=found):
            text = "; ".join(filter(None, (str(witness), found)))
        case Undecided(reason=reason):
            text = reason
    point = [verdict.witness.point] if isinstance(verdict, Refuted) else []
    return [type(verdict).__name__.lower(), verdict.claim, text, *point]


def decided(
    system: FuzzySystem, verdicts: Sequence[Verdict], seconds: float, until: float = math.inf
) -> tuple[Verdict, ...]:
    """Return verdicts on the claims of a system; those that are open take subdivision, with a time limit each.

    Args:
        system: The system.
        verdicts: What quick methods say.
        seconds: How long one claim may take.
        until: When no other claim is begun, on the clock of proofs [s].
    """
    prover = Prover(system, timeout=seconds)
    pairs = zip(system.guarantees, verdicts, strict=True)
    return tuple(prover.verdict(g) if isinstance(v, Undecided) and clock.now() <= until else v for g, v in pairs)


def proofs(
    block: Any,
    quick: Sequence[Verdict],
    seconds: float,
    *,
    bound_seconds: float = BOUND_SECONDS,
    block_seconds: float = math.inf,
    until: float = math.inf,
) -> tuple[list[Verdict], dict[str, list[list[Any]]]]:
    """Return the verdicts on a block, and their rows; of a controller also those of bounds over every step.

    Args:
        block: A system or controller.
        quick: What quick methods say of the claims of a system.
        seconds: How long one claim may take.
        bound_seconds: How long all bounds may take; 0 for no subdivision.
        block_seconds: How long all claims may take together.
        until: When no other claim is begun, on the clock of proofs [s].
    """
    if not block.is_sampled:
        verdicts = list(decided(block, quick, min(seconds, block_seconds / max(len(quick), 1)), until))
        return verdicts, {"verdicts": list(map(verdict_row, verdicts))}
    from fuzzyctl.analysis.induction.bounds import bounds_by  # numpy, which the start of the studio does without
    from fuzzyctl.analysis.induction.prover import ControllerProver

    prover = ControllerProver(block, seconds, until=until)
    prover.timeout = min(seconds, block_seconds / max(len(prover.own), 1))
    verdicts = [prover.verdict(c) for c in prover.own]
    units = {s.name: s.unit for s in (*block.results, *block.states)}
    bounds = [bound_row(b, units[name]) for name, b in bounds_by(prover, bound_seconds).items()]
    return verdicts, {"bounds": bounds, "verdicts": list(map(verdict_row, verdicts))}
