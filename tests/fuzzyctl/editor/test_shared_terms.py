import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.diagnostics.fixes import Fix, fixed
from fuzzyctl.editor.actions import actions
from fuzzyctl.kernels.plan.build import plan
from tests.fuzzyctl.editor.marked import marked

TERMS = ["  terms N P\n", "  terms N@-1 P@1\n", "  N = ramp(0, -1)\n  P = ramp(0, 1)\n", "  terms N  P  # c\n"]
RANGES = ["[-1, 1]", "[-2, 2]"]
CLAUSES = ["", ' unit "m"', "  # c"]
VARIABLE = st.tuples(
    st.sampled_from(TERMS), st.sampled_from(RANGES), st.sampled_from(CLAUSES), st.sampled_from(["", "\n", "# c\n"])
)


def text_of(variables):
    text = "system t\ndefuzzifier center_average\n"
    for k, (terms, ends, clauses, before) in enumerate(variables):
        text += f"{before}input x{k} in {ends}{clauses}\n{terms}"
    text += "output y in [0, 1] else 0\n  terms a b\n"
    names = [f"x{k}" for k in range(len(variables))]
    return text + "".join(f"if {n} is N then y is a\nif {n} is P then y is b\n" for n in names)


def changes(text, at):
    document, offset = marked(text, at)
    found = [a for a in actions(document, offset) if "as" not in a.title.split()]
    return document, {a.title: fixed(document.source, [Fix(a.replacements, "sure")]) for a in found}


@settings(max_examples=20, deadline=None)
@given(st.lists(VARIABLE, min_size=2, max_size=4), st.integers(0, 3))
def test_the_system_stays_as_it_is(variables, chosen):
    """Shared terms mean the same, no comment goes, and what was shared is not offered again."""
    text = text_of(variables)
    at = f"input x{chosen % len(variables)}"
    document, found = changes(text, at)
    (before,) = document.examined.systems
    for title, after in found.items():
        (system,) = marked("§" + after)[0].examined.systems
        assert plan(system) == plan(before)
        assert after.count("#") == text.count("#")
        assert len(after.split("\n")) < len(text.split("\n"))
        if at in after:
            assert title not in changes(after, at)[1]


SAME = (TERMS[0], RANGES[0], "", "")


@pytest.mark.parametrize(
    ("variables", "at", "titles"),
    [
        ([SAME, SAME], "input x0", ["share these terms with 'x1'", "declare 'x0', 'x1' on one line"]),
        ([SAME, SAME], "input x1", ["take the terms of 'x0'", "declare 'x0', 'x1' on one line"]),
        ([SAME, (TERMS[0], RANGES[1], "", "")], "input x1", ["take the terms of 'x0'"]),
        ([SAME, (TERMS[1], RANGES[0], "", "")], "input x1", []),
        ([(TERMS[1], RANGES[0], "", ""), (TERMS[1], RANGES[1], "", "")], "input x1", []),
        ([SAME, (TERMS[0], RANGES[0], "", "# c\n")], "input x1", ["take the terms of 'x0'"]),
        ([SAME, (TERMS[3], RANGES[0], "", "")], "input x1", []),
        ([SAME, SAME, SAME], "input x1", ["take the terms of 'x0'", "declare 'x0', 'x1', 'x2' on one line"]),
    ],
)
def test_what_is_offered(variables, at, titles):
    assert list(changes(text_of(variables), at)[1]) == titles


def test_variables_of_one_line_are_one_declaration():
    text = text_of([SAME, SAME])
    _, found = changes(text, "input x0")
    joined = found["declare 'x0', 'x1' on one line"]
    assert joined.split("\n")[2:4] == ["input x0, x1 in [-1, 1]", "  terms N P"]
    assert changes(joined, "input x0, x1")[1] == {}


def test_other_systems_have_terms_of_their_own():
    text = text_of([SAME]) + text_of([SAME]).replace("system t", "system s")
    assert changes(text, "input x0")[1] == {}
