"""Verdicts on guarantees: what is proved, what is refuted by a point, and what is honestly left open."""

import math
import re
import time

import pytest

from fuzzyctl import Proved, Refuted, Undecided, compile, load, loads, prove
from fuzzyctl.analysis import holes
from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.claims import claim_of
from fuzzyctl.analysis.coverage import diagnostics, uncovered
from fuzzyctl.analysis.extremes import extents
from fuzzyctl.analysis.prove import Prover
from fuzzyctl.analysis.witnesses import Judge

LINE = """
system line
and product
defuzzifier center_average
param c = 1
input e in [-1, 1]
  terms N Z P
input de in [-2, 2]
  terms N Z P
output u in [-1, 1]
  terms NB=-1 NS=-0.5 ZO=0 PS=0.5 PB=1
table u = e x de
     N  Z  P
 N | NB NS ZO
 Z | NS ZO PS
 P | ZO PS PB
"""
CURVED = (
    re.sub(
        r"(input \w+ in \[-(\d), \d\])\n  terms N Z P",
        r"\1\n  N = gaussian(-\2, 0.4 * \2)\n  Z = gaussian(0, 0.4 * \2)\n  P = gaussian(\2, 0.4 * \2)",
        LINE,
    )
    .replace("0.4 * 1", "0.4")
    .replace("0.4 * 2", "0.8")
)
MAMDANI = (
    LINE.replace("and product", "and min")
    .replace("center_average", "centroid")
    .replace("terms NB=-1 NS=-0.5 ZO=0 PS=0.5 PB=1", "terms NB NS ZO PS PB")
)
SAMPLED = MAMDANI.replace("centroid", "centroid(resolution=50)")
WEIGHTED = LINE + "if e is P then u is PB weight 0.5\n"


def verdicts(text, *claims, timeout=10.0):
    return prove(loads(text + "".join(f"require {c}\n" for c in claims)), timeout=timeout)


def words(text, *claims, timeout=10.0):
    return [type(v).__name__ for v in verdicts(text, *claims, timeout=timeout)]


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

    @pytest.mark.parametrize("claim", ["y - y <= 1", "y(-x) == -y within 1e290", "y + log(x - 2) >= 0"])
    def test_what_has_no_value_there_is_not_broken(self, claim):
        text = POWER.replace("min(5, max(-3, x ^ -1))", "1 / x").replace("[0, 1]", "[-1, 1]", 1).replace("K M", "K K")
        judge = Judge(loads(f"{text}require {claim}\n"))
        stated = claim_of(judge.system, judge.system.guarantees[0])
        assert judge.broken(stated.truth, stated.region, [-0.0]) is None

    def test_refutes_a_slope(self):
        text = POWER.replace("output y", "input t in [0, 1]\n  terms A B\noutput y").replace("B\n | K M", "B\n | K K")
        text = text.replace("x ^ -1", "3 * (t - 0.5) * x ^ -1")
        (verdict,) = verdicts(text, "increasing(y, t)")
        assert math.copysign(1.0, verdict.witness.point["x"]) < 0.0


def test_the_fixtures_are_what_they_are_called():
    assert CURVED.count("gaussian") == 6
    assert Prover(loads(LINE)).surface is not None
    assert all(Prover(loads(t)).surface is None for t in (CURVED, MAMDANI, SAMPLED))
    assert not Prover(loads(WEIGHTED)).surface.is_unity[0]


