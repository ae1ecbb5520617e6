"""Outputs whose adaptive integrals may miss details of a set: own hedges whose turning points are not all known."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fuzzyctl.analysis.work import ISOLATION, Work
from fuzzyctl.diagnostics.diagnostic import Diagnostic
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


def diagnostics(system: FuzzySystem, flat: Plan, work: Work) -> list[Diagnostic]:
    """Report exact centroids and bisectors for which the stated accuracy is not guaranteed.

    Where their turning points take more work than a check does, no work is left: other checks would locate them, too.
    """
    part = work.part(ISOLATION)
    return [d for output in flat.outputs for d in _of_output(system, output, part, work)]


def _of_output(system: FuzzySystem, output: OutputPlan, part: Work, work: Work) -> Iterator[Diagnostic]:
    if output.over_rules or output.kind in MAXIMA or output.resolution is not None:
        return
    hedged = dict.fromkeys(t for t in (output.terms[e.term] for e in output.implied) if own_changes(t))
    is_known = _locate(list(hedged), output, part)
    if is_known and all(is_resolved(term, output.lower, output.upper) for term in hedged):
        return
    names = {h for rule in system.rules for c in rule.consequents if c.output == output.name for h in c.hedges}
    own = [h for h in system.hedges if h.name in names]
    message = f"the accuracy of the {output.kind} of '{output.name}' is not guaranteed"
    if not is_known:
        work.takes(math.inf)
        too_much = ("the turning points of its hedges take more work than a check does",)
        yield Diagnostic("FZ409", message, own[0].span, "warning", too_much, _help(output))
        return
    open_ = [h for h in own if not monotone_parts(hedge_change(system, h.name, undone=False)).complete]
    facts = tuple(
        f"the turning points of hedge '{h.name}' cannot all be isolated by interval arithmetic" for h in open_
    )
    many = ("its terms have too many turning points",)
    yield Diagnostic("FZ409", message, (open_ or own)[0].span, "warning", facts or many, _help(output))


def _locate(terms: Sequence[SetPlan], output: OutputPlan, work: Work) -> bool:
    """Locate the turning points of terms while work is left, and return whether it was enough for all."""
    changes = dict.fromkeys(change for term in terms for change in own_changes(term))
    isolated = all(work.left > 0 and work.takes(units_of_hedge(change)) for change in changes)
    return isolated and all(
        work.left > 0 and work.takes(units_of_places(term, output.lower, output.upper)) for term in terms
    )


def _help(output: OutputPlan) -> str:
    return f"sample the set, such as 'defuzzifier {output.kind}(resolution=1000)', or write 'allow FZ409'"
