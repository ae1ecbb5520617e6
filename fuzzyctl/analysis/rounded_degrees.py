"""Change of a hedged set by the rounding of its degrees.

Degrees are rounded to about 10^-16. A hedge with an infinite slope multiplies this: (1 - x)^0.5 is 0 instead of 10^-8
at a degree of 1 - 10^-16. A set whose degree stays that close to such a level over a part of the range, as tails of
sigmoids and flat tops do, has another area for that, however exactly it is integrated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import Final

from fuzzyctl.analysis.work import Work
from fuzzyctl.expr import Expr, Name, replace_names
from fuzzyctl.kernels.inference.defuzzify.curved_sets import places_of
from fuzzyctl.kernels.inference.defuzzify.turning_points import is_own, monotone_parts
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.program.scalar import scalar_function

#: Largest change that the stated accuracy covers, as a part of the range at degree 1; less is not looked for.
COVERED: Final = 1e-14
#: Relative error of a degree: some roundings of formulas.
_ROUNDED: Final = 2.0**-52
#: Allowance for samples instead of an integral, and for degrees that are 1 although rounding is all that they lack.
_ALLOWANCE: Final = 2.0
#: Distances from a level, and from the ends of a stretch as parts of it: four in each power of ten.
_CLOSE: Final = tuple(10.0 ** (-0.25 * k) for k in range(4, 62))
#: Samples of a stretch: evenly, and closer and closer to both ends.
_SAMPLES: Final = tuple(sorted({k / 32 for k in range(1, 32)} | {*_CLOSE} | {1.0 - c for c in _CLOSE}))
#: Units of `analysis.work`, that is microseconds: for a level of a hedge, and for a breakpoint of a term.
_UNITS_OF_LEVEL: Final = 300.0
_UNITS_OF_BREAKPOINT: Final = 100.0

Degree = Callable[[float], float]


def area_of_rounding(output: OutputPlan, term: SetPlan, work: Work) -> float:
    """Return how much the area of a hedged term changes by the rounding of its degrees.

    Returns:
        An upper estimate, as a part of the range at degree 1; 0 where it is less than the stated accuracy covers.

    Raises:
        SpentError: When there is not enough work left.
    """
    total = 0.0
    for k in range(len(term.changes)):
        work.spend(_UNITS_OF_LEVEL * len(_levels(term.changes[k])))
        if _is_steep(term.changes[k:]):
            breakpoints = places_of(output, [term])
            work.spend(_UNITS_OF_BREAKPOINT * len(breakpoints))
            degree = scalar_function(replace(term, changes=term.changes[:k]).degree_of_x)
            total += _area(degree, _hedged(term.changes[k:]), breakpoints)
    total *= _ALLOWANCE / (output.upper - output.lower)
    return total if total > COVERED else 0.0


def _area(degree: Degree, hedged: Degree, breakpoints: list[float]) -> float:
    """Return the area between a hedged set and the same set of rounded degrees."""
    total = 0.0
    for a, b in pairwise(breakpoints):
        before, last = a, 0.0
        for x in (a + (b - a) * s for s in _SAMPLES):
            changed = _changed(hedged, degree(x))
            total += 0.5 * (last + changed) * (x - before)
            before, last = x, changed
    return total


def _changed(hedged: Degree, degree: float) -> float:
    """Return how much a hedged degree changes with the rounding of the degree; a whole degree counts as exact."""
    if degree == 1.0:
        return 0.0
    near = (degree * (1.0 - _ROUNDED), min(degree * (1.0 + _ROUNDED), 1.0))
    return max(_finite(abs(hedged(d) - hedged(degree))) for d in near)


def _finite(x: float) -> float:
    return x if math.isfinite(x) else 0.0


def _levels(change: Expr) -> tuple[float, ...]:
    """Return the degrees next to which the slope of a hedge may be infinite; at 0 rounding is relative."""
    return (1.0, *monotone_parts(change).degrees) if is_own(change) else (1.0,)


@lru_cache(maxsize=1000)
def _is_steep(changes: tuple[Expr, ...]) -> bool:
    """Return whether hedges make more of a rounded degree than the stated accuracy covers."""
    hedged = _hedged(changes)
    near = (d for level in _levels(changes[0]) for c in _CLOSE for d in (level - c, level + c) if 0.0 < d < 1.0)
    return any(_changed(hedged, d) > COVERED for d in near)


def _hedged(changes: tuple[Expr, ...]) -> Degree:
    """Return what hedges make of a degree, one after the other."""
    whole: Expr = Name(ITSELF)
    for change in changes:
        whole = replace_names(change, {ITSELF: whole})
    return scalar_function(whole)
