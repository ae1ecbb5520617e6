"""Conditions in the notation of fuzzylite."""

from __future__ import annotations

from collections.abc import Sequence


def up_to_any(hedges: Sequence[str], term: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what stands behind `is` in a condition, as its hedges and its term, if any.

    `any` is 1 whatever follows it. fuzzylite takes nothing behind it, so that what follows is left out.
    """
    if "any" in hedges:
        return tuple(hedges[: hedges.index("any") + 1]), ()
    return tuple(hedges), (term,)
