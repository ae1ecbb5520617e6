"""Verdicts on regions where no rule fires, where rules leave nothing, or where there is no point at all."""

import pytest

from fuzzyctl import Proved, Refuted, Undecided, check, compile, loads, output_bounds, prove
from fuzzyctl.analysis.coverage import box_search
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.analysis.extremes import extents
from tests.fuzzyctl.analysis.proving import CHAIN, CURVED, LINE, MAMDANI, verdicts, words


class TestVoidRegions:
    """A claim about no point at all is true, which was not meant."""

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
    def test_are_reported(self, claim):
        (verdict,) = verdicts(LINE, claim)
        assert verdict.note == "the claim is void: no point of the ranges is in the region"

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
            largest = box_search.largest_degree
            monkeypatch.setattr(box_search, "largest_degree", lambda *parts: (e := largest(*parts)) and (e[0], e[0]))
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
        assert isinstance(uncovered(loads(DIFFERENCE.format(otherwise="")))["y"], box_search.Undecided)

    def test_no_place_is_named_where_some_rule_moves_it(self, system):
        (found,) = [d for d in check(loads(DIFFERENCE.format(otherwise="")))[1] if d.code == "FZ401"]
        assert found.message == "no rule moves output 'y' at x = 0.5"
        assert found.facts[0] == "rules fire there, but 'implication bounded_difference' leaves nothing of them"


def with_claims(system, *claims):
    text = DIFFERENCE.format(otherwise="else 0.9")
    return system.model_copy(update={"guarantees": loads(text + "".join(f"require {c}\n" for c in claims)).guarantees})


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


def test_without_work_left_a_proof_names_its_own_limit(monkeypatch):
    monkeypatch.setattr("fuzzyctl.analysis.coverage.coverage.COVERAGE", 0)
    (verdict,) = verdicts(LINE, "total(u)")
    assert verdict.reason == "it takes more than 1,200,000 units of work, the most for the coverage of an output"
