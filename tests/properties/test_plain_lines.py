"""Plain lines give what the grammar gives, and the lines of shipped files are plain."""

import dataclasses
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang import fast_path
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import parse_by_grammar
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS
from fuzzyctl.support.shipped import rules_folder
from tests.shipped import LAWS
from tests.sizes import examples

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


STRINGS = st.sampled_from(['"a"', '""', '"σ̇ # (x"', '"a b', 'unit "m/s"', '"e\u0301" unit "µ"'])
VALUES = SIGNED | st.sampled_from(["(1)", "2*k", "1 2", ""])
OPERANDS = st.sampled_from([*NAMES, "within", "when", "unit", "f.g", "1", "2.5", ".5", "1e999", "1.x"])


def pieces(inner):
    pair = st.tuples(inner, st.sampled_from("+ - * / ^ < <= == != and or".split()), inner).map(" ".join)
    call = st.tuples(st.sampled_from(["f", "abs", "not"]), st.lists(inner, max_size=3)).map(
        lambda c: f"{c[0]}({', '.join(c[1])})"
    )
    named = st.tuples(inner, st.sampled_from(["x", "f.g", "1"]), st.sampled_from([" = ", "=", "=="]), inner).map(
        lambda c: f"f({c[0]}, {c[1]}{c[2]}{c[3]})"
    )
    denied = inner.map("not {}".format)
    return pair | call | named | denied | inner.map("({})".format) | inner.map("-{}".format) | inner.map("+ {}".format)


FORMULAS = st.recursive(OPERANDS, pieces, max_leaves=8)


@st.composite
def headers(draw):
    gap = st.sampled_from([" ", "  ", "\t"])
    return draw(spaced(draw(st.lists(WORDS, min_size=1, max_size=5)), gap)) + draw(ENDS)


@st.composite
def rows(draw):
    odd = st.sampled_from([".", "0.5", "-1", "- 1", "+1", ".5", "1.", "1e999", "a*0.5", "a/b", "(k)", "linear(1,2)"])
    cells = draw(st.lists(WORDS | odd, max_size=5))
    label = draw(WORDS | st.just(""))
    gap = st.sampled_from([" ", "  ", "\t", ""])
    return f"{draw(BLANKS)}{label}{draw(BLANKS)}|{draw(spaced(cells, gap))}{draw(ENDS)}"


@st.composite
def terms(draw):
    parameters = draw(st.lists(SIGNED | FORMULAS | st.just("k=1"), max_size=4))
    inside = ",".join(draw(BLANKS) + p + draw(BLANKS) for p in parameters)
    parts = [draw(WORDS), "=", draw(WORDS | st.just("triangle")), f"({inside})"]
    return draw(spaced(parts)) + draw(ENDS)


def mostly(plain, odd):
    return st.one_of(plain, plain, plain, odd)


#: Pieces of statements that are plain, but for one in four.
NAME_PIECES = mostly(st.sampled_from(["NB", "x", "_a1", "linear", "σ"]), WORDS)
VALUE_PIECES = mostly(st.sampled_from(["-1", "2.5", "-k", "1e3", "inf"]), VALUES)
STRING_PIECES = mostly(st.sampled_from(['"a"', '""', '"e\u0301"']), st.just("") | STRINGS)
UNIT_PIECES = mostly(st.sampled_from(["", 'unit "m/s"']), STRINGS | st.sampled_from(["clamp", "terms of x", ", b"]))


@st.composite
def statements(draw, forms):
    """A statement of one of the plain forms, often with something in it that is not plain."""
    word = draw(st.sampled_from([*forms]))
    gap = draw(mostly(st.just(" "), st.sampled_from(["", "  ", "\t"])))
    return draw(BLANKS) + gap.join([word, *(draw(piece) for piece in forms[word])]) + draw(ENDS)


def bounds(within, when):
    return [*(["within", "1e-9"] if within else []), *(["when", "x > 0"] if when else [])]


