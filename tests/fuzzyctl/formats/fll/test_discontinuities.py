"""Jumps of fuzzylite's terms: what holds there is read and written as its two engines compute it."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import as_profile, loads
from tests.fuzzyctl.formats.files import FORMATS, examined
from tests.fuzzyctl.formats.files import read as sound
from tests.fuzzyctl.formats.one_term import FLL, degrees

PYTHON = "# numerics of pyfuzzylite\n"
PLACES = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0]

#: Degrees at these places, of pyfuzzylite 8.0.6 and of fuzzylite 6.0.
MEASURED = {
    "1 0 1 1 2 0": ("0 0 1 0.5 0 0", "0 0 0 0.5 0 0"),
    "0 0 1 1 1 0.5 3 0": ("0 0.5 0.5 0.375 0.25 0", "0 0.5 1 0.375 0.25 0"),
    "0 0 1 0.25 1 0.75 1 0.5 2 0": ("0 0.125 0.5 0.25 0 0", "0 0.125 0.25 0.25 0 0"),
    "0 1 0 0.5 2 0": ("0.5 0.375 0.25 0.125 0 0", "1 0.375 0.25 0.125 0 0"),
    "0 0 2 1 2 0.5": ("0 0.25 0.5 0.75 0.5 0.5", "0 0.25 0.5 0.75 0.5 0.5"),
    "0 0 2 0.5 2 1": ("0 0.125 0.25 0.375 1 1", "0 0.125 0.25 0.375 1 1"),
    "1 1 1 0": ("1 1 0 0 0 0", "1 1 1 0 0 0"),
    "1 0 1 1": ("0 0 1 1 1 1", "0 0 0 1 1 1"),
    "1 0.5 1 1 2 1 2 0.5": ("0.5 0.5 1 1 0.5 0.5", "0.5 0.5 0.5 1 0.5 0.5"),
}


def read(text, name="t.fll"):
    return examined(name, text)


@pytest.mark.parametrize("points", MEASURED)
@pytest.mark.parametrize("python", [True, False])
def test_degrees_at_jumps_are_those_of_the_engine(points, python):
    system, diagnostics = read(PYTHON * python + FLL.format(f"Discrete {points}", f"Discrete {points}"))
    expected = [float(y) for y in MEASURED[points][not python].split()]
    assert degrees(system, PLACES) == pytest.approx(expected, abs=1e-15)
    assert system.outputs[0].terms == system.inputs[0].terms
    differs = len(set(MEASURED[points])) > 1 and not python
    assert [d.span.line for d in diagnostics if d.code == "FZ609"] == ([4, 9] if differs else [])


def test_what_the_other_engine_has_is_said():
    _, diagnostics = read(FLL.format("Discrete 1 0 1 1 2 0", "Triangle 0 1 2"))
    (reported,) = (d for d in diagnostics if d.code == "FZ609")
    assert reported.message == "'Discrete' jumps at 1 from 0 to 1; there it is 0, as fuzzylite computes it"
    assert "pyfuzzylite has 1 there" in reported.help


def computed(points, x, *, python):
    """What the engines compute: at a jump the first point counts, at the right end and in pyfuzzylite the last."""
    pairs = list(zip(points[::2], points[1::2], strict=True))
    there = [y for place, y in pairs if place == x]
    if there:
        return there[-1] if python or x == pairs[-1][0] != pairs[0][0] else there[0]
    before, behind = [p for p in pairs if p[0] < x], [p for p in pairs if p[0] > x]
    if not before or not behind:
        return behind[0][1] if behind else before[-1][1]
    (x0, y0), (x1, y1) = before[-1], behind[0]
    return y0 + (y1 - y0) * ((x - x0) / (x1 - x0))


POLYGONS = st.lists(
    st.tuples(st.sampled_from([-2.0, 0.0, 0.5, 1.0, 4.0]), st.sampled_from([0.0, 0.25, 0.5, 1.0])),
    min_size=1,
    max_size=6,
).map(lambda pairs: tuple(v for pair in sorted(pairs, key=lambda p: p[0]) for v in pair))


def beside(points):
    """Return the places of points, their neighbours, and places between and beyond."""
    places = sorted(set(points[::2]))
    return [x for p in places for x in (p - 0.125, math.nextafter(p, -9), p, math.nextafter(p, 9), p + 0.125)]


@given(POLYGONS, st.booleans(), st.booleans())
def test_a_polygon_is_read_as_computed_and_written_to_be_computed_so(points, python, other):
    word = f"Discrete {' '.join(map(str, points))}"
    system, _ = read(PYTHON * python + FLL.format(word, "Triangle 0 1 2"))
    places = beside(points)
    expected = pytest.approx([computed(points, x, python=python) for x in places], abs=1e-15)
    assert degrees(system, places) == expected
    text, _ = FORMATS["fll"].write(as_profile(system, "pyfuzzylite" if other else "fuzzylite"))
    kind, numbers = re.search(r"term: t (\w+) (.*)", text).groups()
    if kind == "Discrete":
        shown = tuple(map(float, numbers.split()))
        assert [computed(shown, x, python=other) for x in places] == expected
    assert degrees(sound("fll", text), places) == expected


@pytest.mark.parametrize("said", ["", PYTHON])
@pytest.mark.parametrize(
    "word", [*(f"Discrete {points}" for points in MEASURED), "PiShape 1 1 2 3", "PiShape 0 0 0 1 0.5", "SShape 2 2"]
)
def test_files_come_back_as_the_same_system(word, said):
    system, _ = read(said + FLL.format(word, word))
    text, losses = FORMATS["fll"].write(system)
    again, diagnostics = read(text)
    assert not losses
    assert (again.inputs, again.outputs) == (system.inputs, system.outputs)
    assert FORMATS["fll"].write(again)[0] == text
    assert not [d for d in diagnostics if d.severity == "error"]


def test_a_degree_of_one_place_is_written_between_its_neighbours():
    text = "system s\nsemantics fuzzylite\ninput a in [0, 2] extrapolate\n"
    text += (
        "  t = piecewise(0, 0, 1, 0.25, 1, 1, 1, 0.25, 2, 0)\noutput y in [0, 5] else nan\n  t = triangle(0, 1, 2)\n"
    )
    written, _ = FORMATS["fll"].write(loads(text + "if a is t then y is t\n"))
    assert "Discrete 0 0 0.9999999999999999 0.25 1 1 1.0000000000000002 0.25 2 0\n" in written
    places = [math.nextafter(1, 0), 1.0, math.nextafter(1, 2)]
    assert degrees(sound("fll", written), places) == pytest.approx([0.25, 1.0, 0.25], abs=1e-15)


@pytest.mark.parametrize("kind", ["fll", "fis", "fcl"])
def test_a_side_without_width_is_written_so_that_its_foot_has_1(kind):
    text = """
system s
semantics fuzzylite
input a in [0, 5] extrapolate
  t = pi_shape(1, 1, 2, 3)
output y in [0, 5] else nan defuzzifier centroid(resolution=100)
  t = triangle(0, 1, 2)
if a is t then y is t
"""
    system = loads(text)
    written, _ = FORMATS[kind].write(system)
    assert "0.9999999999999999" in written
    again = sound(kind, written)
    assert again.inputs[0].terms[0].membership.arguments == system.inputs[0].terms[0].membership.arguments
    assert degrees(again, [0.9999999999999999, 1.0]) == [0.0, 1.0]
