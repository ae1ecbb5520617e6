"""Points at which kernels may differ: around ranges, at corners and beside them, and oddities."""

import math

import numpy as np

from fuzzyctl.expr import Number


def corners_of(variable):
    """Return the ends of the range of an input, and the parameters of its terms that lie in it."""
    lower, upper = variable.lower.value, variable.upper.value
    numbers = {a.value for term in variable.terms for a in term.membership.arguments if isinstance(a, Number)}
    inside = math.isfinite if variable.extrapolate else lambda x: lower <= x <= upper
    return sorted({lower, upper} | {x for x in numbers if inside(x)})


def points_around(knots, seed, count=90):
    """Return points with a column for the corners of each input."""
    rng = np.random.default_rng(seed)
    columns = []
    for own in knots:
        special = [y for k in own for y in (k, math.nextafter(k, math.inf), math.nextafter(k, -math.inf))]
        special += [math.inf, -math.inf, 0.0, -0.0, 5e-324]
        columns.append(rng.choice([*special, *rng.uniform(min(own) - 3, max(own) + 3, 60)], count))
    return np.stack(columns, axis=1)
