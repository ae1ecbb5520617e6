"""Plants for scipy's solvers."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError
from fuzzyctl.interop.plants import python_plant
from fuzzyctl.interop.scipy import rhs, start


def test_constant_inputs_give_the_step_response(small):
    (plant,) = small("tf(num=[2], den=[0.5, 1])").plants
    found = solve_ivp(rhs(plant, 3.0), (0, 2), start(plant), rtol=1e-10, atol=1e-12)
    derivative = rhs(plant, [3.0])
    assert derivative(0.0, found.y[:, -1]) == pytest.approx(np.zeros(1), abs=0.2)
    assert derivative(0.0, start(plant))[0] > 0.0


def test_a_law_in_continuous_time_is_a_function_of_time_and_states(tank):
    (plant,) = tank().plants
    found = solve_ivp(rhs(plant, lambda t, x: 20 * (1 - x[0])), (0, 10), start(plant), rtol=1e-10, atol=1e-12)
    # at rest the inflow is the outflow: b u = a sqrt(h)
    h = found.y[0, -1]
    assert 5 * 20 * (1 - h) == pytest.approx(2 * np.sqrt(h), rel=1e-6)


def test_the_shipped_pendulum_has_its_derivatives():
    plant = fuzzyctl.load("pendulum", block=fuzzyctl.Plant)
    x, u = np.array([0.1, -0.2, 0.3, 0.4]), 2.0
    found = rhs(plant, u)(0.0, x)
    pushed = (u + 0.1 * 0.5 * 0.4**2 * np.sin(0.3)) / 1.1
    turned = (9.81 * np.sin(0.3) - np.cos(0.3) * pushed) / (0.5 * (4 / 3 - 0.1 * np.cos(0.3) ** 2 / 1.1))
    expected = [-0.2, pushed - 0.1 * 0.5 * turned * np.cos(0.3) / 1.1, 0.4, turned]
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def test_arguments_of_another_shape_are_refused(small):
    (plant,) = small().plants
    with pytest.raises(ArgumentError, match=r"expected 1 input \(u\) of plant 'p', got 2"):
        rhs(plant, [1.0, 2.0])(0.0, start(plant))
    for inputs in (None, "a", lambda t, x: None):
        with pytest.raises(ArgumentError, match="expected numbers as states and inputs of plant 'p', got"):
            rhs(plant, inputs)(0.0, start(plant))
    with pytest.raises(ArgumentError, match="expected a Plant, got Loop"):
        rhs(small())


def test_nan_stays_nan(small):
    (plant,) = small().plants
    assert np.isnan(rhs(plant, float("nan"))(0.0, start(plant))).all()


def test_functions_with_mistakes_are_diagnostics():
    plant = python_plant("own", ["u"], {"x": 0.0}, ["y"], derivative=lambda t, x, u: 3, output=lambda t, x: x)
    with pytest.raises(DiagnosticError, match=r"'derivative' of plant 'own' returned 3 at t = 0\.5 s"):
        rhs(plant, 0.0)(0.5, np.zeros(1))
