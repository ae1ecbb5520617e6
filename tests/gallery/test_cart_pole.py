"""The cart-pole as text is gymnasium's, and its controller keeps the pole up in gymnasium itself."""

import numpy as np
import pytest

import fuzzyctl
from gallery import pages
from tests import sizes

FILE = pages.entries()["cart_pole"] / "cart_pole.fz"


@pytest.fixture
def environment():
    gymnasium = pytest.importorskip("gymnasium")
    made = gymnasium.make("CartPole-v1")
    yield made
    made.close()


def test_the_equations_are_those_of_the_environment(environment):
    run = fuzzyctl.simulate(fuzzyctl.load(FILE, block=fuzzyctl.Loop))
    names = ("pole.position", "pole.speed", "pole.angle", "pole.rate")
    environment.reset(seed=0)
    environment.unwrapped.state = tuple(run[name][0] for name in names)
    expected = []
    for force in run["law.force"]:
        expected.append(environment.unwrapped.state)
        environment.step(int(force > 0))
    assert np.stack([run[name] for name in names], axis=-1) == pytest.approx(np.array(expected), abs=1e-12)


def test_all_steps_from_many_seeds(environment):
    seeds = 100 if sizes.LONG else 20
    step = fuzzyctl.compile(fuzzyctl.load(FILE, block="balance"), "python")
    lasted = []
    for seed in range(seeds):
        seen, _ = environment.reset(seed=seed)
        state, ended, steps = step.start(), False, 0
        while not ended:
            force, state = step(*seen.tolist(), state)
            seen, _, failed, ended, _ = environment.step(int(force > 0))
            steps += 1
            ended = ended or failed
        lasted.append(steps)
    assert lasted == [500] * seeds
