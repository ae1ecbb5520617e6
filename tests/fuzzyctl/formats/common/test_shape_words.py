"""What a table writes for a membership function it reads back, for each format."""

import pytest

from fuzzyctl.formats.common.words import words_by_kind
from fuzzyctl.formats.fcl.words import JFUZZYLOGIC_SHAPES
from fuzzyctl.formats.fis.shapes import MEMBERSHIP_WORDS
from fuzzyctl.formats.fll.shapes import TERM_WORDS
from fuzzyctl.formulas import MEMBERSHIP

TABLES = {"fll": TERM_WORDS, "fis": MEMBERSHIP_WORDS, "jfuzzylogic": JFUZZYLOGIC_SHAPES}
ENTRIES = [(t, kind, *entry) for t, words in TABLES.items() for kind, entry in words_by_kind(words).items()]


@pytest.mark.parametrize(("table", "kind", "name", "word"), ENTRIES, ids=lambda v: v if isinstance(v, str) else "")
def test_parameters_come_back(table, kind, name, word):
    count = 4 if MEMBERSHIP[kind].variadic else len(MEMBERSHIP[kind].parameters)
    parameters = tuple(float(k) for k in range(1, count + 1))
    assert word.count in (count, None)
    if name != "Binary":  # its direction becomes an end that is infinite
        assert word.shape(word.parameters(parameters)) == (kind, parameters)


def test_widths_count_by_their_magnitude_and_half_widths_twice():
    assert MEMBERSHIP_WORDS["gauss2mf"].shape((-1.0, 2.0, -3.0, 4.0)) == ("gaussian2", (2.0, 1.0, 4.0, 3.0))
    assert JFUZZYLOGIC_SHAPES["COSINE"].shape((1.5, 7.0)) == ("cosine", (7.0, 3.0))
    assert JFUZZYLOGIC_SHAPES["COSINE"].parameters((7.0, 3.0)) == (1.5, 7.0)
