"""Stability against its contradictions: a few of the loops, the examples and the edges of tests/bench/stability.py."""

import numpy as np
import pytest

from fuzzyctl import Proved
from tests.bench import enclosures, stability


def test_verdicts_on_drawn_loops_are_not_contradicted():
    rng = np.random.default_rng(2)
    counts = sum((stability.judged(stability.drawn(rng), rng, 120) for _ in range(1)), start=stability.Counter())
    assert counts["contradiction"] == 0
    assert len(counts) >= 2


@pytest.mark.parametrize("start", [0.1, 0.4])
def test_a_false_proof_is_contradicted(monkeypatch, start):
    """An unstable loop that is called stable, and a bound below the runs."""
    loop = stability.Drawn("linear", False, 0.1, [[0.5]], [1.0], [0.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], start, 0.1)
    rng = np.random.default_rng(0)
    ball = type("Ball", (), {"basis": np.eye(1), "radius": 1.0})
    contraction = type("Contraction", (), {"rate": 0.9, "balls": (ball,)})
    monkeypatch.setattr(stability, "verdict", lambda text: Proved("stable", data=contraction))
    assert stability.judged(loop, rng, 120)["contradiction"] >= 1


def test_the_sector_of_the_published_example_is_accepted():
    assert isinstance(stability.verdict(stability.sector_text(0.25)), Proved)
    assert not isinstance(stability.verdict(stability.sector_text(0.1), 0.1), Proved)
    assert stability.circle(0.25)
    assert not stability.circle(0.1)


def test_parallel_distributed_compensation_is_proved_up_to_its_limit():
    assert stability.proved_rules(6.0, 17.8)
    assert not stability.proved_rules(6.0, 18.2)


def test_an_enclosure_is_hardly_wider_than_the_runs():
    plant = enclosures.PLANTS["oscillator"]
    width, (proved, _) = enclosures.runs(*plant), enclosures.ours(*plant)
    assert width <= proved <= 1.2 * width


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) for n in ("water_tank", "pendulum")])
def test_shipped_loops_are_proved_for_families(name):
    """A tank with a filter, `previous`, noise and a root for a minute; a pendulum on a cart for ten seconds."""
    assert all(isinstance(v, Proved) for v in enclosures.shipped(name)[0])
