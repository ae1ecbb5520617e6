"""Outputs whose exact defuzzifiers are not as accurate as stated.

Adaptive integrals may miss details of a set where the turning points of its own hedges are not all known; and rounded
degrees may change the area of a set where its hedges have an infinite slope.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.analysis import clock
from fuzzyctl.analysis.rounded_degrees import area_of_rounding
from fuzzyctl.analysis.work import ISOLATION, SECOND, SpentError, Work
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.kernels.inference.defuzzify.turning_points import (
    is_resolved,
    monotone_parts,
    own_changes,
    units_of_hedge,
    units_of_places,
)
from fuzzyctl.kernels.plan.build import OutputPlan, Plan
from fuzzyctl.kernels.plan.consequents import hedge_change
from fuzzyctl.kernels.plan.sets import SetPlan
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
        shown = (*facts[:_MOST_SHOWN], *more)
        yield Diagnostic("FZ409", _message(output), areas[facts[0]][1], "warning", shown, help_)


def _message(output: OutputPlan) -> str:
    return f"the accuracy of the {output.kind} of '{output.name}' is not guaranteed"


def _unlocated(system: FuzzySystem, output: OutputPlan, part: Work, work: Work) -> Iterator[Diagnostic]:
    """Report an output if the turning points of its own hedges are not all known."""
    hedged = dict.fromkeys(t for t in (output.terms[e.term] for e in output.implied) if own_changes(t))
    is_known = _locate(list(hedged), output, part)
    if is_known and all(is_resolved(term, output.lower, output.upper) for term in hedged):
        return
    names = {h for rule in system.rules for c in rule.consequents if c.output == output.name for h in c.hedges}
    own = [h for h in system.hedges if h.name in names]
    if not is_known:
        work.takes(math.inf)
        too_much = ("the turning points of its hedges take more work than a check does",)
        yield Diagnostic("FZ409", _message(output), own[0].span, "warning", too_much, _help(output))
        return
    open_ = [h for h in own if not monotone_parts(hedge_change(system, h.name, undone=False)).complete]
    facts = tuple(
        f"the turning points of hedge '{h.name}' cannot all be isolated by interval arithmetic" for h in open_
    )
    many = ("its terms have too many turning points",)
    yield Diagnostic("FZ409", _message(output), (open_ or own)[0].span, "warning", facts or many, _help(output))


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