@pytest.mark.parametrize(
    "text", [LINE, CURVED, MAMDANI, SAMPLED, WEIGHTED], ids=["line", "curved", "min", "sampled", "weighted"]
)
class TestAnySystem:
    def test_true_claims_are_proved(self, text):
        claims = [
            "bounded(u, -1, 1)",
            "u <= 1.01 and not u < -1.01",
            "u >= -0.6 when e >= 0 and de >= -1",
            "u > -0.01 when e >= 0.2 and de > 0",
            "abs(u) <= 1",
            "total(u)",
            "u * u <= 1.1",
            "u <= 2 + e",
            "u != 1.5",
            "u(-e, de) <= 1 or e < 0",
        ]
        assert words(text, *claims) == ["Proved"] * len(claims)

    def test_false_claims_are_refuted_by_points_that_break_them(self, text):
        system = loads(text)
        high, low, flat, mirrored, exact = verdicts(
            text, "u <= 0.5", "u >= 0 when de >= 0.5", "u == 0", "u(-e, de) == u within 0.1", "u <= c - 0.7 or u < 0"
        )
        assert all(isinstance(v, Refuted) for v in (high, low, flat, mirrored, exact))
        assert system(**high.witness.point) > 0.5
        assert low.witness.point["de"] >= 0.5
        assert system(**low.witness.point) < 0
        assert system(**flat.witness.point) != 0
        point = mirrored.witness.point
        assert abs(system(e=-point["e"], de=point["de"]) - system(**point)) > 0.1
        assert system(**exact.witness.point) > 0.3

    def test_the_witness_says_what_both_sides_are(self, text):
        (verdict,) = verdicts(text, "2 * u <= c / 2")
        names = dict(verdict.witness.sides)
        assert names["c / 2"] == 0.5
        assert names["2 * u"] == 2 * loads(text)(**verdict.witness.point)

    def test_a_slope_that_is_too_steep_is_refuted_by_two_points(self, text):
        system = loads(text)
        falling, steep = verdicts(text, "decreasing(u, de)", "lipschitz(u, e) <= 0.2")
        for verdict in (falling, steep):
            assert isinstance(verdict, Refuted)
        a, b = falling.witness.point, falling.witness.other
        assert a["de"] < b["de"]
        assert system(**a) < system(**b)
        a, b = steep.witness.point, steep.witness.other
        assert abs(system(**a) - system(**b)) > 0.2 * abs(a["e"] - b["e"])
        assert a["de"] == b["de"]


class TestSlopes:
    @pytest.mark.parametrize("text", [LINE, CURVED], ids=["line", "curved"])
    def test_true_ones_are_proved_in_exact_arithmetic(self, text):
        found = verdicts(
            text, "increasing(u, e)", "increasing(u, de)", "lipschitz(u, e) <= 1.5", "lipschitz(u, de) <= 1"
        )
        assert [type(v) for v in found] == [Proved] * 4
        assert all("exact arithmetic" in v.note for v in found)

    def test_the_slope_of_a_line_is_known_exactly(self):
        assert words(LINE, "lipschitz(u, de) <= 0.25", "lipschitz(u, de) <= 0.2499") == ["Proved", "Refuted"]

    def test_a_tolerance_covers_rounding_and_small_falls(self):
        text = (
            LINE.replace("ZO PS PB", "ZO PS PS").replace("PS=0.5", "PS=0.5001").replace("Z | NS ZO PS", "Z | NS PS ZO")
        )
        falls = verdicts(text, "increasing(u, de)", "increasing(u, de) within 0.4", "increasing(u, de) within 0.51")
        assert [type(v) for v in falls] == [Refuted, Refuted, Proved]
        assert falls[2].note == ""

    def test_a_slope_summed_over_several_cells_needs_their_whole_excess_as_tolerance(self):
        # Between -1 and 1 u rises by 2, which is 1 more than the bound allows.
        assert words(
            LINE.replace("N  Z  P\n N | NB NS ZO", "N  Z  P\n N | NB ZO PB"), "lipschitz(u, de) <= 0.25 within 0.9"
        ) == ["Refuted"]

    def test_a_jump_has_no_slope(self):
        text = LINE.replace(
            "input e in [-1, 1]\n  terms N Z P",
            "input e in [-1, 1]\n  N = rectangle(-1, 0)\n  Z = rectangle(0, 0.5)\n  P = rectangle(0.5, 1)",
        )
        (verdict,) = verdicts(text, "lipschitz(u, e) <= 1e9")
        assert not isinstance(verdict, Proved)

    def test_an_input_that_no_rule_reads_changes_nothing(self):
        text = LINE.replace("output u", "input t in [0, 1]\n  terms A B\noutput u")
        assert words(text, "increasing(u, t) and decreasing(u, t) and lipschitz(u, t) <= 0") == ["Proved"]

    def test_a_witness_stands_at_ends_that_can_be_read(self):
        (verdict,) = verdicts(MAMDANI, "decreasing(u, e)")
        assert (verdict.witness.point["e"], verdict.witness.other["e"]) == (-1.0, 0.0)


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


