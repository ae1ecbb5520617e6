"""Inputs and terms that nothing uses: which they are, and advice that changes no number."""

import pytest

from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine, loads

READS = """system pdc
defuzzifier weighted_average
param k = 2
input x in [-1, 1]
  terms N P
input z in [-1, 1]{terms}
output u in [-9, 9]{clause}
  {declared}
if x is N then u is {first}
if x is P then u is {second}
"""
TERMS = "\n  terms A B"


def codes(text):
    return sorted(d.code for d in check_source(SourceText("s.fz", text))[1])


class TestInputsReadByConsequents:
    @pytest.mark.parametrize("terms", ["", TERMS])
    @pytest.mark.parametrize(
        ("consequent", "is_read"),
        [
            ("linear(0, 1, 2)", True),
            ("linear(0, k - 2, 2)", True),
            ("function(x * z)", True),
            ("linear(1, 0, 2)", False),
            ("function(x)", False),
        ],
    )
    def test_a_consequent_reads_what_it_names(self, terms, consequent, is_read):
        # A term of an input that no antecedent reads is not reported by itself.
        text = READS.format(terms=terms, clause="", declared="", first=consequent, second="linear(k, 0, 0)")
        assert codes(text) == ([] if is_read else ["FZ211"])
        named = READS.format(
            terms=terms, clause="", declared=f"t = {consequent}\n  s = linear(k, 0, 0)", first="t", second="s"
        )
        assert codes(named) == codes(text)

    def test_a_term_that_no_rule_names_reads_nothing(self):
        declared = "t = linear(1, 0, k)\n  s = linear(1, 1, 1)"
        assert codes(READS.format(terms="", clause="", declared=declared, first="t", second="t")) == ["FZ208", "FZ211"]

    def test_an_input_that_only_a_rate_reads_needs_no_terms(self):
        text = READS.format(terms="", clause=" adaptive rate k * z", declared="terms N=-1 P=1", first="N", second="P")
        assert codes(text) == []
        assert loads(text).inputs[1].terms == ()
        assert codes(text.replace("k * z", "k * x")) == ["FZ212"]

    def test_an_input_without_terms_leaves_no_part_of_its_range_uncovered(self):
        text = READS.format(terms="", clause=" else 0", declared="", first="function(z)", second="linear(k, 0, 0)")
        assert codes(text) == []


LINES = """system s
input x in [0, 40]
  terms low high
output u in [-1, 2] defuzzifier {defuzzifier}
  {terms}
if x is low then u is {used[0]}
if x is high then u is {used[1]}
"""


def unused(terms, used, defuzzifier):
    """Return the text of a system, and what is said of its only unused term."""
    text = LINES.format(terms=terms, used=used, defuzzifier=defuzzifier)
    (found,) = (d for d in examine(SourceText("s.fz", text))[1] if d.code == "FZ208")
    return text, found


class TestRemovalOfATerm:
    @pytest.mark.parametrize("defuzzifier", ["center_average", "centroid"])
    @pytest.mark.parametrize("terms", ["terms A B C", "terms A@-1 B@0.25 C@2"])
    @pytest.mark.parametrize("used", ["AB", "BC", "AC"])
    def test_the_advice_keeps_every_number(self, terms, used, defuzzifier):
        text, found = unused(terms, used, defuzzifier)
        written = found.help.rpartition("as they are: ")[2]
        if found.help == "remove it, or use it in a rule":
            written = " ".join(word for word in terms.split() if word[0] in f"t{used}")
        system, changed = loads(text), loads(text.replace(terms, written.replace("), ", ")\n  ")))
        assert [t.name for t in changed.outputs[0].terms] == list(used)
        for x in (0, 3, 11, 20, 29.5, 40):
            assert changed(x=x) == pytest.approx(system(x=x), abs=1e-12)

    @pytest.mark.parametrize(
        ("terms", "defuzzifier", "fact", "advice"),
        [
            ("terms A B C", "center_average", "without it the peaks of its line move", "terms A@-1 C@2"),
            (
                "terms A@-1 B@0 C@2",
                "centroid",
                "without it the terms beside it reach further",
                "A = triangle(-inf, -1, 0), C = triangle(0, 2, inf)",
            ),
            ("terms A@-1 B@0 C@2", "center_average", "", "remove it, or use it in a rule"),
            ("terms A=-1 B=0 C=2", "center_average", "", "remove it, or use it in a rule"),
        ],
    )
    def test_what_would_change_is_said(self, terms, defuzzifier, fact, advice):
        found = unused(terms, "AC", defuzzifier)[1]
        assert found.facts == ((fact,) if fact else ())
        assert found.help.endswith(advice)

    def test_where_the_output_is_read_the_feet_count_as_well(self):
        text = LINES.format(terms="terms A B C", used="AC", defuzzifier="center_average")
        text += "output v in [0, 1]\n  terms L H\nif u is A then v is L\nif u is C then v is H\n"
        (found,) = (d for d in examine(SourceText("s.fz", text))[1] if d.code == "FZ208")
        assert found.help.endswith("A = triangle(-inf, -1, 0.5), C = triangle(0.5, 2, inf)")
