"""Verdicts near the last digits: what rounding leaves open, what it does not refute, and what -0.0 makes infinite."""

import math

import pytest

from fuzzyctl import Proved, Refuted, Undecided, compile, loads
from fuzzyctl.analysis.extremes import extents
from tests.fuzzyctl.analysis.proving import LINE, verdicts, words

POWER = """
system power
defuzzifier weighted_average
input x in [0, 1]
  terms A B
output y in [0, 10]
  K = function(min(5, max(-3, x ^ -1)))
  M = constant(3)
table y = x
   A B
 | K M
"""


def test_what_minus_zero_makes_infinite_is_not_proved():
    (verdict,) = verdicts(POWER.replace("min(5, max(-3, x ^ -1))", "x ^ -1"), "y * x >= -5")
    assert "infinite" in verdict.reason  # where no tolerance helps


class TestMinusZero:
    """As floats compare, 0.0 and -0.0 are one; some functions tell them apart."""

    @pytest.mark.parametrize(
        ("function", "lower", "least"),
        [
            ("min(5, max(-3, x ^ -1))", "0", -3.0),
            ("min(5, max(-3, 1 / x))", "0", -3.0),
            ("min(5, max(-3, 1 / x))", "-1", -3.0),  # no term begins or ends at 0
            ("atan2(x, -1)", "0", -math.pi),
        ],
    )
    def test_breaks_a_claim_about_outputs(self, function, lower, least):
        text = POWER.replace("min(5, max(-3, x ^ -1))", function).replace("[0, 1]", f"[{lower}, 3]", 1)
        text = text.replace("M = constant(3)", f"M = function({function})")
        assert compile(loads(text), "python")(-0.0) == least
        (verdict,) = verdicts(text, "y >= 0 when x >= 0")
        assert math.copysign(1.0, verdict.witness.point["x"]) < 0.0
        assert dict(verdict.witness.sides)["y"] == least
        assert str(verdict.witness).startswith("at x = -0: y = -3")

    def test_is_found_by_quick_methods_too(self):
        assert words(POWER, "y >= 0", timeout=0.0) == ["Refuted"]

    @pytest.mark.parametrize("claim", ["atan2(x, -1) >= 0 * y", "y(-x) >= 0"])
    def test_breaks_a_claim_in_which_its_sign_counts(self, claim):
        (verdict,) = verdicts(POWER.replace("[0, 1]", "[0, 4]", 1), claim)
        assert isinstance(verdict, Refuted)

    def test_is_a_point_where_a_bound_is_attained(self):
        text = POWER.replace("min(5, max(-3, x ^ -1))", "min(max(x ^ -1, -3), 5)")
        (extent,) = extents(loads(text), timeout=0.5)
        assert (extent.lo, extent.lo_found) == (-3.0, -3.0)
        assert math.copysign(1.0, extent.lo_at["x"]) < 0.0

    @pytest.mark.parametrize(
        ("claim", "x", "side"),
        [
            ("y <= 1e300", 0.0, ("y", math.inf)),
            ("y >= -1e300 when x >= 0", -0.0, ("y", -math.inf)),
            ("-y(-x) <= 1e300 when x >= 0", 0.0, ("-y(-x)", math.inf)),
            ("abs(y - x) <= 1e300", 0.0, ("abs(y - x)", math.inf)),
        ],
    )
    def test_and_0_break_claims_where_outputs_are_infinite(self, claim, x, side):
        text = POWER.replace("min(5, max(-3, x ^ -1))", "1 / x").replace("[0, 1]", "[-1, 1]", 1).replace("K M", "K K")
        (verdict,) = verdicts(text, claim)
        assert math.copysign(1.0, verdict.witness.point["x"]) == math.copysign(1.0, x)
        assert verdict.witness.point["x"] == 0.0
        assert verdict.witness.sides == (side,)

    def test_refutes_a_slope(self):
        text = POWER.replace("output y", "input t in [0, 1]\n  terms A B\noutput y").replace("B\n | K M", "B\n | K K")
        text = text.replace("x ^ -1", "3 * (t - 0.5) * x ^ -1")
        (verdict,) = verdicts(text, "increasing(y, t)")
        assert math.copysign(1.0, verdict.witness.point["x"]) < 0.0


class TestRounding:
    def test_a_bound_that_is_touched_needs_a_tolerance(self):
        bare, loose = verdicts(LINE, "u <= 0.5 when e <= 0", "u <= 0.5 within 1e-12 when e <= 0")
        assert isinstance(bare, Undecided)
        assert "within" in bare.reason
        assert loose == Proved(loose.claim)

    def test_an_equality_without_tolerance_is_about_exact_arithmetic(self):
        bare, loose = verdicts(LINE, "u(-e, -de) == -u", "u(-e, -de) == -u within 1e-12")
        assert isinstance(bare, Proved)
        assert "exact arithmetic" in bare.note
        assert loose == Proved(loose.claim)

    def test_what_a_kernel_is_held_within_needs_none(self):
        assert verdicts(LINE, "u <= 1")[0].note == ""

    def test_a_claim_broken_in_the_last_digit_is_not_proved(self):
        assert words(LINE, "u < 1", "u <= 1 - 1e-16 within 1e-17") == ["Refuted"] * 2


class TestRoundingRefutesNothing:
    """Claims about exact arithmetic are not refuted by the last digits of what a kernel returns."""

    CURVE = """
system s
and product
defuzzifier weighted_average
input e in [-1, 1]
  N = gaussian(-1, 0.37)
  Z = gaussian(0, 0.41)
  P = gaussian(1, 0.37)
output u in [-1, 1]
  terms n=-1 z=0 p=1
table u = e
 N Z P
| n z p
"""

    def test_of_two_expressions(self):
        kernel = loads(self.CURVE)
        assert any(kernel(e=-e) != -kernel(e=e) for e in (k / 97 for k in range(97)))
        assert words(self.CURVE, "u(-e) == -u", "u(-e) >= -u", timeout=0.3) == ["Undecided"] * 2
        assert words(self.CURVE, "u(-e) == -u within 1e-4") == ["Proved"]
        # Where one side is a number, it is about what kernels return.
        assert words(self.CURVE, "u + u(-e) == 0", timeout=0.3) == ["Refuted"]

    def test_of_slopes(self):
        flat = self.CURVE.replace("terms n=-1 z=0 p=1", "terms n=0.1 z=0.1 p=0.1")
        values = [loads(flat)(e=k / 97) for k in range(97)]
        assert max(values) - min(values) < 1e-15
        assert words(flat, "decreasing(u, e)", "increasing(u, e)", timeout=0.3).count("Refuted") == 0

    def test_a_true_break_is_still_shown(self):
        tilted = self.CURVE.replace("p=1", "p=1.0001").replace("[-1, 1]\n  terms", "[-2, 2]\n  terms")
        assert words(tilted, "u(-e) == -u", timeout=0.3) == ["Refuted"]
        bumpy = self.CURVE.replace("0.37", "0.1").replace("0.41", "0.1").replace("z=0 p=1", "z=1 p=0.9")
        assert words(bumpy, "increasing(u, e)", timeout=1) == ["Refuted"]
