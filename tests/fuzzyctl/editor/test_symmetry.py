import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.diagnostics.fixes import Fix, fixed
from fuzzyctl.editor.actions import actions
from fuzzyctl.editor.symmetry import mirror_of
from tests.fuzzyctl.editor.marked import marked

HEAD = """\
system pd
and product
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
input de in [-2, 2]
  terms L H
output u in [-4, 4] else 0
  terms NB=-4 NS=-1 Z=0 PS=1 PB=4
table u = e x de
       L   H
"""
OUTPUTS = ["NB", "NS", "Z", "PS", "PB"]

#: Terms of an input in [0, 10], and their mirror images.
MIRRORS = {
    "terms a b c": {"a": "c", "b": "b", "c": "a"},
    "terms a@0 b@2 c@10": None,
    "terms a@0 b@2 c@8 d@10": {"a": "d", "b": "c", "c": "b", "d": "a"},
    "a = gaussian(2, 1)\n  b = gaussian(8, 1)": {"a": "b", "b": "a"},
    "a = gaussian(2, 1)\n  b = gaussian(8, 2)": None,
    "a = sigmoid(4, -2)\n  b = sigmoid(6, 2)": {"a": "b", "b": "a"},
    "a = triangle(-5, 0, 5)\n  b = triangle(5, 10, inf)": {"a": "b", "b": "a"},
    "a = triangle(4, 5, 6)\n  b = rectangle(0, 10)": {"a": "a", "b": "b"},
    "a = ramp(2, 4)\n  b = ramp(8, 6)\n  c = ramp(8, 6)": None,
    "a = function(x / 10)\n  b = function(1 - x / 10)": None,
}


@pytest.mark.parametrize("terms", MIRRORS)
def test_mirror_images_of_terms(terms):
    text = f"system t\ninput x in [0, 10]\n  {terms}\noutput y in [0, 1] else 0\n  terms p q\nif x is a then y is p\n"
    (system,) = marked("§" + text)[0].examined.systems
    assert mirror_of(system, system.inputs[0]) == MIRRORS[terms]


@pytest.mark.parametrize(
    ("terms", "mirror"),
    [("a=0 b=1", {"a": "b", "b": "a"}), ("a=0.2 b=0.5 c=0.8", {"a": "c", "b": "b", "c": "a"}), ("a=0 b=0.9", None)],
)
def test_mirror_images_of_numbers(terms, mirror):
    text = "system t\ndefuzzifier weighted_average\ninput x in [0, 1]\n  n = ramp(0, 1)\n"
    text += f"output y in [0, 1] else 0\n  terms {terms}\nif x is n then y is a\n"
    (system,) = marked("§" + text)[0].examined.systems
    assert mirror_of(system, system.outputs[0]) == mirror


def offered(rows, line):
    """Return the texts that the actions of symmetry make, by title; the cursor is in a row of the table."""
    text = HEAD + "".join(f"  {name} |  {'  '.join(cells)}\n" for name, cells in zip("NZP", rows, strict=False))
    document, offset = marked(text, "NZP"[line] + " |")
    found = actions(document, offset)
    return {a.title: fixed(document.source, [Fix(a.replacements, "sure")]) for a in found if "metr" in a.title}


CELLS = st.lists(st.lists(st.sampled_from([*OUTPUTS, "."]), min_size=2, max_size=2), min_size=3, max_size=3)


@settings(max_examples=15, deadline=None)
@given(CELLS, st.integers(0, 2))
def test_what_is_offered_makes_the_table_symmetric(rows, line):
    """The outputs at opposite points are opposite, or the same; nothing is offered twice."""
    for title, text in offered(rows, line).items():
        document, _ = marked("§" + text)
        (system,) = document.examined.systems
        sign = -1 if "anti" in title else 1
        complete = title.startswith("complete")
        given_cells = [c for row in rows for c in row]
        after = [c for line in text.split("\n")[-4:-1] for c in line.partition("|")[2].split()]
        if complete:
            assert [a for a, g in zip(after, given_cells, strict=True) if g != "."] == [
                g for g in given_cells if g != "."
            ]
        if "." not in after:
            for e, de in ((0.3, 1.1), (-0.9, 0.4), (0.0, -2.0)):
                assert system(e=-e, de=-de) == pytest.approx(sign * system(e=e, de=de), abs=1e-12)
        again = [a.title for a in actions(*marked(text, "NZP"[line] + " |"))]
        assert title not in again


@settings(max_examples=8, deadline=None)
@given(st.lists(st.sampled_from(OUTPUTS), min_size=3, max_size=3))
def test_half_a_table_is_completed(half):
    """Rows N and, of Z, the left cell say all others."""
    opposite = dict(zip(OUTPUTS, reversed(OUTPUTS), strict=True))
    (text,) = (
        t for k, t in offered([half[:2], [half[2], "."]], 0).items() if k == "complete the table by antisymmetry"
    )
    cells = [line.partition("|")[2].split() for line in text.split("\n")[-4:-1]]
    assert cells == [half[:2], [half[2], opposite[half[2]]], [opposite[half[1]], opposite[half[0]]]]


@pytest.mark.parametrize(
    "rows",
    [
        [["NB", "Z"], ["NS", "PS"], ["Z", "PB"]],  # antisymmetric already
        [["0.5", "1"], ["0.3", "0.3"], ["1", "0.5"]],
    ],
)
def test_nothing_to_change(rows):
    assert offered(rows, 0) == {}
