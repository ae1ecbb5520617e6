import pytest

from fuzzyctl.editor.completion import signature
from fuzzyctl.editor.hover import hover
from fuzzyctl.editor.words import hedges, keywords
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked


@pytest.mark.parametrize(
    ("text", "at", "shown"),
    [
        (SYSTEM, "most]", "value: 20"),
        (SYSTEM, "poor |", "poor = ramp(10, 0)"),
        (SYSTEM, "fine   great", "term of 'food'"),
        (SYSTEM, "large=most", "`singleton(most)`"),
        (SYSTEM, "food\n", "Food"),
        (SYSTEM, 'tip "Tip', "Tip for a meal"),
        (SYSTEM, "ramp(10", "ramp(start, end)"),
        (SYSTEM, "defuzzifier", "defuzzifier centroid"),
        (SYSTEM, "defuzzifier", "how the fuzzy set of an output becomes its value"),
        (LOOP, "gain * surface", "param gain in [0, 9] = 2"),
        (LOOP, "steps(0", "steps(0: 1.0, 25 s: 0.5)"),
        (LOOP, "iae(lag", "iae("),
        (LOOP, "every 10", "every 5 ms"),
        (LOOP, "surface(e", "system surface"),
    ],
)
def test_what_is_shown(text, at, shown):
    assert shown in hover(*marked(text, at)).markdown


@pytest.mark.parametrize("block", ["", "controller", "plant", "loop"])
def test_all_keywords_and_hedges_have_a_meaning(block):
    assert [w.name for w in (*keywords(block), *hedges()) if not w.what] == []


def test_nothing_between_words():
    assert hover(*marked(SYSTEM, "| small")) is None


@pytest.mark.parametrize(
    ("text", "form", "active"),
    [
        ("input x in [0, 1]\n  a = triangle(§", "triangle(left, peak, right)", 0),
        ("input x in [0, 1]\n  a = triangle(0, §", "triangle(left, peak, right)", 1),
        ("input x in [0, 1]\n  a = triangle(min(0, 1), 2, §", "triangle(left, peak, right)", 2),
        ("input x in [0, 1]\n  a = triangle(0, 1, 2, 3, §", "triangle(left, peak, right)", 2),
        (LOOP.split("every")[0] + "let q = lowpass(r, §", "lowpass(x, time)", 1),
        (LOOP.split("let r")[0] + "let r = pulse(§", "pulse(begin, end)", 0),
        (LOOP.split("block law")[0] + "block a = law(r, §", "law(r, y)", 1),
    ],
)
def test_signature(text, form, active):
    found = signature(*marked(text))
    assert (found.form, found.active) == (form, active)


@pytest.mark.parametrize("text", ["param k = 2 §", "param k = unknown(§", 'system t "triangle(§', "param k = abs(1)§"])
def test_no_signature(text):
    assert signature(*marked(text)) is None
