"""What is written as `.fll` computes the same numbers when it is read back, or the losses say so."""

import pytest

from fuzzyctl.conversion import convert
from fuzzyctl.errors import render_all
from fuzzyctl.formats.fll import read, write
from fuzzyctl.loading import loads
from fuzzyctl.source import SourceText

TWO = """\
system two
and product
defuzzifier {method}
input x in [0, 10]
  a = {a}
  b = {b}
output y in [0, 4] else 2
  p = {p}
  q = {q}
if x is a then y is p
if x is b then y is q
"""


def two(
    a="gaussian(0, 0.5)", b="gaussian(10, 0.5)", p="constant(1)", q="constant(3)", method="weighted_average", weight=""
):
    text = TWO.format(a=a, b=b, p=p, q=q, method=method)
    return loads(text.replace("then y is p\n", f"then y is p {weight}\n"))


def head(system):
    return write(system)[0].splitlines()[0]


class TestTails:
    def test_far_tails_still_decide_in_the_file(self):
        system = two()
        found = convert(system, "fll")
        assert found.lossy == ()
        assert [loss.what for loss in found.losses] == ["least 0.0"]
        assert system(x=4.9) == pytest.approx(1.036, abs=1e-3)
        assert found.read_back(x=4.9) == pytest.approx(system(x=4.9), rel=1e-12)

    @pytest.mark.parametrize(
        ("changes", "said"),
        [
            ({}, True),
            ({"a": "sigmoid(0, -5)"}, True),
            ({"a": "triangle(-inf, 0, 10)", "b": "bell(10, 0.1, 5)"}, True),
            ({"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)"}, False),
            ({"a": "z_shape(0, 10)", "b": "cosine(10, 20)"}, False),
            ({"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)", "weight": "weight 1e-6"}, True),
            ({"a": "triangle(-inf, 0, 10, height=1e-5)", "b": "triangle(0, 10, inf)"}, True),
        ],
    )
    def test_the_file_is_for_pyfuzzylite_only_where_small_activations_decide(self, changes, said):
        assert head(two(**changes)) == ("# numerics of pyfuzzylite" if said else "Engine: two")

    def test_a_system_of_fuzzylite_stays_one(self):
        text = write(two())[0].partition("\n")[2]
        system, diagnostics = read(SourceText("t.fll", text))
        assert system is not None, render_all(diagnostics)
        assert head(system) == "Engine: two"


class TestPlaces:
    @pytest.mark.parametrize(
        ("changes", "lost"),
        [
            ({"p": "ramp(2, 0)", "q": "ramp(2, 4)"}, []),
            ({"p": "ramp(2, 0)", "q": "ramp(2, 5)"}, ["places clamped"]),
            ({"p": "ramp(2, 0)", "q": "sigmoid(2, 5)"}, ["places clamped"]),
            ({"p": "ramp(2, 0, height=0.5)", "q": "ramp(2, 4)"}, ["places clamped"]),
        ],
    )
    def test_free_places_are_a_loss_only_where_one_may_leave_the_range(self, changes, lost):
        flat = {"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)"}
        _, losses = write(two(method="tsukamoto", **flat, **changes))
        assert [loss.what for loss in losses if not loss.exact] == lost

    def test_degrees_of_points_are_no_places(self):
        text = TWO.format(
            a="triangle(-inf, 0, 10)",
            b="triangle(0, 10, inf)",
            p="ramp(2, 1)",
            q="piecewise(2, 0, 4, 1)",
            method="tsukamoto",
        )
        _, losses = write(loads(text.replace("[0, 4]", "[1, 4]")))
        assert losses == []


def test_an_input_that_equals_a_number_is_a_triangle_without_sides():
    system = two(a="singleton(3)", b="ramp(0, 10)")
    text, losses = write(system)
    assert "  term: a Triangle 3 3 3\n" in text
    assert losses == []
    back, _ = read(SourceText("t.fll", text))
    for x in (2.9, 3.0, 3.1):
        assert back(x=x) == system(x=x)
