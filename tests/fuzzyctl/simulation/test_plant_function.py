"""A plant as functions: what a loop integrates."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError
from fuzzyctl.simulation.plant_function import PlantFunction

LOOP = """
plant p
input u
param k = 2
state x = 0.5
state v = 0.1
der x = v
der v = u - k * sin(x) - 0.3 * v + 0.1 * t
output y = x + t
output both = v * x

loop l
block p = p(sine(0.5, amplitude=3))
measure m = final(p.y)
run 5 s step 20 ms
"""


@pytest.mark.parametrize("substeps", [1, 3])
def test_steps_with_held_inputs_are_those_of_a_loop(loop, substeps):
    held = loop(LOOP.replace("sine(0.5, amplitude=3)", "1.5"))
    run = fuzzyctl.Experiment(held, "python").run(substeps=substeps)
    plant = PlantFunction(held.plants[0])
    x = np.array(plant.start)
    for k, t in enumerate(run.t):
        y, both = plant.output(t, x, [1.5])
        assert (y, both) == pytest.approx((run["p.y"][k], run["p.both"][k]), abs=1e-12)
        x = plant.advanced(t, x, [1.5], 0.02, substeps)


def test_counts_are_checked(loop):
    plant = PlantFunction(loop(LOOP).plants[0])
    with pytest.raises(ArgumentError, match=r"expected 2 states \(x, v\)"):
        plant.derivative(0.0, [1.0], [1.0])
