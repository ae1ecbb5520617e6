"""Verdicts on increasing, decreasing and lipschitz."""

import pytest

from fuzzyctl import Proved, Refuted
from tests.fuzzyctl.analysis.proving import CURVED, LINE, MAMDANI, WEIGHTED, verdicts, words


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
        assert words(flat, "increasing(u, e)", "increasing(u, de)", timeout=0.001) == ["Proved"] * 2

    def test_what_falls_somewhere_is_not_proved(self):
        text = WEIGHTED.replace("Z | NS ZO PS", "Z | NS PS ZO")
        assert words(text, "increasing(u, de)", "increasing(u, e)")[0] == "Refuted"
