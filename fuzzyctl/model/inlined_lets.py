"""Guarantees whose lets are replaced by their expressions, as proofs take them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from fuzzyctl.expr import Expr, Name, children, names_in, replace_names
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.system import FuzzySystem, ordered_lets

#: Most operations of a guarantee, and most levels of them, once the lets that it names are replaced.
MOST_PARTS: Final = 5_000
MOST_LEVELS: Final = 100


def inlined(block: Any, guarantee: Guarantee) -> Guarantee:
    """Return a guarantee with the `lets` of its block replaced; `is_too_large` says whether that is feasible."""
    if not block.lets or not named_lets(block, guarantee):
        return guarantee
    values: dict[str, Expr] = {}
    needed = _needed(block, guarantee)
    for let in ordered_lets(block):
        if let.name in needed:
            values[let.name] = replace_names(let.value, values)
    claim = replace_names(guarantee.claim, values)
    when = None if guarantee.when is None else replace_names(guarantee.when, values)
    return replace(guarantee, claim=claim, when=when)


def is_too_large(system: FuzzySystem, guarantee: Guarantee) -> bool:
    """Return whether a guarantee is beyond the limits once its lets are replaced, without doing so."""
    sizes: dict[str, tuple[int, int]] = {}
    if not named_lets(system, guarantee):
        return False
    for let in ordered_lets(system):
        sizes[let.name] = _size(let.value, sizes)
    results = [_size(e, sizes) for e in (guarantee.claim, guarantee.when) if e is not None]
    return sum(parts for parts, _ in results) > MOST_PARTS or max(levels for _, levels in results) > MOST_LEVELS


def named_lets(system: FuzzySystem, guarantee: Guarantee) -> set[str]:
    """Return the lets that a guarantee names."""
    named = {n.name for e in (guarantee.claim, guarantee.when) if e is not None for n in names_in(e)}
    return named & {v.name for v in system.lets}


def _needed(system: FuzzySystem, guarantee: Guarantee) -> set[str]:
    """Return the lets that a guarantee names, and those that these are made of."""
    lets = {v.name: v for v in system.lets}
    needed: set[str] = set()
    open_names = named_lets(system, guarantee)
    while open_names:
        needed |= open_names
        open_names = {n.name for o in open_names for n in names_in(lets[o].value) if n.name in lets} - needed
    return needed


def _size(expr: Expr, sizes: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return how many operations and levels an expression has, each let with those of its value."""
    if isinstance(expr, Name):
        return sizes.get(expr.name, (1, 1))
    below = [_size(child, sizes) for child in children(expr)]
    return 1 + sum(parts for parts, _ in below), 1 + max((levels for _, levels in below), default=0)
