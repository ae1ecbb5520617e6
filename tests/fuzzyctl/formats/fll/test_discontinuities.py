"""Jumps of fuzzylite's terms: what holds there is read and written as its two engines compute it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fll.shapes import polygon
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.loading.load import examine
from tests.fuzzyctl.formats.one_term import FLL

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
    return examine(SourceText(name, text))


def of_variable(system, variable, places):
    return list(degrees(system, variable, variable.terms[0], places))


@pytest.mark.parametrize("points", MEASURED)
@pytest.mark.parametrize("python", [True, False])
def test_degrees_at_jumps_are_those_of_the_engine(points, python):
    said = "# numerics of pyfuzzylite\n" if python else ""
    system, diagnostics = read(said + FLL.format(f"Discrete {points}", f"Discrete {points}"))
    expected = [float(y) for y in MEASURED[points][not python].split()]
    for variable in (*system.inputs, *system.outputs):
        assert of_variable(system, variable, PLACES) == pytest.approx(expected, abs=1e-15)
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


def of_model(points, x):
    """The polygon's degree, where the larger one holds at a jump."""
    there = [y for place, y in zip(points[::2], points[1::2], strict=True) if place == x]
    return max(there) if there else computed(points, x, python=True)


POLYGONS = st.lists(
    st.tuples(st.sampled_from([-2.0, 0.0, 0.5, 1.0, 4.0]), st.sampled_from([0.0, 0.25, 0.5, 1.0])),
    min_size=1,
    max_size=6,
).map(lambda pairs: tuple(v for pair in sorted(pairs, key=lambda p: p[0]) for v in pair))


def beside(points):
    """Return the places of points, their neighbours, and places between and beyond."""
    places = sorted(set(points[::2]))
    return [x for p in places for x in (p - 0.125, math.nextafter(p, -9), p, math.nextafter(p, 9), p + 0.125)]


@given(POLYGONS, st.booleans())
def test_a_polygon_is_read_as_computed(points, python):
    made = polygon(points, python=python)
    for x in beside(points):
        assert of_model(made, x) == pytest.approx(computed(points, x, python=python), abs=1e-15)


@given(POLYGONS, st.booleans())
def test_a_polygon_is_written_to_be_computed_so(points, python):
    shown = polygon(points, python=python, written=True)
    for x in beside(points):
        assert computed(shown, x, python=python) == pytest.approx(of_model(points, x), abs=1e-15)


@given(POLYGONS, st.booleans())
def test_what_was_read_is_written_and_read_as_the_same(points, python):
    once = polygon(points, python=python)
    assert polygon(polygon(once, python=python, written=True), python=python) == once


@pytest.mark.parametrize("said", ["", "# numerics of pyfuzzylite\n"])
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
    system, _ = examine(SourceText("t.fz", text))
    written, _ = FORMATS[kind].write(system)
    assert "0.9999999999999999" in written
    again, _ = read(written, f"t.{kind}")
    assert again.inputs[0].terms[0].membership.arguments == system.inputs[0].terms[0].membership.arguments
    assert of_variable(again, again.inputs[0], [0.9999999999999999, 1.0]) == [0.0, 1.0]
