"""Measures beside closed forms of step responses, and of signals whose integrals are known."""

import math

import pytest

from fuzzyctl import Experiment

#: y'' + 2 zeta w y' + w^2 y = w^2, at rest at first.
ZETA, W = 0.4, 1.5
DAMPED = W * math.sqrt(1 - ZETA**2)
OVERSHOOT = math.exp(-math.pi * ZETA / math.sqrt(1 - ZETA**2))


def damped(t):
    return f"(1 - exp(-{ZETA * W} * ({t})) * (cos({DAMPED} * ({t})) + {ZETA * W / DAMPED} * sin({DAMPED} * ({t}))))"


LOOP = f"""plant p
input u
output y = u
loop l
block p = p(0)
let s = {damped("t")}
let again = where(t < 20, s, 1 + {damped("t - 20")})
let two = where(t < 20, 1, 2)
let lag = 1 - exp(-t / 2)
let wave = sin(2 * pi * t)
let late = where(t < 38, 0, 0.9)
let one = 1 + 0 * t
run 40 s step 2 ms
"""
#: Measure, value, relative tolerance.
TABLE = [
    ("overshoot(s, one)", OVERSHOOT, 1e-5),
    ("overshoot(3 - 2 * s, one)", OVERSHOOT, 1e-5),
    ("overshoot(again, two, begin=20 s)", OVERSHOOT, 1e-5),
    ("overshoot(again, two, end=19.99 s)", OVERSHOOT, 1e-5),
    ("rise_time(lag, one)", 2 * math.log(9), 1e-5),
    ("rise_time(lag, one, low=0, high=0.5)", 2 * math.log(2), 1e-5),
    ("rise_time(0.5 * s, one)", math.inf, 0),
    ("settling(lag, one)", 2 * math.log(50), 1e-5),
    ("settling(lag, one, band=0.1)", 2 * math.log(10), 1e-5),
    ("settling(0.5 * s, one)", math.inf, 0),
    ("settling(lag, one, band=2)", 0, 0),
    ("settling(where(t > 0, 1, 0.999), one)", 0.002, 0.05),
    ("iae(lag, one)", 2, 1e-5),
    ("ise(lag, one)", 1, 1e-5),
    ("itae(lag, one)", 4, 1e-5),
    ("itae(where(t < 10, 0, lag), one, begin=10 s)", 4 * math.exp(-5), 1e-3),
    ("integral(t)", 800, 1e-9),
    ("effort(2 * wave)", 80, 1e-5),
    ("rms(2 * wave)", math.sqrt(2), 1e-5),
    ("mean(3 + wave)", 3, 1e-5),
    ("mean(t, begin=10 s, end=20 s)", 15, 1e-9),
    ("final(t)", 40, 1e-12),
    ("maximum(s)", 1 + OVERSHOOT, 1e-5),
    ("minimum(s)", 0, 0),
    ("maximum(t, end=0.3 s)", 0.3, 1e-12),
    ("minimum(t, begin=0.7 s)", 0.7, 1e-12),
    ("steady_state_error(late, one)", 0.1, 1e-9),
    ("steady_state_error(late, one, end=37 s)", 1, 1e-9),
    ("overshoot(one, one)", math.nan, 0),
    ("rise_time(one, one)", math.nan, 0),
    ("settling(one, one)", math.nan, 0),
    ("iae(s, one, begin=50 s)", math.nan, 0),
]


def test_values_are_those_of_closed_forms(loop):
    lines = "".join(f"measure m{k} = {formula}\n" for k, (formula, *_) in enumerate(TABLE))
    lines += "measure entry = settling(s, one)\nmeasure second = settling(again, two, begin=20 s)\n"
    run = Experiment(loop(f"{LOOP}{lines}allow FZ214\n"), "python").run()
    for k, (formula, expected, relative) in enumerate(TABLE):
        assert run.measures[f"m{k}"] == pytest.approx(expected, rel=relative, abs=1e-12, nan_ok=True), formula
    outside = run.t[abs(run["s"] - 1) > 0.02][-1]
    assert outside <= run.measures["entry"] <= outside + 0.0021
    assert run.measures["second"] == pytest.approx(run.measures["entry"], abs=4e-3)


def test_coarse_samples_are_joined_by_straight_lines(loop):
    text = LOOP.replace("step 2 ms", "step 1 s").replace("run 40", "run 3")
    text += "measure rise = rise_time(min(t / 2, 1), one)\nmeasure band = settling(min(t / 2, 1), one, band=0.1)\n"
    measures = Experiment(loop(text), "python").run().measures
    assert measures == {"rise": pytest.approx(1.6), "band": pytest.approx(1.8)}