_CROSS = mostly(st.sampled_from(["x y", ""]), st.sampled_from(["× y", "x", 'from "a.csv"', ", b"]))
_VARIABLE = [
    NAME_PIECES,
    mostly(st.just(""), STRING_PIECES),
    st.just("in ["),
    VALUE_PIECES,
    st.just(","),
    VALUE_PIECES,
    st.just("]"),
    UNIT_PIECES,
    mostly(
        st.sampled_from(["", "else 0", "else hold"]), st.tuples(st.sampled_from(["else ", "else"]), VALUES).map("".join)
    ),
]
_SETTING = [NAME_PIECES, mostly(st.just(""), STRING_PIECES)]
_IS = st.tuples(
    NAME_PIECES,
    mostly(st.just("is"), st.sampled_from(["is not", "IS", "is very", "is not very", "is and"])),
    NAME_PIECES,
).map(" ".join)
_REST = mostly(
    st.just(""),
    st.sampled_from(
        ["and y is Z", "or y is Z and x is P", "and y is Z and not x is P", "unless y is Z", "and y is (Z or P)"]
    ),
)
_WEIGHT = mostly(st.sampled_from(["", "weight 0.5", "weight (1 / 3)"]), (FORMULAS | VALUES).map("weight {}".format))
FORMS = {
    "system": [NAME_PIECES, STRING_PIECES],
    "source": [STRING_PIECES, mostly(st.just(""), WORDS)],
    "param": [NAME_PIECES, st.just("="), VALUE_PIECES | FORMULAS, UNIT_PIECES],
    "require": [FORMULAS, st.builds(bounds, st.booleans(), st.booleans()).map(" ".join)],
    "input": _VARIABLE,
    "output": _VARIABLE,
    "let": [
        NAME_PIECES,
        mostly(st.just(""), STRING_PIECES),
        mostly(st.just(""), st.builds("in [{}, {}]".format, VALUE_PIECES, VALUE_PIECES)),
        UNIT_PIECES,
        st.just("="),
        FORMULAS,
    ],
    "terms": [st.lists(mostly(NAME_PIECES, st.sampled_from(["a@1", "b=2"])), max_size=4).map(" ".join)],
    "table": [NAME_PIECES, st.just("="), NAME_PIECES, _CROSS],
    "if": [_IS, _REST, st.just("then"), _IS, mostly(st.just(""), st.sampled_from([", v is very P", "x"])), _WEIGHT],
    **dict.fromkeys(("and", "or", "implication", "aggregation", "defuzzifier"), _SETTING),
    "controller": [NAME_PIECES, STRING_PIECES],
    "use": [STRING_PIECES],
}


_RANGE = st.builds(
    "in {}{}, {}{}".format, st.sampled_from("[("), VALUE_PIECES, VALUE_PIECES, mostly(st.just("]"), st.just(")"))
)
_LABELS = [mostly(st.just(""), STRING_PIECES), mostly(st.just(""), _RANGE), UNIT_PIECES]
_EQUATION = [NAME_PIECES, st.just("="), FORMULAS]
_DEFINED = [NAME_PIECES, *_LABELS, *_EQUATION[1:]]
BLOCK_FORMS = {
    **dict.fromkeys(("controller", "plant", "loop"), _SETTING),
    "use": [STRING_PIECES],
    "param": [NAME_PIECES, mostly(st.just(""), _RANGE), *_EQUATION[1:], UNIT_PIECES],
    "every": [FORMULAS],
    "input": [NAME_PIECES, *_LABELS],
    **dict.fromkeys(("output", "state"), _DEFINED),
    **dict.fromkeys(("let", "next", "der", "block"), _EQUATION),
    "measure": [NAME_PIECES, mostly(st.just(""), STRING_PIECES), UNIT_PIECES, *_EQUATION[1:]],
    "require": FORMS["require"],
}


KINDS = {
    "header": headers(),
    "row": rows(),
    "term_line": terms(),
    "statement": statements(FORMS),
    "block_statement": statements(BLOCK_FORMS),
}
FIRST = re.compile(rf"\s*({NAME})")
CODE = re.compile(r'(?:"[^"\n]*"|[^"#])*')


@settings(max_examples=examples(400), deadline=None)
@given(data=st.data(), before=st.sampled_from(["", "system s\n"]))
@pytest.mark.parametrize("kind", KINDS)
def test_a_plain_line_is_what_the_grammar_makes_of_it(kind, data, before):
    text = CODE.match(data.draw(KINDS[kind]))[0]  # a logical line ends before its comment
    source = SourceText("t", before + text)
    word = FIRST.match(text)
    whole = LogicalLine(len(before), len(before) + len(text), "", kind, word[1] if word else "")
    found = fast_path.read(source, whole, kind)
    if found is not None:
        node, problems = parse_by_grammar(source, whole, kind)
        assert problems == []
        assert list(leaves(node)) == list(leaves(found))


