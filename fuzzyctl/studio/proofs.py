"""Proofs in the studio: as of `fuzzyctl prove`, with less time, for browsers compute more slowly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from fuzzyctl.analysis.prove import UNDIVIDED, quickly
from fuzzyctl.analysis.verdicts import Undecided, Verdict
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.page.proofs import bound_row, decided, verdict_row

#: Seconds that all claims of a block may take together, and most that one of them may.
BLOCK: Final = 16.0
CLAIM: Final = 4.0

#: Why a claim is open until `proofs` has decided it.
FOLLOWS: Final = "it takes subdivision, which is under way"


def proofs(block: FuzzySystem | Controller) -> tuple[list[Verdict], dict[str, list[list[Any]]]]:
    """Return the verdicts on the claims of a block, and rows that a page shows: of a controller bounds as well."""
    if isinstance(block, FuzzySystem):
        found = quick(block)
        verdicts = list(map(_with_advice, decided(block, found, min(CLAIM, BLOCK / max(len(found), 1)))))
        return verdicts, {"verdicts": list(map(verdict_row, verdicts))}
    from fuzzyctl.analysis.induction.bounds import bounds_by  # the start does without
    from fuzzyctl.analysis.induction.prover import ControllerProver

    prover = ControllerProver(block, CLAIM)
    own = prover.claims.own
    prover.timeout = min(CLAIM, BLOCK / max(len(own), 1))
    units = {s.name: s.unit for s in (*block.results, *block.states)}
    verdicts = [_with_advice(prover.verdict(c)) for c in own]
    bounds = [bound_row(b, units[n]) for n, b in bounds_by(prover, 0.0).items()]
    return verdicts, {"verdicts": list(map(verdict_row, verdicts)), "bounds": bounds}


def quick(block: FuzzySystem | Controller) -> list[Verdict]:
    """Return what quick methods say; of a controller nothing, as proofs of steps take numpy."""
    return quickly(block)[0] if isinstance(block, FuzzySystem) else []


def at_once(block: FuzzySystem | Controller) -> list[Verdict]:
    """Return what quick methods say; of what they leave open, that subdivision follows."""
    return [
        replace(v, reason=FOLLOWS) if isinstance(v, Undecided) and v.reason == UNDIVIDED else v for v in quick(block)
    ]


def _with_advice(verdict: Verdict) -> Verdict:
    if isinstance(verdict, Undecided) and verdict.remaining:
        return replace(verdict, reason=f"{verdict.reason}; 'fuzzyctl prove' takes more time")
    return verdict
