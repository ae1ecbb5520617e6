"""The five places of the method of Runge and Kutta: loops, plants as functions and as equations, FMUs, robots."""

import numpy as np
import pytest

import fuzzyctl
from dwmr.plant.disturbances import disturbance
from dwmr.plant.robot import State, advance, body, derivative
from fuzzyctl.interop.control import nlsys, start
from fuzzyctl.testing import run_command
from tests.dwmr.plant.test_robot import CALM, NO_LOAD, robot
from tests.fuzzyctl.codegen.fmu.fmus import Built

PLANT = """plant p
input v
state x = 0.3
state w = -1.7
der x = w - 0.37 * x * x
der w = 1.9 * sin(3 * x) - 0.11 * w + v
output y = x
output z = w
"""
LOOP = PLANT + "loop l\nblock p = p(0.7)\nrun 1 s step 125 ms\n"


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    path = tmp_path_factory.mktemp("rk4") / "loop.fz"
    path.write_text(LOOP)
    return fuzzyctl.load(path, block=fuzzyctl.Loop)


@pytest.fixture(scope="module")
def states(loop):
    """The states at the samples of a run, shape (samples, states)."""
    found = [fuzzyctl.simulate(loop, backend=b, substeps=3) for b in ("python", "numba")]
    python, numba = (np.column_stack([run["p.y"], run["p.z"]]) for run in found)
    assert python.tobytes() == numba.tobytes()
    return python


def test_a_plant_as_a_difference_equation(states, tmp_path):
    (tmp_path / "p.fz").write_text(PLANT)
    options = ("--target", "python", "--step", 0.125, "--substeps", 3)
    assert run_command("codegen", "p.fz", *options, folder=tmp_path).exit_code == 0
    names = {"__name__": "generated"}
    exec((tmp_path / "p.py").read_text(), names)
    state = names["start"]()
    for k, expected in enumerate(states):
        found, state = names["step"](0.7, state)
        assert found == tuple(expected), k


def test_a_plant_as_a_function(loop, states):
    (plant,) = loop.plants
    system, x = nlsys(plant, dt=0.125, substeps=3), start(plant)
    for k, expected in enumerate(states):
        assert tuple(x) == tuple(expected), k
        x = system.dynamics(k * 0.125, x, [0.7])


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu(states, version, tmp_path):
    instance = Built(PLANT, version, tmp_path / "fmu").instance(integration_step=0.125 / 3)
    for k, expected in enumerate(states[1:], 1):
        assert tuple(instance.step(0.125, v=0.7)) == tuple(expected), k


#: Divisors of the weights, and times of the stages.
STAGES = ((6, 0.0), (3, 0.5), (3, 0.5), (6, 1.0))


def test_a_robot():
    """The stages, made with the robot's own derivative, are its step."""
    one, h = robot(coulomb_force=6.0, viscous_force=5.0), 0.005 / 3
    found = now = State(0.0, 0.0, 0.3, 0.5, 0.4, 2.0, 1.0)
    shape, calm = body(0.0, one, NO_LOAD), disturbance(0.0, CALM)
    for _ in range(3):
        following, at = np.array(now), np.array(now)
        for k, (divisor, _) in enumerate(STAGES):
            rate = np.array(derivative(State(*at), 5.0, 4.0, one, shape, calm))
            following = following + h / divisor * rate
            at = np.array(now) + STAGES[min(k + 1, 3)][1] * h * rate
        now = State(*following)
    assert tuple(advance(0.0, found, 5.0, 4.0, one, CALM, NO_LOAD, 0.005, 3)) == tuple(now)
