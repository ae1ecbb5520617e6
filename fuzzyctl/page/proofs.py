"""What is proved of systems and controllers, as the rows that a page shows."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.model.controller import Controller

#: Seconds that each bound of a controller, and each of its claims, may take; 'fuzzyctl bounds' and 'prove' take longer.
BOUND_SECONDS: Final = 0.02
CLAIM_SECONDS: Final = 1.0


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


def verdict_row(verdict: Verdict) -> list[str]:
    """Return what is decided, the claim, and what is known besides."""
    match verdict:
        case Proved(note=found):
            text = found
        case Refuted(witness=witness, note=found):
            text = "; ".join(filter(None, (str(witness), found)))
        case Undecided(reason=reason):
            text = reason
    return [type(verdict).__name__.lower(), verdict.claim, text]


def controller_proofs(controller: Controller) -> dict[str, list[list[str]]]:
    """Return bounds of the outputs and states of a controller over every step, and verdicts of its claims."""
    from fuzzyctl.analysis.induction.bounds import controller_bounds  # numpy, which the studio does without
    from fuzzyctl.analysis.induction.prover import verdicts

    units = {s.name: s.unit for s in (*controller.results, *controller.states)}
    bounds = controller_bounds(controller, BOUND_SECONDS)
    return {
        "bounds": [bound_row(b, units[name]) for name, b in bounds.items()],
        "verdicts": [verdict_row(v) for v in verdicts(controller, CLAIM_SECONDS)],
    }
