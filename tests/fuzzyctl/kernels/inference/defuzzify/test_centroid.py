from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.inference.defuzzify.centroid import line_ends, pieces, uncrossed
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.scalar import compile_source, evaluation_source
from fuzzyctl.model.method import Defuzzifier
from tests import sizes
from tests.tipper import POINTS, TIPS

BACKENDS = ("python", "numpy", "numba")


def at(kernel, *point):
    """Evaluate through the scalar and the batch path, which must agree."""
    value = kernel(*point)
    assert kernel.batch(list(point)) == pytest.approx(value, rel=1e-14)
    return value


@pytest.mark.parametrize("backend", sizes.BACKENDS)
class TestTipper:
    def test_the_exact_centroid_is_the_limit_of_fine_grids(self, tipper, backend):
        # Integrated with a million midpoints by an independent program.
        kernel = compile_system(tipper, backend)
        assert [at(kernel, *p) for p in POINTS] == pytest.approx(TIPS["exact"], abs=1e-9)

    @pytest.mark.parametrize(
        ("resolution", "grid", "expected"),
        [
            # What MATLAB, Octave and others print for 101 end points, and pyfuzzylite for 1000 midpoints.
            (101, "endpoints", TIPS["matlab"]),
            (1000, "midpoint", TIPS["pyfuzzylite"]),
        ],
    )
    def test_sampled_centroids_are_those_of_other_programs(self, tipper, backend, resolution, grid, expected):
        defuzzifier = Defuzzifier(resolution=resolution, grid=grid)
        method = tipper.method.model_copy(update={"defuzzifier": defuzzifier})
        kernel = compile_system(tipper.model_copy(update={"method": method}), backend)
        assert [at(kernel, *p) for p in POINTS] == pytest.approx(expected, abs=1e-10)


TEXT = """
system s
implication {implication}
aggregation {aggregation}
defuzzifier centroid
input x in [0, 1]
  on = triangle(-inf, 0, 1)
input y in [0, 1]
  on = triangle(-inf, 0, 1)
output u in [{lower}, {upper}] else 77
{terms}
{rules}
"""


def system(terms, lower=0, upper=10, implication="min", aggregation="max"):
    lines = "\n".join(f"  t{i} = {t}" for i, t in enumerate(terms))
    rules = "\n".join(f"if {'xy'[i % 2]} is on then u is t{i}" for i in range(len(terms)))
    text = TEXT.format(
        terms=lines, rules=rules, lower=lower, upper=upper, implication=implication, aggregation=aggregation
    )
    return loads(text)


class TestShapes:
    """At x the first set is cut at 1 - x, at y the second one at 1 - y."""

    def test_one_triangle_clipped_in_the_middle_keeps_its_symmetry(self):
        kernel = compile_system(system(["triangle(2, 4, 6)"]), "python")
        assert kernel(0.5, 1.0) == pytest.approx(4, abs=1e-15)

    def test_a_skewed_triangle_moves_with_the_cut(self):
        kernel = compile_system(system(["triangle(0, 0, 3)"]), "python")
        assert kernel(0.0, 1.0) == pytest.approx(1)
        # A trapezoid of height h over [0, 3] with top [0, 3(1 - h)].
        h = Fraction(1, 4)
        top = 3 * (1 - h)
        area = h * (3 + top) / 2
        moment = h * top * top / 2 + h * (3 - top) / 2 * (top + (3 - top) / 3)
        assert kernel(0.75, 1.0) == pytest.approx(float(moment / area), rel=1e-15)

    def test_vertical_sides_are_jumps(self):
        kernel = compile_system(system(["trapezoid(1, 1, 3, 3)", "trapezoid(3, 3, 7, 7)"]), "python")
        assert kernel(0.0, 1.0) == 2
        assert kernel(0.5, 0.0) == pytest.approx((0.5 * 2 * 2 + 1 * 4 * 5) / 5)

    def test_what_lies_outside_the_range_does_not_count(self):
        kernel = compile_system(system(["triangle(-4, 0, 4)"]), "python")
        assert kernel(0.0, 1.0) == pytest.approx(4 / 3)

    def test_an_infinite_foot_ends_at_the_range(self):
        kernel = compile_system(system(["triangle(-inf, 4, 4)"]), "python")
        assert kernel(0.9, 1.0) == pytest.approx(2)

    def test_a_set_wholly_outside_counts_like_no_rule(self):
        kernel = compile_system(system(["triangle(11, 12, 13)", "triangle(1, 2, 3)"]), "python")
        assert kernel(0.0, 1.0) == 77
        assert kernel(0.0, 0.5) == 2

    def test_nothing_fires_where_all_sets_are_empty(self):
        assert compile_system(system(["triangle(1, 2, 3)"]), "python")(1.0, 1.0) == 77

    @pytest.mark.parametrize("implication", ["min", "product"])
    def test_max_counts_an_overlap_once_and_sum_twice(self, implication):
        same = ["triangle(2, 4, 6)", "triangle(2, 4, 6)", "triangle(7, 8, 9)"]
        area, other = 2.0, 1.0
        once = compile_system(system(same, implication=implication), "python")
        assert once(0.0, 0.0) == pytest.approx((area * 4 + other * 8) / (area + other))
        twice = compile_system(system(same, implication=implication, aggregation="sum"), "python")
        assert twice(0.0, 0.0) == pytest.approx((2 * area * 4 + other * 8) / (2 * area + other))

    def test_a_range_far_from_zero_costs_no_digits_of_its_width(self):
        near = compile_system(system(["triangle(1, 2, 5)", "triangle(4, 6, 7)"]), "python")
        far_terms = [f"triangle({a + 4096}, {b + 4096}, {c + 4096})" for a, b, c in ((1, 2, 5), (4, 6, 7))]
        far = compile_system(system(far_terms, lower=4096, upper=4106), "python")
        assert far(0.3, 0.6) - 4096 == pytest.approx(near(0.3, 0.6), abs=1e-12)


