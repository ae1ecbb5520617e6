"""A fuzzy PID that is linear is a PID: both on 1/((s + 1)(s + 3)(s + 5)), sampled at 0.1 s."""

import numpy as np
import pytest
from scipy.linalg import expm

from fuzzyctl import Experiment

#: The surface is (x + y) / 2 on [-1, 1]^2, exactly: product, centre average, equidistant singletons.
TEXT = """
system plane
and product
defuzzifier center_average
input a in [-1, 1]
  terms N Z P
input b in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms NB@-1 NS@-0.5 ZE@0 PS@0.5 PB@1
table u = a x b
      N  Z  P
  N | NB NS ZE
  Z | NS ZE PS
  P | ZE PS PB

controller fuzzy "Fuzzy PD and fuzzy PI in parallel"
input r
input y
param Kp = 12
param Ki = 9
param Kd = 3
param scale = 40
let e = r - y
let pd = plane(e * Kp / scale, derivative(e) * Kd / scale)
let pi_part = plane(integral(e) * Ki / scale, 0)
output u = 2 * scale * (pd + pi_part)
every 0.1 s

controller crisp
input r
input y
param Kp = 12
param Ki = 9
param Kd = 3
let e = r - y
output u = Kp * e + Ki * integral(e) + Kd * derivative(e)
every 0.1 s

plant third = tf(num=[1], den=[1, 9, 23, 15])

loop l
block fuzzy = fuzzy(r, a.y)
block a = third(fuzzy.u)
block crisp = crisp(r, b.y)
block b = third(crisp.u)
let r = steps(0: 1, 8 s: 0.4)
run 15 s
"""


@pytest.mark.parametrize("backend", ["python", "numba"])
def test_a_linear_fuzzy_pid_is_a_pid(loop, backend):
    run = Experiment(loop(TEXT), backend).run()
    assert np.abs(run["fuzzy.u"] - run["crisp.u"]).max() < 1e-12 * np.abs(run["crisp.u"]).max()
    assert np.abs(run["a.y"] - run["b.y"]).max() < 1e-12


def test_the_loop_is_that_of_the_exactly_discretised_plant(loop):
    a = np.array([[-9.0, -23.0, -15.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    whole = expm(0.1 * np.block([[a, np.array([[1.0], [0.0], [0.0]])], [np.zeros((1, 4))]]))
    x, total, before, outputs = np.zeros(3), 0.0, None, []
    for k in range(151):
        e = (1.0 if k < 80 else 0.4) - x[2]
        u = 12 * e + 9 * total + 3 * (0.0 if before is None else e - before) / 0.1
        outputs.append(x[2])
        x, total, before = whole[:3, :3] @ x + whole[:3, 3] * u, total + 0.1 * e, e
    run = Experiment(loop(TEXT), "numba").run(substeps=64)
    assert run["a.y"] == pytest.approx(outputs, abs=1e-9)
