"""Convergence of loops whose controllers run at several rates, beside eigenvalues of the lifted map and runs."""

import random

import numpy as np
import pytest
from scipy.linalg import expm

from fuzzyctl import Experiment, Proved, Undecided
from fuzzyctl.analysis.reach.prover import LoopProver
from fuzzyctl.analysis.reach.reach import image
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.members import members
from tests.fuzzyctl.analysis.reach.loops import loop_of
from tests.sizes import examples

#: An outer controller with a state commands an inner one.
LINEAR = """
controller outer
input y
state s = 0
next s = {leak!r} * s - y
output r = {ki!r} * s - {kp!r} * y
every {slow} ms
controller inner
input r
input w
output u = {k!r} * (r - w)
every {fast} ms
plant mass
input u
state x = 0
state w = 0
der x = w
der w = u - {drag!r} * w
output y = x
output speed = w
loop l
block outer = outer(mass.y)
block inner = inner(outer.r, mass.speed)
block mass = mass(inner.u)
for mass.x in [-0.2, 0.2]
run 4 s
"""


def drawn(seed):
    """Return the numbers of a loop, and the eigenvalue of largest magnitude of its map from cycle to cycle."""
    rng = random.Random(seed)
    fast, ratio = rng.choice([20, 50, 100]), rng.choice([2, 3, 5])
    numbers = {
        "leak": rng.uniform(0.5, 0.95), "ki": rng.uniform(0.0, 0.05), "kp": rng.uniform(0.2, 5.0),
        "k": rng.uniform(1.0, 30.0), "drag": rng.uniform(0.0, 0.5), "fast": fast, "slow": ratio * fast,
    }  # fmt: skip
    a = np.array([[0.0, 1.0, 0.0], [0.0, -numbers["drag"], 1.0], [0.0, 0.0, 0.0]])
    step = expm(a * fast / 1000)[:2]
    # States: position, speed, s, and the command of the outer controller.
    whole = np.eye(4)
    for sample in range(ratio):
        control = np.eye(4)
        if sample == 0:
            control[3] = [-numbers["kp"], 0.0, numbers["ki"], 0.0]
        force = numbers["k"] * (control[3] - np.array([0.0, 1.0, 0.0, 0.0]))
        following = control.copy()
        following[:2] = step[:, :2] @ np.eye(4)[:2] + np.outer(step[:, 2], force)
        if sample == 0:
            following[2] = [-1.0, 0.0, numbers["leak"], 0.0]
        whole = following @ whole
    return numbers, float(np.abs(np.linalg.eigvals(whole)).max())


def verdict_of(text, timeout=1.0):
    loop = loop_of(text, "require stable")
    return LoopProver(loop, timeout).verdict(loop.guarantees[0])


@pytest.mark.parametrize("seed", range(examples(60, 12)))
def test_linear_loops_are_proved_as_their_eigenvalues_say(seed):
    numbers, radius = drawn(seed)
    assert isinstance(verdict_of(LINEAR.format(**numbers)), Proved) == (radius < 1.0), radius


def test_both_verdicts_are_drawn():
    radii = [drawn(seed)[1] for seed in range(12)]
    assert 3 <= sum(r < 1.0 for r in radii) <= 9
    assert min(abs(r - 1.0) for r in radii) > 0.005


#: A fuzzy outer controller, a limited inner one, a plant with friction.
FUZZY = """
system table
and product
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
input v in [-2, 2]
  terms N Z P
output r in [-2, 2]
  terms low=-2 less=-0.8 none=0 more=0.8 high=2
table r = e x v
      N    Z    P
  N | none less low
  Z | more none less
  P | high more none

controller outer
input y
input w
output r = GAIN * table(-y, w)
every 100 ms
controller inner
input r
input w
output u = clamp(3 * (r - w), -4, 4)
every 20 ms
plant mass
input u
state x = 0
state w = 0
der x = w
der w = u - 0.2 * w - 0.1 * w ^ 3
output y = x
output speed = w
loop l
block outer = outer(mass.y, mass.speed)
block inner = inner(outer.r, mass.speed)
block mass = mass(inner.u)
for mass.x in [-0.1, 0.1]
run 20 s
"""


@pytest.mark.parametrize(("gain", "expected"), [(0.5, True), (30.0, False)])
def test_fuzzy_loops_are_proved_if_their_runs_converge(gain, expected):
    text = FUZZY.replace("GAIN", f"{gain}")
    verdict = verdict_of(text, 3.0 if expected else 1.0)
    assert isinstance(verdict, Proved) == expected, verdict
    loop = loop_of(text)
    ends = [Experiment(with_settings(loop, m), "python").run()["mass.x"][-1] for m in members(loop, 3)]
    assert (np.abs(ends).max() < 1e-3) == expected


def test_a_rule_for_many_samples_is_undecided():
    """Periods of 7 and 10 ms meet every 70 ms, 70 samples of 1 ms."""
    numbers = drawn(0)[0] | {"fast": 7, "slow": 10}
    verdict = verdict_of(LINEAR.format(**numbers).replace("run 4 s", "run 4 s step 1 ms"))
    assert isinstance(verdict, Undecided)
    assert "64 or fewer" in verdict.reason


@pytest.mark.parametrize(
    "text", [LINEAR.format(**drawn(4)[0]), LINEAR.format(**drawn(8)[0]), FUZZY.replace("GAIN", "0.5")]
)
def test_each_ball_is_mapped_into_the_next_one(text):
    """Distances of points to the point of rest, 0, shrink as said; without an outer controller they do otherwise."""
    loop = loop_of(text, "require stable")
    looking = LoopProver(loop, 5.0)
    proof, sets, draws = looking.verdict(loop.guarantees[0]).data, looking.sets([], np.inf), np.random.default_rng(0)
    assert len(proof.balls) == sets.cycle > 1
    for k, ball in enumerate(proof.balls):
        following, closest = proof.balls[(k + 1) % sets.cycle], np.inf
        for _ in range(40):
            direction = draws.normal(size=len(ball.centre))
            moved = ball.basis @ (direction / np.linalg.norm(direction)) * ball.radius
            rows = [np.array([[x, 0.0]]) for x in ball.centre + moved]
            end = np.array([row[0, 0] for row in image(sets, rows, [], k)])
            distance = np.linalg.norm(np.linalg.solve(following.basis, end - following.centre))
            assert distance <= ball.rate * ball.radius + 1e-9
            closest = min(closest, ball.rate * ball.radius / max(distance, 1e-300))
        assert closest <= 3.0  # the rate is not far from what is attained
        assert ball.rate * ball.radius <= following.radius * (1.0 + 1e-9) or k == sets.cycle - 1
    assert proof.rate < 1.0
