"""Every membership function keeps its laws: its degree, corners, core and inverse belong together."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyctl.expr import Name
from fuzzyctl.formulas import (
    MEMBERSHIP,
    is_monotone,
    is_straight,
)
from fuzzyctl.kernels.backends.numpy_backend import array_function
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.reference import formulas as reference
from tests.sizes import examples

#: Other processes may slow a test down at any time.
QUICK = settings(max_examples=examples(60, 20), deadline=None)
UNIT = st.floats(0, 1)
FINITE = st.floats(-100, 100, allow_subnormal=False)


def degree(kind, *parameters):
    return scalar_function(MEMBERSHIP[kind].degree(Name("x"), parameters))


class Counted(float):
    """A number that counts how often one like it is compared."""

    comparisons = 0

    def __eq__(self, other):
        Counted.comparisons += 1
        return float.__eq__(self, other)

    def __lt__(self, other):
        Counted.comparisons += 1
        return float.__lt__(self, other)

    __hash__ = float.__hash__


#: One example of each kind, and for some the mirrored one or one with an infinite foot.
EXAMPLES = [
    ("triangle", (0, 1, 3)),
    ("triangle", (-math.inf, 1, 3)),
    ("triangle", (0, 1, math.inf)),
    ("trapezoid", (0, 1, 2, 4)),
    ("trapezoid", (0, 1, 2, math.inf)),
    ("rectangle", (1, 3)),
    ("rectangle", (-math.inf, 1)),
    ("rectangle", (1, math.inf)),
    ("ramp", (0, 2)),
    ("ramp", (2, -1)),
    ("piecewise", (0, 0.25, 1, 1, 1, 0.5, 3, 0.75)),
    ("piecewise", (2, 0.25, 2, 1, 2, 0.5)),
    ("gaussian", (1, 0.5)),
    ("gaussian2", (0, 0.5, 2, 1)),
    ("gaussian2", (2, 1, 0, 0.5)),
    ("bell", (1, 2, 3)),
    ("bell", (1, 0.1, 0.25)),
    ("sigmoid", (1, 4)),
    ("sigmoid", (1, -4)),
    ("sigmoid_difference", (0, 5, 5, 3)),
    ("sigmoid_difference", (3, 5, 2, 0)),
    ("sigmoid_product", (0, 5, -5, 3)),
    ("s_shape", (0, 3)),
    ("z_shape", (0, 3)),
    ("pi_shape", (0, 1, 2, 4)),
    ("pi_shape", (-math.inf, 1, 2, 4)),
    ("pi_shape", (0, 1, 2, math.inf)),
    ("pi_shape", (1, 1, 2, 2)),
    ("cosine", (1, 2)),
    ("spike", (1, 2)),
    ("concave", (0, 2)),
    ("concave", (2, 0)),
    ("arc", (0, 2)),
    ("arc", (2, 0)),
    ("semi_ellipse", (0, 3)),
    ("singleton", (2,)),
    ("constant", (2,)),
    ("gaussian2", (1, 0.5, math.inf, 0.7)),
    ("gaussian2", (-math.inf, 0.5, 1, 0.7)),
    ("piecewise", (0, 0, 1, 0.3, 2, 1)),
    ("piecewise", (0, 1, 0.5, 1, 1, 0.8, 3, 0, 4, 0)),
]
MONOTONE = [(kind, p) for kind, p in EXAMPLES if is_monotone(kind, p)]
SPREAD = np.unique(
    np.concatenate([np.linspace(-3, 6, 361), np.geomspace(1e-9, 1e300, 50), -np.geomspace(1e-9, 1e300, 50)])
)


class TestEveryKind:
    def test_has_an_example_here(self):
        assert {kind for kind, _ in EXAMPLES} == MEMBERSHIP.keys()

    @pytest.mark.parametrize(("kind", "p"), EXAMPLES)
    def test_has_good_parameters_here_and_a_summary(self, kind, p):
        formula = MEMBERSHIP[kind]
        assert formula.mistake(p) is None
        assert formula.summary
        assert formula.variadic or len(p) == len(formula.parameters)

    @pytest.mark.parametrize(("kind", "p"), EXAMPLES)
    def test_has_degrees_between_zero_and_one_everywhere(self, kind, p):
        f = degree(kind, *p)
        for x in [*SPREAD, math.inf, -math.inf]:
            assert 0 <= f(float(x)) <= 1

    @pytest.mark.parametrize(("kind", "p"), [(kind, p) for kind, p in EXAMPLES if kind != "constant"])
    def test_has_the_degrees_of_its_definition(self, kind, p):
        f, xs = degree(kind, *p), [*map(float, SPREAD), *p]
        expected = [reference.degree(reference.FLOAT, kind, p, x) for x in xs]
        np.testing.assert_allclose([f(x) for x in xs], expected, rtol=1e-12, atol=1e-15)

    @pytest.mark.filterwarnings("error")
    @pytest.mark.parametrize(("kind", "p"), EXAMPLES)
    def test_gives_arrays_what_it_gives_numbers(self, kind, p):
        f, xs = degree(kind, *p), np.array([*SPREAD, math.inf, -math.inf])
        found = array_function(MEMBERSHIP[kind].degree(Name("x"), p))(xs)
        np.testing.assert_allclose(found, [f(float(x)) for x in xs], rtol=1e-12, atol=1e-300)

    @pytest.mark.parametrize(("kind", "p"), EXAMPLES)
    def test_is_nowhere_larger_than_in_its_core(self, kind, p):
        left, right = MEMBERSHIP[kind].core(p)
        if math.isinf(left) or kind.startswith("sigmoid_"):
            return
        f = degree(kind, *p)
        assert f(left) == f(right) == pytest.approx(max(f(float(x)) for x in SPREAD), abs=2e-5)
        if kind not in ("piecewise", "gaussian2"):
            assert f(left) == f(0.5 * left + 0.5 * right) == 1

    @pytest.mark.parametrize(("kind", "p"), EXAMPLES)
    def test_has_at_its_corners_the_larger_degree_and_between_them_straight_lines(self, kind, p):
        f, corners = degree(kind, *p), MEMBERSHIP[kind].vertices(p)
        assert is_straight(kind) == (bool(corners) and kind not in ("singleton", "constant"))
        for x, _ in corners:
            assert f(x) == max(v for u, v in corners if u == x)
        for (x0, y0), (x1, y1) in pairwise(corners):
            if x0 < x1:
                assert f(x0 + 0.25 * (x1 - x0)) == pytest.approx(0.75 * y0 + 0.25 * y1, abs=1e-15)
        if corners:
            assert f(corners[0][0] - 1) == corners[0][1]
            assert f(corners[-1][0] + 1) == corners[-1][1]


class TestMembership:
    @pytest.mark.parametrize(
        ("parameters", "points"),
        [
            ((0, 1, 3), {-1: 0, 0: 0, 0.5: 0.5, 1: 1, 2: 0.5, 3: 0, 4: 0}),
            ((-math.inf, 1, 3), {-1e300: 1, 1: 1, 2: 0.5, 3: 0}),
            ((0, 1, math.inf), {0: 0, 0.25: 0.25, 1: 1, 1e300: 1}),
            ((1, 1, 3), {0.999: 0, 1: 1, 2: 0.5}),
            ((0, 3, 3), {1.5: 0.5, 3: 1, 3.001: 0}),
        ],
    )
    def test_a_triangle_rises_to_its_peak_and_falls(self, parameters, points):
        f = degree("triangle", *parameters)
        assert {x: f(x) for x in points} == points

    @pytest.mark.parametrize(
        ("kind", "p", "points"),
        [
            ("trapezoid", (0, 1, 2, 4), {0: 0, 0.5: 0.5, 1: 1, 1.5: 1, 2: 1, 3: 0.5, 4: 0}),
            ("singleton", (2,), {1.999: 0, 2: 1, 2.001: 0}),
            ("rectangle", (1, 3), {0.999: 0, 1: 1, 3: 1, 3.001: 0}),
            ("rectangle", (-math.inf, 1), {-9: 1, 1: 1, 1.001: 0}),
            ("rectangle", (1, math.inf), {0.999: 0, 1: 1, 9: 1}),
            ("ramp", (0, 2), {-1: 0, 0.5: 0.25, 2: 1, 9: 1}),
            ("ramp", (2, 0), {3: 0, 0.5: 0.75, 0: 1, -9: 1}),
            ("piecewise", (0, 0.25, 1, 1, 1, 0.5, 3, 0), {-9: 0.25, 0.5: 0.625, 1: 1, 2: 0.25, 3: 0, 9: 0}),
            ("gaussian2", (0, 1, 2, 3), {-1: math.exp(-0.5), 0: 1, 1: 1, 2: 1, 5: math.exp(-0.5)}),
            ("bell", (1, 2, 3), {1: 1, 3: 0.5, -1: 0.5, 5: 1 / 65}),
            ("sigmoid", (1, 2), {1: 0.5, 2: 1 / (1 + math.exp(-2)), -1e6: 0, 1e6: 1}),
            ("s_shape", (0, 4), {0: 0, 1: 0.125, 2: 0.5, 3: 0.875, 4: 1}),
            ("z_shape", (0, 4), {0: 1, 1: 0.875, 2: 0.5, 3: 0.125, 4: 0}),
            ("pi_shape", (0, 4, 5, 9), {1: 0.125, 4: 1, 4.5: 1, 6: 0.875, 8: 0.125, 9: 0}),
            ("pi_shape", (1, 1, 2, 2), {0.999: 0, 1: 1, 2: 1, 2.001: 0}),
            ("cosine", (1, 4), {-1.1: 0, 0: 0.5, 1: 1, 2: 0.5, 3.1: 0}),
            ("spike", (1, 10), {1: 1, 2: math.exp(-1), 0: math.exp(-1)}),
            ("concave", (0, 2), {0: 0.5, 1: 2 / 3, 2: 1, 9: 1, -2: 1 / 3}),
            ("concave", (2, 0), {2: 0.5, 1: 2 / 3, 0: 1, -9: 1, 4: 1 / 3}),
            ("arc", (0, 5), {-1: 0, 0: 0, 1: 0.6, 2: 0.8, 5: 1, 9: 1}),
            ("arc", (5, 0), {6: 0, 5: 0, 4: 0.6, 3: 0.8, 0: 1, -9: 1}),
            ("semi_ellipse", (0, 10), {0: 0, 1: 0.6, 5: 1, 8: 0.8, 10: 0, 11: 0}),
        ],
    )
    def test_each_kind_has_the_degrees_of_its_formula(self, kind, p, points):
        f = degree(kind, *p)
        assert {x: f(x) for x in points} == pytest.approx(points, rel=1e-15)

    def test_crossing_gaussians_have_their_top_between_the_means(self):
        left, right = MEMBERSHIP["gaussian2"].core((2, 1, 0, 0.5))
        assert left == right == pytest.approx(0.4)

    def test_many_corners_are_searched_by_halves(self):
        p = [v for i in range(1000) for v in (float(i), i % 7 / 7)]
        f = degree("piecewise", *p)
        assert [f(x) for x in (6.0, 13.0, 13.5, 999.0)] == pytest.approx([6 / 7, 6 / 7, 3 / 7, 5 / 7])

    @pytest.mark.parametrize("build", ["degree", "inverse"])
    def test_work_for_many_corners_grows_as_their_number(self, build):
        def comparisons(count):
            Counted.comparisons = 0
            p = tuple(Counted(v) for i in range(count) for v in (i, i / count))
            getattr(MEMBERSHIP["piecewise"], build)(Name("x"), p)
            return Counted.comparisons

        assert comparisons(1600) < 20 * 1600
        assert comparisons(1600) < 2.5 * comparisons(800)

    @QUICK
    @given(st.lists(FINITE, min_size=4, max_size=4).map(sorted), st.floats(allow_nan=False))
    def test_trapezoids_and_pi_shapes_stay_between_zero_and_one(self, p, x):
        assert 0 <= degree("trapezoid", *p)(x) <= 1
        assert 0 <= degree("pi_shape", *p)(x) <= 1

    @QUICK
    @given(st.lists(st.tuples(FINITE, UNIT), min_size=2, max_size=6), st.floats(-101, 101))
    def test_piecewise_degrees_stay_between_zero_and_one(self, corners, x):
        p = tuple(v for corner in sorted(corners, key=lambda c: c[0]) for v in corner)
        f = degree("piecewise", *p)
        assert 0 <= f(x) <= 1
        for u, _ in corners:
            assert f(u) == max(y for v, y in corners if v == u)

    @QUICK
    @given(st.lists(FINITE, min_size=4, max_size=4).map(sorted))
    def test_the_core_has_degree_one_and_the_vertices_their_degrees(self, p):
        formula = MEMBERSHIP["trapezoid"]
        f = degree("trapezoid", *p)
        assert [f(x) for x in formula.core(tuple(p))] == [1, 1]
        corners = formula.vertices(tuple(p))
        for x, y in corners:
            # The larger degree holds where two corners share their place.
            assert f(x) == max(v for u, v in corners if u == x)
            assert y <= f(x)

    @pytest.mark.parametrize(
        ("kind", "parameters", "part"),
        [
            ("triangle", (0, -1, 2), "left = 0 is greater than peak = -1"),
            ("trapezoid", (0, 1, 0.5, 2), "left_top = 1 is greater than right_top = 0.5"),
            ("gaussian", (0, 0), "must be > 0"),
            ("gaussian2", (0, 1, 2, -1), "sigma_right = -1 must be > 0"),
            ("gaussian2", (math.inf, 1, 2, 1), "an infinite mean_left is -inf"),
            ("gaussian2", (-math.inf, 1, math.inf, 1), "both infinite"),
            ("rectangle", (1, 1), "left = 1 must be less than right = 1"),
            ("rectangle", (-math.inf, math.inf), "both infinite"),
            ("rectangle", (math.inf, 1), "must be less"),
            ("ramp", (1, 1), "start and end are both 1"),
            ("bell", (0, 1, 0), "slope = 0 must be > 0"),
            ("sigmoid", (0, 0), "slope must not be 0"),
            ("sigmoid_product", (0, 1, 0, 1), "falling must not be 0"),
            ("s_shape", (1, 0), "start = 1 must be less than end = 0"),
            ("cosine", (1, 0), "width = 0 must be > 0"),
            ("piecewise", (1, 0), "pairs"),
            ("piecewise", (1, 0, 2), "pairs"),
            ("piecewise", (1, 0, 0, 1), "x = 1 is greater than the next x = 0"),
            ("piecewise", (0, 0, 1, 1.5), "the degree 1.5 lies outside"),
            ("piecewise", (0, 0, 1, 0), "0 everywhere"),
        ],
    )
    def test_bad_parameters_are_named(self, kind, parameters, part):
        assert part in MEMBERSHIP[kind].mistake(parameters)


class TestInverse:
    def test_belongs_to_the_monotone_kinds(self):
        kinds = {"ramp", "sigmoid", "s_shape", "z_shape", "concave", "arc", "triangle", "trapezoid", "pi_shape"}
        kinds |= {"gaussian2", "piecewise"}
        assert {kind for kind, _ in MONOTONE} == kinds
        assert not is_monotone("triangle", (0, 1, 2))
        assert not is_monotone("trapezoid", (-math.inf, 1, 2, math.inf))
        assert not is_monotone("linear", ())
        assert not is_monotone("gaussian2", (0, 1, 2, 1))
        assert not is_monotone("piecewise", (0, 0, 1, 1, 2, 0.5))
        assert not is_monotone("piecewise", (0, 0.5, 1, 0.5))

    @pytest.mark.parametrize(("kind", "p"), MONOTONE)
    def test_monotone_kinds_are_monotone(self, kind, p):
        degrees = [degree(kind, *p)(float(x)) for x in SPREAD]
        assert degrees in (sorted(degrees), sorted(degrees, reverse=True))

    @pytest.mark.parametrize(("kind", "p"), MONOTONE)
    @QUICK
    @given(w=st.floats(1e-6, 1 - 1e-6))
    def test_has_the_degree_it_was_asked_for(self, kind, p, w):
        place = scalar_function(MEMBERSHIP[kind].inverse(Name("w"), p))(w)
        assert degree(kind, *p)(place) == pytest.approx(w, abs=1e-9)

    @pytest.mark.parametrize(("kind", "p"), MONOTONE)
    @QUICK
    @given(x=st.floats(-1, 4))
    def test_undoes_the_degree(self, kind, p, x):
        w = degree(kind, *p)(x)
        assume(0 < w < 1)
        place = scalar_function(MEMBERSHIP[kind].inverse(Name("w"), p))(w)
        # Near a flat end the degree holds few digits of the place.
        assert place == pytest.approx(x, abs=1e-7)

    @pytest.mark.parametrize(("kind", "p"), MONOTONE)
    def test_exists_at_zero_and_one(self, kind, p):
        f = scalar_function(MEMBERSHIP[kind].inverse(Name("w"), p))
        assert f(1.0) == MEMBERSHIP[kind].core(p)[0] or f(1.0) == MEMBERSHIP[kind].core(p)[1]
        assert not math.isnan(f(0.0))

    @pytest.mark.parametrize(
        ("p", "places"),
        [
            # A jump from 0.2 to 0.6 at 1, a flat stretch at 0.6, and degrees below 0.2 and above 0.9 nowhere.
            ((0, 0.2, 1, 0.2, 1, 0.6, 2, 0.6, 3, 0.9), {0.0: 1, 0.2: 1, 0.4: 1, 0.6: 1, 0.75: 2.5, 0.9: 3, 1.0: 3}),
            ((0, 0.9, 1, 0.6, 2, 0.6, 2, 0.2, 3, 0.2), {0.0: 2, 0.2: 2, 0.4: 2, 0.6: 2, 0.75: 0.5, 0.9: 0, 1.0: 0}),
        ],
    )
    def test_points_that_jump_or_stay_have_a_place_for_every_degree(self, p, places):
        inverse = scalar_function(MEMBERSHIP["piecewise"].inverse(Name("w"), p))
        assert {w: pytest.approx(inverse(w)) for w in places} == places

    @given(w=UNIT)
    def test_of_points_never_leaves_them(self, w):
        inverse = scalar_function(MEMBERSHIP["piecewise"].inverse(Name("w"), (0.1, 0, 0.3, 0.7, 0.9, 1)))
        assert 0.1 <= inverse(w) <= 0.9