def leaves(node):
    """Yield the type of a node and of all within it, and their texts, numbers and locations."""
    yield type(node)
    if dataclasses.is_dataclass(node) and not isinstance(node, Span):
        for field in dataclasses.fields(node):
            yield from leaves(getattr(node, field.name))
    elif isinstance(node, tuple):
        for part in node:
            yield from leaves(part)
    else:
        yield node


@pytest.mark.parametrize(
    ("statement", "is_plain"),
    [
        ('param k = 2 * (a - -b)^2 / f(1, x) unit "m"', True),
        ("require f(-s, -d) == f within 1e-12 when abs(s) >= 0.03", True),
        ("require a < b < c", False),
        ("require a and b", True),
        ("require not a < b or (c > 1 and d) when not not a or b and c", True),
        ("require " + " and ".join(["a <= 1"] * 40), True),
        ("require " + "not " * 99 + "a", False),
        ("require a and", False),
        ("if x is not a then u is b", True),
        ("if " + " and ".join(["x is not a"] * 90) + " then u is b", True),
        ("if " + " or ".join(["x is a"] * 98) + " then u is b", False),
        ("if x is not not a then u is b", True),
        ("if x is a then u is not b", True),
        ("if x is a and y is b or z is c then u is d", False),
        ("param k = unit", False),
        ("param k = " + "-" * 99 + "1", False),
        ('input x "y" in [-1, k] unit "m"', True),
        ("input x in [-1, 1] clamp", False),
        ("output x in [-inf, k]", True),
        ("let a = x + 1", True),
        ('let a "b" in [-1, k] unit "m" = x > 1 and (x + 2) * 3 < 4', True),
        ("let a in [-1, 2 * k] = x", False),
        ("let aunit = x", True),
        ("let a = 5 ms", False),
        ("system s", True),
        ('source "a"', True),
        ('source "a" "b"', False),
        ("terms a b c", True),
        ("terms a@1 b@2", False),
        ("table u = x x y", True),
        ("table u, v = x x y", False),
        ("aggregation sum", True),
        ('output x in [0, 1] unit "m" else -1', True),
        ("output x in [0, 1] else hold(1)", False),
        ("if x is not very a and y is b then u is c, v is more_or_less d weight 0.5", True),
        ("if x is a then u is c weight (1 / (1 + k))", True),
        ("if x is a then u is c weight 1 / 2", False),
        ("if x is a then u is c weight", False),
        ("if x is not then u is c", False),
        ("if x is a or y is b and z is c then u is d", False),
        ("if x is " + "very " * 90 + "a then u is c", True),
        ("if x is " + "very " * 99 + "a then u is c", False),
    ],
)
def test_which_statements_are_plain(statement, is_plain):
    source = SourceText("t", statement)
    line = LogicalLine(0, len(statement), "", "statement", statement.split()[0])
    found = fast_path.read(source, line, "statement")
    assert (found is not None) == is_plain
    if is_plain:
        node, problems = parse_by_grammar(source, line, "statement")
        assert problems == []
        assert list(leaves(node)) == list(leaves(found))


@pytest.mark.parametrize("name", ["ais_reaction.fz", "boundary_layer.fz", "fcafsmc.fz"])
def test_the_lines_of_a_shipped_file_are_plain(name):
    source = SourceText(name, (rules_folder() / name).read_text(encoding="utf-8"))
    below = [line for line in split(source) if line.kind in KINDS]
    read = [fast_path.read(source, line, line.kind) for line in below]
    assert below
    assert sum(node is not None for node in read) >= 0.7 * len(below)


@pytest.mark.parametrize("path", LAWS, ids=lambda p: p.name)
def test_all_lines_of_a_shipped_law_are_plain(path):
    source = SourceText(path.name, path.read_text(encoding="utf-8"))
    lines = [line for line in split(source) if line.kind in KINDS]
    for line in lines:
        found = fast_path.read(source, line, line.kind)
        node, problems = parse_by_grammar(source, line, line.kind)
        assert problems == []
        assert list(leaves(node)) == list(leaves(found))
