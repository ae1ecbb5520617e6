"""Program that looks up the rules of a cell: their degrees are lines, and their consequents are added up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from itertools import product

from fuzzyctl.expr import ZERO, Call, Expr, Logic, Number, Where, minus, plus, times
from fuzzyctl.kernels.algorithms.rule_cells import Active, Side
from fuzzyctl.kernels.inference.defuzzify.defuzzify import average
from fuzzyctl.kernels.inference.inference import raw_names
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, Item, Locate, Offset, Place, Program, Refuse


def lookup(plan: Plan, own: Active) -> Program:
    """Write the program that adds up over the rules of a cell."""
    builder, raw = Builder(), raw_names(plan)
    degrees, places = _degrees(builder, own, raw)
    norm = _min if own.norm == "min" else times
    strengths = [reduce(lambda a, b: builder.let(norm(a, b)), combination) for combination in product(*degrees)]
    strides = [math.prod(len(a.knots) for a in own.axes[k + 1 :]) for k in range(len(own.axes))]
    cell = builder.fresh()
    builder.statements.append(Offset(cell, tuple(zip(places, strides, strict=True))))
    clamped = {
        i.name: x if i.extrapolate else builder.let(clip(x, i.lower, i.upper))
        for i, x in zip(plan.inputs, raw, strict=True)
    }
    results: list[Expr] = []
    for output, sums in zip(plan.outputs, own.outputs, strict=True):
        above = _total(builder, strengths, sums.constants, cell)
        for name, factors in sums.factors.items():
            above = plus(above, times(clamped[name], builder.let(_total(builder, strengths, factors, cell))))
        below = builder.let(_total(builder, strengths, sums.weights, cell))
        value, fires = average(builder, output, builder.let(above), below, sums.hull)
        if output.otherwise == "error":
            quiet = Logic("and", (Logic("not", (fires,)), Logic("not", (any_nan(raw),))))
            builder.statements.append(Refuse(quiet, output.name))
        results.append(Where(any_nan(raw), NAN, value))
    return builder.program(raw, results)


def _min(a: Expr, b: Expr) -> Expr:
    return Call("min", (a, b))


def _degrees(builder: Builder, own: Active, raw: Sequence[Expr]) -> tuple[list[list[Expr]], list[str]]:
    """Write the two degrees of each input, and where its cell is."""
    degrees: list[list[Expr]] = []
    places: list[str] = []
    for axis in own.axes:
        place, rest = builder.fresh(), builder.fresh()
        x = builder.let(clip(raw[axis.position], axis.knots[0], axis.knots[-1]))
        builder.statements.append(Locate(place, rest, x, builder.table(axis.knots), axis.knots, 1, wants_rest=False))
        places.append(place)
        degrees.append([_degree(builder, side, x, place) for side in axis.sides])
    return degrees, places


def _degree(builder: Builder, side: Side, x: Expr, place: str) -> Expr:
    foot, slope, base = (_looked_up(builder, values, place) for values in (side.foot, side.slope, side.base))
    return builder.let(plus(times(slope, minus(x, foot)), base))


def _looked_up(builder: Builder, values: Sequence[float], place: str) -> Expr:
    """Return a number of a table, or the number that all of them are."""
    if len(set(values)) == 1:
        return Number(values[0])
    return Item(builder.table(values), Place(place))


def _total(builder: Builder, strengths: Sequence[Expr], tables: Sequence[Sequence[float]], cell: str) -> Expr:
    """Return Σ strength · number of the cell."""
    parts = []
    for strength, values in zip(strengths, tables, strict=True):
        factor = _looked_up(builder, values, cell)
        parts.append(ZERO if factor == ZERO else times(factor, strength))
    return builder.total(parts)
