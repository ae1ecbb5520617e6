"""The tanker's heading is that of Passino's program, written again with numpy alone."""

import math

import numpy as np
import pytest

from fuzzyctl import simulate
from gallery import pages
from tests import sizes

#: What the rules say along a diagonal of the table, from both errors at -1 to both at 1.
DIAGONAL = np.array([1, 1, 1, 1, 1, 1, 0.8, 0.6, 0.3, 0.1, 0, -0.1, -0.3, -0.6, -0.8, -1, -1, -1, -1, -1, -1])
RULES = np.array([DIAGONAL[k : k + 11] for k in range(11)])
CENTRES = np.linspace(-1, 1, 11)


def degrees(x):
    """Triangles around the centres, with shoulders at both ends."""
    return np.maximum(0, 1 - np.abs(np.clip(x, -1, 1) - CENTRES) / 0.2)


def rudder(e, c):
    weights = np.minimum.outer(degrees(2 / math.pi * e), degrees(250 * c))
    return 8 * math.pi / 18 * (weights * RULES).sum() / weights.sum()


def headings(samples, k_0, tau_10, tau_20, tau_30):
    time = 350 / 5
    gain, t1, t2, t3 = k_0 / time, tau_10 * time, tau_20 * time, tau_30 * time

    def derivative(x, delta):
        turned = x[2] + gain * t3 / (t1 * t2) * delta
        return np.array(
            [x[1], turned, -(1 / t1 + 1 / t2) * turned - (x[1] ** 3 + x[1]) / (t1 * t2) + gain / (t1 * t2) * delta]
        )

    x, before, found = np.zeros(3), 0.0, []
    for t in range(samples):
        found.append(x[0])
        if t % 10 == 0:
            wanted = math.pi / 4 if 100 <= t < 1500 or 3000 <= t < 4500 else 0.0
            error = wanted - x[0]
            delta = np.clip(rudder(error, (error - before) / 10), -80 * math.pi / 180, 80 * math.pi / 180)
            before = error
        k1 = derivative(x, delta)
        k2 = derivative(x + k1 / 2, delta)
        k3 = derivative(x + k2 / 2, delta)
        x = x + (k1 + 2 * k2 + 2 * k3 + derivative(x + k3, delta)) / 6
    return np.array(found)


@pytest.mark.parametrize(("loop", "ship"), [("calm", (5.88, -16.91, 0.45, 1.43)), ("full", (0.83, -2.88, 0.38, 1.07))])
def test_the_heading_is_that_of_the_program(loop, ship):
    (found,) = [found for found in pages.loops_of(pages.entries()["passino_tanker"]) if found.name == loop]
    samples = 6001 if sizes.LONG else 2001
    heading = simulate(found)["ship.heading"][:samples]
    assert heading == pytest.approx(headings(samples, *ship), abs=1e-9)
