"""Sets of outputs: polygons, rules over samples in compiled code, narrow notches of hedges, curves of many corners."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

import fuzzyctl
from fuzzyctl import Refuted, loads
from tests import sizes
from tests.effort import at_most_calls
from tests.fuzzyctl.kernels.joined import LOWER, UPPER, WIDTH, build, evaluated, parsed
from tests.properties.running import quick
from tests.reference.formulas import FLOAT, corners, degree, norm
from tests.reference.sets import Straight

ALL = ("python", "numpy", "numba")
ON_BACKENDS = pytest.mark.parametrize("backend", sizes.BACKENDS)
TERMS = ("triangle(-4, -2, 1)", "triangle(0, 2, 5)", "triangle(-1, 0, 1)", "gaussian(1, 1.25)")
ACTIVATIONS = st.sampled_from([0.0, 0.25, 0.5, 0.8125, 1.0])


def polygon(terms, activations, norms, kind, count):
    """Return the corners of a polygon, at samples and where a term meets its activation, and the degrees there."""
    step = (UPPER - LOWER) / (count - 1 if kind == "endpoints" else count)
    points = [LOWER + (i + (0.5 if kind == "midpoint" else 0.0)) * step for i in range(count)]
    sampled = [[degree(FLOAT, *parsed(term), p) for p in points] for term in terms]
    found = set(points)
    for h, v in zip(activations, sampled, strict=True):
        for p, q, a, b in zip(points, points[1:], v, v[1:], strict=False):
            if norms[0] == "min" and min(a, b) < h < max(a, b):
                found.add(p + (q - p) * (h - a) / (b - a))
    found = sorted(found)
    implied = [
        [norm(FLOAT, norms[0], h, d) for d in np.interp(found, points, v).tolist()]
        for h, v in zip(activations, sampled, strict=True)
    ]
    return found, [norm(FLOAT, norms[1], *pair) for pair in zip(*implied, strict=True)]


def centroid_of(places, degrees):
    area = moment = 0.0
    for a, b, y0, y1 in zip(places, places[1:], degrees, degrees[1:], strict=False):
        area += (b - a) * (y0 + y1) / 2
        moment += (b - a) * (a * (2 * y0 + y1) + b * (y0 + 2 * y1)) / 6
    return moment / area


class TestPolygons:
    """Corners at the samples and where a term meets its activation, and none where terms cross in between."""

    @given(
        st.tuples(st.sampled_from(TERMS), st.sampled_from(TERMS)),
        st.tuples(ACTIVATIONS, ACTIVATIONS),
        st.tuples(st.sampled_from(["min", "product"]), st.sampled_from(["max", "sum"])),
        st.sampled_from(["midpoint", "endpoints", "left"]),
        st.sampled_from([2, 3, 9, 40]),
    )
    @quick(80, 10)
    def test_the_centroid_is_that_of_the_polygon(self, terms, activations, norms, kind, count):
        system = build(terms, *norms, f"centroid(resolution={count}, grid={kind}, rule=polygon)")
        places, degrees = polygon(terms, activations, norms, kind, count)
        expected = centroid_of(places, degrees) if max(degrees) > 0.0 else 77
        assert evaluated(system, activations) == pytest.approx(expected, abs=1e-12)

    @pytest.mark.parametrize("kind", ["centroid", "bisector"])
    def test_samples_at_the_corners_give_what_the_corners_give(self, kind):
        terms = ("triangle(-3, -1, 1)", "triangle(-1, 1, 3)")
        sampled, of_corners, exact = (
            build(terms, "min", "max", f"{kind}{options}")
            for options in ("(resolution=5, grid=endpoints, rule=polygon)", "(rule=polygon)", "")
        )
        for point in ((0.9, 0.75), (0.3, 1.0), (0.25, 0.25), (1.0, 0.0)):
            assert evaluated(of_corners, point) == pytest.approx(evaluated(sampled, point), abs=1e-12)
        assert abs(evaluated(of_corners, (0.9, 0.75)) - evaluated(exact, (0.9, 0.75))) > 1e-3


#: Numba compiles some of them in the test line; python and numpy are held to the reference by drawn systems.
COMPILED = {
    "centroid(resolution=30, grid=endpoints, rule=polygon)": True,
    **{f"bisector(resolution=30, grid=endpoints, rule={r})": r == "first" for r in (
        "first", "nearest", "walk", "two_sided", "between", "interpolated"
    )},
    **{f"{kind}(resolution=30, grid=left)": kind == "som" for kind in ("som", "lom", "mom")},
    "lom(resolution=30, grid=left, by=magnitude)": False,
    "som(resolution=30, grid=left, rule=running, tolerance=0.01)": True,
    "mom(resolution=30, grid=left, rule=running)": False,
}  # fmt: skip


@pytest.mark.parametrize("rule", [r if now else pytest.param(r, marks=pytest.mark.long) for r, now in COMPILED.items()])
def test_compiled_rules_over_samples_give_the_same(rule):
    system = build(("triangle(-4, -2, 1)", "gaussian(1, 1.25)"), "min", "max", rule)
    for point in ((0.3, 0.9), (0.5, 0.5), (0.0, 0.4)):
        evaluated(system, point, ALL, off=1e-13)


def test_half_of_the_area_at_a_gap_is_the_middle_of_the_gap():
    for options in ("(resolution=40)", "(resolution=41, grid=endpoints)", ""):
        system = build(("triangle(-3, -2, -1)", "triangle(3, 4, 5)"), "min", "max", f"bisector{options}")
        assert evaluated(system, (0.7, 0.7)) == pytest.approx(1.0, abs=1e-12)


def test_a_running_maximum_follows_a_slope_down():
    # Each step of the flank is within the tolerance, so that the largest place is far from the top, which is at -2.
    for rule, expected in (("all", -1.97), ("running", 4.99)):
        system = build(("triangle(-4, -2, 1)",), "min", "max", f"lom(resolution=400, tolerance=0.01, rule={rule})")
        assert evaluated(system, (1.0,)) == pytest.approx(expected)


# --- hedges and sigmoids that turn a set -----------------------------------------------------------------------------


def hedged(term, consequent="a", *, hedges=(), defuzzifier="centroid", implication="min", bounds="[0, 1]", more=""):
    own = "".join(f"hedge {h}\n" for h in hedges)
    return loads(
        f"system s\ndefuzzifier {defuzzifier}\nimplication {implication}\naggregation max\n{own}input x in [0, 1]\n"
        f"  r = ramp(0, 1)\noutput y in {bounds} else 0\n  a = {term}\nif x is r then y is {consequent}\n{more}\n"
    )


def notched(**options):
    return hedged("ramp(0, 1)", "dip a", hedges=["dip(x) = abs(x - 0.29)"], **options)


class TestNarrowNotches:
    @ON_BACKENDS
    @pytest.mark.parametrize("power", [1, 2, 3])
    def test_the_centroid_sees_the_gap_about_a_zero_where_a_norm_jumps(self, backend, power):
        hedge = f"dip(x) = abs(x - 0.29)^{power}"
        made = hedged("ramp(0, 1)", "dip a", hedges=[hedge], implication="nilpotent_minimum")
        kernel = fuzzyctl.compile(made, backend=backend)
        for rest in (1e-2, 3e-4, 2e-5, 1e-6, 3e-8):
            # Degrees up to the rest count for nothing: a gap of that height, as wide on both sides of 0.29.
            gap = rest ** (1 / power)
            area = (0.29 ** (power + 1) + 0.71 ** (power + 1) - 2 * gap ** (power + 1)) / (power + 1)
            exact = 0.29 + (0.71 ** (power + 2) - 0.29 ** (power + 2)) / (power + 2) / area
            assert kernel(1.0 - rest) == pytest.approx(exact, abs=1e-12)

    @ON_BACKENDS
    @pytest.mark.parametrize(
        ("system", "x", "exact", "off"),
        [
            # 0.01 but for a triangle of the area 1e-4 about 0.29.
            (notched(), 0.01, (0.01 * 0.5 - 1e-4 * 0.29) / (0.01 - 1e-4), 1e-14),
            (notched(defuzzifier="bisector"), 0.01, 0.505, 1e-14),
            (hedged("sigmoid_difference(0.27, 20, 5, 0.66)"), 0.003, 0.5011233588708, 1e-12),
            (
                hedged("triangle(0, 0.2, 1)", "bump a", hedges=["bump(x) = exp(-((x - 0.29) / 1e-10)^2)"]),
                *(1.0, 0.2 * 0.2 * 0.29 + 0.8 * (1.0 - 0.8 * 0.29), 1e-6),
            ),
            # Rounded places make noise of it: a bump on either side, three times as wide on the right.
            (
                hedged(
                    *("triangle(100.4, 100.5, 100.8)", "bump a"),
                    hedges=["bump(x) = exp(-((x - 0.464) / 1.6e-6)^2)"],
                    bounds="[100, 101]",
                ),
                *(0.001, 0.25 * (100.4 + 0.1 * 0.464) + 0.75 * (100.8 - 0.3 * 0.464), 1e-9),
            ),
        ],
        ids=["centroid", "bisector", "equal sigmoids", "bump", "noise"],
    )
    def test_is_seen(self, backend, system, x, exact, off):
        kernel = fuzzyctl.compile(system, backend)
        assert [kernel(x), *kernel.batch([[x]])] == pytest.approx([exact, exact], abs=off)

    @pytest.mark.parametrize("defuzzifier", ["centroid", pytest.param("bisector", marks=pytest.mark.long)])
    def test_refutes_no_guarantee_that_holds(self, defuzzifier):
        checked = notched(defuzzifier=defuzzifier, more="require y >= 0.502 when x >= 0.01 and x <= 0.0101")
        assert not [v for v in fuzzyctl.prove(checked) if isinstance(v, Refuted)]


@pytest.mark.parametrize("hedge", ["sin(100000 * x)", "abs(mod(4 * x, 1) - 0.5)", "sin(1 / x)", "x / x"])
def test_hostile_hedges_end_soon_and_are_reported(hedge):
    system = hedged("gaussian(0.3, 0.1)", "h a", hedges=[f"h(x) = {hedge}"])
    with at_most_calls(3_000_000):
        assert "FZ409" in [d.code for d in fuzzyctl.check(system)[1]]


def test_turning_points_that_take_more_work_than_a_check_does_are_reported():
    hedges = [f"h{k}(x) = abs(sin(400 * x)) * {k + 1}" for k in range(20)]
    rules = "\n".join(f"if x is r then y is h{k} a" for k in range(1, 20))
    _, found = fuzzyctl.check(hedged("gaussian(0.3, 0.1)", "h0 a", hedges=hedges, more=rules))
    (warning,) = (d for d in found if d.code == "FZ409")
    assert warning.facts == ("the turning points of its hedges take more work than a check does",)


# --- curves of many corners, which stand in tables -------------------------------------------------------------------

#: Places and degrees of a curve, with a flat part.
CURVE = [(0.1 * k + 1.0, round(math.exp(-((0.1 * k - 4.0) ** 2)), 6) if k % 7 else 0.25) for k in range(101)]
#: The same with jumps, one at the first place: upwards, downwards, and to a single higher place.
JUMPS = [(1.0, 0.0), (1.0, 0.5), *CURVE[1:50], (5.95, 0.1), (5.95, 0.9), (5.95, 0.2), *CURVE[50:], (11.0, 0.0)]


def curve(points):
    return f"piecewise({', '.join(f'{x!r}, {y!r}' for x, y in points)})"


@pytest.mark.parametrize("backend", ALL)
@pytest.mark.parametrize(
    "points", [CURVE, JUMPS, [(12.0 - x, y) for x, y in CURVE[::-1]]], ids=["curve", "jumps", "back"]
)
def test_degrees_of_curves_are_those_of_the_formula(backend, points):
    system = loads(
        f"system s\ndefuzzifier weighted_sum\ninput a in [0, 12]\n  t = {curve(points)}\n"
        "output c in [0, 12] else nan\n  u = constant(1)\nif a is t then c is u\n"
    )
    kernel = fuzzyctl.compile(system, backend)
    places = [0.0, 1.0, 5.95, 11.0, 12.0, *(x for x, _ in CURVE), *map(float, np.linspace(0, 12, 500))]
    flat = [v for point in points for v in point]
    due = np.array([degree(FLOAT, "piecewise", flat, x) or math.nan for x in places])  # no rule fires at 0
    np.testing.assert_allclose([kernel(x) for x in places], due, rtol=1e-12)
    np.testing.assert_array_equal(kernel.batch(np.array(places)[:, None]), [kernel(x) for x in places])
    assert math.isnan(kernel(math.nan))


@pytest.mark.parametrize("aggregation", ["max", pytest.param("sum", marks=pytest.mark.long)])
def test_centroids_of_many_corners_are_those_of_rational_arithmetic(aggregation):
    terms = [curve([(round(0.7 * x - 4.0 + 0.01 * k, 6), y) for x, y in CURVE[::6]]) for k in range(3)]
    system = build(terms, "min", aggregation, "centroid")
    for activations in ((0.3, 0.9, 0.5), (0.01, 0.0, 0.02)):
        shapes = [(corners(*parsed(t)), a) for t, a in zip(terms, activations, strict=True)]
        expected = float(Straight(shapes, "min", aggregation, LOWER, UPPER).centroid())
        assert evaluated(system, activations, off=1e-11) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("activations", [(0.3, 0.9, 0.2), (0.7, 0.6, 1.0)])
def test_centroids_over_a_partition_are_those_of_rational_arithmetic(activations):
    terms = ["triangle(-5, -2, 1)", "triangle(-2, 1, 4)", "triangle(1, 4, 7)"]
    shapes = [(corners(*parsed(t)), a) for t, a in zip(terms, activations, strict=True)]
    expected = float(Straight(shapes, "min", "max", LOWER, UPPER).centroid())
    assert evaluated(build(terms, "min", "max", "centroid"), activations) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("activations", [(0.3, 0.9), (0.7, 0.4)])
def test_a_bisector_of_many_samples_is_next_to_the_exact_one(activations):
    terms = ["triangle(-2, 0, 2)", "triangle(0, 2, 5)"]
    exact = evaluated(build(terms, "min", "max", "bisector"), activations)
    sampled = evaluated(build(terms, "min", "max", "bisector(resolution=801)"), activations)
    assert sampled == pytest.approx(exact, abs=WIDTH / 800)


@pytest.mark.parametrize("defuzzifier", ["bisector", "centroid"])
def test_curves_are_read_inside_of_integrals_too(defuzzifier):
    # Beside a gaussian a set has no closed form.
    terms = [curve([(round(0.7 * x - 4.0, 6), y) for x, y in CURVE]), "gaussian(2, 1.5)"]
    evaluated(build(terms, "product", "sum", defuzzifier), (0.25, 0.75), off=1e-9)
