"""Hedges with an infinite slope: what the rounding of degrees makes of a set, and the warning about it."""

import re

import pytest

import fuzzyctl

FLAT = ("sigmoid(0.3, 50)", "bell(0.4, 0.2, 3)")
ROUND = ("gaussian(0.4, 0.1)", "pi_shape(0.1, 0.3, 0.6, 0.8)")
STRAIGHT = ("triangle(0.2, 0.5, 0.7)", "trapezoid(0.2, 0.3, 0.5, 0.7)", "ramp(0, 1)")


def system(term, consequents, hedge="x", defuzzifier="centroid"):
    rules = "\n".join(f"if a is r then y is {c} t" for c in consequents)
    return fuzzyctl.loads(
        f"system s\ndefuzzifier {defuzzifier}\nimplication min\naggregation max\nhedge h(x) = {hedge}\n"
        f"input a in [0, 1]\n  r = ramp(0, 1)\noutput y in [0, 1] else 0\n  t = {term}\n{rules}\n"
    )


def reported(one):
    """Return the areas that FZ409 reports."""
    facts = [f for d in fuzzyctl.check(one)[1] if d.code == "FZ409" for f in d.facts]
    return [float(x) for f in facts for x in re.findall(r"by up to (\S+) of the range", f)]


@pytest.mark.parametrize("term", FLAT)
@pytest.mark.parametrize(
    ("consequent", "hedge"),
    [
        ("h", "4 * x * (1 - x)^0.5"),
        ("h", "1 - sqrt(1 - x)"),
        ("somewhat not", "x"),
        ("seldom", "x"),
        ("h not", "x^0.5"),
    ],
)
def test_infinite_slopes_where_a_term_is_flat_are_reported(term, consequent, hedge):
    (area,) = reported(system(term, [consequent], hedge))
    assert 1e-14 < area < 1e-8


@pytest.mark.parametrize("term", [*STRAIGHT, *ROUND])
@pytest.mark.parametrize("consequent", ["h", "somewhat not", "seldom"])
def test_infinite_slopes_where_a_term_is_not_flat_are_not(term, consequent):
    assert reported(system(term, [consequent], "4 * x * (1 - x)^0.5")) == []


@pytest.mark.parametrize("term", [*FLAT, *ROUND, *STRAIGHT])
@pytest.mark.parametrize("consequent", ["h", "very h", "somewhat", "not", "extremely", "slightly"])
def test_finite_slopes_and_roots_at_0_are_not(term, consequent):
    assert reported(system(term, [consequent], "abs(x - 0.29)")) == []


def test_the_consequent_is_named_and_sampled_sets_are_not_reported():
    (found,) = (d for d in fuzzyctl.check(system(FLAT[0], ["seldom"]))[1] if d.code == "FZ409")
    # The documentation shows this figure.
    assert found.facts == ("the rounding of degrees changes the area of 'seldom t' by up to 2.6e-10 of the range",)
    assert found.span.line == 10
    assert reported(system(FLAT[0], ["somewhat not"], defuzzifier="centroid(resolution=100)")) == []


def test_of_many_the_largest_are_named():
    consequents = [f"{'somewhat ' * k}not" for k in range(1, 9)]
    (found,) = (d for d in fuzzyctl.check(system(FLAT[1], consequents))[1] if d.code == "FZ409")
    areas = [float(f.split("by up to ")[1].split()[0]) for f in found.facts[:5]]
    assert areas == sorted(areas, reverse=True)
    assert found.facts[5:] == ("and that of 3 others",)
