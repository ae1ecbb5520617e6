"""Outputs that hold their previous value: every backend does what a loop over single evaluations does."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl import NoRuleFiresError, dumps, loads
from fuzzyctl import compile as compile_system
from tests.sizes import examples

BACKENDS = ("python", "numpy", "numba")

#: Averages take the peaks of terms. u holds; v reads u and holds; w reads v and has a value; z holds on its own.
SYSTEM = """
system held
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 1, 3)
  high = triangle(6, 8, 9)
input y in [-1, 1]
  down = triangle(-inf, -0.6, 0.1)
output u in [-5, 5] else hold(START)
  a = triangle(-6, -4, -2)
  b = triangle(4, 5, 6)
  low_u = triangle(-6, -5, -1)
  high_u = triangle(3, 5, 6)
output v in [0, 1] else hold
  a = triangle(-1, 0.1, 0.3)
  b = triangle(0.6, 0.9, 2)
output w in [0, 1] else 0.25
  a = singleton(0)
  b = singleton(1)
output z in [0, 8] else hold(3) defuzzifier centroid
  mid = triangle(1, 2, 6)
if x is low then u is a
if x is high then u is b
if u is low_u and y is down then v is a
if u is high_u then v is b
if v is a then w is a
if v is b and y is down then w is b
if y is down and x is high then z is mid
"""

VALUES = st.floats(-1, 11) | st.sampled_from([math.nan, math.inf, -math.inf, 2.0, 4.5, 7.0, 9.5])
POINTS = st.lists(st.tuples(VALUES, st.floats(-1.5, 1.5) | st.just(math.nan)), max_size=12)


@pytest.fixture(scope="module")
def kernels():
    return {b: compile_system(loads(SYSTEM.replace("START", "-1.5")), b) for b in BACKENDS}


def stepped(kernel, points, state):
    """Evaluate one point after the other, as a controller does, by hand."""
    state, results = list(state), []
    names = ("u", "v", "z")
    for point in points:
        outputs = kernel(*point, state)
        results.append(outputs)
        by_name = dict(zip(kernel.output_names, outputs, strict=True))
        order = [kernel.output_names[o] for o in kernel.plan.held]
        assert sorted(order) == sorted(names)
        state = [old if math.isnan(by_name[n]) else by_name[n] for n, old in zip(order, state, strict=True)]
    return np.array(results).reshape(len(results), len(kernel.output_names)), state


@given(points=POINTS)
@settings(max_examples=examples(150), deadline=None)
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_run_is_the_sequence_of_its_points(kernels, backend, points):
    kernel = kernels[backend]
    state = kernel.start()
    expected, last = stepped(kernels["python"], points, state)
    found, after = kernel.run(np.array(points, dtype=float).reshape(len(points), 2))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, equal_nan=True)
    np.testing.assert_allclose(after, last, rtol=1e-12)


@given(points=POINTS, cut=st.integers(0, 12))
@settings(max_examples=examples(50), deadline=None)
def test_a_sequence_may_be_cut_anywhere(kernels, points, cut):
    kernel = kernels["numba"]
    whole, _ = kernel.run(np.array(points, dtype=float).reshape(len(points), 2))
    first, second = (np.array(p, dtype=float).reshape(len(p), 2) for p in (points[:cut], points[cut:]))
    begun, state = kernel.run(first)
    rest, _ = kernel.run(second, state)
    np.testing.assert_array_equal(whole, np.concatenate([begun, rest]))


@pytest.mark.parametrize("backend", BACKENDS)
class TestHold:
    def test_begins_with_the_value_given_or_the_middle_of_the_range(self, kernels, backend):
        kernel = kernels[backend]
        outputs = dict(zip(kernel.output_names, kernel(4.5, 1.0, kernel.start()), strict=True))
        assert (outputs["u"], outputs["v"], outputs["z"]) == (-1.5, 0.5, 3.0)

    def test_a_read_output_counts_as_it_is_held(self, kernels, backend):
        outputs, _ = kernels[backend].run([[7.0, 1.0], [4.5, 1.0]])
        v = kernels[backend].output_names.index("v")
        assert outputs[:, v].tolist() == [0.9, 0.9]

    def test_states_of_single_points_are_no_sequence(self, kernels, backend):
        kernel = kernels[backend]
        state = np.array([kernel.start(), kernel.start() + 0.25])
        u = kernel.output_names.index("u")
        assert kernel.batch([[7.0, 1.0], [4.5, 1.0]], state)[:, u].tolist() == [5.0, -1.25]

    def test_a_state_that_is_nan_gives_nan_where_it_is_held_and_only_there(self, kernels, backend):
        kernel = kernels[backend]
        state = np.full(3, math.nan)
        u = kernel.output_names.index("u")
        assert math.isnan(kernel(4.5, 1.0, state)[u])
        assert kernel(7.0, 1.0, state)[u] == 5.0


#: v promises that a rule fires, and reads nothing that is held; w reads what is held, and is NaN where that is.
PROMISED = """
system promised
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 1, 3)
  high = triangle(6, 8, inf)
output u in [-5, 5] else hold(nan)
  a = triangle(-6, -4, -2)
output v in [0, 1]
  b = triangle(0, 0.25, 1)
output w in [0, 1]
  c = triangle(0, 0.5, 1)
if x is low then u is a, v is b
if x is high then v is b
if u is a then w is c
"""


@pytest.mark.parametrize("backend", BACKENDS)
class TestPromisesBesideAHeldNaN:
    def test_a_broken_one_is_an_error_not_a_nan(self, backend):
        kernel = compile_system(loads(PROMISED), backend)
        with pytest.raises(NoRuleFiresError, match="'v' at x = 4"):
            kernel(4.0, kernel.start())
        with pytest.raises(NoRuleFiresError, match="'v' at x = 4"):
            kernel.batch([[7.0], [4.0], [1.0]])
        with pytest.raises(NoRuleFiresError, match="'v' at x = 4"):
            kernel.batch([[7.0], [4.0]], [[math.nan], [math.nan]])

    def test_what_reads_it_has_no_value_and_broke_none(self, backend):
        kernel = compile_system(loads(PROMISED), backend)
        np.testing.assert_array_equal(kernel(7.0, kernel.start()), [math.nan, 0.25, math.nan])
        np.testing.assert_array_equal(
            kernel.run([[7.0], [1.0], [7.0]])[0], [[math.nan, 0.25, math.nan], [-4.0, 0.25, 0.5], [-4.0, 0.25, 0.5]]
        )


def test_what_is_held_at_first_is_a_param_like_any_other():
    system = loads(SYSTEM.replace("START", "first").replace("input x", "param first = 2\ninput x"))
    assert loads(dumps(system)) == system
    assert system(x=4.5, y=1.0)["u"] == 2.0
    assert system.with_params(first=3)(x=4.5, y=1.0)["u"] == 3.0
    assert "else hold(first)" in dumps(system)
    assert "output v in [0, 1] else hold\n" in dumps(system)
