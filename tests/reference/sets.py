"""Exact values of aggregated sets: in rational arithmetic, and by integrals between locations found by root finding."""

import math
from bisect import bisect_right
from fractions import Fraction
from functools import reduce
from itertools import combinations, pairwise

import numpy as np
from scipy.optimize import brentq

from tests.reference.formulas import ARRAY, degree, norm


class Straight:
    """An aggregated set with straight sides, exactly.

    Args:
        terms: Corners and activation of each rule.
        lower, upper: The range.
    """

    def __init__(self, terms, implication, aggregation, lower, upper):
        self.terms = [([(Fraction(x), Fraction(y)) for x, y in v if abs(x) < math.inf], Fraction(h)) for v, h in terms]
        self.implication, self.aggregation = implication, aggregation
        self.lower, self.upper = Fraction(lower), Fraction(upper)
        corners = {x for v, _ in self.terms for x, _ in v if self.lower < x < self.upper}
        self.cuts = sorted({self.lower, self.upper} | corners)
        #: Places that are one but for rounding.
        self.same = (self.upper - self.lower) / 10**12
        #: Straight parts: (left, degree there, right, degree there).
        self.parts = [part for a, b in pairwise(self.cuts) for part in self._parts(a, b)]

    def _line(self, vertices, a, b):
        """Return the line that a term is between two corners, as its values at both."""
        if b <= vertices[0][0]:
            return vertices[0][1], vertices[0][1]
        if a >= vertices[-1][0]:
            return vertices[-1][1], vertices[-1][1]
        for (x0, y0), (x1, y1) in pairwise(vertices):
            if x0 <= a and b <= x1 and x0 < x1:
                slope = (y1 - y0) / (x1 - x0)
                return y0 + slope * (a - x0), y0 + slope * (b - x0)
        raise AssertionError

    def _parts(self, a, b):
        lines = [(*self._line(v, a, b), h) for v, h in self.terms]
        straight = [(h, h) for *_, h in lines] + [(p, q) for p, q, _ in lines]
        if self.implication == "product":
            straight = [(h * p, h * q) for p, q, h in lines]
        shares = {Fraction(0), Fraction(1)}
        for (p, q), (r, s) in combinations(straight, 2):
            if (p - r) * (q - s) < 0:
                shares.add((p - r) / ((p - r) - (q - s)))
        for s, t in pairwise(sorted(shares)):
            yield a + s * (b - a), self._at(lines, s), a + t * (b - a), self._at(lines, t)

    def _at(self, lines, share):
        degrees = [(p + share * (q - p), h) for p, q, h in lines]
        return self._join(degrees)

    def _join(self, degrees):
        implied = [min(h, d) if self.implication == "min" else h * d for d, h in degrees]
        return max(implied) if self.aggregation == "max" else sum(implied)

    def area_up_to(self, place):
        total = Fraction(0)
        for x0, y0, x1, y1 in self.parts:
            if place >= x1:
                total += (x1 - x0) * (y0 + y1) / 2
            elif place > x0:
                y = y0 + (y1 - y0) * (place - x0) / (x1 - x0)
                total += (place - x0) * (y0 + y) / 2
        return total

    @property
    def area(self):
        return self.area_up_to(self.upper)

    def centroid(self):
        """Return the centroid as a fraction; None for an empty set."""
        moment = sum((x1 - x0) * (x0 * (2 * y0 + y1) + x1 * (y0 + 2 * y1)) / 6 for x0, y0, x1, y1 in self.parts)
        area = self.area
        return moment / area if area else None

    def points(self):
        """Yield corners with the larger limit of each term from both sides."""
        for place in self.cuts:
            degrees = []
            for v, h in self.terms:
                limits = []
                for a, b in pairwise(self.cuts):
                    if b == place:
                        limits.append(self._line(v, a, b)[1])
                    if a == place:
                        limits.append(self._line(v, a, b)[0])
                degrees.append((max(limits), h))
            yield place, self._join(degrees)

    def maxima(self, tolerance):
        """Return intervals and points where the set is largest, but for a part of the largest degree."""
        points = list(self.points()) + [(x, y) for x0, y0, x1, y1 in self.parts for x, y in ((x0, y0), (x1, y1))]
        bound = max(y for _, y in points) * (1 - Fraction(tolerance))
        intervals = [(x0, x1) for x0, y0, x1, y1 in self.parts if y0 == y1 >= bound]
        beside: dict[Fraction, Fraction] = {}
        for x0, y0, x1, y1 in self.parts:
            beside[x0], beside[x1] = max(beside.get(x0, y1), y1), max(beside.get(x1, y0), y0)
        return intervals, sorted({x for x, y in points if y >= bound and y >= beside[x]})

    def maximum(self, kind, tolerance=1e-9):
        intervals, points = self.maxima(tolerance)
        if kind != "mom":
            return float(points[0] if kind == "som" else points[-1])
        length = sum(b - a for a, b in intervals)
        if length > self.same:
            return float(sum((b - a) * (a + b) / 2 for a, b in intervals) / length)
        apart = [x for x, before in zip(points, [-math.inf, *points], strict=False) if x - before > self.same]
        return float(sum(apart) / len(apart))


