import pytest

from fuzzyctl.editor.hover import hints
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked


def system(*lines):
    """Return a system of one input whose lines are given."""
    own = "\n".join(lines)
    names = "output u in [0, 1] else 0\n  terms l=0 h=1\n"
    return f"system t\ndefuzzifier center_average\n{own}\n{names}if x is {'a' if ' a' in own else 'N'} then u is l\n"


#: A text, and the hints of the line that holds the second text.
CASES = {
    "three terms": (SYSTEM, "terms bad", "bad@0 fine@5 great@10"),
    "terms with values": (SYSTEM, "terms small", ""),
    "a number": (SYSTEM, "param most", ""),
    "a sum": (SYSTEM.replace("= 20", "= 4 * 5"), "param most", "4 * 5= 20"),
    "a param of params": (SYSTEM.replace("= 20", "= 20\nparam p = most / 3"), "param p", "most / 3= 6.66667"),
    "a comment stays behind": (SYSTEM.replace("= 20", "= 10 + 10  # most"), "param most", "10 + 10= 20"),
    "a negative number": (SYSTEM.replace("= 20", "= 20\nparam p = -3"), "param p", ""),
    "a function": (SYSTEM.replace("= 20", "= max(20, 1)"), "param most", "max(20, 1)= 20"),
    "a unit": (SYSTEM.replace("= 20", '= 4 * 5 unit "%"'), "param most", "4 * 5= 20"),
    "a range of params": (system("param w = 3", "input x in [-w, w]", "  terms N Z P"), "terms", "N@-3 Z@0 P@3"),
    "peaks that are written": (system("input x in [0, 8]", "  terms N@1 Z@2 P@8"), "terms", ""),
    "two terms": (system("input x in [0, 1]", "  terms N P"), "terms", "N@0 P@1"),
    "seven terms": (
        system("input x in [-3, 3]", "  terms N a b c d e P"),
        "terms",
        "N@-3 a@-2 b@-1 c@0 d@1 e@2 P@3",
    ),
    "functions have no hint": (SYSTEM, "poor =", ""),
    "a mistake elsewhere in the system": (SYSTEM.replace("large  large", "large  no"), "terms bad", ""),
    "an output of singletons": (SYSTEM, "terms small", ""),
    "an output before proofs": (SYSTEM, "output tip", ""),
    "terms of a system that is called": (LOOP, "terms N", "N@-1 Z@0 P@1"),
    "a param of a controller": (LOOP.replace("= 2\n", "= 1 + 1\n"), "param gain", "1 + 1= 2"),
    "a number of a controller": (LOOP, "param gain", ""),
    "a broken text": ("input x in [0, 1]\n  terms a b\nif", "terms", ""),
    "an empty text": ("", "", ""),
}


def shown(document, at):
    line = document.source.line_of(document.text.index(at))
    found = []
    for hint in hints(document):
        if document.source.line_of(hint.offset) == line:
            before = document.source.line_text(line)[: document.source.column_of(hint.offset) - 1]
            word = before.split("=")[-1].strip() if "=" in before else before.split()[-1]
            found.append(f"{word}{hint.text}")
    return " ".join(found)


@pytest.mark.parametrize("case", CASES)
def test_hints_of_a_line(case):
    text, at, wanted = CASES[case]
    assert shown(marked(text + "§")[0], at) == wanted


def test_bounds_of_outputs_once_they_are_proved():
    document, _ = marked(SYSTEM, "tip")
    document.bounds["tip", "tip"] = (0.0, 20.0)
    assert shown(document, "output tip") == "0proved [0, 20]"


def test_a_range_has_its_hints():
    document, offset = marked(SYSTEM, "fine")
    assert [h.text for h in hints(document, offset, offset + 4)] == ["@5"]