class TestRegions:
    def test_strict_and_open_conditions_are_told_from_closed_ones(self):
        assert words(LINE, "u > 0 when e > 0 and de >= 0", "u > 0 when e >= 0 and de >= 0") == ["Undecided", "Refuted"]
        assert words(LINE, "u < 1 when e < 1", "u < 1 when e <= 1") != ["Proved", "Proved"]

    def test_a_region_that_is_empty_proves_everything(self):
        assert words(LINE, "u >= 5 when e > 1") == ["Proved"]

    def test_shifted_arguments_are_clamped_like_inputs(self):
        assert words(LINE, "u(e + 5, de + 9) == 1 within 1e-12", "u(e + 1, 0) >= 0 within 1e-12") == ["Proved"] * 2
        assert words(LINE, "u(e + 1, 0) >= 0.01") == ["Refuted"]

    def test_inputs_without_a_range_are_taken_whole(self):
        text = LINE.replace("e in [-1, 1]", "e in [-1, 1] extrapolate", 1)
        assert words(text, "bounded(u, -1, 1)", "u >= e", timeout=2) == ["Proved", "Refuted"]
        assert words(CURVED.replace("e in [-1, 1]", "e in [-1, 1] extrapolate", 1), "u <= 1", timeout=2) == ["Proved"]

    def test_what_is_broken_far_out_is_found(self):
        text = CURVED.replace("e in [-1, 1]", "e in [-1, 1] extrapolate").replace(
            "[-1, 1]\n  terms", "[-1, 1] else 0\n  terms"
        )
        (verdict,) = verdicts(text, "u <= e + 1e9")
        assert verdict.witness.point["e"] < -0.9e9
        assert words(text, "u > -0.5 when e >= 40") == ["Proved"]


ADAPTIVE = """
system a
and product
defuzzifier weighted_average
input e in [-1, 1]
  terms N P
output u in [-2, 2] adaptive rate e
  terms N=0 P=0
table u = e
     N  P
  |  N  P
"""


class TestUndecided:
    @pytest.mark.parametrize("claim", ["u <= 1.9", "u(-e) == -u within 0.1"])
    def test_what_adapts_is_named(self, claim):
        (verdict,) = verdicts(ADAPTIVE, claim, timeout=1)
        assert verdict.reason.startswith("'u' is adaptive: its consequents may become anything from -2 to 2; no point")
        assert verdicts(ADAPTIVE, "u >= 0.5")[0].witness.sides == (("u", 0.0),)

    @pytest.mark.parametrize(("claim", "is_said"), [("u != 0.5", False), ("not u == 0.5", False), ("u < 1 - e", True)])
    def test_a_tolerance_is_advised_where_it_helps(self, claim, is_said):
        (verdict,) = verdicts(CURVED, f"{claim} when e <= -0.001 or e >= 0.0131", timeout=1e-9)
        assert ("tolerance" in verdict.reason) == is_said

    def test_values_that_are_not_known_are_told_from_values_at_their_bound(self):
        text = CURVED.replace("output u in [-1, 1]", "output u in [-1, 1] else 0").replace("[-1, 1]", "[-60, 60]", 1)
        (far,) = verdicts(text, "u >= -0.5 when e >= 12")
        assert far.reason.startswith("too little is known of values there")

    def test_what_is_held_is_named(self):
        text = CHAIN.replace("else 0", "else hold(1)")
        (verdict,) = verdicts(text, "u <= 1.9 when e >= -0.629 and e <= -0.628", timeout=1)
        assert verdict.reason.startswith("'u' holds what it was before where no rule fires")

    def test_without_time_it_says_that_none_is_given(self):
        (verdict,) = verdicts(CURVED, "u(-e, -de) == -u within 1e-12", timeout=0)
        assert verdict.reason == "it takes subdivision, for which no time is given"

    def test_slopes_at_kinks_are_told_from_slopes_at_their_bound(self):
        text = (
            "system kink\nand min\nor max\ndefuzzifier weighted_average\ninput e in [-1, 1]\n"
            "  A = gaussian(-0.5, 0.6)\n  B = gaussian(0.6, 0.6)\noutput u in [0, 1]\n  terms a=0 b=1\n"
            "if e is A or e is B then u is a\nif e is A and e is B then u is b\n"
        )
        kinks, proved = verdicts(text, "lipschitz(u, e) <= 1", "lipschitz(u, e) <= 2")
        assert isinstance(proved, Proved)
        assert kinks.reason.startswith("there one formula takes over from another")

    def test_comparisons_of_many_alternatives_take_no_longer_than_others(self):
        many = f"max({', '.join(['u'] * 400)}) <= min({', '.join(['2'] * 400)})"
        begun = time.process_time()
        assert words(LINE, many) == ["Proved"]
        assert time.process_time() - begun < 3

    def test_time_is_kept_and_open_boxes_are_shown(self):
        (verdict,) = verdicts(CURVED, "u(-e, -de) == -u within 1e-13", timeout=0.2)
        assert isinstance(verdict, Undecided)
        assert verdict.remaining >= len(verdict.boxes) > 0
        assert set(verdict.boxes[0]) == {"e", "de"}

    def test_a_quotient_that_may_be_infinite_is_not_proved(self):
        assert words(LINE, "1 / e <= 1e300", timeout=0.5) != ["Proved"]

    def test_progress_is_told(self):
        told = []
        system = loads(CURVED + "require u(-e, -de) == -u within 1e-13\n")
        prove(system, timeout=0.2, progress=lambda *state: told.append(state))
        assert told[-1][0] == "u(-e, -de) == -u within 1e-13"
        assert told[-1][1] + told[-1][2] > 0


