from base64 import b64decode
from xml.etree import ElementTree

import pytest

from fuzzyctl.editor.hover import as_markdown, hover, picture
from tests.fuzzyctl.editor.marked import SYSTEM, marked

KINDS = {
    "triangle": "triangle(0, 2, 4)",
    "trapezoid": "trapezoid(0, 1, 2, 4)",
    "rectangle": "rectangle(1, 3)",
    "ramp up": "ramp(0, 10)",
    "ramp down": "ramp(10, 0)",
    "gaussian": "gaussian(5, 1)",
    "bell": "bell(5, 1, 2)",
    "sigmoid": "sigmoid(5, 2)",
    "a shoulder": "triangle(-inf, 2, 4)",
    "a height": "triangle(0, 2, 4)",
    "beyond the range": "triangle(-20, -12, -11)",
    "a param": "triangle(0, most / 10, 4)",
}


def term_of(function):
    document, _ = marked(SYSTEM.replace("ramp(10, 0)", function) + "§")
    system = document.examined.systems[0]
    return system, system.inputs[0], system.inputs[0].terms[0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_is_well_formed_and_stays_inside(kind):
    svg = picture(*term_of(KINDS[kind]))
    root = ElementTree.fromstring(svg)
    lines = [e for e in root if e.tag.endswith("polyline")]
    assert len(lines) == 2
    assert [e.text for e in root if e.tag.endswith("text")] == ["0", "service", "10"]
    for line in lines:
        points = [tuple(map(float, p.split(","))) for p in line.attrib["points"].split()]
        assert all(0 <= x <= 260 and 0 <= y <= 66 for x, y in points)


def test_the_peak_is_at_the_top():
    root = ElementTree.fromstring(picture(*term_of("triangle(0, 5, 10)")))
    strong = [e for e in root if e.tag.endswith("polyline")][-1].attrib["points"].split()
    assert strong[65] == "130.0,4.0"


def test_singletons_are_lines():
    document, _ = marked(SYSTEM + "§")
    system = document.examined.systems[0]
    assert "259.0,66 259.0,4.0" in picture(system, system.outputs[0], system.outputs[0].terms[1])


@pytest.mark.parametrize("at", ["poor |", "good = ", "bad    fine", "fine   great", "small  small", "large\n\n"])
def test_a_hover_holds_the_picture(at):
    text = hover(*marked(SYSTEM, at)).markdown
    svg = b64decode(text.split("base64,")[1].split(")")[0]).decode()
    assert svg.startswith("<svg ")
    assert svg.endswith("</svg>")
    assert "peak at" in text


def test_functions_of_inputs_have_none():
    text = SYSTEM.replace("small=0 large=most", "small=0\n  large = linear(1, 1, 0)")
    document, _ = marked(text + "§")
    system = document.examined.systems[0]
    assert picture(system, system.outputs[0], system.outputs[0].terms[1]) == ""
    assert "image" not in hover(*marked(text, "large\n\n")).markdown


def test_labels_are_escaped():
    document, _ = marked(SYSTEM.replace('"Food"', '"a < b & c"') + "§")
    system = document.examined.systems[0]
    assert "a &lt; b &amp; c" in picture(system, system.inputs[1], system.inputs[1].terms[0])
    assert as_markdown("<svg/>", "x") == "![x](data:image/svg+xml;base64,PHN2Zy8+)"
