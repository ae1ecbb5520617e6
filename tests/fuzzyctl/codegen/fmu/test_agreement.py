"""FMUs in FMPy compute what the kernel computes."""

import math

import numpy as np
import pytest

import fuzzyctl
from tests.fuzzyctl.codegen.conftest import averaged, text
from tests.fuzzyctl.codegen.steps.targets import by_kernel, unit_of
from tests.fuzzyctl.codegen.steps.texts import ADAPTIVE, TEXTS

TANK = """plant p "Tank"
input v in [0, 10] unit "V"
param A in (0, 100] = 20
param start = 0.5
state h "level" in [0, inf) unit "m" = start
state w = 0
der h = (5 * v - 2 * sqrt(max(h, 0))) / A
der w = sin(2 * t) - w + h
output y "level" unit "m" = h
output sum = h + 2 * w + 0.1 * v
"""


def rows(unit, count, seed=1):
    rng = np.random.default_rng(seed)
    found = rng.uniform(-2, 2, (count, len(unit.arguments)))
    if unit.equations.period is None:
        found[:, -1] = rng.choice([0.05, 0.02], count)
    return found


@pytest.mark.parametrize("version", [2, 3])
def test_a_system_agrees_over_2_000_steps(built, version):
    own = text("plain")
    drawn = np.random.default_rng(2).uniform([-1, -1.2], [11, 1.2], (2_000, 2))
    found = built(own, version).instance().steps(drawn, 0.01)
    expected = fuzzyctl.compile(fuzzyctl.loads(own)).batch(drawn)
    assert np.max(np.abs(found[:, 0] - expected)) <= 1e-12 * 20


@pytest.mark.parametrize("version", [2, 3])
def test_two_instances_of_a_controller_agree_over_2_000_steps_each(built, version):
    unit = unit_of(TEXTS["pid"])
    made = built(TEXTS["pid"], version)
    first, second = rows(unit, 2_000), rows(unit, 2_000, seed=5)
    a, b = made.instance(), made.instance()
    found = [(a.step(0.05, r=x[0], y=x[1]), b.step(0.05, r=y[0], y=y[1])) for x, y in zip(first, second, strict=True)]
    for k, drawn in enumerate((first, second)):
        expected = by_kernel(TEXTS["pid"], drawn)
        assert np.max(np.abs([pair[k] for pair in found] - expected)) <= 1e-12 * np.max(np.abs(expected))


#: Controllers of kinds that FMUs treat apart; the others compute the same in C, which other tests compare.
APART = {"operators", "clock", "refusing", "partial", "holding"}


@pytest.mark.parametrize("name", [n if n in APART else pytest.param(n, marks=pytest.mark.long) for n in TEXTS])
def test_controllers_of_all_kinds_agree(built, name):
    unit = unit_of(TEXTS[name])
    drawn = rows(unit, 150)
    if name == "refusing":
        drawn = np.where(np.abs(drawn) < 0.6, 1.0, drawn)
    made = built(TEXTS[name], 2 + len(name) % 2)
    found = made.instance().steps(drawn, unit.equations.period)
    expected = by_kernel(TEXTS[name], drawn)
    scale = np.nanmax(np.abs(expected), axis=0)
    assert np.array_equal(np.isnan(found), np.isnan(expected))
    assert np.nanmax(np.abs(found - expected) / scale, initial=0.0) <= 1e-12


def test_params_that_are_set_are_those_of_the_kernel(built):
    made = built(TEXTS["pid"])
    drawn = rows(unit_of(TEXTS["pid"]), 300)
    found = made.instance(GE=2.5).steps(drawn, 0.05)
    expected = by_kernel(TEXTS["pid"].replace("GE in (0, 10] = 0.7", "GE in (0, 10] = 2.5"), drawn)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
    instance = made.instance()
    instance.steps(drawn[:150], 0.05)
    instance.set(GE=2.5)
    assert instance.get("GE") == [2.5]
    assert not np.allclose(instance.steps(drawn[150:], 0.05), by_kernel(TEXTS["pid"], drawn)[150:])


def test_single_precision_is_that_of_the_c(built):
    drawn = rows(unit_of(TEXTS["pid"]), 200)
    found = built(TEXTS["pid"], 3, "--float", "float").instance().steps(drawn, 0.05)
    assert found == pytest.approx(by_kernel(TEXTS["pid"], drawn), abs=1e-4)
    assert np.array_equal(found, found.astype(np.float32))


def test_outputs_that_hold_keep_their_values(built):
    own = averaged("holding", otherwise=" else hold(1)", rules="if x is low and y is down then u is a")
    points = [[1.0, -0.8], [9.0, 0.9], [3.0, -0.5], [8.0, 0.9]]
    found = built(own).instance().steps(np.array(points), 0.1)
    kernel = fuzzyctl.compile(fuzzyctl.loads(own))
    state, expected = kernel.start(), []
    for point in points:
        state[0] = kernel(*point, state)
        expected.append([*state])
    assert found == pytest.approx(np.array(expected), abs=1e-12)
    assert found[0] == found[1]


def test_adaptive_consequents_take_one_euler_step_for_each_communication_step(built):
    drawn = np.random.default_rng(3).uniform(-2, 2, (200, 2))
    found = built(ADAPTIVE).instance().steps(drawn, 0.02)
    kernel = fuzzyctl.compile(fuzzyctl.loads(ADAPTIVE))
    state, expected = kernel.start(), []
    rates = np.empty_like(state)
    for s, e in drawn:
        expected.append([kernel(s, e, state)])
        kernel.jit_rates(s, e, state, rates)
        state = np.clip(state + 0.02 * rates, -0.5, 0.5)
    assert found == pytest.approx(np.array(expected), abs=1e-12)


@pytest.mark.parametrize("version", [2, 3])
def test_a_plant_is_integrated_as_a_loop_integrates_it(built, version, tmp_path):
    loop = f"{TANK}loop l\nblock p = p(v = 2 + steps(0: 1, 0.5 s: 4))\nrun 2 s step 50 ms\n"
    (tmp_path / "l.fz").write_text(loop, encoding="utf-8")
    run = fuzzyctl.simulate(fuzzyctl.load(tmp_path / "l.fz", block=fuzzyctl.Loop), substeps=50)
    instance = built(TANK, version).instance(v=3.0)
    found = [instance.get("y", "sum")]
    found += [instance.step(0.05, v=2.0 + (1.0 if t < 0.5 - 1e-9 else 4.0)) for t in run.t[:-1]]
    expected = np.column_stack([run["p.h"], run["p.h"] + 2 * run["p.w"]])
    found = np.array(found) - np.array([0, 0.1]) * np.concatenate([run["p.v"][:1], run["p.v"][:-1]])[:, None]
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_the_step_of_integration_of_a_plant_is_a_parameter(built):
    made = built(TANK)
    coarse, fine = made.instance(integration_step=0.5), made.instance()
    errors = abs(np.array(coarse.step(0.5, v=9.0)) - np.array(fine.step(0.5, v=9.0)))
    assert 1e-9 < max(errors) < 1e-2
    assert math.isclose(coarse.get("A")[0], 20)
