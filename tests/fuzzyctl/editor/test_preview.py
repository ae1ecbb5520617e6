"""Pictures of the system at the cursor, by the request `fuzzyctl/preview`."""

import asyncio
import itertools
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzyctl
from tests import sizes
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM
from tests.golden.answers import Case

POINT = {"service": 7.0, "food": 8.0}
CURVE = "system t\ndefuzzifier center_average\ninput x in [0, 1]\n  terms a b c\noutput y in [0, 1]\n  terms p q r\n"
CURVE += "table y = x\n    a  b  c\n  | p  q  r\n"
TWO = "\n".join([CURVE.replace("system t", "system s"), CURVE])
OUTPUTS = (
    CURVE.replace("table", "output z in [0, 2] else 0\n  terms p q r\ntable")
    + "if x is a then z is p\nif x is c then z is r\n"
)


def names_of(data):
    """Return data as a request brings it: with members in place of keys."""
    if isinstance(data, dict):
        return SimpleNamespace(**{name: names_of(value) for name, value in data.items()})
    return [names_of(value) for value in data] if isinstance(data, list) else data


def shown(marked, point=None, **more):
    """Return the answer at the mark of a text."""
    case = Case(marked)
    (place,) = case.places
    given = None if point is None else [{"name": name, "value": value} for name, value in point.items()]
    position = {"line": place.line, "character": place.character}
    params = {"textDocument": {"uri": case.uri}, "position": position, "point": given, **more}
    return SimpleNamespace(**asyncio.run(case.ask("fuzzyctl/preview", names_of(params))))


def at(text, part):
    return text.replace(part, "①" + part, 1)


def test_the_surface_and_the_terms():
    found = shown(at(SYSTEM, "most = 20"))
    assert (found.message, found.title, found.rules, found.rule) == ("", "tip: tip", "", None)
    assert found.surface.count("<svg") == found.terms.count("<svg") == 1
    assert [(i["name"], i["label"], i["low"], i["high"], i["value"]) for i in found.inputs] == [
        ("service", "service", 0, 10, 5),
        ("food", "Food", 0, 10, 5),
    ]
    frame = found.frame
    assert frame["axes"] == ("service", "food")
    assert 0.4 < frame["left"] < frame["left"] + frame["width"] < 1
    # Numbers and label of the axis have their room below the map.
    assert 0 < frame["top"] < 1 - frame["top"] - frame["height"]


def test_the_same_system_gives_the_same_pictures_with_other_comments():
    assert shown(at(CURVE, "x in")) == shown("# other\n" + at(CURVE, "x in"))
    assert shown(at(CURVE, "x in")) != shown(at(CURVE.replace("p  q  r", "p  r  r"), "x in"))


def test_the_region_of_the_rule_at_the_cursor_is_marked():
    texts = [at(SYSTEM, "food"), at(SYSTEM, "small  large\n  good"), at(SYSTEM, "large\n  good")]
    assert len({shown(text).surface for text in texts}) == 3


@pytest.mark.parametrize(
    ("text", "part", "title"),
    [
        (TWO, "s\n", "s: y"),
        (TWO, "system t", "t: y"),
        (OUTPUTS, "terms p", "t: y"),
        (OUTPUTS, "z in", "t: z"),
        (OUTPUTS, "if x is c", "t: z"),
        (LOOP, "controller law", "surface: u"),
        (LOOP, "run 5 s", "surface: u"),
    ],
)
def test_the_cursor_chooses_system_and_output(text, part, title):
    assert shown(at(text, part)).title == title


def test_a_point_gives_rules_and_the_cell_of_the_strongest_one():
    found = shown(at(SYSTEM, "food"), POINT)
    assert found.rules.startswith("<?xml")
    assert (found.rule.start.line, found.rule.start.character) == (16, 23)
    assert found.surface == shown(at(SYSTEM, "food")).surface
    quick = shown(at(SYSTEM, "large\n  good"), POINT, pictures=False)
    assert (quick.surface, quick.terms, quick.rules, quick.frame) == ("", "", "", None)
    assert (quick.rule, quick.strength) == (found.rule, pytest.approx(0.6))


def test_the_surface_is_that_at_the_other_inputs_of_the_point():
    more = SYSTEM.replace("output tip", "input mood in [0, 1]\n  terms low high\noutput tip", 1)
    found, other, same = (shown(at(more, "food"), {**POINT, "mood": mood}).surface for mood in (0.2, 0.8, 0.2))
    assert found == same != other


def test_a_dark_background_shows_through():
    light, dark = (shown(at(SYSTEM, "food"), dark=dark).surface for dark in (False, True))
    background, text = 'style="fill: #ffffff"', "fill: #d4d4d4"
    assert (background in light, text in light) == (True, False)
    assert (background in dark, text in dark) == (False, True)


def test_a_curve_of_one_input_and_a_point_without_a_rule():
    found = shown(at(CURVE, "q  r"), {"x": 0.9})
    assert (found.frame["axes"], found.rule.start.character) == (("x",), 10)
    assert found.surface != shown(at(CURVE, "system")).surface
    silent = shown(at(OUTPUTS, "z in"), {"x": 0.5})
    assert (silent.message, silent.title, silent.rule) == ("", "t: z", None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("①", "the text has no system, or its system has mistakes"),
        ("①\0", "the text has no system, or its system has mistakes"),
        ("①" + SYSTEM.replace("small  large", "smal  large"), "system 'tip' has mistakes"),
        (at(TWO.replace("| p  q  r", "| p  q  rr", 1), "system s"), "system 's' has mistakes"),
    ],
)
def test_without_a_system_there_is_a_message(text, message):
    found = shown(text, POINT)
    assert (found.message, found.surface, found.inputs) == (message, "", ())


