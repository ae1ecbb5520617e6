"""Blocks with other values of free numbers compute what their kernels with free numbers do, and are written."""

import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError, UnknownNameError, ValueOutOfBoundsError

SYSTEM = """system s
defuzzifier weighted_average
param k in (0, 4] = 2
param twice = 2 * k
input x in [0, 1]
  terms low middle high
output y in [-9, 9]
  a = linear(1, k)
  b = constant(twice)
table y = x
    low middle high
  | a   b      a
"""
CONTROLLER = """controller inner
param gain in [0, 10] = 1
input e
output u = gain * e
every 10 ms

controller c
param p in [-1, 1] = 0.5
input e in [0, 1]
block first = inner(e)
output u = s(e) + p + first.u
every 10 ms
"""
POINTS = np.linspace(0, 1, 23)


@pytest.fixture
def controller(tmp_path):
    path = tmp_path / "c.fz"
    path.write_text(SYSTEM + "\n" + CONTROLLER)
    return fuzzyctl.load(path, block="c")


VALUES = {"k": 3.0, "x.middle.peak": 0.3, "y.a.x": -1.5, "y.weights": [0.25, 1.0, 0.5]}


def test_a_system_computes_what_its_kernel_with_free_numbers_does():
    system = fuzzyctl.loads(SYSTEM)
    kernel = fuzzyctl.compile(system, "python", free=list(VALUES))
    expected = kernel.batch(POINTS, VALUES)
    changed = system.with_values(VALUES)
    for same in (changed, fuzzyctl.loads(fuzzyctl.dumps(changed)), system.with_values(named(kernel, VALUES))):
        np.testing.assert_allclose(fuzzyctl.compile(same, "python").batch(POINTS), expected, rtol=1e-12)
    assert "param k in (0, 4] = 3" in fuzzyctl.dumps(changed)


def named(kernel, values):
    return dict(zip(kernel.free_names, kernel.start(values), strict=True))


def test_ranges_are_those_that_params_declare(controller):
    kernel = fuzzyctl.compile(fuzzyctl.loads(SYSTEM), free=["y.a.constant", "k"])
    assert kernel.free_bounds.tolist() == [[-math.inf, math.inf], [0, 4]]
    step = fuzzyctl.compile(controller, free=["p", "s.k", "first.gain", "s.x.middle.peak"])
    assert step.free_bounds.tolist() == [[-1, 1], [0, 4], [0, 10], [-math.inf, math.inf]]
    assert fuzzyctl.compile(controller).free_bounds.shape == (0, 2)


def test_a_controller_computes_what_its_kernel_with_free_numbers_does(controller, tmp_path):
    values = {"p": -0.25, "first.gain": 7.0, "s.k": 1.0, "s.x.middle.peak": 0.6}
    step = fuzzyctl.compile(controller, "python", free=list(values))
    expected, _ = step.run(POINTS, step.start(values))
    changed = controller.with_values(values)
    fuzzyctl.dump(changed, tmp_path / "again.fz")
    for same in (changed, fuzzyctl.load(tmp_path / "again.fz", block="c")):
        np.testing.assert_allclose(fuzzyctl.compile(same, "python").run(POINTS)[0], expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"kk": 1.0}, UnknownNameError),
        ({"x.middle.peek": 1.0}, UnknownNameError),
        ({"x.middle.peak": math.nan}, ValueOutOfBoundsError),
        ({"x.middle.peak": "1"}, ValueOutOfBoundsError),
        ({"x.middle.peak": None}, ArgumentError),
        ({"k": 5.0}, DiagnosticError),
        ({"x.middle.peak": 2.0}, DiagnosticError),
        ({"y.weights": [1.0, 2.0]}, ArgumentError),
    ],
)
def test_what_a_system_cannot_have_is_refused(values, error):
    with pytest.raises(error):
        fuzzyctl.loads(SYSTEM).with_values(values)


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"q": 1.0}, UnknownNameError),
        ({"first.q": 1.0}, UnknownNameError),
        ({"s.q": 1.0}, UnknownNameError),
        ({"first.gain": math.inf}, ValueOutOfBoundsError),
        ({"first.gain": 11.0}, DiagnosticError),
        ({"p": 2.0}, DiagnosticError),
    ],
)
def test_what_a_controller_cannot_have_is_refused(controller, values, error):
    with pytest.raises(error):
        controller.with_values(values)
