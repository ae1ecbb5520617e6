import math

import numpy as np
import pytest

from fuzzyctl import ArgumentError, FuzzyctlError, NoRuleFiresError, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.expr import Name

BACKENDS = ("python", "numba")


def stored(function, *arguments, size=7):
    result = np.full(size, 99.0)
    function(*arguments, result)
    return result


@pytest.mark.parametrize("backend", BACKENDS)
class TestAdaptiveKernel:
    def test_rates_stop_at_the_ends_of_the_range_and_let_go_inwards(self, adaptive, backend):
        rates = compile_system(adaptive, backend).jit_rates
        at_top = np.full(7, 2.0)
        assert not stored(rates, 0.4, at_top).any()
        assert stored(rates, -0.4, at_top)[0] == -0.4
        assert not stored(rates, -0.4, -at_top).any()
        assert stored(rates, 0.4, -at_top)[6] == 0.4

    def test_an_infinite_input_moves_only_rules_that_fire(self, adaptive, backend):
        rates = stored(compile_system(adaptive, backend).jit_rates, math.inf, np.zeros(7))
        np.testing.assert_array_equal(rates, [0, 0, 0, 0, 0, 0, math.inf])

    def test_nan_makes_everything_nan(self, adaptive, backend):
        kernel = compile_system(adaptive, backend)
        assert math.isnan(kernel(math.nan, np.zeros(7)))
        assert np.isnan(stored(kernel.jit_rates, math.nan, np.zeros(7))).all()
        assert np.isnan(stored(kernel.jit_strengths, math.nan)).all()

    def test_consequents_that_are_nan_break_no_promise(self, backend):
        system = loads(
            """
system s
defuzzifier weighted_average
input x in [-1, 1]
  n = triangle(-inf, -1, 0)
output u in [-2, 2] adaptive rate x
  n = singleton(-1)
if x is n then u is n
"""
        )
        kernel = compile_system(system, backend)
        assert math.isnan(kernel(-0.75, np.array([math.nan])))
        assert math.isnan(kernel.batch([[-0.75]], np.array([math.nan]))[0])
        for evaluate in (kernel, lambda x, state: kernel.batch([[x]], state)):
            with pytest.raises(NoRuleFiresError, match="'u'"):
                evaluate(0.5, np.zeros(1))

    def test_a_rate_may_divide_by_zero_without_an_exception(self, backend):
        system = loads(
            """
system s
defuzzifier weighted_average
input x in [-1, 1]
  n = triangle(-inf, -1, 1)
  p = triangle(-1, 1, inf)
output u in [-2, 2] else 9 adaptive rate 1 / x + log(x) + sqrt(x) + x ^ 0.5 - sign(x)
  n = singleton(-1)
  p = singleton(1)
if x is n then u is n
if x is p then u is p
"""
        )
        kernel = compile_system(system, backend)
        np.testing.assert_array_equal(kernel.start(), [-1, 1])
        with np.errstate(all="ignore"):
            assert np.isnan(stored(kernel.jit_rates, 0.0, np.zeros(2), size=2)).all()
            assert np.isnan(stored(kernel.jit_rates, -0.5, np.zeros(2), size=2)).all()
        x = 0.25
        expected = 1 / x + math.log(x) + 2 * math.sqrt(x) - 1
        rates = stored(kernel.jit_rates, x, np.zeros(2), size=2)
        np.testing.assert_allclose(rates, expected * np.array([(1 - x) / 2, (1 + x) / 2]))

    def test_a_missing_state_is_named(self, adaptive, backend):
        kernel = compile_system(adaptive, backend)
        with pytest.raises(ArgumentError, match=r"2 arguments \(sigma, state\), got 1"):
            kernel(0.1)
        assert kernel.batch([[0.1]]) == kernel.batch([[0.1]], kernel.start())
        with pytest.raises(ArgumentError, match=r"shape \(..., 7\), got \(3,\)"):
            kernel.batch([[0.1]], np.zeros(3))
        with pytest.raises(ArgumentError, match="must have 7 entries, got 6"):
            kernel(0.1, np.zeros(6))
        with pytest.raises(ArgumentError, match="state must be an array of real numbers"):
            kernel(0.1, None)
        with pytest.raises(ArgumentError, match="input must be a real number"):
            kernel("0.1", np.zeros(7))
        with pytest.raises(ArgumentError, match="does not fit"):
            kernel.batch([[0.1]] * 3, np.zeros((2, 7)))
        with pytest.raises(ArgumentError, match=r"the state must have the shape \(7,\), got \(2, 7\)"):
            kernel.run([0.1, 0.2], np.zeros((2, 7)))
        with pytest.raises(ArgumentError, match=r"the state must have the shape \(7,\), got \(1, 7\)"):
            kernel(0.1, np.zeros((1, 7)))


