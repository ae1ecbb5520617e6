import math

import numpy as np
import pytest

from dwmr import find, read
from dwmr.results import metrics
from dwmr.results.metrics import errors, measure, rmse
from dwmr.simulation.simulate import COLUMNS, SIGNALS, Stop, Trajectory


def trajectory(law="smc", stop=None, **columns):
    """Three samples of the paper's robots, zero but for the columns given per robot."""
    robots = ("leader", "follower1", "follower2")
    values = np.zeros((3, 3, len(SIGNALS)))
    values[:, :, COLUMNS["obstacle"]] = -1
    for name, column in columns.items():
        values[:, :, COLUMNS[name]] = column
    return Trajectory(law, robots, np.array([0.0, 0.005, 0.01]), values, np.zeros((3, 3, 0)), (), 0.1, stop)


SCENARIO = read(find("paper-with-limits")).scenario


class TestRmse:
    def test_is_the_root_of_the_mean_square(self):
        assert rmse(np.array([3.0, -4.0])) == pytest.approx(math.sqrt(12.5))


class TestErrors:
    def test_distinguish_the_frames(self):
        run = trajectory(x_r=[1.0, 0, 0], y_r=[2.0, 0, 0], x_e=[3.0, 0, 0], y_e=[4.0, 0, 0])
        assert [errors(run, "leader", "inertial")[k][0] for k in ("x_e", "y_e")] == [1.0, 2.0]
        assert [errors(run, "leader", "body")[k][0] for k in ("x_e", "y_e")] == [3.0, 4.0]

    def test_count_full_turns_only_where_they_say_so(self):
        theta = np.array([[0.0], [3.0], [6.0]]) * [1, 0, 0]
        found = errors(trajectory(theta=theta), "leader", "body")
        assert found["theta_e"][-1] == pytest.approx(2 * math.pi - 6.0)
        assert found["theta_e_unwrapped"][-1] == pytest.approx(-6.0)

    def test_distinguish_the_reference_from_the_auxiliary_one(self):
        found = errors(trajectory(theta_r=[0.5, 0, 0], theta_r_star=[0.25, 0, 0]), "leader", "body")
        assert (found["theta_e"][0], found["theta_e_star"][0]) == (0.5, 0.25)


class TestMeasure:
    def test_takes_inertial_axes_for_the_leader_and_body_axes_for_followers(self):
        result = measure(trajectory(x_r=[1.0, 5.0, 0], x_e=[3.0, 4.0, 0]), SCENARIO)
        assert result["rmse"]["leader"]["x_e"] == 1.0
        assert result["rmse"]["follower1"]["x_e"] == 4.0
        assert result["rmse_body"]["leader"]["x_e"] == 3.0
        assert result["rmse_inertial"]["follower1"]["x_e"] == 5.0

    def test_a_run_that_diverged_is_measured_as_far_as_it_is_finite(self):
        stop = Stop(0.01, "leader", "v is not finite: the run diverged")
        v = np.array([[0.0] * 3, [0.0] * 3, [math.inf, 0.0, 0.0]])
        x_e = np.array([[3.0] * 3, [3.0] * 3, [math.nan, 9.0, 9.0]])
        result = measure(trajectory(stop=stop, x_e=x_e, x=x_e, v=v), SCENARIO)
        assert result["rmse_body"]["leader"]["x_e"] == 3.0
        assert result["rmse_body"]["follower1"]["x_e"] == 3.0
        assert math.isfinite(result["centre_distance"]["leader"])
        assert (result["steps"], result["t_end"], result["stopped"]["t"]) == (2, 0.01, 0.01)

    def test_a_run_without_a_finite_sample_is_measured_whole(self):
        run = trajectory(stop=Stop(0.0, "leader", "diverged"), v=math.nan)
        assert metrics.finite_part(run) is run

    def test_chattering_is_the_mean_change_of_the_command(self):
        v_c = np.array([[0.0], [0.1], [0.0]]) * [1, 2, 0]
        result = measure(trajectory(v_c=v_c), SCENARIO)
        assert result["chattering"]["leader"]["v"] == pytest.approx(20.0)
        assert result["chattering"]["follower1"] == pytest.approx({"v": 40.0, "omega": 0.0})

    def test_says_how_long_the_condition_of_the_surfaces_fails(self):
        x_e = np.array([[1.2], [1.3], [-1.5]]) * [1, 0, 0]
        result = measure(trajectory(x_e=x_e), SCENARIO)
        # |d + x_e| = 1.3, 1.4, 1.4 against 0.7/0.3 − 1 = 1.333
        assert result["condition_violated"] == pytest.approx({"leader": 2 / 3, "follower1": 0.0, "follower2": 0.0})

    def test_says_how_long_limits_and_avoidance_last(self):
        v_c = np.array([[2.1], [-2.1], [0.0]]) * [1, 0, 0]
        obstacle = np.array([[-1], [0], [2]]) * [1, 0, 0] + [0, -1, -1]
        result = measure(trajectory(v_c=v_c, obstacle=obstacle), SCENARIO)
        assert result["saturation"]["leader"]["v"] == pytest.approx(2 / 3)
        assert result["avoidance_s"]["leader"] == pytest.approx(0.01 * 2 / 3)

    def test_measures_each_velocity_against_its_own_limit(self):
        omega_c = np.array([[6.3], [3.0], [-6.3]]) * [1, 0, 0]
        v_c = np.array([[6.3], [3.0], [0.5]]) * [1, 0, 0]
        result = measure(trajectory(omega_c=omega_c, v_c=v_c), SCENARIO)["saturation"]["leader"]
        assert (result["omega"], result["v"]) == pytest.approx((2 / 3, 2 / 3))
        result = measure(trajectory(omega_c=np.array([[3.0], [3.0], [3.0]]) * [1, 0, 0]), SCENARIO)
        assert result["saturation"]["leader"]["omega"] == 0.0

    def test_names_the_least_gain_of_aifqsmc_only(self, measured_with_limits):
        assert measured_with_limits("aifqsmc", "run.horizon=1")["g_ais_min"] > 0.0
        assert "g_ais_min" not in measured_with_limits("smc", "run.horizon=1")

    def test_tells_where_a_run_stopped(self):
        result = measure(trajectory(stop=Stop(0.01, "leader", "it fell over")), SCENARIO)
        assert result["stopped"] == {"t": 0.01, "robot": "leader", "reason": "it fell over"}


def test_only_the_measures_wanted_are_computed(run_with_limits, monkeypatch):
    file, trajectory = run_with_limits("aifqsmc", "run.horizon=2")
    whole = measure(trajectory, file.scenario)
    monkeypatch.setattr(metrics.lyapunov, "measure", lambda *_: pytest.fail("it was not asked for"))
    found = measure(trajectory, file.scenario, ("centre_distance", "obstacles_hit"))
    ending = {"g_ais_min", "steps", "t_end", "stopped", "wall_s"}
    assert set(found) == {"centre_distance", "obstacles_hit"} | ending
    assert found == {name: whole[name] for name in found}
