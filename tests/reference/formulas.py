"""Membership functions, norms and hedges from their definitions, for floats, arrays and numbers of mpmath."""

import math
from itertools import pairwise

import numpy as np


class Numbers:
    """The functions that definitions need, over one type of numbers."""

    def __init__(self, module, number, choose):
        self.exp, self.sin, self.cos, self.sqrt, self.pi = module.exp, module.sin, module.cos, module.sqrt, module.pi
        self.number, self.choose = number, choose

    def smaller(self, a, b):
        return self.choose(a < b, a, b)

    def larger(self, a, b):
        return self.choose(a < b, b, a)

    def within_unit(self, x):
        return self.smaller(self.larger(x, 0), 1)

    def quotient(self, a, b, otherwise):
        """Divide; `otherwise` is the value of 0 / 0."""
        return self.choose(b == 0, otherwise, a / self.choose(b == 0, 1, b))


def chosen(condition, a, b):
    return a if condition else b


FLOAT = Numbers(math, float, chosen)
ARRAY = Numbers(np, np.float64, np.where)


# --- membership functions --------------------------------------------------------------------------------------------


def corners(kind, p):
    """Return the finite corners of a term with straight sides; None for a curved one."""
    match kind:
        case "triangle":
            points = [(p[0], 0), (p[1], 1), (p[2], 0)]
        case "trapezoid":
            points = [(p[0], 0), (p[1], 1), (p[2], 1), (p[3], 0)]
        case "rectangle":
            points = [(p[0], 0), (p[0], 1), (p[1], 1), (p[1], 0)]
        case "ramp":
            points = sorted([(p[0], 0), (p[1], 1)])
        case "piecewise":
            points = list(zip(p[::2], p[1::2], strict=True))
        case _:
            return None
    return [(x, y) for x, y in points if abs(x) < math.inf]


def straight(n, x, points):
    """Interpolate between corners: constant beyond them, at a vertical side the larger degree."""
    found = points[0][1]
    for (a, p), (b, q) in pairwise(points):
        if a == b:
            found = n.choose(x < a, found, n.choose(x > a, q, n.larger(found, max(p, q))))
        else:
            side = q if p == q else (p * (b - x) + q * (x - a)) / (b - a)
            found = n.choose(x > a, n.choose(x < b, side, q), found)
    return found


def gaussian(n, x, mean, sigma):
    z = (x - mean) / sigma
    return n.exp(-z * z / 2)


def gaussian2(n, x, left, sigma_left, right, sigma_right):
    rise = 1 if abs(left) == math.inf else n.choose(x < left, gaussian(n, x, left, sigma_left), 1)
    return rise if abs(right) == math.inf else rise * n.choose(x > right, gaussian(n, x, right, sigma_right), 1)


def bell(n, x, center, width, slope):
    z = abs((x - center) / width)
    small = n.choose(z < 1, z, n.quotient(1, z, 0)) ** (2 * slope)
    return n.choose(z < 1, 1, small) / (1 + small)


def sigmoid(n, x, inflection, slope):
    z = slope * (x - inflection)
    small = n.exp(-abs(z))
    return n.choose(z < 0, small, 1) / (1 + small)


def s_shape(n, x, start, end):
    if start == end:
        return n.choose(x >= start, 1, 0)
    u = n.within_unit((x - start) / (end - start))
    return n.choose(2 * u <= 1, 2 * u * u, 1 - 2 * (1 - u) * (1 - u))


def pi_shape(n, x, left, left_top, right_top, right):
    rise = 1 if left == -math.inf else s_shape(n, x, left, left_top)
    fall = 1 if right == math.inf else s_shape(n, -x, -right, -right_top)
    return n.choose(x < left_top, rise, fall)


def circle(n, u):
    return n.sqrt(n.within_unit(1 - u * u))


def arc(n, x, start, end):
    u = (x - end) / (end - start)
    return n.choose(u >= 0, 1, circle(n, u))


def cosine(n, x, center, width):
    u = (x - center) / width
    return n.choose(abs(u) < 0.5, (1 + n.cos(2 * n.pi * u)) / 2, 0)


CURVES = {
    "gaussian": gaussian,
    "gaussian2": gaussian2,
    "bell": bell,
    "sigmoid": sigmoid,
    "sigmoid_difference": lambda n, x, a, rise, fall, b: abs(sigmoid(n, x, a, rise) - sigmoid(n, x, b, fall)),
    "sigmoid_product": lambda n, x, a, rise, fall, b: sigmoid(n, x, a, rise) * sigmoid(n, x, b, fall),
    "s_shape": s_shape,
    "z_shape": lambda n, x, start, end: s_shape(n, x, end, start),
    "pi_shape": pi_shape,
    "cosine": cosine,
    "spike": lambda n, x, center, width: n.exp(-10 * abs((x - center) / width)),
    "concave": lambda n, x, inflection, end: 1 / (1 + n.larger((end - x) / (end - inflection), 0)),
    "arc": arc,
    "semi_ellipse": lambda n, x, start, end: circle(n, (x - (start + end) / 2) / ((end - start) / 2)),
    "singleton": lambda n, x, value: n.choose(x == value, 1, 0),
}


