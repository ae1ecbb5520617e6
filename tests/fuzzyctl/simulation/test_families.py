"""Families of loops: claims about every instant on a run, starts and disturbances as numbers that can be set."""

import numpy as np
import pytest

from fuzzyctl import ArgumentError, DiagnosticError, Experiment, UnknownNameError, dumps, loads, simulate

TEXT = """
controller law
input y
param k = 2
state s = 0
next s = s + 1
output v = where(s > 100, 0, -k * y)
every 0.5 s
plant tank
input v
param A in (0, 50] = 4
state h in [-10, 10] = 1
der h = v / A
output y = h
loop l
param goal = 0.5
block law = law(tank.y)
block tank = tank(law.v + leak)
for tank.h in [0.5, 2]
for tank.A in [2, 8]
for law.s in [0, 5]
for goal in [0.25, 1]
disturbance leak "a leak" in [0, goal] unit "V" = 0
{lines}
run 4 s step 0.5 s
"""


@pytest.fixture
def family(loop):
    return lambda lines="": loop(TEXT.format(lines=lines))


def test_a_family_is_written_as_it_is_read(family):
    claims = ("always tank.h <= 1 within 0.1 from 1 s until 2 s", "always leak < 1 forever", "stable")
    one = family("\n".join(f"require {claim}" for claim in claims))
    assert list(one.family) == ["tank.h", "tank.A", "law.s", "goal", "leak"]
    assert [type(g).__name__ for g in one.guarantees] == ["Always", "Always", "Stable"]
    assert one.requirements == ()
    assert loads(dumps(one), block="l") == one


@pytest.mark.parametrize(
    ("claim", "verdict", "facts"),
    [
        ("tank.h <= 1", "kept by this run", ()),
        ("tank.h < 1", "broken", ("at t = 0 s", "tank.h = 1")),
        ("tank.h < 1 within 1e-9", "kept by this run", ()),
        ("tank.h < 1 from 0.5 s", "kept by this run", ()),
        ("tank.h > 0.5 until 1 s", "kept by this run", ()),
        ("tank.h > goal", "broken", ("at t = 1.5 s", "tank.h = 0.421875")),
        ("not (tank.h < 0.5 or tank.v > 0)", "broken", ("at t = 1.5 s", "tank.h = 0.421875", "tank.v = -0.84375")),
        ("tank.y == tank.h and leak != 1", "kept by this run", ()),
        ("sqrt(tank.h - 0.9) >= 0", "broken", ("at t = 0.5 s", "sqrt(tank.h - 0.9) = nan")),
        ("law.s <= 3 until 1.5 s", "kept by this run", ()),
        ("tank.h <= 1 forever", "kept by this run", ()),
    ],
)
def test_claims_about_every_instant_are_judged_at_samples(family, claim, verdict, facts):
    run = simulate(family(f"require always {claim}"), backend="python")
    (one,) = run.requirements
    assert (one.text, one.verdict, one.facts) == (f"always {claim}", verdict, facts)
    assert run.passed == (verdict != "broken")


def test_a_stopped_run_keeps_no_claim(loop):
    text = TEXT.format(lines="require always tank.h <= 20\nrequire always tank.h <= 5").replace("-k * y", "k * y")
    run = simulate(loop(text.replace("run 4 s", "run 9 s")), backend="python")
    assert run.stopped is not None
    assert [r.verdict for r in run.requirements] == ["open, the run was stopped", "broken"]


def test_a_disturbance_is_a_recorded_signal_with_its_nominal_value(family):
    experiment = Experiment(family(), "python")
    assert experiment.equations.disturbances == {"leak": (0.0, 0.5, 0.0)}
    assert np.all(experiment.run()["leak"] == 0.0)


NAMES = ("tank.h", "leak", "tank.A", "law.s")


@pytest.mark.parametrize("backend", ["python", "numba"])
def test_starts_and_disturbances_are_free_numbers(family, backend):
    one, values = family("require always tank.h >= goal"), (2.0, 0.25, 8.0, 5.0)
    free = Experiment(one, backend, free=NAMES)
    run = free.run(values)
    same = simulate(one, backend="python", **dict(zip(NAMES, values, strict=True)))
    assert run.params == dict(zip(NAMES, values, strict=True))
    for name in ("tank.h", "leak", "law.s", "law.v"):
        np.testing.assert_allclose(run[name], same[name], rtol=1e-12)
    assert (run["tank.h"][0], run["law.s"][0], run["leak"][-1]) == (2.0, 5.0, 0.25)
    np.testing.assert_allclose(free.run()["tank.h"], simulate(one, backend="python")["tank.h"], rtol=1e-12)


def test_instances_of_one_plant_have_starts_of_their_own(loop):
    plant = "plant p\ninput u\nstate x = 1\nder x = u\noutput y = x\n"
    two = loop(plant + "loop l\nblock a = p(0)\nblock b = p(0)\nrun 1 s step 1 s\n")
    run = simulate(two, backend="python", **{"b.x": 3.0})
    assert (run["a.x"][0], run["b.x"][0]) == (1.0, 3.0)


def test_numbers_outside_of_their_ranges_are_refused(family):
    with pytest.raises(DiagnosticError, match=r"start of state 'tank\.h' is 11"):
        simulate(family(), **{"tank.h": 11.0})
    with pytest.raises(DiagnosticError, match="disturbance 'leak' is 2"):
        simulate(family(), leak=2.0)
    with pytest.raises(UnknownNameError):
        simulate(family(), **{"tank.y": 1.0})
    with pytest.raises(ArgumentError, match="'goal' cannot be free"):
        Experiment(family(), free=("goal",))  # the range of the leak depends on it
