"""Least and largest values and slopes, proved."""

from functools import cache

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.analysis.extremes import extents

PD = """
system pd
and {conjunction}
defuzzifier {defuzzifier}
input e in [-1, 1]
{terms}
input de in [-1, 1]
{terms}
output u in [-1, 1]
  terms N Z P
table u = e x de
     N  Z  P
 N | N  N  Z
 Z | N  P  P
 P | Z  P  P
"""
LINES = "  terms N Z P"
CURVES = "  N = gaussian(-1, 0.4)\n  Z = gaussian(0, 0.4)\n  P = gaussian(1, 0.4)"
SHIFTED = "  N = trapezoid(-inf, -1, -0.5, 0.5)\n  Z = triangle(-1, 0, 1)\n  P = trapezoid(-0.2, 0.5, 1, inf)"


def pd(conjunction="product", defuzzifier="center_average", terms=LINES):
    return loads(PD.format(conjunction=conjunction, defuzzifier=defuzzifier, terms=terms))


SYSTEMS = {
    "lines": pd(),
    "quotient": pd(terms=SHIFTED),
    "curves": pd(terms=CURVES),
    "minimum": pd("min"),
    "centroid": pd("min", "centroid"),
    "sampled": pd("min", "centroid(resolution=40)"),
}


@cache
def extent_of(name):
    (extent,) = extents(SYSTEMS[name], timeout=0.3)
    return extent


@pytest.fixture(scope="module", params=SYSTEMS)
def case(request):
    system, extent = SYSTEMS[request.param], extent_of(request.param)
    axis = np.linspace(-1, 1, 201)
    return extent, system, system(e=axis[:, None], de=axis)


def test_no_sample_lies_outside(case):
    extent, _, samples = case
    assert extent.lo <= samples.min()
    assert samples.max() <= extent.hi


def test_bounds_come_near_attained_values(case):
    extent, system, samples = case
    assert samples.min() - extent.lo <= 0.021
    assert extent.hi - samples.max() <= 0.021
    assert system(**extent.lo_at) == extent.lo_found
    assert system(**extent.hi_at) == extent.hi_found
    assert extent.lo_found - extent.lo <= 0.021
    assert extent.hi - extent.hi_found <= 0.021


def test_no_two_samples_are_steeper(case):
    extent, _, samples = case
    step = 0.01
    assert np.abs(np.diff(samples, axis=0)).max() / step <= extent.steepness["e"] * (1 + 1e-9)
    assert np.abs(np.diff(samples, axis=1)).max() / step <= extent.steepness["de"] * (1 + 1e-9)


def test_slopes_of_lines_and_curves_come_near_those_of_samples():
    for name in ("lines", "curves"):
        axis = np.linspace(-1, 1, 401)
        samples = SYSTEMS[name](e=axis[:, None], de=axis)
        steepest = np.abs(np.diff(samples, axis=0)).max() / 0.005
        assert extent_of(name).steepness["e"] == pytest.approx(steepest, rel=0.07)


def test_of_a_piecewise_linear_system_the_bound_is_attained():
    (extent,) = extents(SYSTEMS["quotient"])
    assert extent.lo_found - extent.lo <= 1e-12
    assert extent.hi - extent.hi_found <= 1e-12


@pytest.mark.parametrize("name", ["curves", "minimum", "centroid"])
def test_bounds_and_slopes_do_not_depend_on_a_clock(name, monkeypatch):
    monkeypatch.setattr("fuzzyctl.analysis.work.clock.now", lambda: pytest.fail("the time is read"))
    (first,), (second,) = (extents(SYSTEMS[name], timeout=0.05) for _ in range(2))
    assert first == second


def test_more_time_gives_tighter_slopes():
    short, long = (extents(SYSTEMS["curves"], timeout=t)[0].steepness["e"] for t in (0.05, 1.0))
    assert long < short < np.inf