#: Nodes and weights on [-1, 1].
_X, _W = np.polynomial.legendre.leggauss(12)


class Curved:
    """An aggregated set of any terms, whose bends are found by looking for changes of sign on a fine grid."""

    FINE = 3000

    def __init__(self, terms, implication, aggregation, lower, upper):
        self.lower, self.upper = lower, upper
        degrees = [lambda x, kind=kind, p=p: degree(ARRAY, kind, p, x) for kind, p, _ in terms]
        heights = [h for *_, h in terms]
        implied = [lambda x, d=d, h=h: norm(ARRAY, implication, h, d(x)) for d, h in zip(degrees, heights, strict=True)]
        self.degree = lambda x: reduce(lambda a, b: norm(ARRAY, aggregation, a, b), [own(x) for own in implied])
        gaps = [lambda x, d=d, h=h: d(x) - h for d, h in zip(degrees, heights, strict=True)]
        gaps += [lambda x, d=d, h=h: d(x) - (1.0 - h) for d, h in zip(degrees, heights, strict=True)]
        gaps += [lambda x, a=a, b=b: a(x) - b(x) for a, b in combinations(implied, 2)]
        if aggregation in ("bounded_sum", "nilpotent_maximum"):
            gaps += [lambda x, a=a, b=b: a(x) + b(x) - 1.0 for a, b in combinations(implied, 2)]
        locations = [x for _, p, _ in terms for x in p]
        locations += [p[0] + side * p[1] / 2 for kind, p, _ in terms if kind == "cosine" for side in (-1, 1)]
        # Sides of two parabolas bend where these meet.
        locations += [0.5 * (a + b) for kind, p, _ in terms if "shape" in kind for a, b in pairwise(p)]
        # Where two sigmoids are equal their difference has no slope.
        locations += [
            (rise * a - fall * b) / (rise - fall)
            for kind, p, _ in terms
            if kind == "sigmoid_difference"
            for a, rise, fall, b in [p]
        ]
        places = {lower, upper} | {x for x in locations if lower < x < upper}
        grid = np.linspace(lower, upper, self.FINE + 1)
        for gap in gaps:
            values = np.broadcast_to(gap(grid), grid.shape)
            places |= set(grid[values == 0.0].tolist())
            for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
                places.add(brentq(gap, grid[k], grid[k + 1], xtol=1e-15, rtol=9e-16))
        # Sides may be steep without bound at their feet, as those of ellipses are: shorter and shorter stretches there.
        graded = {p + side * 0.04 * 2.0**-k for p in places for side in (-1, 1) for k in range(48)}
        even = set(np.linspace(lower, upper, 201).tolist())
        self.places = np.array(sorted(places | even | {x for x in graded if lower < x < upper}))
        self.areas, self.moments = self._integrals(self.places[:-1], self.places[1:])

    def _integrals(self, a, b):
        """Return areas and moments about the middle of the range over some stretches."""
        x = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * _X
        y = np.broadcast_to(self.degree(x), x.shape)
        return 0.5 * (b - a) * (y @ _W), 0.5 * (b - a) * ((y * (x - 0.5 * (self.lower + self.upper))) @ _W)

    def centroid(self):
        return 0.5 * (self.lower + self.upper) + math.fsum(self.moments) / self.area

    def area_up_to(self, place):
        k = min(bisect_right(self.places.tolist(), place) - 1, len(self.areas) - 1)
        rest, _ = self._integrals(self.places[k : k + 1], np.array([place]))
        return math.fsum([*self.areas[:k], *rest])

    @property
    def area(self):
        return math.fsum(self.areas)
