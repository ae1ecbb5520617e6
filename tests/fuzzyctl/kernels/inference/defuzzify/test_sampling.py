"""Sampled defuzzifiers against plain loops that say what each rule means."""

import math
import tracemalloc

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from fuzzyctl import loads, output_bounds
from fuzzyctl.kernels.inference.defuzzify.defuzzify import support_hull
from fuzzyctl.kernels.plan.build import plan
from tests.fuzzyctl.kernels.joined import LOWER, UPPER, build, evaluated
from tests.properties.running import quick

BACKENDS = ("python", "numpy", "numba")


def grid(kind, count):
    step = (UPPER - LOWER) / (count - 1 if kind == "endpoints" else count)
    return [LOWER + (i + (0.5 if kind == "midpoint" else 0.0)) * step for i in range(count)], step


def triangle(left, top, right):
    def degree(x):
        if x <= top:
            return 1.0 if left == top else max(0.0, (x - left) / (top - left))
        return max(0.0, (right - x) / (right - top))

    return degree


def gaussian(mean, sigma):
    return lambda x: math.exp(-0.5 * ((x - mean) / sigma) ** 2)


TERMS = {
    "triangle(-4, -2, 1)": triangle(-4, -2, 1),
    "triangle(0, 2, 5)": triangle(0, 2, 5),
    "triangle(-1, 0, 1)": triangle(-1, 0, 1),
    "gaussian(1, 1.25)": gaussian(1, 1.25),
}
IMPLICATIONS = {"min": min, "product": lambda a, b: a * b}
AGGREGATIONS = {"max": max, "sum": lambda a, b: a + b}


# --- what each rule means --------------------------------------------------------------------------------------------


def centroid_plain(x, v, _):
    return sum(a * b for a, b in zip(x, v, strict=True)) / sum(v)


def centroid_trapezoid(x, v, _):
    weights = [0.5, *[1.0] * (len(v) - 2), 0.5]
    return sum(w * a * b for w, a, b in zip(weights, x, v, strict=True)) / sum(
        w * b for w, b in zip(weights, v, strict=True)
    )


def bisector_first(x, v, _):
    sums = np.cumsum(v)
    return next(place for place, s in zip(x, sums, strict=True) if s >= 0.5 * sums[-1])


def bisector_nearest(x, v, _):
    sums = np.cumsum(v)
    away = np.abs(sums / sums[-1] - 0.5)
    return float(np.mean([place for place, d in zip(x, away, strict=True) if d == away.min()]))


def bisector_walk(x, v, _):
    left, right, k = 0.0, 0.5 * (2.0 * sum(v) - v[0] - v[-1]), 0
    while left < right:
        area = 0.5 * (v[k] + v[k + 1])
        left, right, k = left + area, right - area, k + 1
    return x[k] if 0.5 * (v[k - 1] + v[k]) >= left - right else x[k - 1]


def bisector_two_sided(x, v, _):
    low, high, below, above = 0, len(v) - 1, 0.0, 0.0
    while low < high:
        if below <= above:
            low += 1
            below += v[low]
        else:
            high -= 1
            above += v[high]
    return x[low]


def bisector_between(x, v, kind):
    left, right, below, above = 0, len(v), 0.0, 0.0
    while left < right:
        if below <= above:
            below += v[left]
            left += 1
        else:
            right -= 1
            above += v[right]
    ends = (x[left - 1] if left else LOWER, x[right] if right < len(v) else UPPER)
    return (below * ends[1] + above * ends[0]) / (below + above)


def bisector_interpolated(x, v, kind):
    fine = 20_000
    step = x[1] - x[0]
    if kind == "endpoints":
        at = np.linspace(x[0], x[-1], fine * (len(x) - 1) + 1)
        density = np.interp(at, x, v)
        area = np.concatenate(([0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))))
    else:
        first = x[0] - (0.5 * step if kind == "midpoint" else 0.0)
        at = first + step / fine * np.arange(fine * len(x) + 1)
        area = np.concatenate(([0.0], np.cumsum(np.repeat(v, fine))))
    return float(np.interp(0.5 * area[-1], area, at))


