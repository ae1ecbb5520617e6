"""Region of a rule: ends of its terms, and the point that leads back to it."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.editor.preview import Side, ends_of, preview, region, strongest
from tests.fuzzyctl.editor.marked import SYSTEM, marked

TIP = marked(SYSTEM, "food")[0].examined.systems[0]

ONE = "system t\ndefuzzifier center_average\ninput x in [0, 10]\n  a = {}\n  b = ramp(0, 10)\n"
ONE += "output y in [0, 1] else 0\n  terms p q\nif x is a then y is p\nif x is b then y is q\n"

#: A term of an input in [0, 10], its support and its core.
TERMS = {
    "triangle(2, 3, 5)": ((2, 5), (3, 3)),
    "triangle(-inf, 3, 5)": ((0, 5), (0, 3)),
    "triangle(-4, -2, 5)": ((0, 5), (0, 0)),
    "trapezoid(1, 3, 6, 7)": ((1, 7), (3, 6)),
    "trapezoid(1, 3, 6, 7, height=0.5)": ((1, 7), (3, 6)),
    "rectangle(2, 4)": ((2, 4), (2, 4)),
    "singleton(4)": ((4, 4), (4, 4)),
    "ramp(8, 2)": ((0, 8), (0, 2)),
    "gaussian(4, 0.01)": ((0, 10), (4, 4)),
    "s_shape(2, 6)": ((2, 10), (6, 10)),
    "piecewise(0, 0, 1, 1, 3, 0, 4, 0, 6, 1, 8, 0)": ((0, 8), (1, 6)),
}


@pytest.mark.parametrize("term", TERMS)
def test_the_ends_of_a_term(term):
    (system,) = marked("§" + ONE.format(term))[0].examined.systems
    x = system.inputs[0]
    assert ends_of(system, x, x.terms[0]) == TERMS[term]


@pytest.mark.parametrize("term", ["triangle(20, 30, 50)", "function(x / 10)"])
def test_a_term_without_ends(term):
    (system,) = marked("§" + ONE.format(term))[0].examined.systems
    assert ends_of(system, system.inputs[0], system.inputs[0].terms[0]) is None
    assert region(system, 0).inputs is None


def test_the_region_of_a_cell():
    found = preview(*marked(SYSTEM, "large\n  good", "table"), pictures=False).region
    assert found.text == "if service is poor and food is great then tip is large"
    assert found.inputs == (Side("service", (0, 10), (0, 0)), Side("food", (5, 10), (10, 10)))
    assert [(v.name, v.value) for v in found.point] == [("service", 0), ("food", 10)]
    assert found.rule.text == "large"


@pytest.mark.parametrize(
    ("condition", "is_box"),
    [
        ("service is poor", True),
        ("service is any and food is bad", True),
        ("service is poor and service is good", False),  # cores without a common point
        ("service is very poor", False),
        ("service is poor or food is bad", False),
        ("not service is poor", False),
    ],
)
def test_only_conjunctions_of_terms_are_boxes(condition, is_box):
    (system,) = marked("§" + SYSTEM + f"if {condition} then tip is small\n")[0].examined.systems
    found = region(system, len(system.rules) - 1)
    assert (found.inputs is not None) == (found.point is not None) == is_box


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(1, 9), min_size=1, max_size=4, unique=True), st.integers(1, 4))
def test_the_point_of_a_region_leads_back_to_its_cell(inner, rows):
    peaks = [0, *sorted(inner), 10]
    xs, ys = [f"a{k}" for k in range(len(peaks))], [f"b{k}" for k in range(rows + 1)]
    text = "system t\ndefuzzifier center_average\ninput x in [0, 10]\n"
    text += "  terms " + " ".join(f"{n}@{p}" for n, p in zip(xs, peaks, strict=True)) + "\n"
    text += "input y in [-1, 3]\n  terms " + " ".join(ys) + "\noutput z in [0, 1]\n  terms p q\ntable z = y x x\n"
    text += f"    {' '.join(xs)}\n" + "".join(f"  {n} | {' '.join('p' for _ in xs)}\n" for n in ys)
    (system,) = marked("§" + text)[0].examined.systems
    for position, _ in enumerate(itertools.product(ys, xs)):
        found = region(system, position)
        place, strength = strongest(system, "z", [(v.name, v.value) for v in found.point])
        assert (place, strength) == (found.rule, pytest.approx(1))


def test_an_answer_without_pictures():
    document, offset = marked(SYSTEM, "large\n  good", "table")
    found = preview(document, offset, {"service": 7.0, "food": 8.0}, pictures=False)
    assert (found.surface, found.terms, found.rules, found.frame) == ("", "", "", None)
    assert (found.rule.line, found.rule.text, found.strength) == (17, "large", pytest.approx(0.6))
    assert preview(document, 0, {}, pictures=False).region is None
