"""Degrees of terms with many corners, looked up in tables.

A point set of a measured curve has a hundred corners and more, and a system fifty such terms: as choices they take a
compiler minutes. Here the stretch is searched, and what holds in it stands in constant arrays, with the same numbers.
"""

from __future__ import annotations

from itertools import groupby, pairwise
from typing import Final

from fuzzyctl.expr import Compare, Expr, Number, Where
from fuzzyctl.kernels.plan.sets import SetPlan
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import Item, Place

#: Terms of more corners than this stand in tables.
MOST_CHOICES: Final = 32


def degree_of(builder: Builder, term: SetPlan, x: Expr) -> Expr:
    """Return the degree of an atom: from tables for a term of many corners, where the program may have them."""
    is_large = builder.most_pairs is not None and term.kind == "piecewise" and len(term.parameters) > 2 * MOST_CHOICES
    return term.finished(_looked_up(builder, term.parameters, x)) if is_large else term.degree(x)


def _looked_up(builder: Builder, parameters: tuple[float, ...], x: Expr) -> Expr:
    """Search the stretch of x and go straight between its ends, as the formula of `piecewise` does."""
    corners = zip(parameters[::2], parameters[1::2], strict=True)
    degrees = {place: [y for _, y in own] for place, own in groupby(corners, key=lambda corner: corner[0])}
    places = tuple(degrees)
    first, last = ([own[k] for own in degrees.values()] for k in (0, -1))
    rises = [b - a for a, b in zip(last, first[1:], strict=False)]
    widths = [b - a for a, b in pairwise(places)]
    name, rest = builder.located(x, places)

    def item(values: list[float]) -> Expr:
        return Item(builder.table(values), Place(name))

    run = item([*rises, 0.0]) * (rest / item([*widths, 1.0]))
    degree: Expr = item(last) + run
    tops = [max(own) for own in degrees.values()]
    if tops != last:  # at a jump the largest degree holds
        degree = Where(Compare("==", x, item(list(places))), item(tops), degree)
    if first[0] != last[0]:
        degree = Where(Compare("<", x, Number(places[0])), Number(first[0]), degree)
    return degree