def compiled_some(known, *some):
    """Return kinds; the test line compiles some of them."""
    return [kind if kind in some else pytest.param(kind, marks=pytest.mark.long) for kind in known]


MAXIMA = (
    *("som", "lom", "mom", "som(by=magnitude)", "lom(by=magnitude)", "som(rule=running, tolerance=0.01)"),
    *("lom(rule=running, tolerance=0.01)", "mom(rule=running)"),
)
CENTROIDS = {"plain": centroid_plain, "trapezoid": centroid_trapezoid}
BISECTORS = {
    "first": bisector_first,
    "nearest": bisector_nearest,
    "walk": bisector_walk,
    "two_sided": bisector_two_sided,
    "between": bisector_between,
    "interpolated": bisector_interpolated,
}
SETS = st.fixed_dictionaries(
    {
        "a": st.sampled_from(list(TERMS)),
        "b": st.sampled_from(list(TERMS)),
        "implication": st.sampled_from(list(IMPLICATIONS)),
        "aggregation": st.sampled_from(list(AGGREGATIONS)),
        "grid": st.sampled_from(["midpoint", "endpoints", "left"]),
        "count": st.sampled_from([2, 3, 9, 40]),
    }
)
#: Binary fractions, so that ties are ties in any order of additions.
ACTIVATIONS = st.sampled_from([0.0, 0.25, 0.5, 0.8125, 1.0])


def samples(chosen, x, y):
    points, _ = grid(chosen["grid"], chosen["count"])
    imply, join = IMPLICATIONS[chosen["implication"]], AGGREGATIONS[chosen["aggregation"]]
    a, b = TERMS[chosen["a"]], TERMS[chosen["b"]]
    return points, [join(imply(x, a(p)), imply(y, b(p))) for p in points]


def joined(chosen, defuzzifier):
    return build([chosen["a"], chosen["b"]], chosen["implication"], chosen["aggregation"], defuzzifier)


def value(system, x, y, backends=("python", "numpy")):
    return evaluated(system, [x, y], backends, off=1e-13)


class TestRules:
    @given(SETS, st.sampled_from([*CENTROIDS.items(), *BISECTORS.items()]), ACTIVATIONS, ACTIVATIONS)
    @quick(150)
    def test_each_is_what_a_plain_loop_says(self, chosen, rule, x, y):
        name, reference = rule
        kind = "centroid" if name in CENTROIDS else "bisector"
        system = joined(chosen, f"{kind}(resolution={chosen['count']}, grid={chosen['grid']}, rule={name})")
        found = value(system, x, y)
        points, values = samples(chosen, x, y)
        whole = sum(values[1:]) if name == "two_sided" else sum(values)
        if whole <= 0.0:
            assert found == 77
            return
        expected = reference(points, values, chosen["grid"])
        if name in ("first", "nearest", "walk", "two_sided", "between") and found != pytest.approx(expected, abs=1e-9):
            # Only where sums that are equal but for rounding decide.
            assert is_tie(values)
            return
        tolerance = 2e-3 if name == "interpolated" else 1e-12
        assert found == pytest.approx(expected, abs=tolerance)

    @pytest.mark.parametrize("rule", compiled_some(BISECTORS, "first", "between"))
    def test_compiled_code_gives_the_same(self, rule):
        chosen = {"a": "triangle(-4, -2, 1)", "b": "gaussian(1, 1.25)", "implication": "min", "aggregation": "sum"}
        system = joined(chosen, f"bisector(resolution=30, grid=endpoints, rule={rule})")
        for x, y in ((0.3, 0.9), (0.0, 0.4), (1.0, 0.0)):
            value(system, x, y, BACKENDS)

    def test_half_of_the_area_at_a_gap_is_the_middle_of_the_gap(self):
        chosen = {"a": "triangle(-3, -2, -1)", "b": "triangle(3, 4, 5)", "implication": "min", "aggregation": "max"}
        for kind in ("midpoint", "endpoints"):
            count = 41 if kind == "endpoints" else 40
            system = joined(chosen, f"bisector(resolution={count}, grid={kind})")
            assert value(system, 0.7, 0.7) == pytest.approx(1.0, abs=1e-12)


