"""Sets of loops hold the runs of their members, for the values of what varies and in all their states."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzzyctl import Experiment, load, loads
from fuzzyctl.analysis.reach.forms import DomainError, ends
from fuzzyctl.analysis.reach.prover import LoopProver
from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.expr import Number
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.members import members
from tests.fuzzyctl.analysis.reach.loops import DISTURBED, LOOPS, TANK, loop_of
from tests.shipped import rules_folder

#: Of simulated states, by their size: Runge and Kutta's method.
ACCURACY = 1e-8


def enclosed(loop):
    """Return the sets of a loop at its samples, hulls of its plants' states over its steps, and the members' sides."""
    prover = LoopProver(loop, 100.0)
    sets = prover.sets([], prover.loop.number(loop.duration))
    low, high = (e[None] for e in prover._family())
    plant, memory, free = prover._begin(sets, low, high)
    samples = {0: [*plant, *memory]}

    def keep(k, rows):
        samples[k] = [r.copy() for r in rows]
        return rows if k < sets.equations.samples - 1 else None

    steps = list(sets.run(plant, memory, free, len(prover.dimensions), keep))
    return prover, sets, samples, steps


def simulated(loop, count, substeps=16):
    """Return the members of a family with their runs."""
    for member in members(loop, count):
        yield member, Experiment(with_settings(loop, member), "python").run(substeps=substeps)


def check(loop, count=24, accuracy=ACCURACY):
    prover, sets, samples, steps = enclosed(loop)
    plants = [s.name for s in sets.equations.plant_states]
    names = [*plants, *(s.name for s in sets.equations.states)]
    sides = prover.dimensions
    assert len(samples) == sets.equations.samples
    for member, run in simulated(loop, count):
        each = round(sets.equations.step / (run["t"][1] - run["t"][0]))  # samples of the run in a period
        # Symbols of what varies, which are never reduced, are those of the member.
        own = [(member[d.name] - 0.5 * (d.low + d.high)) / (0.5 * (d.high - d.low)) for d in sides]
        for k, rows in samples.items():
            for name, row in zip(names, rows, strict=True):
                if "#" in name:
                    continue
                middle = row[0, 0] + row[0, 2 : 2 + len(sides)] @ own
                rest = np.abs(row[0, 1]) + np.abs(row[0, 2 + len(sides) :]).sum()
                assert abs(run[name][each * k] - middle) <= rest + accuracy * (1 + abs(middle)), (name, k, member)
        between = run["t"][1]
        for step in steps:
            first, last = step.time / between - 1e-9, (step.time + step.length) / between + 1e-9
            for k in range(math.ceil(first), min(math.floor(last) + 1, len(run))):
                for name, row in zip(plants, step.states, strict=True):
                    low, high = ends(row)
                    slack = accuracy * (1 + abs(high[0]))
                    assert low[0] - slack <= run[name][k] <= high[0] + slack, (name, k, member)
    return samples


@pytest.mark.parametrize("name", [n for n in LOOPS if n != "disturbed"])
def test_sets_hold_the_runs_of_members(name):
    # A switch within a step costs the simulation its order.
    check(loop_of(LOOPS[name]), accuracy=2e-3 if name == "switched" else ACCURACY)


def test_sets_hold_runs_whose_disturbance_pushes_to_a_side():
    """The side is that of a plane through the states, which turns: a search for the worst."""
    loop = loop_of(DISTURBED)
    *_, samples, _ = enclosed(loop)
    gain = np.array([[1 - 2 * 0.05**2, 0.05 * (1 - 3 * 0.05 / 2)], [-0.2, 1 - 0.15]])
    for period in (1, 5, 20, 60):
        for direction in ((1, 0), (-1, 0), (0, 1), (1, -1)):
            adjoint = [np.array(direction) @ np.linalg.matrix_power(gain, period - 1 - k) for k in range(period)]
            pushes = [0.3 if a @ [0.05**2 / 2, 0.05] > 0 else -0.5 for a in adjoint]
            corner = np.sign(np.array(direction) @ np.linalg.matrix_power(gain, period)) * 0.1
            signal = "steps(" + ", ".join(f"{0.05 * k!r} s: {p}" for k, p in enumerate(pushes)) + ")"
            text = DISTURBED.replace("disturbance w in [-0.5, 0.3] = 0", f"let w = {signal}")
            member = dict(zip(["mass.x", "mass.v"], corner.tolist(), strict=True))
            run = Experiment(with_settings(loads(text, block="l"), member), "python").run(substeps=8)
            for name, row in zip(["mass.x", "mass.v"], samples[period], strict=True):
                low, high = ends(row)
                assert low[0] - 1e-9 <= run[name][period] <= high[0] + 1e-9
            # And the sets are not much wider than what such pushes do.
            if period == 60 and direction == (1, 0):
                assert high[0] < 4 * 0.5


@pytest.mark.parametrize(
    ("path", "block", "family", "duration"),
    [
        ("rules/loops/pendulum.fz", "balanced", {"cart.x": (-0.5, 0.5), "cart.th": (-0.05, 0.05)}, 0.6),
        ("rules/loops/water_tank.fz", "fill", {}, 0.5),
        ("apps/gallery/arch_unicycle/arch_unicycle.fz", "parked", {}, 3.0),
        ("apps/gallery/arch_attitude/arch_attitude.fz", "attitude", {}, 1.0),
        ("apps/gallery/arch_tora/arch_tora.fz", "caught", {}, 2.0),
    ],
)
def test_sets_hold_the_runs_of_shipped_loops(path, block, family, duration):
    loop = load(rules_folder().parent / path, block=block)
    loop = replace(loop, duration=Number(duration), guarantees=(), requirements=(), measures=())
    if family:
        loop = replace(loop, varied=tuple(varied(n, *ends_) for n, ends_ in family.items()))
    check(loop, count=10)


def varied(name, low, high):
    from fuzzyctl.model.block import Bounds
    from fuzzyctl.model.loop import Varied

    return Varied(name=name, bounds=Bounds(lower=Number(low), upper=Number(high)))


def test_a_long_run_is_reduced_and_still_holds_its_members(monkeypatch):
    from fuzzyctl.analysis.reach import sets

    monkeypatch.setattr(sets, "MOST", 6)
    monkeypatch.setattr(sets, "LEFT", 3)
    samples = check(loop_of(LOOPS["fuzzy"]), 16)
    assert max(r.shape[-1] for rows in samples.values() for r in rows) < 2 + 2 + 8 * 2


def test_several_boxes_at_once_are_the_boxes_alone():
    prover = LoopProver(loop_of(TANK), 100.0)
    sets = prover.sets([], 1.0)
    low, high = prover._family()
    middle = 0.5 * (low + high)
    lows, highs = np.array([low, middle, low]), np.array([middle, high, high])
    together = list(sets.run(*prover._begin(sets, lows, highs), len(low)))[-1]
    for box in range(3):
        alone = list(sets.run(*prover._begin(sets, lows[box : box + 1], highs[box : box + 1]), len(low)))[-1]
        for several, one in zip(together.states, alone.states, strict=True):
            # The order of the polynomials is that of all boxes.
            assert np.allclose([e[box] for e in ends(several)], [e[0] for e in ends(one)], rtol=1e-7, atol=1e-7)


def test_states_with_constant_rates_go_with_several_boxes():
    plant = "plant p\nstate a = 0\nstate b = 0\nder a = 1\nder b = a\noutput y = b\n"
    text = plant + "loop l\nblock p = p()\nfor p.b in [0, 1]\nrun 1 s step 100 ms\n"
    prover = LoopProver(loads(text, block="l"), 100.0)
    sets = prover.sets([], 1.0)
    low, high = (np.tile(e, (3, 1)) for e in prover._family())
    *_, last = sets.run(*prover._begin(sets, low, high), 1)
    assert all(a[0] <= 0.5 and b[0] >= 1.5 for a, b in [ends(last.states[1])])


DEAD_TIME = TANK.replace("loop l", "plant lag = tf(num=[1], den=[1, 1], delay=0.1 s)\nloop l").replace(
    "block tank = tank(law.v)", "block lag = lag(law.v)\nblock tank = tank(lag.y)"
)


def test_loops_whose_states_are_not_all_known_are_refused():
    equations = loop_equations(loads(DEAD_TIME, block="l"))
    with pytest.raises(DomainError, match="dead time"):
        ReachableSets(equations, 0, np.zeros((equations.samples, 0)))
    equations = loop_equations(loads(TANK, block="l"))
    with pytest.raises(DomainError, match="missing"):
        ReachableSets(equations, 0, np.full((equations.samples, 1), np.nan))