class TestWordsInLogic:
    def test_parts_that_speak_of_all_points_are_joined(self):
        claims = ["increasing(u, e) and u <= 1", "decreasing(u, e) or total(u)", "not decreasing(u, e)"]
        assert words(LINE, *claims) == ["Proved"] * 3
        assert words(LINE, "increasing(u, e) and u <= 0", "decreasing(u, e) or decreasing(u, de)") == ["Refuted"] * 2
        assert words(LINE, "not increasing(u, e)") == ["Undecided"]

    def test_a_hole_refutes_total(self):
        text = LINE.replace("output u in [-1, 1]", "output u in [-1, 1] else 0").replace(
            "e in [-1, 1]\n  terms N Z P",
            "e in [-1, 1]\n  N = triangle(-2, -1, -0.5)\n  Z = triangle(-0.2, 0, 0.2)\n  P = triangle(0, 1, 2)",
        )
        (verdict,) = verdicts(text, "total(u)")
        assert isinstance(verdict, Refuted)
        assert -0.5 <= verdict.witness.point["e"] <= -0.2


def test_points_are_tried_only_while_there_is_time(monkeypatch):
    def never(*_):
        raise AssertionError

    prover = Prover(loads(CURVED + "require u(-e, -de) == -u within 1e-12\n"), timeout=1e-9)
    monkeypatch.setattr(prover.judge, "broken", never)
    assert isinstance(prover.verdict(prover.system.guarantees[0]), Undecided)


class TestVoidRegions:
    """A claim about no point at all is true, which nobody meant."""

    @pytest.mark.parametrize(
        "claim",
        [
            "u <= -3 when e > 3",
            "total(u) when e > 3",
            "increasing(u, e) when e > 3",
            "u <= -3 when e > 0.5 and e + de < -2",
            "u <= -3 when u > 1.5",
            "u <= -3 when e * e > 1.5 and abs(de) <= 1",
        ],
    )
    def test_are_told(self, claim):
        (verdict,) = verdicts(LINE, claim)
        assert verdict.note == "nothing is claimed: no point of the ranges is in the region"

    @pytest.mark.parametrize("claim", ["u >= 0 when e >= 1 and de >= 0", "total(u) when e > 0.9", "u <= 1"])
    def test_others_are_not(self, claim):
        (verdict,) = verdicts(LINE, claim)
        assert isinstance(verdict, Proved)
        assert "nothing" not in verdict.note

    def test_of_an_input_that_extrapolates_are_none(self):
        text = LINE.replace("input e in [-1, 1]", "input e in [-1, 1] extrapolate")
        (verdict,) = verdicts(text, "u <= 1 when e > 3")
        assert verdict.note == ""


DIFFERENCE = """
system difference
implication bounded_difference
aggregation max
defuzzifier centroid
input x in [0, 1]
  terms A B
output y in [0, 1] {otherwise}
  P = triangle(0, 0.2, 0.4, height=0.5)
if x is A then y is P
if x is B then y is P
"""


