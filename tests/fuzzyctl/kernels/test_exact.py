"""Exact defuzzifiers against rational arithmetic and integrals between places found by root finding."""

import math
import re

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from fuzzyctl import DiagnosticError, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.formulas import CONJUNCTIONS
from fuzzyctl.kernels.compile import degrees as degrees_of
from tests import sizes
from tests.fuzzyctl.kernels.joined import LOWER, UPPER, WIDTH, build, evaluated, parsed
from tests.properties.running import quick
from tests.reference.formulas import corners
from tests.reference.sets import Curved, Straight

#: Compiled code is held to plain Python by other tests, too.
SOME = ("python", "numpy", *(["numba"] if sizes.LONG else []))
STRAIGHT = (
    "triangle(-5, -2, 1)",
    "triangle(-1, 0, 1)",
    "triangle(0.5, 2, 6)",
    "trapezoid(-2, -1, 2, 3)",
    "trapezoid(2, 2, 4, 4.5)",
    "rectangle(-2.5, 0.25)",
    "rectangle(0.25, 3)",
    "ramp(0, 4)",
    "ramp(1, -4)",
    "triangle(-inf, -1, 2)",
    "piecewise(-2, 0, -1, 1, 0, 0.25, 1, 1, 2, 0)",
    "piecewise(-1, 0.5, 1, 0.5, 1, 1, 3, 0.75)",
)
CURVED = (
    "gaussian(1, 0.7)",
    "gaussian(-2, 0.01)",
    "gaussian2(-1, 0.5, 1, 1.5)",
    "gaussian2(1, 1, 0, 1.5)",
    "bell(2, 1, 3)",
    "bell(-1, 0.1, 0.75)",
    "sigmoid(1, -6)",
    "sigmoid(0, 40)",
    "sigmoid_difference(-1, 6, 9, 2)",
    "sigmoid_product(-1, 6, -9, 2)",
    "s_shape(-2, 3)",
    "z_shape(0, 1)",
    "pi_shape(-2, 0, 1, 4)",
    "cosine(1, 3)",
    "spike(0, 2)",
    "concave(-1, 2)",
    "arc(-2, 1)",
    "semi_ellipse(-1, 3)",
)
#: Of ordinary size, at ends, tied, and tiny.
ACTIVATIONS = st.one_of(
    st.floats(0.0, 1.0), st.sampled_from([0.0, 0.25, 0.5, 0.5, 1.0, 1e-9, 1e-30]), st.floats(1e-12, 1e-3)
)


@st.composite
def sets(draw, kinds, least=1):
    terms = draw(st.lists(st.sampled_from(kinds), min_size=least, max_size=3))
    return terms, [draw(ACTIVATIONS) for _ in terms]


NORMS = st.tuples(st.sampled_from(["min", "product"]), st.sampled_from(["max", "sum"]))


def straight(terms, activations, norms, lower=LOWER, upper=UPPER):
    shapes = [corners(*parsed(t)) for t in terms]
    return Straight(list(zip(shapes, activations, strict=True)), *norms, lower, upper)


