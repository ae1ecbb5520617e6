"""Conditions with a name: where they are conditions, where they are numbers, and what is neither."""

import numpy as np
import pytest

import fuzzyctl

HEAD = """function inside(a) = a in [0, 1)
function deep(a) = not inside(a) or a > 2
controller inner
input x
output alarm = inside(x)
output same = alarm
controller c
input x in [-3, 3]
block b = inner(x)
let near = x > -1 and x < 0.5
let far = not near
let held = hysteresis(x, -1, 1)
state s = 0
next s = where(held, s, 1)
every 10 ms
"""
#: A condition over names, and the same one written out.
CONDITIONS = {
    "near": "x > -1 and x < 0.5",
    "far and x > 0": "not (x > -1 and x < 0.5) and x > 0",
    "inside(x)": "x >= 0 and x < 1",
    "deep(x) or near": "not (x >= 0 and x < 1) or x > 2 or x > -1 and x < 0.5",
    "held": "hysteresis(x, -1, 1) > 0",
    "hysteresis(x, -1, 1) and far": "held > 0 and not (x > -1 and x < 0.5)",
    "b.alarm or not b.same": "b.alarm > 0 or not b.same > 0",
    "lt(x, 0.5)": "x < 0.5",
    "x in (-1, 0.5]": "x > -1 and x <= 0.5",
}


def step_of(text, backend):
    return fuzzyctl.compile(fuzzyctl.loads(text, block="c"), backend)


@pytest.mark.parametrize("named", CONDITIONS)
@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_a_name_is_the_condition_written_out(named, backend):
    rows = np.linspace(-3, 3, 61)[:, None]
    line = "output y = where({}, x, -2 * x) + integral(x, hold={})\n"
    steps = [step_of(HEAD + line.format(c, c), backend) for c in (named, CONDITIONS[named])]
    (found, state), (expected, same) = (step.run(rows) for step in steps)
    assert np.array_equal(found, expected)
    assert np.array_equal(state, same)
    slopes = [step.gradient(rows, step.start(), by="all") for step in steps]
    for a, b in zip(*slopes, strict=True):
        assert np.array_equal(a, b)


def test_a_condition_with_a_name_is_a_number_as_well():
    step = step_of(HEAD + "output y = 2 * near + inside(x) - b.alarm + min(held, 0.5)\n", "python")
    assert step(0.25, step.start())[0] == 2.0


SYSTEM = """function inside(a) = a > -0.5 and a < 0.5
system s
defuzzifier center_average
input e in [-1, 1]
  terms N Z P
let near = inside(e)
let far = not near and lt(-1, e)
output alarm in [0, 1] = far or near
output u in [-1, 1]
  terms N Z P
table u = e
   N Z P
 | N Z P
"""


@pytest.mark.parametrize(
    ("claim", "verdict"),
    [
        ("abs(u) <= 0.5 when near", "Proved"),
        ("abs(u) <= 0.49 when near", "Refuted"),
        ("u in [-1, 1]", "Proved"),
        ("u > 0.4 or near or e <= -0.5", "Proved"),
        ("u >= 0 when far and e > 0", "Proved"),
        ("not alarm or u >= -1", "Proved"),
    ],
)
def test_claims_about_systems_name_conditions(claim, verdict):
    claim = " within 1e-9 when".join(claim.split(" when"))
    (found,) = fuzzyctl.prove(fuzzyctl.loads(SYSTEM + f"require {claim}\n"))
    assert type(found).__name__ == verdict


def test_systems_whose_claims_name_conditions_are_read_back():
    system = fuzzyctl.loads(SYSTEM + "require abs(u) <= 0.5 when near\nrequire far or near or alarm\nallow FZ214\n")
    assert fuzzyctl.loads(fuzzyctl.dumps(system)) == system


LOOP = """plant p
input u
state h = 0
let high = h > 0.5
der h = where(high, 0, u)
output y = h
output full = high
loop l
block p = p(where(on, 1, 0))
let on = pulse(0 s, 1 s)
let wait = not on and p.full
measure top = maximum(p.y)
measure fine = top in [0.4, 0.6] and not late
measure late = final(wait) < 0.5
run 2 s step 10 ms
require fine and not late
"""


def test_loops_plants_and_measures_have_conditions():
    run = fuzzyctl.simulate(fuzzyctl.loads(LOOP, block="l"))
    assert run.measures["fine"] == 1.0
    assert run.measures["late"] == 0.0
    assert [r.holds for r in run.requirements] == [True]