CHAIN = """
system chain
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
output m in [0, 1]
  lo = triangle(-inf, 0, 0.371)
  hi = triangle(0.3723, 1, inf)
output u in [-5, 5] else 0
  a = constant(1)
  b = constant(2)
table m = e
     N   Z   P
  |  lo  hi  hi
if m is lo then u is a
if m is hi then u is b
"""


def test_total_is_refuted_between_corners_too():
    whole, part, other = verdicts(CHAIN, "total(u)", "total(u) when e > -0.64 and e < -0.6", "total(u) when e > -0.6")
    assert loads(CHAIN)(**whole.witness.point)["u"] == 0
    assert loads(CHAIN)(**part.witness.point)["u"] == 0
    assert isinstance(other, Undecided)


class TestSilence:
    """Where no rule moves an output is shown by evaluating it there."""

    @pytest.fixture(params=[True, False], ids=["tops enclosed", "tops at nodes"])
    def system(self, request, monkeypatch):
        if not request.param:
            # What the first nodes see is below the height of the set: what is then taken for a hole is none.
            enclosed = holes._top
            monkeypatch.setattr(holes, "_top", lambda *given: (enclosed(*given)[0],) * 2)
        return loads(DIFFERENCE.format(otherwise="else 0.9"))

    def test_total_is_refuted_where_the_output_is_silent(self, system):
        kernel = compile(system, "python")
        assert kernel(0.5) == 0.9
        assert kernel(0.5021) != 0.9
        (verdict,) = prove(with_claims(system, "total(y)"))
        assert verdict.witness.point == {"x": 0.5}
        assert verdict.witness.sides == (("largest activation, which does not move y", 0.5),)

    def test_total_in_a_region_where_some_rule_moves_it_is_not_refuted(self, system):
        (verdict,) = prove(with_claims(system, "total(y) when x >= 0.501"))
        assert isinstance(verdict, Undecided)

    def test_total_in_a_region_where_it_is_silent_is_refuted(self, system):
        (verdict,) = prove(with_claims(system, "total(y) when x >= 0.3 and x <= 0.6"))
        assert isinstance(verdict, Refuted)

    def test_where_an_end_is_attained_it_is(self, system):
        (extent,) = extents(system, timeout=0.1)
        assert extent.hi == 0.9
        assert extent.hi_at is not None
        assert compile(system, "python")(*extent.hi_at.values()) == extent.hi_found
        bound = output_bounds(system)["y"]
        assert bound.hi_at is None or compile(system, "python")(*bound.hi_at.values()) == bound.hi

    def test_an_integral_sees_a_set_up_to_its_height(self):
        assert isinstance(uncovered(loads(DIFFERENCE.format(otherwise="")))["y"], holes.Undecided)

    def test_no_place_is_named_where_some_rule_moves_it(self, system):
        (found,) = diagnostics(loads(DIFFERENCE.format(otherwise="")))
        assert found.message == "no rule moves output 'y' at x = 0.5"
        assert found.facts[0] == "rules fire there, but 'implication bounded_difference' leaves nothing of them"


def with_claims(system, *claims):
    text = DIFFERENCE.format(otherwise="else 0.9")
    return system.model_copy(update={"guarantees": loads(text + "".join(f"require {c}\n" for c in claims)).guarantees})


