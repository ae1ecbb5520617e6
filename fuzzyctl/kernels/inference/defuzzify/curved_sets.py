"""Centroid and bisector of curved sets by adaptive integrals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Logic, Name, Number, Where, minus, names_in, plus, times
from fuzzyctl.formulas import AGGREGATIONS, IMPLICATIONS, MEMBERSHIP, alpha_cut
from fuzzyctl.kernels.inference.defuzzify.alpha_cuts import has_cuts
from fuzzyctl.kernels.inference.defuzzify.centroid import Height, in_units, unit_of
from fuzzyctl.kernels.inference.defuzzify.sampling import aggregated, implied_degrees
from fuzzyctl.kernels.inference.defuzzify.turning_points import turning_points
from fuzzyctl.kernels.inference.degrees.tabulated import degree_of
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.quadrature import NODES
from fuzzyctl.kernels.program.traversal import parts as parts_of
from fuzzyctl.kernels.program.traversal import writes

#: Where the slopes of curved terms change much, in multiples of their widths: bell-shaped ones that vanish fast, those
#: that vanish as an exponential does, and those that vanish as a power does.
_MULTIPLES: Final = {
    "normal": (1.5, 4.0, 10.0, 20.0, 39.0),
    "exponential": (2.0, 8.0, 30.0, 100.0, 300.0, 750.0),
    "power": tuple(0.5 * 3.0**k for k in range(40)),
}
#: Where a set vanishes, or is 1, the values on both sides of a jump near that place tell too little from each other for
#: the integral to see it. Such places get neighbours at these parts of the range.
_BESIDE: Final = (1e-8, 1e-6, 1e-4, 1e-2)
#: Places nearer to another one than this part of their distance from the middle of their term are left out.
_NEAR: Final = 0.3


def adaptive(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the integrals of an aggregated set.

    Returns:
        For a centroid the moment about the middle of the range, for a bisector its place counted from there; and the
        area. All are in the unit of the output (`unit_of`).
    """
    if not heights:
        return ZERO, ZERO
    middle = 0.5 * output.lower + 0.5 * output.upper
    inner, x = builder.inner(), builder.fresh()
    unit = unit_of(output)
    place = inner.let(plus(times(Name(x), Number(unit)), Number(middle)))
    parts = [(h, inner.let(degree_of(inner, output.terms[t], place)), output.terms[t]) for t, h, _ in heights]
    implied = implied_degrees(output, inner, parts)
    value = inner.let(aggregated(output, inner, implied))
    body = tuple(inner.statements)
    own = {x}.union(*map(writes, body))
    named = [n.name for e in (*(e for s in body for e in parts_of(s).values), value) for n in names_in(e)]
    given = tuple(dict.fromkeys(n for n in named if n not in own))
    table = builder.table((p - middle) / unit for p in places_of(output, [output.terms[t] for t, _, _ in heights]))
    found, area = builder.fresh(), builder.fresh()
    kind = "half" if output.kind == "bisector" else "moments"
    marks: list[Expr] = []
    for t, h, _ in heights:
        ends = [e for e in _ends(builder, output, output.terms[t], h) if not isinstance(e, Number)]
        marks += dict.fromkeys(builder.let(in_units(e, unit)) for e in ends)
    builder.statements.append(Quadrature(found, area, kind, x, body, value, given, table, tuple(marks)))
    return Name(found), Name(area)


def _ends(builder: Builder, output: OutputPlan, term: SetPlan, activation: Expr) -> list[Expr]:
    """Return where an implied set bends or jumps: where its term reaches the activation, or for some norms the rest.

    Terms whose places have no closed form have none; there stretches are halved until they are short.
    """
    bends = IMPLICATIONS[output.implication_of(term)].bends
    if bends is None or not has_cuts(term):
        return []
    level = activation if bends == "equal" else builder.let(minus(ONE, activation))
    share = builder.let(term.share(level))
    inside = Logic("and", (Compare(">", share, ZERO), Compare("<=", share, ONE)))
    found = alpha_cut(term.kind, builder.let(Where(inside, share, ONE)), term.parameters)
    assert found is not None
    middle = 0.5 * output.lower + 0.5 * output.upper
    ends = [builder.let(clip(builder.let(e), output.lower, output.upper)) for e in found]
    # Without a value, as of inputs that have none, nothing could be sorted.
    known = [builder.let(Where(Compare("==", e, e), e, Number(output.lower))) for e in ends]
    return [e if isinstance(e, Number) else builder.let(minus(e, Number(middle))) for e in known]


def places_of(output: OutputPlan, terms: Sequence[SetPlan]) -> list[float]:
    """Return places between which terms are smooth, from end to end of the range."""
    lower, upper = output.lower, output.upper
    found = {lower, upper} | {x for t in terms for x in t.pieces if lower < x < upper}
    found |= {x for t in terms for x in turning_points(t, lower, upper)}
    for term in terms:
        for center, width, multiples in _scales(term):
            for multiple in multiples:
                for x in (center - multiple * width, center + multiple * width):
                    if lower < x < upper and all(abs(x - p) > _NEAR * multiple * width for p in found):
                        found.add(x)
    found |= {x for t in terms for x in _beside_jumps(output, t) if lower < x < upper}
    return sorted(found)


def _beside_jumps(output: OutputPlan, term: SetPlan) -> Iterator[float]:
    """Yield places beside those of a term whose implied set jumps where no closed form says."""
    lower, upper = output.lower, output.upper
    norms = IMPLICATIONS[output.implication_of(term)], AGGREGATIONS[output.aggregation]
    if has_cuts(term) or not any(norm.jumps and norm.bends for norm in norms):
        return
    for place in (lower, upper, *term.pieces, *turning_points(term, lower, upper)):
        for part in _BESIDE:
            yield from (place - part * (upper - lower), place + part * (upper - lower))


def _scales(term: SetPlan) -> Iterator[tuple[float, float, tuple[float, ...]]]:
    """Yield around which places a curved term changes, over which width, and the multiples of it to look at."""
    kind = term.kind.split()[0]
    for center, width, decay in MEMBERSHIP[kind].scales(term.parameters) if kind in MEMBERSHIP else ():
        yield center, width, _MULTIPLES[decay]


def nodes_of(output: OutputPlan, term: SetPlan) -> list[float]:
    """Return where the adaptive integral of a set of one term looks at it first.

    Other terms only cut the stretches shorter, so that its core is looked at more closely.
    """
    found: list[float] = []
    for a, b in pairwise(places_of(output, [term])):
        center, half = 0.5 * a + 0.5 * b, 0.5 * (b - a)
        found += [center, *(center + side * half * node for node in NODES for side in (-1.0, 1.0))]
    return found