def degree(n, kind, p, x, *, clamped=False):
    """Return a degree; a difference of sigmoids has its magnitude, or `clamped` 0, where it is negative."""
    p = [n.number(v) for v in p]
    if kind == "sigmoid_difference" and clamped:
        return n.larger(sigmoid(n, x, p[0], p[1]) - sigmoid(n, x, p[3], p[2]), 0)
    points = corners(kind, p)
    return CURVES[kind](n, x, *p) if points is None else straight(n, x, points)


#: The numbers of the parameters that the core of a term lies between.
_CORES = dict.fromkeys(("gaussian", "bell", "cosine", "spike", "z_shape", "singleton", "constant"), (0, 0))
_CORES |= dict.fromkeys(("triangle", "ramp", "s_shape", "concave", "arc"), (1, 1))
_CORES |= {"trapezoid": (1, 2), "pi_shape": (1, 2), "rectangle": (0, 1), "semi_ellipse": (0, 1)}
_CORES |= {"gaussian2": (0, 2), "sigmoid_difference": (0, 3), "sigmoid_product": (0, 3)}


def core_middle(kind, p):
    """Return the middle of the core of a term: the location that an average over rules takes for it."""
    if kind == "piecewise":
        tops = [x for x, y in corners(kind, p) if y == max(p[1::2])]
        return (tops[0] + tops[-1]) / 2
    first, last = _CORES[kind]
    if kind == "gaussian2" and p[0] > p[2]:
        raise NotImplementedError(kind)
    return (p[first] + p[last]) / 2


def inverse(kind, p, degree):
    """Return where a monotone term has a degree above 0."""
    if kind == "sigmoid":
        return p[0] - math.log((1 - degree) / degree) / p[1] if degree < 1 else math.copysign(math.inf, p[1])
    start, end = p[::-1] if kind == "z_shape" else p
    match kind:
        case "ramp":
            return start + (end - start) * degree
        case "s_shape" | "z_shape":
            rise = math.sqrt(degree / 2)
            return start + (end - start) * (rise if degree < 0.5 else 1 - math.sqrt((1 - degree) / 2))
        case "concave":
            return end - (end - start) * (1 - degree) / degree
        case "arc":
            return end - (end - start) * math.sqrt(1 - degree * degree)
    raise NotImplementedError(kind)


# --- norms and hedges ------------------------------------------------------------------------------------------------


def near(a, b, equal):
    """Whether two degrees count as equal."""
    return (a == b) | (abs(a - b) < equal)


def nilpotent(n, a, b, equal, beyond, otherwise, joined):
    """Join two degrees whose sum lies beyond 1, and is not equal to it."""
    return n.choose(beyond, n.choose(near(a + b, 1, equal), otherwise, joined), otherwise)


#: Norms of degrees a and b; those that differ by less than e count as equal.
NORMS = {
    "min": lambda n, a, b, e: n.smaller(a, b),
    "max": lambda n, a, b, e: n.larger(a, b),
    "product": lambda n, a, b, e: a * b,
    "sum": lambda n, a, b, e: a + b,
    "probabilistic_sum": lambda n, a, b, e: a + b * (1 - a),
    "bounded_sum": lambda n, a, b, e: n.smaller(a + b, 1),
    "bounded_difference": lambda n, a, b, e: n.larger(a - (1 - b), 0),
    "drastic_product": lambda n, a, b, e: n.choose(near(n.larger(a, b), 1, e), n.smaller(a, b), 0),
    "drastic_sum": lambda n, a, b, e: n.choose(near(n.smaller(a, b), 0, e), n.larger(a, b), 1),
    "nilpotent_minimum": lambda n, a, b, e: nilpotent(n, a, b, e, a + b > 1, 0, n.smaller(a, b)),
    "nilpotent_maximum": lambda n, a, b, e: nilpotent(n, a, b, e, a + b < 1, 1, n.larger(a, b)),
    "einstein_product": lambda n, a, b, e: a * b / (1 + (1 - a) * (1 - b)),
    "einstein_sum": lambda n, a, b, e: n.smaller((a + b) / (1 + a * b), 1),
    "hamacher_product": lambda n, a, b, e: n.quotient(a * b, a + b * (1 - a), 0),
    "hamacher_sum": lambda n, a, b, e: n.smaller(n.quotient(a * (1 - b) + b * (1 - a), (1 - a) + a * (1 - b), 1), 1),
}


def norm(n, name, a, b, equal=0.0):
    """Join two degrees; those that differ by less than `equal` count as equal."""
    return NORMS[name](n, a, b, equal)


#: Hedges; `cube` is what `extremely` is where the semantics say so.
HEDGES = {
    "very": lambda n, x: x * x,
    "somewhat": lambda n, x: n.sqrt(x),
    "not": lambda n, x: 1 - x,
    "any": lambda n, x: n.number(1),
    "cube": lambda n, x: x * x * x,
    "slightly": lambda n, x: x ** (n.number(1) / 3),
    "extremely": lambda n, x: n.choose(2 * x <= 1, 2 * x * x, 1 - 2 * (1 - x) * (1 - x)),
    "seldom": lambda n, x: n.choose(2 * x <= 1, n.sqrt(x / 2), 1 - n.sqrt((1 - x) / 2)),
}
#: The hedges that undo others.
INVERSES = {"very": "somewhat", "extremely": "seldom", "slightly": "cube", "not": "not"}
INVERSES |= {inverse: name for name, inverse in INVERSES.items()}
