"""Plain lines give what the grammar gives, and the lines of shipped files are plain."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.lang import plain
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import parse_by_grammar
from fuzzyctl.lang.syntax import STATEMENT_KEYWORDS
from fuzzyctl.shipped import rules_folder
from fuzzyctl.source import SourceText

NAMES = "NB Z x inf pi _a1 linear not and or then σ".split()
WORDS = st.sampled_from([*NAMES, "a" * 60, *STATEMENT_KEYWORDS])
NUMBERS = st.floats(allow_nan=False, allow_infinity=False).map(repr) | st.sampled_from(
    ["0", "1.", ".5", "1e999", "1e-999", "0e5", "1E+3", "٣", "1_0", "0x1", "00.10"]
)
SIGNED = st.tuples(st.sampled_from(["", "-", "+", "- ", "--"]), NUMBERS | WORDS).map("".join)
BLANKS = st.sampled_from(["", " ", "  ", "\t"])
ENDS = st.sampled_from(["", " ", "  # a comment (1, 2) | b", "#", "\r", " \t"])


@st.composite
def spaced(draw, parts, gaps=BLANKS):
    return "".join(draw(gaps) + part for part in parts)


@st.composite
def headers(draw):
    gap = st.sampled_from([" ", "  ", "\t"])
    return draw(spaced(draw(st.lists(WORDS, min_size=1, max_size=5)), gap)) + draw(ENDS)


@st.composite
def rows(draw):
    cells = draw(st.lists(WORDS | st.sampled_from([".", "0.5", "a*0.5", "a/b", "(k)", "linear(1,2)"]), max_size=5))
    label = draw(WORDS | st.just(""))
    gap = st.sampled_from([" ", "  ", "\t", ""])
    return f"{draw(BLANKS)}{label}{draw(BLANKS)}|{draw(spaced(cells, gap))}{draw(ENDS)}"


@st.composite
def terms(draw):
    parameters = draw(st.lists(SIGNED, max_size=4))
    inside = ",".join(draw(BLANKS) + p + draw(BLANKS) for p in parameters)
    parts = [draw(WORDS), "=", draw(WORDS | st.just("triangle")), f"({inside})"]
    return draw(spaced(parts)) + draw(ENDS)


KINDS = (("header", headers()), ("row", rows()), ("term_line", terms()))
LINES = st.one_of(*(st.tuples(st.just(kind), lines) for kind, lines in KINDS))


@settings(max_examples=600, deadline=None)
@given(line=LINES, before=st.sampled_from(["", "system s\n"]))
def test_a_plain_line_is_what_the_grammar_makes_of_it(line, before):
    kind, text = line[0], line[1].partition("#")[0]  # a logical line ends before its comment
    source = SourceText("t", before + text)
    whole = LogicalLine(len(before), len(before) + len(text), "", kind, "")
    found = plain.read(source, whole, kind)
    if found is not None:
        assert parse_by_grammar(source, whole, kind) == (found, [])


@pytest.mark.parametrize("name", ["ais_reaction.fz", "boundary_layer.fz", "fcafsmc.fz"])
def test_the_lines_of_a_shipped_file_are_plain(name):
    source = SourceText(name, (rules_folder() / name).read_text(encoding="utf-8"))
    below = [line for line in split(source) if line.kind in ("header", "row", "term_line")]
    read = [plain.read(source, line, line.kind) for line in below]
    assert below
    assert sum(node is not None for node in read) >= 0.8 * len(below)
