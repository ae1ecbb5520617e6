"""Proofs in the studio: as of `fuzzyctl prove`, with less time, for browsers compute more slowly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from fuzzyctl.analysis.prove import UNDIVIDED, quickly
from fuzzyctl.analysis.verdicts import Undecided, Verdict
from fuzzyctl.model.block import Block
from fuzzyctl.page.proofs import proofs as page_proofs
from fuzzyctl.page.proofs import verdict_row

#: Seconds that all claims of a block may take together, and most that one of them may.
BLOCK: Final = 16.0
CLAIM: Final = 4.0

#: Why a claim is open until `proofs` has decided it.
FOLLOWS: Final = "it takes subdivision, which is under way"


def proofs(block: Block) -> tuple[list[Verdict], dict[str, list[list[Any]]]]:
    """Return the verdicts on the claims of a block, and rows that a page shows: of a controller bounds as well."""
    verdicts, rows = page_proofs(block, quick(block), CLAIM, bound_seconds=0.0, block_seconds=BLOCK)
    advised = list(map(_with_advice, verdicts))
    return advised, {**rows, "verdicts": list(map(verdict_row, advised))}


def quick(block: Any) -> list[Verdict]:
    """Return what quick methods say; of a controller nothing, as proofs of steps take numpy."""
    return [] if block.is_sampled else quickly(block)[0]


def at_once(block: Block) -> list[Verdict]:
    """Return what quick methods say; of what they leave open, that subdivision follows."""
    return [
        replace(v, reason=FOLLOWS) if isinstance(v, Undecided) and v.reason == UNDIVIDED else v for v in quick(block)
    ]


def _with_advice(verdict: Verdict) -> Verdict:
    if isinstance(verdict, Undecided) and verdict.remaining:
        return replace(verdict, reason=f"{verdict.reason}; 'fuzzyctl prove' takes more time")
    return verdict
