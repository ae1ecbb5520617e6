"""Outputs whose exact defuzzifiers are less accurate than stated.

Adaptive integrals may miss details of a set if the turning points of a user-defined hedge are not all known.

Degrees are rounded to about 10^-16. A hedge with an infinite slope multiplies this: (1 - x)^0.5 is 0 instead of 10^-8
at a degree of 1 - 10^-16. If the degree of a set stays that close to such a level over a part of the range, as on tails
of sigmoids and on flat tops, its area changes, however exactly it is integrated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import Final

from fuzzyctl.analysis.work import ISOLATION, SECOND, SpentError, Work, clock
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, Name, replace_names
from fuzzyctl.kernels.inference.defuzzify.curved_sets import (
    is_own,
    is_resolved,
    monotone_parts,
    own_changes,
    places_of,
    units_of_hedge,
    units_of_places,
)
from fuzzyctl.kernels.plan.build import OutputPlan, Plan
from fuzzyctl.kernels.plan.clauses import hedge_change
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.system import FuzzySystem

#: Consequents that are named where rounding changes the areas of many.
_MOST_SHOWN: Final = 5


def diagnostics(system: FuzzySystem, flat: Plan, work: Work) -> list[Diagnostic]:
    """Report exact centroids and bisectors for which the stated accuracy is not guaranteed.

    Where their turning points take more work than a check does, no work is left: other checks would locate them, too.
    """
    part = work.part(ISOLATION)
    exact = [o for o in flat.outputs if not (o.over_rules or o.kind in MAXIMA or o.resolution is not None)]
    return [d for o in exact for d in [*_unlocated(system, o, part, work)] or _rounded(system, o, part)]


def _rounded(system: FuzzySystem, output: OutputPlan, work: Work) -> Iterator[Diagnostic]:
    """Report the consequents of an output whose areas change much by the rounding of degrees, the largest first."""
    areas: dict[str, tuple[float, Span | None]] = {}
    for entry in output.implied:
        rule = system.rules[entry.rule]
        try:
            area = area_of_rounding(output, output.terms[entry.term], work)
        except SpentError:
            areas["the areas of its hedged terms take more work than a check does"] = math.inf, rule.span
            break
        if area:
            text = next(" ".join((*c.hedges, str(c.term))) for c in rule.consequents if c.output == output.name)
            fact = f"the rounding of degrees changes the area of '{text}' by up to {area:.1e} of the range"
            areas[fact] = area, rule.span
    facts = sorted(areas, key=lambda fact: areas[fact][0], reverse=True)
    if facts:
        more = (f"and that of {len(facts) - _MOST_SHOWN} others",) if len(facts) > _MOST_SHOWN else ()
        help_ = "avoid hedges with an infinite slope, such as that of sqrt(1 - x) at 1, or write 'allow FZ409'"
        notes = (*facts[:_MOST_SHOWN], *more)
        yield Diagnostic("FZ409", _message(output), areas[facts[0]][1], "warning", notes, help_)


def _message(output: OutputPlan) -> str:
    return f"the accuracy of the {output.kind} of '{output.name}' is not guaranteed"


def _unlocated(system: FuzzySystem, output: OutputPlan, part: Work, work: Work) -> Iterator[Diagnostic]:
    """Report an output if some turning points of its user-defined hedges are unknown."""
    hedged = dict.fromkeys(t for t in (output.terms[e.term] for e in output.implied) if own_changes(t))
    is_known = _locate(list(hedged), output, part)
    if is_known and all(is_resolved(term, output.lower, output.upper) for term in hedged):
        return
    names = {h for rule in system.rules for c in rule.consequents if c.output == output.name for h in c.hedges}
    hedges = [h for h in system.hedges if h.name in names]
    if not is_known:
        work.takes(math.inf)
        too_much = ("the turning points of its hedges take more work than a check does",)
        yield Diagnostic("FZ409", _message(output), hedges[0].span, "warning", too_much, _help(output))
        return
    open_ = [h for h in hedges if not monotone_parts(hedge_change(system, h.name, undone=False)).complete]
    facts = tuple(
        f"the turning points of hedge '{h.name}' cannot all be isolated by interval arithmetic" for h in open_
    )
    many = ("its terms have too many turning points",)
    yield Diagnostic("FZ409", _message(output), (open_ or hedges)[0].span, "warning", facts or many, _help(output))


def _locate(terms: Sequence[SetPlan], output: OutputPlan, work: Work) -> bool:
    """Locate the turning points of terms while work is left, and return whether it was enough for all."""
    changes = dict.fromkeys(change for term in terms for change in own_changes(term))
    isolated = all(_is_left(work) and work.takes(units_of_hedge(change)) for change in changes)
    return isolated and all(
        _is_left(work) and work.takes(units_of_places(term, output.lower, output.upper)) for term in terms
    )


def _is_left(work: Work) -> bool:
    """Return whether there is work, and time for a hedge that turns often."""
    return work.left > 0 and not clock.is_over(ISOLATION / SECOND)


def located(flat: Plan, work: Work) -> bool:
    """Locate the turning points that a kernel needs, and return whether the work was enough for all."""
    exact = [o for o in flat.outputs if not (o.over_rules or o.kind in MAXIMA or o.resolution is not None)]
    return all(_locate([t for t in o.terms if own_changes(t)], o, work) for o in exact)


def _help(output: OutputPlan) -> str:
    return f"sample the set, such as 'defuzzifier {output.kind}(resolution=1000)', or write 'allow FZ409'"


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
    """Return a degree after some hedges, which are applied one after the other."""
    whole: Expr = Name(ITSELF)
    for change in changes:
        whole = replace_names(change, {ITSELF: whole})
    return scalar_function(whole)
