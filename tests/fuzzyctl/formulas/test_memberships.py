"""Every membership function keeps its laws: its degree, corners, core and inverse belong together."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyctl import compile, loads
from fuzzyctl.expr import Name
from fuzzyctl.formulas import MEMBERSHIP, is_monotone, is_straight
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.reference import formulas as reference
from tests.sizes import examples

#: Other processes may slow a test down at any time.
QUICK = settings(max_examples=examples(60, 20), deadline=None)
UNIT = st.floats(0, 1)
FINITE = st.floats(-100, 100, allow_subnormal=False)


def degree(kind, *parameters):
    return scalar_function(MEMBERSHIP[kind].degree(Name("x"), parameters))


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

    @pytest.mark.parametrize(("kind", "p"), [(kind, p) for kind, p in EXAMPLES if kind != "constant"])
    def test_has_the_degrees_of_its_definition(self, kind, p):
        f, xs = degree(kind, *p), [*map(float, SPREAD), *p]
        expected = [reference.degree(reference.FLOAT, kind, p, x) for x in xs]
        found = [f(x) for x in (*xs, math.inf, -math.inf)]
        assert 0 <= min(found) <= max(found) <= 1
        np.testing.assert_allclose(found[:-2], expected, rtol=1e-12, atol=1e-15)

    @pytest.mark.filterwarnings("error")
    def test_gives_arrays_what_it_gives_numbers(self):
        named = [(f"t{k}", kind, p) for k, (kind, p) in enumerate(EXAMPLES) if kind != "constant"]
        terms = "".join(f"  {name} = {kind}({', '.join(map(str, p))})\n" for name, kind, p in named)
        rules = "".join(f"if x is {name} then y is 1\n" for name, *_ in named)
        head = "system s\ndefuzzifier weighted_average\ninput x in [-1, 1] extrapolate\n"
        system = loads(f"{head}{terms}output y in [0, 1] else 0\n{rules}")
        points = np.array([*SPREAD, math.inf, -math.inf])[:, None]
        degrees = compile(system, "numpy").degrees(points)["x"]
        for name, kind, p in named:
            f = degree(kind, *p)
            np.testing.assert_allclose(degrees[name], [f(float(x)) for x in points[:, 0]], rtol=1e-12, atol=1e-300)

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
    def test_crossing_gaussians_have_their_top_between_the_means(self):
        left, right = MEMBERSHIP["gaussian2"].core((2, 1, 0, 0.5))
        assert left == right == pytest.approx(0.4)

    def test_many_corners_are_searched_by_halves(self):
        p = [v for i in range(1000) for v in (float(i), i % 7 / 7)]
        f = degree("piecewise", *p)
        assert [f(x) for x in (6.0, 13.0, 13.5, 999.0)] == pytest.approx([6 / 7, 6 / 7, 3 / 7, 5 / 7])

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