CHANGES = [
    ("ais_reaction", "triangle(0.09, 0.18, inf)", "triangle(0.09, 0.19, inf)"),
    ("ais_reaction", "triangle(0.09, 0.18, inf)", "triangle(0.09, 0.1800001, inf)"),
    ("ais_reaction", "PS = triangle(0, 0.09, 0.18)", "PS = triangle(0, 0.2, 0.3)"),
    ("ais_reaction", "param k_s     = 0.55", "param k_s     = 0.56"),
    ("ais_reaction", "param k_h_min = 0.1 ", "param k_h_min = 0.09 "),
    ("ais_reaction", "param G_min   = 0.001", "param G_min   = 0.002"),
    ("ais_reaction", "NB |  NB  NM  NM  NS  NS", "NB |  NM  NB  NM  NS  NS"),
    ("ais_reaction", "NB |  NB  NM  NM  NS  NS", "NB |  NB  NM  NM  NS  PS"),
    ("ais_reaction", "NS |  NM  NS  ZO  PS  ZO", "NS |  NM  NS  PS  ZO  ZO"),
    ("ais_reaction", "NS |  NM  NS  ZO  PS  ZO", "NS |  NM  ZO  ZO  PS  ZO"),
    ("ais_reaction", "PB |  NS  NS  NM  NM  NB", "PB |  NS  NS  NM  NM  NM"),
    ("ais_reaction", "PB |  NS  NS  NM  NM  NB", "PB |  PS  NS  NM  NM  NB"),
    ("ais_reaction", "ZO = triangle(-0.015, 0, 0.015)", "ZO = triangle(-0.014, 0, 0.015)"),
    ("ais_reaction", "NS = triangle(-0.50, -0.25, 0)", "NS = triangle(-0.50, -0.24, 0)"),
    ("boundary_layer", "VS = triangle(1e-6, 0.0050, 0.0162)", "VS = triangle(1e-6, 0.0049, 0.0162)"),
    ("boundary_layer", "0.0500, inf)\n\ntable", "0.0501, inf)\n\ntable"),
    ("boundary_layer", "|  VB  B  M  S  VS", "|  VB  M  B  S  VS"),
    ("boundary_layer", "|  VB  B  M  S  VS", "|  VS  S  M  B  VB"),
    ("fcafsmc", "PB=0", "PB=2.4"),
    ("tipper", "generous = triangle(20, 25, 30)", "generous = triangle(38, 39, 40)"),
]  # fmt: skip

#: Claims evaluated at a witness without the machinery of proofs: whether they are broken there.
BROKEN = {
    "k_h_min - k_s * f >= G_min within 1e-12": lambda s, w: (
        s.values["k_h_min"] - s.values["k_s"] * s(**w.point) < s.values["G_min"] - 1e-12
    ),
    "f(-sigma, -dsigma) == f within 1e-12": lambda s, w: (
        abs(s(**{n: -v for n, v in w.point.items()}) - s(**w.point)) > 1e-12
    ),
    "f <= 0 within 1e-12 when abs(sigma) >= 0.03": lambda s, w: abs(w.point["sigma"]) >= 0.03 and s(**w.point) > 0,
    "beta >= 0.005 within 1e-12": lambda s, w: s(**w.point) < 0.005 - 1e-12,
    "beta <= 0.05 within 1e-12": lambda s, w: s(**w.point) > 0.05 + 1e-12,
    "decreasing(beta, abs_sigma)": lambda s, w: (
        w.point["abs_sigma"] < w.other["abs_sigma"] and s(**w.point) < s(**w.other)
    ),
    "F <= 2": lambda s, w: s(**w.point) > 2,
    "bounded(tip, 0, 30)": lambda s, w: not 0 <= s(**w.point) <= 30,
}


class TestSeededFaults:
    """Twenty changes of the shipped files, each of which breaks a guarantee."""

    @pytest.mark.parametrize(("name", "old", "new"), CHANGES)
    def test_a_fault_is_refuted_by_a_valid_witness(self, rules, name, old, new):
        text = (rules / f"{name}.fz").read_text(encoding="utf-8")
        assert text.count(old) == 1
        # Wider ranges let the consequent leave the bound that the guarantee keeps.
        text = (
            text.replace(old, new)
            .replace("F in [-2, 2]", "F in [-2, 2.5]")
            .replace("in [0, 30] unit", "in [0, 40] unit")
        )
        system = loads(text)
        refuted = [v for v in prove(system) if isinstance(v, Refuted)]
        assert refuted
        for verdict in refuted:
            assert BROKEN[verdict.claim](system, verdict.witness), verdict

    def test_the_shipped_files_are_proved(self, shipped):
        for system in shipped.values():
            assert [type(v) for v in prove(system)] == [Proved] * len(system.guarantees)


def test_a_path_is_read(rules):
    assert [v.claim for v in prove(rules / "tipper.fz")] == ["bounded(tip, 0, 30)"]
    assert prove(load(rules / "tipper.fz"))[0].span.line == 33


