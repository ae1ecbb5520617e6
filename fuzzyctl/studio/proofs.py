"""Proofs in the studio: as of `fuzzyctl prove`, with less time, for browsers compute more slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from fuzzyctl.analysis.prove import UNDIVIDED, prove, quickly
from fuzzyctl.analysis.verdicts import Undecided, Verdict
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.page.proofs import bound_row, verdict_row

#: Seconds that all claims of a block may take together, and most that one of them may.
BLOCK: Final = 16.0
CLAIM: Final = 4.0

#: Why a claim is open until `proofs` has decided it.
FOLLOWS: Final = "it takes subdivision, which is under way"


def proofs(block: FuzzySystem | Controller) -> dict[str, list[list[str]]]:
    """Return what a page shows of the claims of a block: verdicts, of a controller bounds as well."""
    if isinstance(block, FuzzySystem):
        return {"verdicts": list(map(verdict_row, decided(block)))}
    from fuzzyctl.analysis.induction.bounds import bounds_by  # the start does without
    from fuzzyctl.analysis.induction.prover import ControllerProver

    prover = ControllerProver(block, CLAIM)
    own = prover.claims.own
    prover.timeout = min(CLAIM, BLOCK / max(len(own), 1))
    units = {s.name: s.unit for s in (*block.results, *block.states)}
    return {
        "verdicts": [verdict_row(_with_advice(prover.verdict(c))) for c in own],
        "bounds": [bound_row(b, units[n]) for n, b in bounds_by(prover, 0.0).items()],
    }


def decided(system: FuzzySystem) -> list[Verdict]:
    """Return what is proved of a system; by subdivision only where quick methods leave something open."""
    verdicts: Sequence[Verdict] = quickly(system)[0]
    if any(isinstance(v, Undecided) for v in verdicts):
        verdicts = prove(system, timeout=min(CLAIM, BLOCK / len(system.guarantees)))
    return list(map(_with_advice, verdicts))


def at_once(system: FuzzySystem) -> list[Verdict]:
    """Return what quick methods say; of what they leave open, that subdivision follows."""
    return [
        replace(v, reason=FOLLOWS) if isinstance(v, Undecided) and v.reason == UNDIVIDED else v
        for v in quickly(system)[0]
    ]


def _with_advice(verdict: Verdict) -> Verdict:
    if isinstance(verdict, Undecided) and verdict.remaining:
        return replace(verdict, reason=f"{verdict.reason}; 'fuzzyctl prove' takes more time")
    return verdict
