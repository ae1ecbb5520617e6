"""The pages of the gallery show the verdicts on the claims about their families."""

import pytest

from gallery import pages

ENTRIES = {n: f for n, f in pages.entries().items() if not n.startswith("arch_") and n != "wang_tanaka_1996"}
#: Pages whose claims take the least time; the others are tested before a release.
FAST = {"mudi_pal_1999", "wang_mendel_1992"}


@pytest.mark.parametrize("name", [n if n in FAST else pytest.param(n, marks=pytest.mark.long) for n in ENTRIES])
def test_a_page_shows_what_is_proved(name):
    text = (ENTRIES[name] / "README.md").read_text(encoding="utf-8")
    (table,) = pages.PROOFS.findall(text)
    assert table == pages.verdicts_of(pages.loops_of(ENTRIES[name]))


def test_most_pages_are_decided():
    """A table with open claims only is that of an undecided page."""
    tables = [pages.PROOFS.findall((f / "README.md").read_text(encoding="utf-8"))[0] for f in ENTRIES.values()]
    assert sum("| proved |" in t and "undecided" not in t for t in tables) >= 11
