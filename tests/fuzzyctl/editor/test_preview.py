"""Pictures of the system at the cursor."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.editor.preview import chosen, inputs_at, preview, strongest
from fuzzyctl.plot.surfaces import lead
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

POINT = {"service": 7.0, "food": 8.0}
CURVE = "system t\ndefuzzifier center_average\ninput x in [0, 1]\n  terms a b c\noutput y in [0, 1]\n  terms p q r\n"
CURVE += "table y = x\n    a  b  c\n  | p  q  r\n"
TWO = "\n".join([CURVE.replace("system t", "system s"), CURVE])
OUTPUTS = (
    CURVE.replace("table", "output z in [0, 2] else 0\n  terms p q r\ntable")
    + "if x is a then z is p\nif x is c then z is r\n"
)


def shown(text, at, point=None, before=""):
    return preview(*marked(text, at, before), point)


def test_the_surface_and_the_terms():
    found = shown(SYSTEM, "most = 20")
    assert (found.message, found.title, found.rules, found.rule) == ("", "tip: tip", "", None)
    assert found.surface.count("<svg") == found.terms.count("<svg") == 1
    assert [(i.name, i.label, i.low, i.high, i.value) for i in found.inputs] == [
        ("service", "service", 0, 10, 5),
        ("food", "Food", 0, 10, 5),
    ]


def test_the_same_system_gives_the_same_pictures_whatever_its_comments_say():
    assert shown(CURVE, "x in") == shown("# other\n" + CURVE, "x in")
    assert shown(CURVE, "x in") != shown(CURVE.replace("p  q  r", "p  r  r"), "x in")


def test_the_region_of_the_rule_at_the_cursor_is_marked():
    plain = shown(SYSTEM, "food").surface
    cells = [shown(SYSTEM, at, before="great\n  poor").surface for at in ("small  large\n  good", "large\n  good")]
    assert len({plain, *cells}) == 3


@pytest.mark.parametrize(
    ("text", "at", "title"),
    [
        (TWO, "s\n", "s: y"),
        (TWO, "terms a b c\noutput", "s: y"),
        (TWO, "system t", "t: y"),
        (OUTPUTS, "terms p", "t: y"),
        (OUTPUTS, "z in", "t: z"),
        (OUTPUTS, "if x is c", "t: z"),
        (LOOP, "controller law", "surface: u"),
        (LOOP, "run 5 s", "surface: u"),
    ],
)
def test_the_cursor_chooses_system_and_output(text, at, title):
    system, output, _ = chosen(*marked(text, at))
    assert f"{system.name}: {output}" == title


def test_a_point_gives_rules_and_the_cell_of_the_strongest_one():
    found = shown(SYSTEM, "food", POINT)
    assert found.rules.startswith("<?xml")
    assert (found.rule.line, found.rule.text) == (17, "large")
    assert found.rule.start == SYSTEM.rindex("large")
    assert found.surface == shown(SYSTEM, "food").surface


def test_the_surface_is_that_at_the_other_inputs_of_the_point():
    more = SYSTEM.replace("output tip", "input mood in [0, 1]\n  terms low high\noutput tip", 1)
    found, other, same = (shown(more, "food", {**POINT, "mood": mood}).surface for mood in (0.2, 0.8, 0.2))
    assert found == same != other


def test_a_dark_background_shows_through():
    light, dark = (preview(*marked(SYSTEM, "food"), dark=dark).surface for dark in (False, True))
    background, text = 'style="fill: #ffffff"', "fill: #d4d4d4"
    assert (background in light, text in light) == (True, False)
    assert (background in dark, text in dark) == (False, True)


@pytest.mark.parametrize("at", [(2, 1), (2, 9), (9, 1), (9, 5), (9, 9), (1, 5)])
def test_the_region_of_a_cell_holds_the_points_that_select_it(at):
    """Both ways agree: a point selects the cell in whose region it is."""
    document, _ = marked(SYSTEM, "food")
    (system,) = document.examined.systems
    place, _ = strongest(system, "tip", [("service", at[0]), ("food", at[1])])
    rule = next(k for k, r in enumerate(system.rules) if r.span.start == place.start)
    for k in range(len(system.rules)):
        assert (lead(system, "tip", k, np.array(at, dtype=float)) > 0) == (k == rule)


def test_a_frame_says_where_the_map_is():
    frame = shown(SYSTEM, "food").frame
    assert frame.axes == ("service", "food")
    assert 0.4 < frame.left < frame.left + frame.width < 1
    # Numbers and label of the axis have their room below the map.
    assert 0 < frame.top < 1 - frame.top - frame.height
    assert all(type(x) is float for x in (frame.left, frame.top, frame.width, frame.height))


def test_a_curve_of_one_input():
    found = shown(CURVE, "q  r", {"x": 0.9})
    assert (found.frame.axes, found.rule.text) == (("x",), "r")
    assert found.surface != shown(CURVE, "system").surface


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the text has no system, or its system has mistakes"),
        (SYSTEM.replace("small  large", "smal  large"), "system 'tip' has mistakes"),
        ("\0", "the text has no system, or its system has mistakes"),
    ],
)
def test_without_a_system_there_is_a_message(text, message):
    found = preview(*marked("§" + text), POINT)
    assert (found.message, found.surface, found.inputs) == (message, "", ())


def test_another_system_may_have_mistakes():
    text = TWO.replace("| p  q  r", "| p  q  rr", 1)
    assert preview(*marked(text, "system s")).message == "system 's' has mistakes"
    assert chosen(*marked(text, "system t"))[0].name == "t"


def test_where_no_rule_acts_there_is_none_to_select():
    found = shown(OUTPUTS, "z in", {"x": 0.5})
    assert (found.message, found.title, found.rule) == ("", "t: z", None)


def test_a_table_with_gaps_has_no_surface_but_terms():
    found = shown(OUTPUTS.replace(" else 0", ""), "z in", {"x": 0.0})
    assert found.message.startswith("no rule fires for output 'z' at x = 0.5")
    assert (found.surface, found.frame, found.rules) == ("", None, "")
    assert found.terms.startswith("<?xml")


TIP = marked(SYSTEM, "food")[0].examined.systems[0]


@settings(max_examples=20, deadline=None)
@given(st.dictionaries(st.sampled_from(["service", "food", "other"]), st.floats()))
def test_any_point_is_brought_into_the_ranges(point):
    for i in inputs_at(TIP, point):
        assert i.low <= i.value <= i.high