class TestPolygons:
    """Corners at the samples and where a term meets its activation, and none where terms cross in between."""

    @given(SETS, ACTIVATIONS, ACTIVATIONS)
    @quick(80)
    def test_the_centroid_is_that_of_the_polygon(self, chosen, x, y):
        system = joined(chosen, f"centroid(resolution={chosen['count']}, grid={chosen['grid']}, rule=polygon)")
        corners, degrees = polygon(chosen, x, y)
        expected = centroid_of(corners, degrees) if max(degrees) > 0.0 else 77
        assert value(system, x, y) == pytest.approx(expected, abs=1e-12)

    @given(SETS, ACTIVATIONS, ACTIVATIONS)
    @quick(40)
    def test_the_bisector_halves_its_area(self, chosen, x, y):
        system = joined(chosen, f"bisector(resolution={chosen['count']}, grid={chosen['grid']}, rule=polygon)")
        corners, degrees = polygon(chosen, x, y)
        if max(degrees) == 0.0:
            assert value(system, x, y) == 77
            return
        at = np.union1d(np.linspace(corners[0], corners[-1], 200_001), corners)
        density = np.interp(at, corners, degrees)
        area = np.concatenate(([0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(at))))
        found = value(system, x, y)
        assert np.interp(found, at, area) == pytest.approx(0.5 * area[-1], abs=1e-6)

    @pytest.mark.parametrize("kind", ["centroid", "bisector"])
    def test_samples_at_the_corners_give_what_the_corners_give(self, kind):
        chosen = {"a": "triangle(-3, -1, 1)", "b": "triangle(-1, 1, 3)", "implication": "min", "aggregation": "max"}
        sampled = joined(chosen, f"{kind}(resolution=5, grid=endpoints, rule=polygon)")
        corners = joined(chosen, f"{kind}(rule=polygon)")
        exact = joined(chosen, kind)
        for x, y in ((0.9, 0.75), (0.3, 1.0), (0.25, 0.25), (1.0, 0.0)):
            assert value(corners, x, y) == pytest.approx(value(sampled, x, y), abs=1e-12)
        assert abs(value(corners, 0.9, 0.75) - value(exact, 0.9, 0.75)) > 1e-3

    def test_compiled_code_gives_the_same(self):
        chosen = {"a": "triangle(-4, -2, 1)", "b": "gaussian(1, 1.25)", "implication": "min", "aggregation": "max"}
        system = joined(chosen, "centroid(resolution=30, grid=endpoints, rule=polygon)")
        for x, y in ((0.3, 0.9), (0.0, 0.4), (1.0, 0.0)):
            value(system, x, y, BACKENDS)

    def test_values_lie_within_proved_bounds(self):
        chosen = {"a": "triangle(-1, 0, 1)", "b": "triangle(0, 2, 5)", "implication": "min", "aggregation": "max"}
        for kind in ("centroid(rule=polygon)", "centroid(resolution=4, grid=endpoints, rule=polygon)"):
            bounds = output_bounds(joined(chosen, kind))["u"]
            found = [value(joined(chosen, kind), x, y) for x in (0.0, 0.1, 1.0) for y in (0.2, 1.0)]
            assert bounds.lo <= min(found) <= max(found) <= bounds.hi


def polygon(chosen, x, y):
    """Return the corners of a polygon and the degrees there."""
    points, _ = grid(chosen["grid"], chosen["count"])
    sampled = {h: [TERMS[term](p) for p in points] for h, term in ((("a", x), chosen["a"]), (("b", y), chosen["b"]))}
    corners = set(points)
    for (_, h), v in sampled.items():
        for p, q, y0, y1 in zip(points, points[1:], v, v[1:], strict=False):
            if chosen["implication"] == "min" and min(y0, y1) < h < max(y0, y1):
                corners.add(p + (q - p) * (h - y0) / (y1 - y0))
    corners = sorted(corners)
    imply, join = IMPLICATIONS[chosen["implication"]], AGGREGATIONS[chosen["aggregation"]]
    implied = [[imply(h, d) for d in np.interp(corners, points, v).tolist()] for (_, h), v in sampled.items()]
    return corners, [join(*pair) for pair in zip(*implied, strict=True)]


