"""Plain lines give what the grammar gives, and the lines of shipped files are plain."""

import dataclasses
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.lang import plain
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import parse_by_grammar
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS
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


STRINGS = st.sampled_from(['"a"', '""', '"σ̇ # (x"', '"a b', 'unit "m/s"', '"e\u0301" unit "µ"'])
VALUES = SIGNED | st.sampled_from(["(1)", "2*k", "1 2", ""])
OPERANDS = st.sampled_from([*NAMES, "within", "when", "unit", "f.g", "1", "2.5", ".5", "1e999", "1.x"])


def pieces(inner):
    pair = st.tuples(inner, st.sampled_from("+ - * / ^ < <= == != and or".split()), inner).map(" ".join)
    call = st.tuples(st.sampled_from(["f", "abs", "not"]), st.lists(inner, max_size=3)).map(
        lambda c: f"{c[0]}({', '.join(c[1])})"
    )
    return pair | call | inner.map("({})".format) | inner.map("-{}".format) | inner.map("+ {}".format)


FORMULAS = st.recursive(OPERANDS, pieces, max_leaves=8)


@st.composite
def statements(draw):
    """A statement of one of the plain forms, often with something in it that is not plain."""
    name, other, value, more = draw(WORDS), draw(WORDS), draw(VALUES), draw(VALUES)
    text = draw(st.just("") | STRINGS)
    forms = {
        "system": [name, text],
        "source": [text, draw(st.sampled_from(["", "", name]))],
        "param": [name, "=", draw(VALUES | FORMULAS), text],
        "require": [
            draw(FORMULAS),
            *draw(st.sampled_from([[], ["within"], ["when"], ["within", "when"]])),
            draw(FORMULAS),
        ],
        "input": [name, text, "in", "[", value, ",", more, "]", draw(st.just("") | STRINGS | st.just("clamp"))],
        "terms": draw(st.lists(WORDS | st.sampled_from(["a@1", "b=2"]), max_size=4)),
        "table": [name, "=", other, draw(st.sampled_from(["x", "×", "", "from", ", b"])), draw(WORDS | st.just(""))],
    }
    forms["output"] = forms["input"]
    forms |= {key: [name, text] for key in ("and", "or", "implication", "aggregation", "defuzzifier")}
    word = draw(st.sampled_from(sorted(forms)))
    gap = draw(st.sampled_from([" ", "  ", "\t"]) | st.just(""))
    return draw(BLANKS) + word + draw(BLANKS) + gap.join(forms[word]) + draw(ENDS)


KINDS = (("header", headers()), ("row", rows()), ("term_line", terms()), ("statement", statements()))
FIRST = re.compile(rf"\s*({NAME})")
CODE = re.compile(r'(?:"[^"\n]*"|[^"#])*')
LINES = st.one_of(*(st.tuples(st.just(kind), lines) for kind, lines in KINDS))


@settings(max_examples=900, deadline=None)
@given(line=LINES, before=st.sampled_from(["", "system s\n"]))
def test_a_plain_line_is_what_the_grammar_makes_of_it(line, before):
    kind, text = line[0], CODE.match(line[1])[0]  # a logical line ends before its comment
    source = SourceText("t", before + text)
    word = FIRST.match(text)
    whole = LogicalLine(len(before), len(before) + len(text), "", kind, word[1] if word else "")
    found = plain.read(source, whole, kind)
    if found is not None:
        node, problems = parse_by_grammar(source, whole, kind)
        assert (node, problems) == (found, [])
        assert list(places(node)) == list(places(found))  # which expressions do not compare


def places(node):
    """Yield what is typed and where, of a node and all within it."""
    if dataclasses.is_dataclass(node) and not isinstance(node, SourceText):
        for field in dataclasses.fields(node):
            value = getattr(node, field.name)
            yield value if field.name in ("span", "text") else type(value)
            yield from places(value)
    elif isinstance(node, tuple):
        for part in node:
            yield from places(part)


@pytest.mark.parametrize(
    ("statement", "is_plain"),
    [
        ('param k = 2 * (a - -b)^2 / f(1, x) unit "m"', True),
        ("require f(-s, -d) == f within 1e-12 when abs(s) >= 0.03", True),
        ("require a < b < c", False),
        ("require a and b", False),
        ("param k = unit", False),
        ("param k = " + "-" * 99 + "1", False),
        ('input x "y" in [-1, k] unit "m"', True),
        ("input x in [-1, 1] clamp", False),
    ],
)
def test_which_statements_are_plain(statement, is_plain):
    source = SourceText("t", statement)
    line = LogicalLine(0, len(statement), "", "statement", statement.split()[0])
    found = plain.read(source, line, "statement")
    assert (found is not None) == is_plain
    if is_plain:
        node, problems = parse_by_grammar(source, line, "statement")
        assert (node, problems, list(places(node))) == (found, [], list(places(found)))


@pytest.mark.parametrize("name", ["ais_reaction.fz", "boundary_layer.fz", "fcafsmc.fz"])
def test_the_lines_of_a_shipped_file_are_plain(name):
    source = SourceText(name, (rules_folder() / name).read_text(encoding="utf-8"))
    below = [line for line in split(source) if line.kind in ("header", "row", "term_line", "statement")]
    read = [plain.read(source, line, line.kind) for line in below]
    assert below
    assert sum(node is not None for node in read) >= 0.7 * len(below)
