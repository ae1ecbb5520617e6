"""Maxima of sampled sets: the smallest, the largest and the mean of the samples where the set is largest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Compare, Expr, Logic, Number, Where
from fuzzyctl.kernels.plan import OutputPlan
from fuzzyctl.kernels.program import Builder, plus, times
from fuzzyctl.kernels.sampling import Carried, Samples, largest

#: Degrees that fall short of the largest by less than this part of it count as largest, unless a file says otherwise.
TOLERANCE: Final = 1e-9


def tolerance(output: OutputPlan) -> float:
    """Return the part of the largest degree by which others may fall short."""
    return TOLERANCE if output.tolerance is None else output.tolerance


def sampled_maximum(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Write the place of the maximum that the output asks for.

    Returns:
        Its place, counted from the middle, and the largest degree; the place is not computed yet, so that it may be
        left out where the set is empty.
    """
    most = largest(samples)
    bound = samples.builder.let(times(Number(1.0 - tolerance(samples.output)), most))
    # Where the set is empty all samples are maxima, for those who look at them.
    gaps = samples.output.none_active == "range"
    places = [p - middle for p in samples.points]
    if samples.output.kind == "mom":
        return _mean(samples, bound, places, gaps=gaps), most
    if samples.output.by == "magnitude":
        return _by_magnitude(samples, bound, places, gaps=gaps), most
    largest_place = samples.output.kind == "lom"
    join, neutral = ("max", -math.inf) if largest_place else ("min", math.inf)

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        own = b.let(Where(Compare(">=", v, bound), items[0], Number(neutral)))
        return {"place": Call(join, (c["place"], own))}

    return samples.scan({"place": Number(neutral)}, step, [places], gaps=gaps)["place"], most


def _mean(samples: Samples, bound: Expr, places: Sequence[float], *, gaps: bool) -> Expr:
    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        hit = b.let(Where(Compare(">=", v, bound), ONE, ZERO))
        return {"total": plus(c["total"], times(hit, items[0])), "count": plus(c["count"], hit)}

    found = samples.scan({"total": ZERO, "count": ZERO}, step, [places], gaps=gaps)
    return Binary("/", found["total"], found["count"])


def _by_magnitude(samples: Samples, bound: Expr, places: Sequence[float], *, gaps: bool) -> Expr:
    """Return the place of smallest or largest magnitude; of two that are equally far from 0 the lower one."""
    op: str = "<" if samples.output.kind == "som" else ">"
    worst = math.inf if samples.output.kind == "som" else -1.0

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        better = Logic("and", (Compare(">=", v, bound), Compare(op, items[1], c["away"])))  # type: ignore[arg-type]
        hit = b.let(Where(better, ONE, ZERO))
        is_hit = Compare(">", hit, ZERO)
        return {"place": Where(is_hit, items[0], c["place"]), "away": Where(is_hit, items[1], c["away"])}

    start = {"place": ZERO, "away": Number(worst)}
    magnitudes = [abs(p) for p in samples.points]
    return samples.scan(start, step, [places, magnitudes], gaps=gaps)["place"]