def centroid_of(corners, degrees):
    area = moment = 0.0
    for a, b, y0, y1 in zip(corners, corners[1:], degrees, degrees[1:], strict=False):
        area += (b - a) * (y0 + y1) / 2
        moment += (b - a) * (a * (2 * y0 + y1) + b * (y0 + 2 * y1)) / 6
    return moment / area


def is_tie(values):
    """Return whether half of a sum is a sum of samples but for rounding, in one of the ways that rules add up."""
    sums, traps = np.cumsum(values), np.cumsum(0.5 * (np.array(values[1:]) + np.array(values[:-1])))
    inner = np.cumsum(values[1:-1]) if len(values) > 2 else np.zeros(1)
    close = [np.abs(2.0 * s - s[-1]) < 1e-9 for s in (sums, traps, inner) if len(s)]
    halves = np.abs(np.abs(sums[:-1] / sums[-1] - 0.5) - np.abs(sums[1:] / sums[-1] - 0.5)) < 1e-9
    trap_halves = np.abs(np.abs(traps[:-1] / traps[-1] - 0.5) - np.abs(traps[1:] / traps[-1] - 0.5)) < 1e-9
    return any(c.any() for c in close) or bool(halves.any()) or bool(trap_halves.any())


def running(kind, x, v, tolerance):
    """What fuzzylite 6 does, in three loops."""
    most, place, end, stays = -1.0, x[0], x[0], False
    for p, d in zip(x, v, strict=True):
        equal = d == most or abs(d - most) < tolerance
        if kind == "lom" and (equal or d > most):
            most, place = d, p
        elif kind != "lom" and not equal and d > most:
            most, place, end, stays = d, p, p, True
        elif equal and stays:
            end = p
        elif not equal and d < most:
            stays = False
    return 0.5 * (place + end) if kind == "mom" else place


