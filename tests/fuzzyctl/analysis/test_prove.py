"""Verdicts on guarantees: what is proved, what is refuted by a point, and what is honestly left open."""

import re

import pytest

from fuzzyctl import Proved, Refuted, Undecided, load, loads, prove
from fuzzyctl.analysis.extremes import extents
from fuzzyctl.testing import check_text
from tests.fuzzyctl.analysis.proving import CHAIN, CURVED, LINE, MAMDANI, SAMPLED, WEIGHTED, verdicts, words


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


class TestRegions:
    def test_strict_and_open_conditions_are_progress_from_closed_ones(self):
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

    def test_values_that_are_not_known_are_progress_from_values_at_their_bound(self):
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

    def test_slopes_at_kinks_are_progress_from_slopes_at_their_bound(self):
        text = (
            "system kink\nand min\nor max\ndefuzzifier weighted_average\ninput e in [-1, 1]\n"
            "  A = gaussian(-0.5, 0.6)\n  B = gaussian(0.6, 0.6)\noutput u in [0, 1]\n  terms a=0 b=1\n"
            "if e is A or e is B then u is a\nif e is A and e is B then u is b\n"
        )
        kinks, proved = verdicts(text, "lipschitz(u, e) <= 1", "lipschitz(u, e) <= 2")
        assert isinstance(proved, Proved)
        assert kinks.reason.startswith("there one formula takes over from another")

    def test_time_is_kept_and_open_boxes_are_shown(self):
        (verdict,) = verdicts(CURVED, "u(-e, -de) == -u within 1e-13", timeout=0.2)
        assert isinstance(verdict, Undecided)
        assert verdict.remaining >= len(verdict.boxes) > 0
        assert set(verdict.boxes[0]) == {"e", "de"}

    @pytest.mark.parametrize("claim", ["u(-e, -de) == -u within 1e-9", "abs(u + u(-e, -de)) <= 1e-9"])
    def test_where_time_ends_it_says_what_is_known_and_promises_nothing(self, claim):
        (verdict,) = verdicts(MAMDANI, claim, timeout=0.01)
        known = (
            r"(less than 1|\d+) % of the input space is settled in the time given, and no point is found that breaks it"
        )
        assert re.match(known, verdict.reason)
        exactly = "of a system that interpolates ('and product', 'center_average') it is decided exactly"
        assert verdict.reason.endswith(exactly)
        assert "would decide" not in verdict.reason
        assert words(LINE, claim) == ["Proved"]

    def test_a_quotient_that_may_be_infinite_is_not_proved(self):
        assert words(LINE, "1 / e <= 1e300", timeout=0.5) != ["Proved"]

    def test_progress_is_progress(self):
        progress = []
        system = loads(CURVED + "require u(-e, -de) == -u within 1e-13\n")
        prove(system, timeout=0.2, progress=lambda *state: progress.append(state))
        assert progress[-1][0] == "u(-e, -de) == -u within 1e-13"
        assert progress[-1][1] + progress[-1][2] > 0


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
    """Twenty changes of the shipped files; each breaks a guarantee."""

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


class TestLets:
    SLIDING = LINE.replace("output u", "let s = 2 * e + de\nlet w = s / 4\noutput u", 1)

    @pytest.mark.parametrize(
        ("named", "written"),
        [
            ("u >= -0.51 when s >= 0", "u >= -0.51 when 2 * e + de >= 0"),
            ("abs(u - w) <= 0.1", "abs(u - (2 * e + de) / 4) <= 0.1"),
            ("u <= w - 0.1", "u <= (2 * e + de) / 4 - 0.1"),
            ("u(-e, -de) == -w within 0.1", "u(-e, -de) == -((2 * e + de) / 4) within 0.1"),
            ("u > 0.6 when w > 0.75", "u > 0.6 when (2 * e + de) / 4 > 0.75"),
        ],
    )
    def test_a_claim_that_names_them_has_the_verdict_of_their_expressions(self, named, written):
        (found,) = verdicts(self.SLIDING, named)
        (expected,) = verdicts(LINE, written)
        assert type(found) is type(expected)
        assert not isinstance(found, Undecided)
        assert found.claim == named
        if isinstance(found, Refuted):
            assert found.witness.point == expected.witness.point

    def test_those_that_call_other_systems_may_be_named(self):
        text = (
            self.SLIDING.replace("let w = s / 4", "let w = inner.y(e)") + "require u <= w + 2.1\nrequire u <= w - 3\n"
        )
        inner = "\nsystem inner\ndefuzzifier center_average\ninput x in [-1, 1]\n  terms N P\n"
        inner += "output y in [-1, 1]\n  terms N P\ntable y = x\n   N P\n | N P\n"
        found = prove(loads(text + inner, block="line"))
        assert [type(v) for v in found] == [Proved, Refuted]

    def test_where_rules_read_one_the_reason_says_that_nothing_is_exact(self):
        text = LINE.replace("table u = e x de", "let q in [-1, 1] = e\n  terms N Z P\ntable u = q x de")
        claims = ("u == e / 2 + de / 4 within 1e-9", "increasing(u, e)")
        for found in verdicts(text, *claims, timeout=0.05):
            assert found.reason.endswith("; where rules read a let, here 'q', no claim is decided exactly")
        assert words(LINE, *claims) == ["Proved", "Proved"]

    def test_one_without_a_value_is_reported_where_it_stands(self):
        text = self.SLIDING.replace("let w = s / 4", "let w = 1 / e") + "require u <= w + 2\n"
        (d,) = [d for d in check_text(text, "s.fz")[1] if d.code == "FZ307"]
        assert d.message.startswith("the guarantee divides by 'e', which is 0 at e = 0")
