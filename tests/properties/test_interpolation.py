"""Interpolation and the evaluation of all rules are the same function."""

import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzzyctl import ArgumentError, loads, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan
from tests import sizes
from tests.properties.around import points_around
from tests.properties.drawn_tables import systems
from tests.sizes import examples


@settings(max_examples=examples(60), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(case=systems(), seed=st.integers(0, 1000))
@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_interpolation_is_the_evaluation_of_all_rules(backend, case, seed):
    text, knots = case
    system = loads(text)
    found = algorithm_of(plan(system))
    assert found.name == "interpolation" or "close to 0" in found.reason
    points = points_around(knots, seed)
    expected = compile_system(system, "numpy", algorithm="rules").batch(points)
    np.testing.assert_allclose(compile_system(system, backend).batch(points), expected, rtol=0, atol=20e-12)
    bound = output_bounds(system)["u"]
    assert bound.lo <= compile_system(system, backend).batch(points).min()
    assert compile_system(system, backend).batch(points).max() <= bound.hi


@settings(max_examples=examples(6, 1), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(case=systems(), seed=st.integers(0, 1000))
def test_compiled_interpolation_too(case, seed):
    text, knots = case
    system = loads(text)
    points = points_around(knots, seed)
    kernel = compile_system(system, "numba")
    expected = compile_system(system, "python", algorithm="rules").batch(points)
    np.testing.assert_allclose(kernel.batch(points), expected, rtol=0, atol=20e-12)
    for point, value in zip(points[:20].tolist(), expected[:20], strict=True):
        assert kernel(*point) == pytest.approx(value, abs=20e-12)


MANY = """
system many
and product
defuzzifier weighted_average
{inputs}
output u in [-9, 9]
  a = constant(-7)
  b = constant(0.125)
  c = constant(8)
{rules}
"""


CONSEQUENTS = {"a": -7.0, "b": 0.125, "c": 8.0}


def interpolated(values, points):
    """Interpolate between the values at the peaks of even partitions, one input after the other."""
    results = []
    for point in points:
        left = values
        for i, x in enumerate(point):
            peaks = np.linspace(i, i + 2, len(left))
            degrees = np.array([np.interp(x, peaks, row) for row in np.eye(len(left))])
            left = np.tensordot(degrees, left, axes=(0, 0))
        results.append(float(left))
    return np.array(results)


def weighted(knots, seed):
    """Return a complete rule base, by the numbers of knots of its inputs, and the values and weights at all knots."""
    rng = np.random.default_rng(seed)
    values, weights = rng.choice([-7.0, 0.125, 8.0], knots), rng.choice([1.0, 0.5], knots)
    names = {v: k for k, v in CONSEQUENTS.items()}
    text = "\n".join(f"input x{i} in [{i}, {i + 2}]\n  terms {' '.join('ABCDE'[:k])}" for i, k in enumerate(knots))
    rules = []
    for c in itertools.product(*map(range, knots)):
        conditions = " and ".join(f"x{i} is {'ABCDE'[t]}" for i, t in enumerate(c))
        rules.append(f"if {conditions} then u is {names[values[c]]} weight {weights[c]}")
    return loads(MANY.format(inputs=text, rules="\n".join(rules))), values, weights


def around_all(inputs, count, seed):
    """Return points within the ranges, beyond them, and at corners."""
    rng = np.random.default_rng(seed)
    inside = rng.uniform(-0.3, 2.3, (count, inputs)) + np.arange(inputs)
    return np.where(rng.random((count, inputs)) < 0.3, rng.integers(0, 3, (count, inputs)) + np.arange(inputs), inside)


class TestManyInputs:
    """Loops over the corners of a cell, beyond six inputs."""

    @pytest.mark.parametrize("backend", sizes.BACKENDS)
    @pytest.mark.parametrize(
        "knots", [(5,) * 4, (3,) * 6, (2,) * 7, (2, 3, 2, 2, 2, 2, 2, 2), (3, 2, 2, 2, 2, 2, 3)], ids=str
    )
    def test_the_quotient_of_the_sums_over_all_rules_is_computed(self, knots, backend):
        system, values, weights = weighted(knots, seed=len(knots))
        points = around_all(len(knots), 25, seed=sum(knots))
        expected = interpolated(values * weights, points) / interpolated(weights, points)
        kernel = compile_system(system, backend)
        assert kernel.algorithm.name == "interpolation"
        # Sums of up to 8 · 2^-1, of 2^n products, over weights of 1/2 or more.
        np.testing.assert_allclose(kernel.batch(points), expected, rtol=0, atol=2e-11)
        np.testing.assert_allclose([kernel(*p) for p in points.tolist()], expected, rtol=0, atol=2e-11)

    def test_corners_are_exact_and_nan_goes_through(self):
        system, values, _ = weighted((2,) * 8, seed=8)
        corners = np.array(list(itertools.product((0, 1), repeat=8)))[::7]
        points = 2.0 * corners + np.arange(8)
        expected = [values[tuple(c)] for c in corners] + [np.nan] * 8
        points = np.vstack([points, [points[0]] * 8])
        points[range(-8, 0), range(8)] = np.nan
        for backend in ("python", "numpy"):
            np.testing.assert_array_equal(compile_system(system, backend).batch(points), expected)


class TestChoice:
    TEXT = """
system s
and {conjunction}
defuzzifier weighted_average
activation {activation}
input x in [0, 1]
  {a}
  b = triangle(0, 1, inf)
input y in [0, 2]
  terms a b
output u in [0, 1]
  lo = constant(0)
  hi = {hi}
if x is a and y is a then u is lo
if x is a and y is b then u is hi
if x is {hedge}b {and_y}then u is hi
"""

    def text(self, **changes):
        usual = {
            "conjunction": "product",
            "activation": "general",
            "a": "a = triangle(-inf, 0, 1)",
            "hi": "constant(1)",
            "hedge": "",
            "and_y": "",
        }
        return self.TEXT.format(**usual | changes)

    def test_is_interpolation_where_it_can_be(self):
        kernel = compile_system(loads(self.text()), "python")
        assert kernel.algorithm.name == "interpolation"
        assert kernel.algorithm.reason == "the output at 2 x 2 knots of the inputs"
        assert compile_system(loads(self.text()), "python", algorithm="rules").algorithm.name == "rules"

    @pytest.mark.parametrize(
        ("changes", "reason"),
        [
            ({"conjunction": "min"}, "not products of straight lines"),
            ({"hedge": "very "}, "not products of straight lines"),
            ({"and_y": "and x is a and y is a "}, "not products of straight lines"),
            ({"a": "a = gaussian(0, 0.4)"}, "'a' of 'x' has no straight sides or jumps"),
            ({"a": "a = rectangle(0, 1)"}, "'a' of 'x' has no straight sides or jumps"),
            ({"a": "a = triangle(-inf, 0, 1e-9)"}, "'x' lie too close"),
            ({"activation": "proportional"}, "activation 'proportional' compares rules"),
            ({"hi": "linear(1, 0, 0)"}, "functions of the inputs"),
        ],
    )
    def test_is_the_rules_where_it_cannot(self, changes, reason):
        system = loads(self.text(**changes))
        assert reason in compile_system(system, "python").algorithm.reason
        with pytest.raises(ArgumentError, match="does not interpolate"):
            compile_system(system, "python", algorithm="interpolation")

    def test_a_hole_is_left_to_the_rules(self):
        text = self.text(a="a = triangle(-inf, 0, 0.5)").replace("b = triangle(0, 1, inf)", "b = triangle(0.6, 1, inf)")
        kernel = compile_system(loads(text.replace("output u in [0, 1]", "output u in [0, 1] else 0.3")), "python")
        assert kernel.algorithm.reason == "activations come close to 0"
        assert kernel(0.55, 0.0) == 0.3
