"""Inference written from the model as plainly as possible, centroids in rational arithmetic."""

import math
from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np

from fuzzyctl.model.rule import And, Is, Not


def degree(membership, x):
    p = [a.value for a in membership.arguments]
    if membership.kind == "gaussian":
        return math.exp(-0.5 * ((x - p[0]) / p[1]) ** 2) if math.isfinite(x) else 0.0
    if membership.kind == "singleton":
        return 1.0 if x == p[0] else 0.0
    a, b, c, d = (p[0], p[1], p[1], p[2]) if membership.kind == "triangle" else p
    if b <= x <= c or (x < b and a == -math.inf) or (x > c and d == math.inf):
        return 1.0
    if x <= a or x >= d:
        return 0.0
    return (x - a) / (b - a) if x < b else (d - x) / (d - c)


CONJUNCTION = {"min": min, "product": lambda a, b: a * b, "bounded_difference": lambda a, b: max(0.0, a - (1.0 - b))}
# With the same rounding as the kernels, since whether a bounded difference fires may hang on the last digit.
DISJUNCTION = {
    "max": max,
    "probabilistic_sum": lambda a, b: a + b * (1.0 - a),
    "bounded_sum": lambda a, b: min(1.0, a + b),
}


def truth(system, antecedent, point):
    match antecedent:
        case Is(variable=variable, term=term):
            return degree(system.input(variable).term(term).membership, point[variable])
        case Not(operand=operand):
            return 1.0 - truth(system, operand, point)
    method, values = system.method, [truth(system, o, point) for o in antecedent.operands]
    norm = CONJUNCTION[method.conjunction] if isinstance(antecedent, And) else DISJUNCTION[method.disjunction]
    result = values[0]
    for value in values[1:]:
        result = norm(result, value)
    return result


def corners(membership):
    p = [a.value for a in membership.arguments]
    a, b, c, d = (p[0], p[1], p[1], p[2]) if membership.kind == "triangle" else p
    return [(a, 0), (b, 1), (c, 1), (d, 0)]


def limits(membership, x0, x1):
    """Degrees at both ends of an interval without corners inside, as limits from inside."""
    (a, _), (b, _), (c, _), (d, _) = corners(membership)
    middle = (x0 + x1) / 2
    if middle <= a or middle >= d:
        return Fraction(0), Fraction(0)
    if b <= middle <= c or (middle < b and a == -math.inf) or (middle > c and d == math.inf):
        return Fraction(1), Fraction(1)
    if middle < b:
        a, b = Fraction(a), Fraction(b)
        return (x0 - a) / (b - a), (x1 - a) / (b - a)
    c, d = Fraction(c), Fraction(d)
    return (d - x0) / (d - c), (d - x1) / (d - c)


def rational_centroid(system, output, activations):
    """The centroid of the aggregated set in rational arithmetic, over all points where it can bend."""
    lower, upper = Fraction(output.lower.value), Fraction(output.upper.value)
    shapes = [(output.term(term).membership, Fraction(a)) for term, a in activations if a > 0.0]
    cuts = {lower, upper}
    for membership, _ in shapes:
        cuts |= {Fraction(x) for x, _ in corners(membership) if math.isfinite(x) and lower <= Fraction(x) <= upper}
    area = moment = Fraction(0)
    for x0, x1 in pairwise(sorted(cuts)):
        ends = [limits(m, x0, x1) for m, _ in shapes]
        heights = [a for _, a in shapes]
        if system.method.implication == "min":
            lines = [*ends, *((a, a) for a in heights)]
        else:
            lines = [(a * u, a * v) for a, (u, v) in zip(heights, ends, strict=True)]
        bends = {Fraction(0), Fraction(1)}
        for (u0, u1), (v0, v1) in combinations(lines, 2):
            if (u0 - v0) * (u1 - v1) < 0:
                bends.add((u0 - v0) / ((u0 - v0) - (u1 - v1)))

        def height(t, ends=ends, heights=heights):
            degrees = [u + (v - u) * t for u, v in ends]
            if system.method.implication == "min":
                cut = [min(a, d) for a, d in zip(heights, degrees, strict=True)]
            else:
                cut = [a * d for a, d in zip(heights, degrees, strict=True)]
            return max(cut, default=Fraction(0)) if system.method.aggregation == "max" else sum(cut, Fraction(0))

        for t0, t1 in pairwise(sorted(bends)):
            y0, y1 = height(t0), height(t1)
            a, b = x0 + (x1 - x0) * t0, x0 + (x1 - x0) * t1
            area += (b - a) * (y0 + y1) / 2
            moment += (b - a) * (y0 * (2 * a + b) + y1 * (a + 2 * b)) / 6
    return moment / area if area else None


def sampled_centroid(system, output, activations):
    lower, upper, n = output.lower.value, output.upper.value, system.method.defuzzifier.resolution
    area = moment = 0.0
    for i in range(n):
        midpoint = system.method.defuzzifier.grid == "midpoint"
        x = lower + ((i + 0.5) / n if midpoint else i / (n - 1)) * (upper - lower)
        cut = []
        for term, a in activations:
            d = degree(output.term(term).membership, x)
            cut.append(min(a, d) if system.method.implication == "min" else a * d)
        y = max(cut, default=0.0) if system.method.aggregation == "max" else sum(cut)
        area, moment = area + y, moment + y * x
    return moment / area if area else None


def activations_of(system, output, point):
    return [
        (c.term, rule.weight.value * truth(system, rule.antecedent, point))
        for rule in system.rules
        for c in rule.consequents
        if c.output == output.name
    ]


def reference(system, output, point):
    """Return the value of an output, or the word of its `else` that has none."""
    activations = activations_of(system, output, point)
    if system.method.defuzzifier.averages:
        total = sum(a for _, a in activations)
        value = None
        if total > 0.0:
            peaks = [np.mean(core(output.term(t).membership)) for t, _ in activations]
            value = sum(a * p for p, (_, a) in zip(peaks, activations, strict=True)) / total
    elif system.method.defuzzifier.resolution is None:
        value = rational_centroid(system, output, activations)
    else:
        value = sampled_centroid(system, output, activations)
    if value is not None:
        return float(value)
    match output.otherwise:
        case "nan":
            return math.nan
        case "midpoint":
            return (output.lower.value + output.upper.value) / 2
        case "error" | None:
            return "error"
    return output.otherwise.value


def core(membership):
    p = [a.value for a in membership.arguments]
    return {"triangle": p[1:2], "trapezoid": p[1:3], "gaussian": p[:1], "singleton": p[:1]}[membership.kind]


def clamped(system, point):
    return {
        v.name: x if v.extrapolate else min(max(x, v.lower.value), v.upper.value)
        for v, x in zip(system.inputs, point, strict=True)
    }


def clear(system, point):
    """Whether activations are well above the smallest numbers, where sums and products lose their digits."""
    values = [a for o in system.outputs for _, a in activations_of(system, o, clamped(system, point))]
    return all(a == 0.0 or a > 1e-12 for a in values)
