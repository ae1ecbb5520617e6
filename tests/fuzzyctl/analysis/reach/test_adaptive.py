"""Loops with systems that adapt: runs of members lie in the sets, which are hardly wider than the runs."""

import random

import numpy as np
import pytest

from fuzzyctl import Experiment, Proved, Undecided, loads
from fuzzyctl.analysis.reach import prover
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.members import members

#: Two inputs, an output that adapts towards both ends of its range, another one that does not.
LOOP = """
system gain
and product
defuzzifier {defuzzifier}
param gamma = 30
input sigma in [-0.4, 0.4] {extrapolate}
  N = triangle(-0.8, -0.4, 0)
  Z = triangle(-0.4, 0, {foot})
  P = triangle(0, 0.4, 0.8)
input rate in [-1, 1]
  terms L R
output F in [-0.3, 0.2] adaptive rate gamma * sigma - rate {otherwise}
  terms a={a!r} b={b!r}
output other in [-1, 1] else 0
  terms low=-1 high=1
{rules}

controller law
input x
input v
let push = gain(x, v)
output u = -push.F - 2 * x - v - 0.1 * push.other
every 20 ms

plant mass
param d = 0.3
input u
state x = 0.2
state v = 0
der x = v
der v = u + d
output y = x
output w = v

loop l
block law = law(mass.y, mass.w)
block mass = mass(law.u)
for mass.x in [{low!r}, {high!r}]
for mass.d in [0.3, 0.31]
run 1.2 s step 20 ms
"""


def drawn(seed, width):
    """Return the text of a loop with drawn consequents and weights; of odd seeds no rule fires for x above 0.02."""
    rng, has_hole = random.Random(seed), seed % 2 == 1
    rules = [
        f"if sigma is {n} and rate is {m} then F is {rng.choice('ab')}, other is {rng.choice(['low', 'high'])}"
        f" weight {rng.choice([1, 0.5, 0.25])}"
        for n in "NZP"
        for m in "LR"
    ]
    low = rng.uniform(0.05, 0.3)
    return LOOP.format(
        defuzzifier=rng.choice(["weighted_average", "center_average"]),
        extrapolate=rng.choice(["", "extrapolate"]),
        foot=0.02 if has_hole else 0.4,
        otherwise=rng.choice(["else 0.1", "else midpoint"] if has_hole else ["else 0.1", ""]),
        a=rng.uniform(-0.3, 0.2),
        b=rng.uniform(-0.3, 0.2),
        rules="\n".join(rules[: 4 if has_hole else 6]),
        low=low,
        high=low + width,
    ).replace("mass.d in [0.3, 0.31]", f"mass.d in [0.3, {0.3 + 0.1 * width!r}]")


def enclosed(loop):
    """Return the prover of a loop without runs that refute."""
    looking = prover.LoopProver(loop, 60.0)
    looking.__dict__["_refuted"] = {}
    assert all(isinstance(looking.verdict(c), Proved) for c in loop.guarantees)
    return looking


@pytest.mark.parametrize(("seed", "width"), [(0, 1e-9), (1, 1e-9), (2, 1e-9), (3, 1e-9), (0, 0.05), (2, 0.05)])
def test_runs_of_members_lie_in_the_sets(seed, width):
    loop = loads(drawn(seed, width) + "require always abs(mass.y) <= 50\n", block="l")
    tube = enclosed(loop).tube
    runs = [Experiment(with_settings(loop, m), "python").run(substeps=8) for m in members(loop, 8)]
    at = np.minimum(np.searchsorted(tube.end, runs[0].t), len(tube.end) - 1)
    for signal, (low, high) in tube.bounds.items():
        values = np.array([run[signal] for run in runs])
        assert np.all(values >= low[at] - 1e-9), signal
        assert np.all(values <= high[at] + 1e-9), signal
        moves = np.abs(np.diff(values, axis=1)).max() * 2
        assert np.all((high - low)[at] <= np.ptp(values, axis=0) + moves + 0.5 * width + 1e-6), signal


def test_convergence_and_outputs_that_hold_are_undecided():
    text = drawn(0, 0.05)
    held = text.replace("[-1, 1] else 0", "[-1, 1] else hold") + "require always abs(mass.y) <= 50\n"
    for loop, reason in ((text + "require stable\n", "settle anywhere"), (held, "'gain' keeps a state")):
        looking = prover.LoopProver(loop := loads(loop, block="l"), 10.0)
        verdict = looking.verdict(loop.guarantees[0])
        assert isinstance(verdict, Undecided)
        assert reason in verdict.reason
