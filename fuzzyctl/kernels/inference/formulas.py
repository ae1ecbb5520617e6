"""Values of what formulas may read at one point, as plain numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.scalar import scalar_function


def known_at(plan: Plan, point: Sequence[float]) -> dict[str, float]:
    """Return the inputs as consequents see them, and the lets, by name."""
    known = {
        i.name: x if i.extrapolate else min(max(x, i.lower), i.upper) for i, x in zip(plan.inputs, point, strict=True)
    }
    for let in plan.lets:
        known[let.name] = value_of(let.value, known)
    return known


def value_of(expr: Expr, known: Mapping[str, float]) -> float:
    """Return the value of an expression over known names."""
    return float(scalar_function(expr)(**{n.name: known[n.name] for n in names_in(expr)}))
