"""Places where sets turn that own hedges or two sigmoids make, and the integrals that depend on them."""

import itertools
import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.analysis.verdicts import Refuted
from fuzzyctl.formulas.sigmoids import difference_extrema, product_extrema
from fuzzyctl.kernels.inference.defuzzify.curved_sets import (
    MOST_DEGREES,
    MOST_PLACES,
    is_resolved,
    monotone_parts,
    turning_points,
)
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.clauses import hedge_change
from fuzzyctl.kernels.program.scalar import scalar_function
from tests import sizes

ON_BACKENDS = pytest.mark.parametrize("backend", sizes.BACKENDS)


def system(term, consequent="a", *, hedges=(), defuzzifier="centroid", implication="min", bounds="[0, 1]", more=""):
    return fuzzyctl.loads(
        "\n".join(
            [
                "system s",
                f"defuzzifier {defuzzifier}",
                f"implication {implication}",
                "aggregation max",
                *(f"hedge {h}" for h in hedges),
                "input x in [0, 1]",
                "  r = ramp(0, 1)",
                f"output y in {bounds} else 0",
                f"  a = {term}",
                f"if x is r then y is {consequent}",
                more,
                "",
            ]
        )
    )


def change(text):
    return hedge_change(system("ramp(0, 1)", "h a", hedges=[f"h(x) = {text}"]), "h", undone=False)


def parts(text):
    return monotone_parts(change(text))


def notched(**options):
    return system("ramp(0, 1)", "dip a", hedges=["dip(x) = abs(x - 0.29)"], **options)


class TestNarrowNotches:
    @ON_BACKENDS
    def test_the_centroid_sees_where_an_own_hedge_is_0(self, backend):
        kernel = fuzzyctl.compile(notched(), backend=backend)
        # 0.01 but for a triangle of the area 1e-4 about 0.29.
        exact = (0.01 * 0.5 - 1e-4 * 0.29) / (0.01 - 1e-4)
        assert kernel(0.01) == pytest.approx(exact, abs=1e-14)
        assert kernel.batch(np.array([[0.01]])) == pytest.approx(exact, abs=1e-14)

    @ON_BACKENDS
    def test_the_bisector_sees_it(self, backend):
        kernel = fuzzyctl.compile(notched(defuzzifier="bisector"), backend=backend)
        assert kernel(0.01) == pytest.approx(0.505, abs=1e-14)

    @ON_BACKENDS
    @pytest.mark.parametrize("power", [1, 2, 3])
    def test_the_centroid_sees_the_gap_about_a_zero_where_a_norm_jumps(self, backend, power):
        hedge = f"dip(x) = abs(x - 0.29)^{power}"
        made = system("ramp(0, 1)", "dip a", hedges=[hedge], implication="nilpotent_minimum")
        kernel = fuzzyctl.compile(made, backend=backend)
        for rest in (1e-2, 3e-4, 2e-5, 1e-6, 3e-8):
            # Degrees up to the rest count for nothing: a gap of that height, as wide on both sides of 0.29.
            gap = rest ** (1 / power)
            area = (0.29 ** (power + 1) + 0.71 ** (power + 1) - 2 * gap ** (power + 1)) / (power + 1)
            exact = 0.29 + (0.71 ** (power + 2) - 0.29 ** (power + 2)) / (power + 2) / area
            assert kernel(1.0 - rest) == pytest.approx(exact, abs=1e-12)

    @ON_BACKENDS
    def test_the_centroid_sees_where_two_sigmoids_are_equal(self, backend):
        kernel = fuzzyctl.compile(system("sigmoid_difference(0.27, 20, 5, 0.66)"), backend=backend)
        assert kernel(0.003) == pytest.approx(0.5011233588708, abs=1e-12)

    @pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
    def test_a_bump_much_narrower_than_the_range_is_seen(self, backend):
        hedge = "bump(x) = exp(-((x - 0.29) / 1e-10)^2)"
        kernel = fuzzyctl.compile(system("triangle(0, 0.2, 1)", "bump a", hedges=[hedge]), backend=backend)
        rising, falling = 0.2 * 0.29, 1.0 - 0.8 * 0.29
        assert kernel(1.0) == pytest.approx(0.2 * rising + 0.8 * falling, abs=1e-6)


@pytest.mark.parametrize("defuzzifier", ["centroid", "bisector"])
def test_a_guarantee_that_holds_is_not_refuted_for_a_notch(defuzzifier):
    checked = notched(defuzzifier=defuzzifier, more="require y >= 0.502 when x >= 0.01 and x <= 0.0101")
    assert not [v for v in fuzzyctl.prove(checked) if isinstance(v, Refuted)]


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("abs(x - 0.29)", [0.29]),
        ("(x - 0.3)^4", [0.3]),
        ("2 * x", []),
        ("(x - 0.3)^9 + 0.5", []),
        ("5 * abs(x - 0.2) * abs(x - 0.6)", [0.2, 0.4, 0.6]),
        ("min(x, 1 - x)", [0.5]),
        ("lt(x, 0.3)", [0.3]),
        ("floor(2 * x) / 2", [0.5]),
        ("sqrt(abs(x - 0.7))", [0.7]),
        ("sign(x - 0.3)", [0.3]),
        ("1 - exp(-((x - 0.29) / 1e-9)^2)", [0.29]),
        ("abs(x - 1e-9)", [1e-9]),
        ("sin(10 * x)^2", [k * math.pi / 20 for k in range(1, 7)]),
    ],
)
def test_degrees_at_which_a_hedge_turns_are_isolated(text, degrees):
    found = parts(text)
    assert found.complete
    for degree in degrees:
        assert min(abs(degree - d) for d in found.degrees) < 1e-14


