import pytest

from fuzzyctl.editor.requests import KINDS, MODIFIERS, tokens
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

#: A word of a text with a mark before it, and its token.
CASES = {
    "a keyword": (SYSTEM, "defuzzifier", "", "keyword"),
    "the name of a system": (SYSTEM, "tip", "system", "namespace/declaration"),
    "a title": (SYSTEM, '"Tip for', "", "string"),
    "a value of a setting": (SYSTEM, "center_average", "", "enumMember"),
    "a param": (SYSTEM, "most", "", "variable/declaration/readonly"),
    "a param in a range": (SYSTEM, "most]", "", "variable/readonly"),
    "a number": (SYSTEM, "20", "", "number"),
    "a hedge": (SYSTEM, "hardly", "", "function/declaration"),
    "an input": (SYSTEM, "service", "", "parameter/declaration"),
    "an input in a table": (SYSTEM, "food\n   ", "", "parameter"),
    "an output": (SYSTEM, "tip", "output", "variable/declaration"),
    "a membership function": (SYSTEM, "ramp(10", "", "function"),
    "a term": (SYSTEM, "fine", "terms", "enumMember/declaration/readonly"),
    "a term in a header": (SYSTEM, "fine", "table", "enumMember/readonly"),
    "a term in a cell": (SYSTEM, "large", "good |", "enumMember/readonly"),
    "a label of a row": (SYSTEM, "good |", "", "enumMember/readonly"),
    "the word between two inputs": (SYSTEM, "x food", "", "keyword"),
    "a clause": (SYSTEM, "else", "", "keyword"),
    "a controller": (LOOP, "law", "controller", "class/declaration"),
    "a controller that is added": (LOOP, "law(r", "", "class"),
    "a state": (LOOP, "level =", "next", "property"),
    "a function of signals": (LOOP, "steps", "", "function"),
    "a measure that is called": (LOOP, "iae(", "", "function"),
    "a loop": (LOOP, "closed", "", "namespace/declaration"),
    "a system that is called": (LOOP, "surface(", "", "namespace"),
    "an instance": (LOOP, "lag.y", "", "variable"),
    "a member": (LOOP, "y, r)", "", "variable"),
    "a comment": ("param a = 1  # of param", "# of", "", "comment"),
    "a text that is open": ('system t "a b', '"a b', "", "string"),
    "no name": ("param a = unknown", "unknown", "", ""),
}


def shown(document):
    return {t.span.start: "/".join([t.kind, *t.modifiers]) for t in tokens(document)}


@pytest.mark.parametrize("case", CASES)
def test_a_word_is(case):
    text, at, before, wanted = CASES[case]
    document, offset = marked(text, at, before)
    assert shown(document).get(offset, "") == wanted


@pytest.mark.parametrize("text", [SYSTEM, LOOP, "", "\0", "🙂 is 🙂\r\nsystem 🙂", "if x is"])
def test_tokens_are_in_order_and_of_known_kinds(text):
    found = list(tokens(marked(text + "§")[0]))
    ends = [0, *(t.span.end for t in found)]
    for token, end in zip(found, ends, strict=False):
        assert end <= token.span.start < token.span.end
        assert token.kind in KINDS
        assert set(token.modifiers) <= set(MODIFIERS)
        assert "\n" not in token.span.text


def test_a_range_has_its_tokens():
    document, offset = marked(SYSTEM, "table")
    part = [t.span for t in tokens(document, offset, offset + 30)]
    assert part == [s for s in (t.span for t in tokens(document)) if offset <= s.start < offset + 30]
