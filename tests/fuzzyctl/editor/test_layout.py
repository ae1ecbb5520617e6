import pytest

from fuzzyctl.diagnostics.fixes import Fix, fixed
from fuzzyctl.editor.actions import laid_out, typed
from fuzzyctl.lang.formatter import format_source
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

HEAD = "system t\n" + "table u = x x y\n"


def after(document, changes):
    return fixed(document.source, [Fix(tuple(changes), "sure")])


@pytest.mark.parametrize("text", [SYSTEM, LOOP, "", "\n\n", "param a=1\r\nparam bb = 2\r\n"])
def test_all_lines_are_the_whole_layout_but_for_blank_lines(text):
    document, _ = marked(text + "§")
    whole = format_source(document.source).split("\n")
    lines = after(document, laid_out(document.source, 1, 10**9)).replace("\r", "").split("\n")
    assert [x for x in lines if x.strip()] == [x for x in whole if x.strip()]


@pytest.mark.parametrize(
    ("text", "lines", "wanted"),
    [
        ("param a=1\nparam b=2\n", (1, 1), "param a = 1\nparam b=2\n"),
        ("param a=1\nparam b=2\n", (2, 2), "param a=1\nparam b = 2\n"),
        ("param a=1\n\n\n\nparam b=2\n", (5, 5), "param a=1\n\n\n\nparam b = 2\n"),
        ("param a=1\nparam long=2\n", (1, 1), "param a    = 1\nparam long=2\n"),
        ("param a=1\nparam b=2\n", (3, 9), "param a=1\nparam b=2\n"),
        ("system  t\nwhat  is  this\n", (1, 2), "system t\nwhat is this\n"),
        ("if   x is a then   u is b\n", (1, 1), "if x is a then u is b\n"),
        ("# a\n#b\nparam a=1\n", (1, 3), "# a\n#b\nparam a = 1\n"),
    ],
)
def test_some_lines(text, lines, wanted):
    document, _ = marked(text + "§")
    assert after(document, laid_out(document.source, *lines)) == wanted


#: A text with the cursor behind the character that was typed, and the text afterwards.
TYPED = {
    "a bar lays out the rows above": (
        HEAD + "  a bbb\n  lo | a  b\n  high |§\n",
        HEAD + "          a  bbb\n  lo   |  a  b\n  high |\n",
    ),
    "the row of the cursor stays": (HEAD + "  a b\n   high|§\n", HEAD + "          a  b\n   high|\n"),
    "a line feed lays out all above": (HEAD + "  a b\n  lo |a b\n§", HEAD + "        a  b\n  lo |  a  b\n"),
    "a line feed in the middle": (HEAD + "  a b\n  lo |a b\n§\n  hi | a b\n", None),
    "a line feed below the header": (HEAD + "  aa   b\n§", HEAD + "     aa  b\n"),
    "what is laid out stays": (HEAD + "        a  b\n  lo |  a  b\n§", HEAD + "        a  b\n  lo |  a  b\n"),
    "comments are kept": (HEAD + "  a b # c\n  lo |a b\n§", HEAD + "        a  b  # c\n  lo |  a  b\n"),
    "wide cells": (HEAD + "  a b\n  lo |aaaa b*0.5\n§", HEAD + "        a     b\n  lo |  aaaa  b*0.5\n"),
    "lines above the table stay": (
        "param a=1\n" + HEAD + "  a b\n  lo |a b\n§", "param a=1\n" + HEAD + "        a  b\n  lo |  a  b\n"),
    "the line of the table": ("table u=x x y\n  a b\n§", "table u = x x y\n     a  b\n"),
    "one input": ("table u = x\n a b\n |c d\n§", "table u = x\n     a  b\n  |  c  d\n"),
    "a line feed behind a table line": ("table u=x x y\n§", None),
    "a line feed elsewhere": ("param a=1\n§", None),
    "a bar elsewhere": ("param a=1 |§", None),
    "a bar at the beginning": ("|§", None),
    "an empty text": ("§", None),
    "a bar in a comment": (HEAD + "  a   b\n# |§", None),
    "a bar in a guarantee": ("require |§x| <= 1", None),
    "a broken row above": (HEAD + "  a b\n  lo |a (b\n  hi |§", None),
    "rows below stay": (HEAD + "  a b\n  l |§\n  lo |a b\n", HEAD + "        a  b\n  l |\n  lo |a b\n"),
    "carriage returns": (
        HEAD.replace("\n", "\r\n") + "  a b\r\n  lo |a b\r\n§",
        HEAD.replace("\n", "\r\n") + "        a  b\r\n  lo |  a  b\r\n"),
}  # fmt: skip


@pytest.mark.parametrize("case", TYPED)
def test_after_typing(case):
    text, wanted = TYPED[case]
    document, offset = marked(text)
    character = document.text[offset - 1 : offset] or "\n"
    changes = typed(document, offset, character)
    if wanted is None:
        assert "|" not in text or character == "|" or "middle" in case or changes == []
        line = document.source.line_of(offset)
        assert all(c.span.line < line for c in changes)
        if "middle" not in case and "broken" not in case:
            assert changes == []
    else:
        assert after(document, changes) == wanted
