"""Norms as the peers write them down, whose sums cancel near 1.

The package arranges the same formulas so that they stay within [0, 1] and keep their digits. Where a peer's number is
another one, but is what fuzzyctl computes with the peer's formula, the difference is the peer's rounding error.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from unittest.mock import patch

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Compare, Expr, Logic, Number, Where
from fuzzyctl.formulas import norms

TWO = Number(2.0)


def _plus(a: Expr, b: Expr) -> Expr:
    return Binary("+", a, b)


def _minus(a: Expr, b: Expr) -> Expr:
    return Binary("-", a, b)


def _times(a: Expr, b: Expr) -> Expr:
    return Binary("*", a, b)


def _over(a: Expr, b: Expr) -> Expr:
    return Binary("/", a, b)


def _smaller(a: Expr, b: Expr) -> Expr:
    return Call("min", (a, b))


def _larger(a: Expr, b: Expr) -> Expr:
    return Call("max", (a, b))


def _equal(a: Expr, b: Expr, equal: float) -> Expr:
    if equal == 0.0:
        return Compare("==", a, b)
    near = Logic("and", (Compare("<", _minus(a, b), Number(equal)), Compare("<", _minus(b, a), Number(equal))))
    return Logic("or", (Compare("==", a, b), near))


def _above(a: Expr, b: Expr, equal: float) -> Expr:
    return Logic("and", (Logic("not", (_equal(a, b, equal),)), Compare(">", a, b)))


def conjunctions(equal: float) -> dict[str, norms.Combination]:
    """Return the triangular norms whose formula is another one; `equal` is what degrees that are equal differ by."""
    return {
        "bounded_difference": lambda a, b: _larger(ZERO, _minus(_plus(a, b), ONE)),
        "drastic_product": lambda a, b: Where(_equal(_larger(a, b), ONE, equal), _smaller(a, b), ZERO),
        "einstein_product": lambda a, b: _over(_times(a, b), _minus(TWO, _minus(_plus(a, b), _times(a, b)))),
        "hamacher_product": lambda a, b: Where(
            _equal(_plus(a, b), ZERO, equal), ZERO, _over(_times(a, b), _minus(_plus(a, b), _times(a, b)))
        ),
        "nilpotent_minimum": lambda a, b: Where(_above(_plus(a, b), ONE, equal), _smaller(a, b), ZERO),
    }


def disjunctions(equal: float) -> dict[str, norms.Combination]:
    """Return the triangular conorms; see `conjunctions`."""
    return {
        "probabilistic_sum": lambda a, b: _minus(_plus(a, b), _times(a, b)),
        "drastic_sum": lambda a, b: Where(_equal(_smaller(a, b), ZERO, equal), _larger(a, b), ONE),
        "einstein_sum": lambda a, b: _over(_plus(a, b), _plus(ONE, _times(a, b))),
        "hamacher_sum": lambda a, b: Where(
            _equal(_times(a, b), ONE, equal),
            ONE,
            _over(_minus(_plus(a, b), _times(TWO, _times(a, b))), _minus(ONE, _times(a, b))),
        ),
        "nilpotent_maximum": lambda a, b: Where(_above(ONE, _plus(a, b), equal), _larger(a, b), ONE),
    }


def _less(norm: norms.Combination, factor: Expr) -> norms.Combination:
    return lambda a, b: _times(factor, norm(a, b))


@contextmanager
def literal_norms(equal: float, *, shaken: bool = False) -> Iterator[None]:
    """Put the literal formulas in the place of the package's, for what is compiled meanwhile.

    Args:
        equal: What degrees that are equal differ by.
        shaken: Whether results are less by one unit in the last place.
    """
    factor = Number(1.0 - 2.0**-53)
    lower, upper = (
        {**{k: n.combine for k, n in a.items()}, **b(equal)}
        for a, b in ((norms.CONJUNCTIONS, conjunctions), (norms.AGGREGATIONS, disjunctions))
    )
    if shaken:
        lower, upper = ({k: _less(n, factor) for k, n in d.items()} for d in (lower, upper))
    lower, upper = (
        {k: replace(known[k], combine=n, tolerant=lambda _, n=n: n) for k, n in d.items()}
        for known, d in ((norms.CONJUNCTIONS, lower), (norms.AGGREGATIONS, upper))
    )
    with (
        patch.dict(norms.CONJUNCTIONS, lower),
        patch.dict(norms.DISJUNCTIONS, {k: n for k, n in upper.items() if k in norms.DISJUNCTIONS}),
        patch.dict(norms.AGGREGATIONS, upper),
    ):
        yield
