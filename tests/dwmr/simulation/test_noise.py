"""Measurement noise: of the given size, reproducible, seen by the law and not by the record."""

import numpy as np
import pytest

from dwmr import read
from dwmr.simulation import simulate
from dwmr.simulation.periods import noise_source
from tests.dwmr.scenarios import PAPER, shared
from tests.dwmr.scenarios import run as run_scenario

ALL = tuple(
    f"robot.noise.{name}={value}"
    for name, value in {"x": 0.01, "y": 0.02, "theta": 0.005, "v": 0.03, "omega": 0.04}.items()
)


def run(law, *overrides):
    return shared("paper", law, "run.horizon=5", *overrides)[1]


class TestSource:
    def test_has_the_given_deviations(self):
        drawn = noise_source(read(PAPER, ALL).scenario)(20_000)[:, :, :5]
        assert drawn.std(axis=0) == pytest.approx(np.tile([0.01, 0.02, 0.005, 0.03, 0.04], (3, 1)), rel=0.03)
        assert np.abs(drawn.mean(axis=0) / drawn.std(axis=0)).max() < 0.03

    def test_is_cut_at_four_deviations(self):
        drawn = noise_source(read(PAPER, ["robots.leader.noise.x=0.01"]).scenario)(200_000)[:, 0, 0]
        assert np.abs(drawn).max() == 4 * 0.01  # one of 16,000 lies beyond

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
        assert not np.isclose(first, second)[..., :5].any()

    def test_is_empty_without_deviations(self):
        for overrides in ([], ["robot.noise.x=0.0"]):
            assert noise_source(read(PAPER, overrides).scenario)(10).shape == (0, 3, 6)


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
        assert np.array_equal(whole.values, run_scenario("paper", "aifqsmc", "run.horizon=5", *ALL).values)

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