def test_systems_without_adaptive_outputs_have_no_rates(ais):
    kernel = compile_system(ais, "python")
    with pytest.raises(FuzzyctlError, match="no adaptive output"):
        kernel.jit_rates  # noqa: B018 - looking it up is what raises


def test_only_rules_that_name_an_adaptive_output_have_a_consequent():
    system = loads(
        """
system s
defuzzifier weighted_average
input x in [0, 1]
  lo = triangle(-inf, 0, 1)
  hi = triangle(0, 1, inf)
output fixed in [0, 1]
  a = singleton(1)
output free in [0, 5] else 0
  b = singleton(2)
  c = singleton(3)
if x is lo then fixed is a
if x is hi then fixed is a, free is c
if x is lo then free is b weight 0.5
"""
    )
    fixed, free = system.outputs
    free = free.model_copy(update={"adaptive": Name("x")})
    kernel = compile_system(system.model_copy(update={"outputs": (fixed, free)}), "python")
    assert (kernel.n_rules, kernel.n_states) == (3, 2)
    np.testing.assert_array_equal(kernel.start(), [3, 2])
    assert kernel(0.5, [4.0, 1.0]) == (1.0, pytest.approx((0.5 * 4 + 0.25 * 1) / 0.75))


SEVERAL = """
system two
defuzzifier weighted_average
and product
input x in [-1, 1]
  terms N Z P
input e in [-1, 1]
output f in [-2, 2] adaptive rate 3 * e
  terms a=0.5 b=-0.25
output g in [0.1, 2] adaptive rate -e * x
  terms c=1
output h in [-1, 1]
  terms N=-1 P=1
output k in [-20, 20] = f / g
if x is N then f is a, g is c, h is N
if x is Z then f is b, g is c
if x is P then f is a, h is P
if not x is P then h is N weight 0.5
if x is P then g is c
"""


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_several_adaptive_outputs_move_each_by_its_own_rate(backend):
    kernel = compile_system(loads(SEVERAL), backend)
    state, f, g = kernel.start(), np.array([0.5, -0.25, 0.5]), np.ones(3)
    assert state.tolist() == [*f, *g]
    for x, e in np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)):
        own = np.clip(x, -1, 1)
        w = np.array([max(0.0, -own), 1 - abs(own), max(0.0, own)])
        xi = w / w.sum()
        other = np.array([w[0], w[2], 0.5 * (1 - w[2])])
        expected = (f @ xi, g @ xi, other @ [-1, 1, -1] / other.sum(), (f @ xi) / (g @ xi))
        np.testing.assert_allclose(kernel(x, e, state), expected, rtol=1e-12, atol=1e-14)
        rates = np.zeros(6)
        kernel.jit_rates(x, e, state, rates)
        state = np.clip(state + 0.05 * rates, [-2] * 3 + [0.1] * 3, 2)
        f, g = np.clip(f + 0.15 * e * xi, -2, 2), np.clip(g - 0.05 * e * x * xi, 0.1, 2)
        np.testing.assert_allclose(state, [*f, *g], rtol=1e-12, atol=1e-14)
