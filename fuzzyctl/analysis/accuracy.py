"""Outputs whose adaptive integrals may miss details of a set: own hedges whose turning points are not all known."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.errors import Diagnostic
from fuzzyctl.kernels.conclusions import hedge_change
from fuzzyctl.kernels.plan import OutputPlan, Plan
from fuzzyctl.kernels.turning_points import is_resolved, monotone_parts
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.system import FuzzySystem


def diagnostics(system: FuzzySystem, flat: Plan) -> list[Diagnostic]:
    """Report exact centroids and bisectors for which the stated accuracy is not guaranteed."""
    return [d for output in flat.outputs for d in _of_output(system, output)]


def _of_output(system: FuzzySystem, output: OutputPlan) -> Iterator[Diagnostic]:
    if output.over_rules or output.kind in MAXIMA or output.resolution is not None:
        return
    if all(is_resolved(output.terms[e.term], output.lower, output.upper) for e in output.implied):
        return
    names = {h for rule in system.rules for c in rule.consequents if c.output == output.name for h in c.hedges}
    own = [h for h in system.hedges if h.name in names]
    open_ = [h for h in own if not monotone_parts(hedge_change(system, h.name, undone=False)).complete]
    yield Diagnostic(
        "FZ409",
        f"the accuracy of the {output.kind} of '{output.name}' is not guaranteed",
        (open_ or own)[0].span,
        "warning",
        tuple(f"the turning points of hedge '{h.name}' cannot all be isolated by interval arithmetic" for h in open_)
        or ("its terms have too many turning points",),
        f"sample the set, such as 'defuzzifier {output.kind}(resolution=1000)', or write 'allow FZ409'",
    )