class TestStrengths:
    """`total(u) >= STRENGTH`: the largest activation is nowhere below."""

    def test_the_weakest_place_of_a_partition_decides(self):
        # With products of two halves four rules fire with 1/4 each.
        assert words(LINE, "total(u) >= 0.24", "total(u) >= 0.26") == ["Proved", "Refuted"]
        assert words(MAMDANI, "total(u) >= 0.49", "total(u) >= 0.51") == ["Proved", "Refuted"]

    def test_a_touch_needs_a_tolerance(self):
        assert words(LINE, "total(u) >= 0.25 within 1e-9") == ["Proved"]
        assert words(LINE, "total(u) >= 0.25") == ["Undecided"]

    def test_curved_terms_are_bounded_too(self):
        assert words(CURVED, "total(u) >= 0.2", "total(u) >= 0.3") == ["Proved", "Refuted"]

    def test_weights_count(self):
        text = LINE.replace("P | ZO PS PB", "P | ZO PS*0.5 PB")
        (verdict,) = verdicts(text, "total(u) >= 0.6 when e >= 0.999 and abs(de) <= 0.001")
        assert isinstance(verdict, Refuted)
        assert dict(verdict.witness.sides)["total(u)"] == pytest.approx(0.5, abs=0.01)
        assert words(text, "total(u) >= 0.49 when e >= 0.999 and abs(de) <= 0.001") == ["Proved"]

    def test_where_no_rule_fires_it_is_0(self):
        gap = "system s\ndefuzzifier weighted_average\ninput x in [0, 3]\n  A = triangle(-inf, 0, 1)\n" + (
            "  B = triangle(2, 3, inf)\noutput y in [0, 1] else error\n  terms l=0 h=1\ntable y = x\n A B\n| l h\n"
        )
        (verdict,) = verdicts(gap, "total(y) >= 0.001")
        assert isinstance(verdict, Refuted)
        assert 1 <= verdict.witness.point["x"] <= 2
        assert words(gap, "total(y) >= 0.001 when x <= 0.99") == ["Proved"]


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


class TestSlopesOfQuotients:
    """Where activations do not sum to 1 the output is a quotient of two sums."""

    TWO = WEIGHTED.replace("if e is P then u is PB weight 0.5", "if e is P and de is P then u is PB weight 0.5")

    def test_they_are_proved_at_corners(self):
        for text in (WEIGHTED, self.TWO):
            found = verdicts(text, "increasing(u, e)", "increasing(u, de)", timeout=1e-9)
            assert [type(v).__name__ for v in found] == ["Proved", "Proved"]
            assert words(text, "decreasing(u, de)") == ["Refuted"]
            assert "exact arithmetic" in found[0].note

    def test_a_tolerance_covers_rounding(self):
        (verdict,) = verdicts(WEIGHTED, "increasing(u, e) within 1e-9")
        assert (type(verdict).__name__, verdict.note) == ("Proved", "")

    def test_a_stretch_where_nothing_changes_is_no_slope(self):
        flat = LINE.replace(
            "terms N Z P\ninput de",
            "N = triangle(-inf, -1, -0.5)\n  Z = triangle(-0.9, 0, 0.9)\n  P = triangle(0.5, 1, inf)\ninput de",
        )
        assert not Prover(loads(flat)).surface.is_unity[0]
        assert words(flat, "increasing(u, e)", "increasing(u, de)", timeout=0.001) == ["Proved"] * 2

    def test_what_falls_somewhere_is_not_proved(self):
        text = WEIGHTED.replace("Z | NS ZO PS", "Z | NS PS ZO")
        assert words(text, "increasing(u, de)", "increasing(u, e)")[0] == "Refuted"


class TestSeveralOutputs:
    """What one output does where another has no value counts."""

    HALF = """
system s
defuzzifier weighted_average
input x in [0, 4]
  L = gaussian(0, 1)
  H = gaussian(4, 1)
  Q = triangle(0, 1, 2)
output u in [0, 1]
  terms low=0 high=1
output v in [0, 1] else nan
  terms one=1
if x is L then u is low
if x is H then u is high
if x is Q then v is one
"""

    def test_claims_about_the_one_hold_where_the_other_is_none(self):
        found = verdicts(self.HALF, "u <= 0.9", "u <= 1", "v >= 1", "u <= 0.6 or v >= 1")
        assert [type(v).__name__ for v in found] == ["Refuted", "Proved", "Proved", "Proved"]
        assert found[0].witness.point["x"] > 2

    def test_so_do_bounds(self):
        u, v = extents(loads(self.HALF))
        assert u.hi >= 0.999
        assert (v.lo, v.hi) == (1.0, 1.0)