class TestMaxima:
    @given(
        SETS,
        st.sampled_from(["som", "lom", "mom"]),
        st.sampled_from(["value", "magnitude"]),
        st.sampled_from([0.0, 1e-9, 0.25]),
        ACTIVATIONS,
        ACTIVATIONS,
    )
    @quick(120)
    def test_they_are_the_samples_of_the_largest_degree(self, chosen, kind, by, tolerance, x, y):
        options = f"resolution={chosen['count']}, grid={chosen['grid']}, tolerance={tolerance}"
        measured = f", by={by}" if kind != "mom" else ""
        found = value(joined(chosen, f"{kind}({options}{measured})"), x, y)
        points, values = samples(chosen, x, y)
        most = max(values)
        if most <= 0.0:
            assert found == 77
            return
        below, places, above = (
            [p for p, v in zip(points, values, strict=True) if v >= (1.0 - tolerance + slack) * most]
            for slack in (1e-12, 0.0, -1e-12)
        )
        if places != above or (tolerance > 0.0 and places != below):
            return  # rounding decides which samples count
        size = abs if by == "magnitude" else float
        expected = {"som": min(places, key=size), "lom": max(places, key=size), "mom": sum(places) / len(places)}
        assert found == pytest.approx(expected[kind], abs=1e-12)

    @pytest.mark.parametrize(
        "kind", compiled_some(MAXIMA, "mom", "lom(by=magnitude)", "som(rule=running, tolerance=0.01)")
    )
    def test_compiled_code_gives_the_same(self, kind):
        name, _, options = kind.partition("(")
        chosen = {"a": "triangle(-4, -2, 1)", "b": "gaussian(1, 1.25)", "implication": "min", "aggregation": "max"}
        tail = f", {options}" if options else ")"
        system = joined(chosen, f"{name}(resolution=30, grid=left{tail}")
        for x, y in ((0.3, 0.9), (0.5, 0.5), (0.0, 0.4)):
            value(system, x, y, BACKENDS)

    @given(SETS, st.sampled_from(["som", "lom", "mom"]), st.sampled_from([0.0, 1e-6, 0.0625]), ACTIVATIONS, ACTIVATIONS)
    @quick(120)
    def test_a_running_maximum_is_what_a_plain_loop_says(self, chosen, kind, tolerance, x, y):
        options = f"resolution={chosen['count']}, grid={chosen['grid']}, rule=running, tolerance={tolerance}"
        found = value(joined(chosen, f"{kind}({options})"), x, y)
        points, values = samples(chosen, x, y)
        if max(values) <= 0.0:
            assert found == 77
            return
        expected = {
            running(kind, points, [v * (1.0 + slant * i) for i, v in enumerate(values)], t)
            for t in (tolerance - 1e-12, tolerance, tolerance + 1e-12)
            for slant in (-1e-15, 0.0, 1e-15)
        }
        if len(expected) == 1:  # else rounding decides which degrees are equal
            assert found == pytest.approx(expected.pop(), abs=1e-12)

    def test_a_running_maximum_follows_a_slope_down(self):
        # Each step of the flank is within the tolerance, so that the largest place is far from the top.
        chosen = {"a": "triangle(-4, -2, 1)", "b": "triangle(-1, 0, 1)", "implication": "min", "aggregation": "max"}
        options = "resolution=400, tolerance=0.01, rule"
        # The top is at -2, between samples at -2.01 and -1.99.
        assert value(joined(chosen, f"lom({options}=all)"), 1.0, 0.0) == pytest.approx(-1.97)
        assert value(joined(chosen, f"lom({options}=running)"), 1.0, 0.0) == pytest.approx(4.99)
        # Where all degrees are within the tolerance, it goes on to where the set is 0.
        assert value(joined(chosen, f"lom({options}=running)"), 0.005, 0.0) == pytest.approx(4.99)

    def test_a_bisector_has_a_tolerance_too(self):
        chosen = {"a": "triangle(-4, -2, 1)", "b": "triangle(0, 2, 5)", "implication": "min", "aggregation": "max"}
        found = [
            value(joined(chosen, f"bisector(resolution=2, rule=between, tolerance={t})"), x, 1.0)
            for x, t in ((1.0, 0.0), (1.0, 0.99))
        ]
        # Samples at -1 and 3 with 2/3 each. The second is taken from the right unless 2/3 counts as no more than 0.
        assert found == pytest.approx([1.0, 5.0])

    def test_tools_differ_where_a_plateau_lies_left_of_zero(self):
        # The older manual of MATLAB: of a plateau from -8 to -2 the smallest is -2 and the largest -8.
        text = """
system s
defuzzifier {}
input x in [0, 1]
  on = ramp(0, 1)
output u in [-10, 10] else 0
  a = trapezoid(-10, -8, -2, 2)
if x is on then u is a
"""
        found = [
            loads(text.format(f"{kind}(resolution=101, grid=endpoints, by={by})"))(x=1)
            for by in ("value", "magnitude")
            for kind in ("som", "lom")
        ]
        assert found == [-8, -2, -2, -8]


def test_samples_between_the_ends_of_sets_are_neither_computed_nor_kept():
    text = (
        "system s\nand product\nimplication product\naggregation max\ndefuzzifier centroid(resolution=1000000)\n"
        "input x in [0, 1]\n  terms low high\noutput u in [-1, 1]\n  N = gaussian(-1, 0.4)\n  P = gaussian(1, 0.4)\n"
        "table u = x\n  low high\n| N P\n"
    )
    (output,) = plan(loads(text)).outputs
    tracemalloc.start()
    try:
        low, high = support_hull(output, [0, 1])
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (low, high) == (pytest.approx(-1.0, abs=1e-5), pytest.approx(1.0, abs=1e-5))
    assert peak < 1e6  # a million numbers take 32 MB