class TestStraightSides:
    @given(sets(STRAIGHT), NORMS)
    @quick(60)
    def test_the_bisector_halves_the_area(self, chosen, norms):
        terms, activations = chosen
        found = evaluated(build(terms, *norms, "bisector"), activations)
        reference = straight(terms, activations, norms)
        if reference.area < 1e-300:
            assert found == 77
            return
        half = float(reference.area_up_to(found) / reference.area)
        # Rounding of a sum of areas, and of a place: far below what any grid gives.
        assert half == pytest.approx(0.5, abs=1e-14 + 1e-15 * WIDTH * max(activations) / float(reference.area))

    @given(sets(STRAIGHT), NORMS, st.sampled_from(["som", "lom", "mom"]))
    @quick(60)
    def test_maxima_are_those_of_rational_arithmetic(self, chosen, norms, kind):
        terms, activations = chosen
        found = evaluated(build(terms, *norms, kind), activations)
        reference = straight(terms, activations, norms)
        if reference.area == 0:
            assert found == 77
            return
        narrow, wide = reference.maximum(kind, 0.5e-9), reference.maximum(kind, 2e-9)
        if abs(narrow - wide) > 1e-7:
            return  # whether two maxima are one is what the tolerance decides
        # The reference takes places where the degree is a little less for maxima, too.
        assert found == pytest.approx(narrow, abs=1e-7)

    def test_the_mean_of_maxima_counts_overlaps_once_and_weighs_by_length(self):
        # [-1, 1] and [0, 2] together are [-1, 2]; beside them a lower set and a plateau [4, 4.5].
        terms = ["rectangle(-1, 1)", "rectangle(0, 2)", "rectangle(4, 4.5)"]
        found = evaluated(build(terms, "min", "max", "mom"), [0.7, 0.7, 0.7], SOME)
        assert found == pytest.approx((3 * 0.5 + 0.5 * 4.25) / 3.5, abs=1e-15)

    def test_peaks_alone_count_each_once(self):
        terms = ["triangle(-2, -1, 0)", "triangle(0, 1, 2)", "triangle(2, 4.5, 5)"]
        assert evaluated(build(terms, "min", "max", "mom"), [1.0, 1.0, 1.0]) == pytest.approx(1.5, abs=1e-15)
        assert evaluated(build(terms, "product", "sum", "mom"), [0.5, 0.5, 0.5]) == pytest.approx(1.5, abs=1e-15)

    def test_plateaus_tied_but_for_rounding_are_one_maximum(self):
        # 0.1 + 0.2 is not 0.3 in floating point.
        terms = ["rectangle(-2, -1)", "rectangle(1, 4)"]
        system = build(terms, "min", "max", "lom")
        assert evaluated(system, [0.3, 0.1 + 0.2]) == evaluated(system, [0.1 + 0.2, 0.3]) == 4.0
        strict = build(terms, "min", "max", "lom(tolerance=0)")
        assert evaluated(strict, [0.1 + 0.2, 0.3]) == -1.0


class TestCurvedSides:
    @given(
        sets((*CURVED, "triangle(-1, 0, 1)", "rectangle(0.25, 3)")),
        # The drastic product only sees where a degree rounds to 1.
        st.sampled_from([n for n in CONJUNCTIONS if n != "drastic_product"]),
        st.sampled_from(["max", "sum", "probabilistic_sum", "bounded_sum", "einstein_sum", "nilpotent_maximum"]),
    )
    @quick(15)
    def test_centroid_and_bisector_are_exact_for_all_terms_and_norms(self, chosen, implication, aggregation):
        terms, activations = chosen
        shapes = [(*parsed(t), a) for t, a in zip(terms, activations, strict=True)]
        reference = Curved(shapes, implication, aggregation, LOWER, UPPER)
        centroid = compile_system(build(terms, implication, aggregation, "centroid"), "python")
        bisector = compile_system(build(terms, implication, aggregation, "bisector"), "python")
        point = [*activations, *[0.0] * (3 - len(activations))]
        if reference.area < max(1e-290, 1e-4 * WIDTH * max(activations)):
            return  # hardly more than rounding is left of the set
        assert centroid(*point) == pytest.approx(reference.centroid(), abs=1e-12 * WIDTH)
        half = reference.area_up_to(bisector(*point)) / reference.area
        assert half == pytest.approx(0.5, abs=1e-12)

    @pytest.mark.parametrize(
        ("defuzzifier", "norms"),
        [
            ("centroid", ("nilpotent_minimum", "probabilistic_sum")),
            ("bisector", ("min", "max")),
            pytest.param("centroid", ("min", "max"), marks=pytest.mark.long),
            pytest.param("bisector", ("nilpotent_minimum", "probabilistic_sum"), marks=pytest.mark.long),
        ],
    )
    def test_all_backends_agree(self, defuzzifier, norms):
        terms = ["gaussian(-1, 0.7)", "bell(2, 1, 3)", "z_shape(0, 1)"]
        system = build(terms, *norms, defuzzifier)
        kernels = [compile_system(system, b) for b in SOME]
        points = np.array([[0.3, 0.8, 0.5], [1, 0, 0], [1e-9, 1e-12, 0], [0, 0, 0], [0.4, 0.4, 0.4]])
        found = [k.batch(points) for k in kernels]
        for other in found[1:]:
            assert other == pytest.approx(found[0], rel=1e-12)
        assert found[0][3] == 77
        assert [k(*points[0]) for k in kernels] == pytest.approx([found[0][0]] * len(kernels), rel=1e-12)
        assert all(math.isnan(k(math.nan, 1, 1)) for k in kernels)

    @given(sets((*CURVED, "triangle(-1, 0, 1)", "rectangle(0.25, 3)")), st.sampled_from(["som", "lom"]))
    @quick(60)
    def test_ends_of_maxima_are_where_a_term_reaches_the_activation(self, chosen, kind):
        terms, activations = chosen
        allowed = [not t.startswith(("sigmoid_", "gaussian2(1")) for t in terms]
        if not all(allowed) or 0.0 < max(activations) < 1e-9 or max(activations) > 0.99:
            return  # near a foot degrees have no digits, and near a top many places round to the same degree
        found = evaluated(build(terms, "min", "max", kind), activations)
        if max(activations) == 0.0:
            assert found == 77
            return
        grid = np.append(np.linspace(LOWER, UPPER, 4001), [found - 1e-12, found, found + 1e-12])
        degrees = []
        for term, activation in zip(terms, activations, strict=True):
            system = build([term], "min", "max", "centroid(resolution=2)")
            output = system.outputs[0]
            degrees.append(np.minimum(activation, degrees_of(system, output, output.terms[0], grid)))
        whole = np.max(degrees, axis=0)
        # Near a foot a place has no more digits than the degree needs.
        most = whole[-3:].max()
        assert most >= whole.max() * (1.0 - 1e-8)
        beyond = grid[:-3] < found - 1e-9 if kind == "som" else grid[:-3] > found + 1e-9
        assert whole[:-3][beyond].max(initial=0.0) < most * (1.0 - 1e-9) or not beyond.any()

    def test_maxima_without_a_closed_form_are_refused_with_a_way_out(self):
        for terms, norms in (
            (["sigmoid_product(-1, 6, -9, 2)"], ("min", "max")),
            (["gaussian(1, 0.7)"], ("min", "sum")),
            (["triangle(-1, 0, 1)"], ("einstein_product", "max")),
        ):
            with pytest.raises(DiagnosticError) as error:
                build(terms, *norms, "mom")
            assert [d.code for d in error.value.diagnostics] == ["FZ214"]
            assert "mom(resolution=1000)" in error.value.diagnostics[0].help
            assert build(terms, *norms, "mom(resolution=100)") is not None