@pytest.mark.parametrize(
    "text", ["abs(x - 0.29)", "5 * abs(x - 0.2) * abs(x - 0.6)", "sin(10 * x)^2", "floor(5 * x) / 5"]
)
def test_a_hedge_is_monotone_between_the_degrees_that_are_isolated(text):
    function, found = scalar_function(change(text)), (0.0, *parts(text).degrees, 1.0)
    for low, high in itertools.pairwise(found):
        values = np.array([function(x) for x in np.linspace(low, high, 400)[1:-1].tolist()])
        moves = np.diff(values)
        assert (moves >= -1e-12).all() or (moves <= 1e-12).all()


@pytest.mark.parametrize(
    "text", ["sin(100000 * x)", "abs(sin(400 * x))", "abs(mod(4 * x, 1) - 0.5)", "sin(1 / x)", "x / x"]
)
def test_hostile_hedges_end_soon_and_are_not_claimed_to_be_known(text):
    found = parts(text)
    assert not found.complete
    assert len(found.degrees) <= MOST_DEGREES


def test_terms_of_too_many_turning_points_are_not_claimed_to_be_known():
    corners = ", ".join(f"{k / 100}, {k % 2}" for k in range(101))
    one = system(f"piecewise({corners})", "h a", hedges=["h(x) = sin(40 * x)^2"])
    output = plan(one).outputs[0]
    term = output.terms[output.implied[0].term]
    assert len(turning_points(term, 0.0, 1.0)) <= 2 * MOST_PLACES + 1
    assert not is_resolved(term, 0.0, 1.0)


def test_a_hedge_that_takes_too_many_intervals_is_given_up():
    found = parts(f"abs(sin(400 * x)) * ({' + '.join(['x'] * 60)})")
    assert not found.complete
    assert found.enclosed < 750_000


def test_turning_points_that_take_more_work_than_a_check_does_are_reported_and_no_other_check_locates_them():
    hedges = [f"h{k}(x) = abs(sin(400 * x)) * {k + 1}" for k in range(20)]
    rules = "\n".join(f"if x is r then y is h{k} a" for k in range(1, 20))
    one = system("gaussian(0.3, 0.1)", "h0 a", hedges=hedges, more=rules)
    isolated = monotone_parts.cache_info().misses
    _, found = fuzzyctl.check(one)
    (warning,) = (d for d in found if d.code == "FZ409")
    assert warning.facts == ("the turning points of its hedges take more work than a check does",)
    assert monotone_parts.cache_info().misses - isolated < 10


@pytest.mark.parametrize("hedge", ["very", "somewhat", "extremely", "slightly", "seldom", "not"])
def test_built_in_hedges_add_no_places(hedge):
    output = plan(system("gaussian(0.4, 0.1)", f"{hedge} a")).outputs[0]
    assert turning_points(output.terms[output.implied[0].term], 0.0, 1.0) == ()


def sigmoid(x, center, slope):
    return 1.0 / (1.0 + np.exp(np.clip(-slope * (x - center), -700, 700)))


@pytest.mark.parametrize("slopes", [(20, 5), (5, 20), (-20, -5), (7, 7), (12, -30), (-12, 30)])
@pytest.mark.parametrize("centers", [(0.27, 0.66), (0.66, 0.27), (0.5, 0.5)])
def test_two_sigmoids_are_monotone_between_their_extrema(centers, slopes):
    x = np.linspace(-1.0, 2.0, 300_001)
    first, second = sigmoid(x, centers[0], slopes[0]), sigmoid(x, centers[1], slopes[1])
    p = (centers[0], *map(float, slopes), centers[1])
    for degrees, places in ((abs(first - second), difference_extrema(p)), (first * second, product_extrema(p))):
        moves = np.diff(degrees)
        steps = np.flatnonzero(abs(moves) > 1e-13)
        turns = x[steps[1:][np.sign(moves[steps[1:]]) != np.sign(moves[steps[:-1]])]]
        assert all(min(abs(turn - place) for place in places) < 1e-3 for turn in turns)


@pytest.mark.parametrize(
    "p", [(0.0, 1e-300, 1e300, 1.0), (1e300, 1.0, 2.0, -1e300), (0.5, 3.0, 3.0, 0.5), (0.0, 1e9, 1e-9, 1.0)]
)
def test_extrema_of_extreme_sigmoids_are_finite(p):
    assert all(map(math.isfinite, (*difference_extrema(p), *product_extrema(p))))


@ON_BACKENDS
def test_a_set_so_narrow_that_rounded_places_make_noise_of_it_is_integrated_evenly(backend):
    hedge = "bump(x) = exp(-((x - 0.464) / 1.6e-6)^2)"
    narrow = system("triangle(100.4, 100.5, 100.8)", "bump a", hedges=[hedge], bounds="[100, 101]")
    kernel = fuzzyctl.compile(narrow, backend=backend)
    # The set is a bump on either side, three times as wide on the right.
    rising, falling = 100.4 + 0.1 * 0.464, 100.8 - 0.3 * 0.464
    assert kernel(0.001) == pytest.approx(0.25 * rising + 0.75 * falling, abs=1e-9)
