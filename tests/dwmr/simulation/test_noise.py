"""Measurement noise: of the size asked for, reproducible, seen by the law and not by the record."""

import subprocess
import sys

import numpy as np
import pytest

from dwmr.control.fuzzy_gains import Rules
from dwmr.scenario.file import find, read
from dwmr.scenario.model import LARGEST_NOISE
from dwmr.simulation import simulate
from dwmr.simulation.periods import MEASURED, noise_source
from tests.dwmr.process import LONG

PAPER = find("paper")
ALL = tuple(
    f"robot.noise.{name}={value}" for name, value in zip(MEASURED, (0.01, 0.02, 0.005, 0.03, 0.04), strict=True)
)


def run(law="aifqsmc", *overrides):
    file = read(PAPER, ["run.horizon=5", *overrides])
    return simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, (), file.places)))


class TestSource:
    def test_has_the_deviations_asked_for(self):
        drawn = noise_source(read(PAPER, ALL).scenario)(20_000)
        assert drawn.std(axis=0) == pytest.approx(np.tile([0.01, 0.02, 0.005, 0.03, 0.04], (3, 1)), rel=0.03)
        assert np.abs(drawn.mean(axis=0) / drawn.std(axis=0)).max() < 0.03

    def test_is_cut_at_four_deviations(self):
        drawn = noise_source(read(PAPER, ["robots.leader.noise.x=0.01"]).scenario)(200_000)[:, 0, 0]
        assert np.abs(drawn).max() == LARGEST_NOISE * 0.01  # one of 16,000 lies beyond

    def test_does_not_depend_on_how_much_is_drawn_at_once(self):
        scenario = read(PAPER, ALL).scenario
        pieces = noise_source(scenario)
        assert np.array_equal(np.concatenate([pieces(3), pieces(0), pieces(97)]), noise_source(scenario)(100))

    def test_of_a_robot_does_not_depend_on_the_others(self):
        both = noise_source(read(PAPER, ALL).scenario)(50)
        one = noise_source(read(PAPER, ["robots.follower1.noise.x=0.01"]).scenario)(50)
        assert not one[:, [0, 2]].any()
        assert np.array_equal(one[:, 1, 0], both[:, 1, 0])
        assert not np.array_equal(both[:, 0, 0], both[:, 1, 0])

    def test_another_seed_gives_other_numbers(self):
        first, second = (noise_source(read(PAPER, [*ALL, f"run.seed={k}"]).scenario)(10) for k in (0, 1))
        assert not np.isclose(first, second).any()

    def test_is_empty_where_nobody_asked_for_any(self):
        for overrides in ([], ["robot.noise.x=0.0"]):
            assert noise_source(read(PAPER, overrides).scenario)(10).shape == (0, 3, 5)


class TestRun:
    def test_without_deviations_is_the_run_without_noise(self, run_paper):
        assert np.array_equal(
            run("aifqsmc", "robot.noise.x=0.0").values, run_paper("aifqsmc", "run.horizon=5")[1].values
        )

    @pytest.mark.parametrize("which", range(5))
    def test_every_measurement_moves_the_robots(self, run_paper, which):
        _, exact = run_paper("smc", "run.horizon=5")
        assert np.abs(run("smc", ALL[which])["y"][-1] - exact["y"][-1]).min() > 1e-7

    def test_is_the_same_however_often_it_reports(self, monkeypatch):
        whole = run("aifqsmc", *ALL)
        monkeypatch.setattr(simulate, "PERIODS_AT_A_TIME", 37)
        assert np.array_equal(whole.values, run("aifqsmc", *ALL).values)

    def test_is_seen_by_the_law_and_kept_out_of_the_record(self):
        trajectory = run("smc", *ALL)
        record, seen = trajectory["x_e"][:, 0], trajectory["sigma_v"][:, 0] / -0.25  # −λ1²
        assert np.abs(np.diff(record)).max() < 0.01
        inertial = np.hypot(trajectory["x_r"] - trajectory["x"], trajectory["y_r"] - trajectory["y"])[:, 0]
        assert np.hypot(record, trajectory["y_e"][:, 0]) == pytest.approx(inertial, abs=1e-9)
        assert 0.01 < (seen - record).std() < 0.02

    def test_of_the_leader_reaches_its_follower(self, run_paper):
        _, exact = run_paper("smc", "run.horizon=5")
        noisy = run("smc", "robots.leader.noise.x=0.05")
        assert not np.allclose(np.diff(noisy["sigma_v"][:20, 1]), np.diff(exact["sigma_v"][:20, 1]), atol=1e-3)

    def test_is_the_same_in_plain_python(self):
        code = (
            "import sys; sys.modules['numba'] = None\n"
            "from dwmr.control.fuzzy_gains import Rules\nfrom dwmr.scenario.file import find, read\n"
            "from dwmr.simulation import simulate\n"
            "file = read(find('paper'), ['run.horizon=0.25', *sys.argv[1:]])\n"
            "rules = Rules(file.scenario.rules, (), file.places)\n"
            "print(repr(simulate.run(simulate.prepare(file, 'aifqsmc', rules)).values.tolist()))\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, *ALL], capture_output=True, text=True, check=True, timeout=LONG
        )
        plain = np.array(eval(done.stdout, {"__builtins__": {}}))
        assert plain == pytest.approx(run("aifqsmc", *ALL).values[:51], abs=1e-9)