class TestPieces:
    def test_are_cut_at_corners_and_crossings(self):
        output = plan(system(["triangle(0, 2, 4)", "triangle(2, 4, 6)"])).outputs[0]
        heights = [(0, None, 1.0), (1, None, 1.0)]
        found = pieces(output, heights)
        assert [float(p.start) + 5 for p in found] == [0, 2, 4]
        assert [float(p.start) + 5 for piece in found for p in uncrossed(piece)] == [0, 2, 3, 4]

    def test_lines_are_limits_from_inside(self):
        box = ((1.0, 0.0), (1.0, 1.0), (3.0, 1.0), (3.0, 0.0))
        assert line_ends(box, Fraction(1), Fraction(3)) == (1, 1)
        assert line_ends(box, Fraction(0), Fraction(1)) == (0, 0)
        assert line_ends(box, Fraction(3), Fraction(4)) == (0, 0)


def test_a_sum_of_many_clipped_triangles_is_written_out():
    """Triangles of one width, cut at w, have areas in proportion to w - w²/2 (Passino and Yurkovich 1998)."""
    names = [f"T{k}" for k in range(11)]
    text = "system many\naggregation sum\ninput a, b in [-1, 1]\n" + f"terms {' '.join(names)}\n"
    text += "output y in [-1.2, 1.2]\n"
    text += "".join(f"{n} = triangle({(k - 6) / 5}, {(k - 5) / 5}, {(k - 4) / 5})\n" for k, n in enumerate(names))
    text += f"table y = a x b\n  {' '.join(names)}\n"
    text += "".join(
        f"{n} | {' '.join(names[min(max(10 - k - j + 5, 0), 10)] for j in range(11))}\n" for k, n in enumerate(names)
    )
    planned = plan(loads(text))
    program = algorithm_of(planned, "rules").point
    assert not any(isinstance(s, Quadrature) for s in program.body)
    function = compile_source(evaluation_source(program), program, ["a", "b"])
    for a, b in ((0.03, -0.45), (-0.98, 0.55), (0.6, 0.6)):
        degrees = [[max(0, 1 - abs(x - (k - 5) / 5) * 5) for k in range(11)] for x in (a, b)]
        cut = {(k, j): min(degrees[0][k], degrees[1][j]) for k in range(11) for j in range(11)}
        areas = {at: w - w * w / 2 for at, w in cut.items()}
        middles = {(k, j): (min(max(15 - k - j, 0), 10) - 5) / 5 for k, j in areas}
        expected = sum(areas[at] * middles[at] for at in areas) / sum(areas.values())
        assert np.ravel(function(a, b))[0] == pytest.approx(expected, abs=1e-13)