BEND = """
system s
input x in [0, 10]
  a = triangle(-inf, 0, 10)
  b = ramp(0, 10)
output y in [0, 10]
  p = s_shape(2, 5)
  q = ramp(10, 2)
if x is a then y is p
if x is b then y is q
"""


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_a_bend_near_the_end_of_a_stretch_is_seen(backend):
    """q falls below the activation of p so near to 10 that no node of Gauss and Kronrod lies beyond."""
    kernel = compile_system(loads(BEND), backend)
    for x in (9.98, 9.99, 9.999, 9.99999):
        low, high = 1 - x / 10, x / 10
        # q falls below its own activation at `fall`, and at `bend` below p's, which p has long reached by then.
        fall, bend = 10 - 8 * high, 10 - 8 * low
        area = high * fall + ((10 - fall) ** 2 - (10 - bend) ** 2) / 16 + low * (10 - bend)
        moment = high * fall**2 / 2 + low * (100 - bend**2) / 2
        moment += (5 * bend**2 - bend**3 / 3 - 5 * fall**2 + fall**3 / 3) / 8
        assert kernel.batch([[x]])[0] == pytest.approx(moment / area, rel=1e-12)


@pytest.mark.parametrize("width", [1e-310, 8e307])
@pytest.mark.parametrize("kind", ["centroid", "bisector", "mom"])
@pytest.mark.parametrize(
    ("norms", "shapes"),
    [
        (("min", "max"), "triangle(-1, -1, 0) triangle(-1, 0, 0.5) triangle(0, 1, 1)"),
        (("product", "sum"), "triangle(-1, -1, 0) triangle(-1, 0, 0.5) triangle(0, 1, 1)"),
        (("min", "max"), "gaussian(-1, 0.3) gaussian(0, 0.3) gaussian(0.8, 0.2)"),
    ],
    ids=str,
)
def test_ranges_may_be_as_small_or_large_as_numbers(width, kind, norms, shapes):
    """Squares of lengths are no numbers there, and moments are made of these."""
    terms = [f"{name}({numbers}" for name, numbers in re.findall(r"(\w+)\(([^)]*\))", shapes)]
    small = build(terms, *norms, kind, lower=-1, upper=1)
    scaled = [re.sub(r"-?\d[\d.]*(?=[,)])", lambda n: repr(float(n[0]) * width), t) for t in terms]
    large = build(scaled, *norms, kind, lower=-width, upper=width)
    for activations in ([0.3, 0.6, 0.2], [0.5, 0.5, 0.9]):
        # Ranges below 2e-308 have not all digits.
        tolerance = 1e-12 if width > 1e-300 else 1e-9
        share = evaluated(large, activations) / width
        assert share == pytest.approx(evaluated(small, activations), rel=0, abs=tolerance)