def test_a_table_with_gaps_has_no_surface_but_terms():
    found = shown(at(OUTPUTS.replace(" else 0", ""), "z in"), {"x": 0.0})
    assert found.message.startswith("no rule fires for output 'z' at x = 0.5")
    assert (found.surface, found.frame, found.rules) == ("", None, "")
    assert found.terms.startswith("<?xml")


@settings(max_examples=sizes.examples(20, 8), deadline=None)
@given(st.dictionaries(st.sampled_from(["service", "food", "other"]), st.floats()))
def test_any_point_is_brought_into_the_ranges(point):
    for i in shown("①" + SYSTEM, point, pictures=False).inputs:
        assert i["low"] <= i["value"] <= i["high"]


#: A term of an input in [0, 10], its support and its core.
TERMS = {
    "triangle(2, 3, 5)": ((2, 5), (3, 3)),
    "triangle(-inf, 3, 5)": ((0, 5), (0, 3)),
    "triangle(-4, -2, 5)": ((0, 5), (0, 0)),
    "trapezoid(1, 3, 6, 7, height=0.5)": ((1, 7), (3, 6)),
    "rectangle(2, 4)": ((2, 4), (2, 4)),
    "singleton(4)": ((4, 4), (4, 4)),
    "ramp(8, 2)": ((0, 8), (0, 2)),
    "gaussian(4, 0.01)": ((0, 10), (4, 4)),
    "s_shape(2, 6)": ((2, 10), (6, 10)),
    "piecewise(0, 0, 1, 1, 3, 0, 4, 0, 6, 1, 8, 0)": ((0, 8), (1, 6)),
    "triangle(20, 30, 50)": None,
    "function(x / 10)": None,
}


class TestRegion:
    """Ends of the terms of a rule, and the point that leads back to it."""

    ONE = "system t\ndefuzzifier center_average\ninput x in [0, 10]\n  a = {}\n  b = ramp(0, 10)\n"
    ONE += "output y in [0, 1] else 0\n  terms p q\nif x is a ①then y is p\nif x is b then y is q\n"

    def region(self, marked):
        return shown(marked, pictures=False).region

    @pytest.mark.parametrize("term", TERMS)
    def test_the_ends_of_a_term(self, term):
        inputs = self.region(self.ONE.format(term))["inputs"]
        assert (inputs and (inputs[0]["support"], inputs[0]["core"])) == TERMS[term]

    def test_of_a_cell(self):
        found = self.region(at(SYSTEM, "large\n  good"))
        assert found["text"] == "if service is poor and food is great then tip is large"
        sides = [(s["name"], s["support"], s["core"]) for s in found["inputs"]]
        assert sides == [("service", (0, 10), (0, 0)), ("food", (5, 10), (10, 10))]
        assert [(v["name"], v["value"]) for v in found["point"]] == [("service", 0), ("food", 10)]
        assert found["rule"].start.line == 15
        assert self.region("①" + SYSTEM) is None

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
    def test_only_conjunctions_of_terms_are_boxes(self, condition, is_box):
        found = self.region(SYSTEM + f"if {condition} ①then tip is small\n")
        assert (found["inputs"] is not None) == (found["point"] is not None) == is_box

    @settings(max_examples=sizes.examples(10, 3), deadline=None)
    @given(st.lists(st.integers(1, 9), min_size=1, max_size=4, unique=True), st.integers(1, 3))
    def test_the_point_leads_back_to_its_cell(self, inner, rows):
        peaks = [0, *sorted(inner), 10]
        xs, ys = [f"a{k}" for k in range(len(peaks))], [f"b{k}" for k in range(rows + 1)]
        text = "system t\ndefuzzifier center_average\ninput x in [0, 10]\n"
        text += "  terms " + " ".join(f"{n}@{p}" for n, p in zip(xs, peaks, strict=True)) + "\n"
        text += "input y in [-1, 3]\n  terms " + " ".join(ys) + "\noutput z in [0, 1]\n  terms p q\ntable z = y x x\n"
        text += f"    {' '.join(xs)}\n" + "".join(f"  {n} | {' '.join('p' for _ in xs)}\n" for n in ys)
        rows = [k for k, line in enumerate(text.split("\n")) if " | " in line]
        for line, column in itertools.product(rows, range(len(xs))):
            lines = text.split("\n")
            before = lines[line].index("|") + 2 + 2 * column
            lines[line] = f"{lines[line][:before]}①{lines[line][before:]}"
            found = shown("\n".join(lines), pictures=False).region
            back = shown("\n".join(lines), {v["name"]: v["value"] for v in found["point"]}, pictures=False)
            assert (back.rule, back.strength) == (found["rule"], pytest.approx(1))

    @pytest.mark.parametrize("point", [(2, 1), (2, 9), (9, 1), (9, 5), (9, 9), (1, 5)])
    def test_a_point_selects_the_rule_that_acts_most(self, point):
        named = dict(zip(("service", "food"), map(float, point), strict=True))
        found = shown("①" + SYSTEM, named, pictures=False)
        (system,) = Case(SYSTEM).now.examined.systems
        strongest = fuzzyctl.why(system, named).rules[0]
        assert found.strength == pytest.approx(strongest.activation)
        assert found.rule.start.line + 1 == system.rules[strongest.number - 1].span.line
