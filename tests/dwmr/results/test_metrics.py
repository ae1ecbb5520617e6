import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from dwmr import find, measure, read
from tests.dwmr.scenarios import by_hand

SCENARIO = read(find("paper-with-limits")).scenario


def stopped(t, reason):
    return SimpleNamespace(t=t, robot="leader", reason=reason, mistake=None)


class TestRmse:
    def test_is_the_root_of_the_mean_square(self):
        x_e = np.array([[3.0], [-4.0], [0.0]]) * [1, 1, 0]
        found = measure(by_hand(x_e=x_e), SCENARIO)["rmse_body"]
        assert found["leader"]["x_e"] == pytest.approx(math.sqrt(25.0 / 3.0))

    def test_distinguishes_the_frames(self):
        result = measure(by_hand(x_r=[1.0, 0, 0], y_r=[2.0, 0, 0], x_e=[3.0, 0, 0], y_e=[4.0, 0, 0]), SCENARIO)
        inertial, body = (result[f"rmse_{frame}"]["leader"] for frame in ("inertial", "body"))
        assert [inertial[k] for k in ("x_e", "y_e")] == [1.0, 2.0]
        assert [body[k] for k in ("x_e", "y_e")] == [3.0, 4.0]

    def test_counts_full_turns_only_where_it_says_so(self):
        theta = np.array([[0.0], [3.0], [6.0]]) * [1, 0, 0]
        found = measure(by_hand(theta=theta), SCENARIO)["rmse_body"]["leader"]
        assert found["theta_e"] == pytest.approx(math.sqrt((9.0 + (2 * math.pi - 6.0) ** 2) / 3.0))
        assert found["theta_e_unwrapped"] == pytest.approx(math.sqrt(45.0 / 3.0))

    def test_distinguishes_the_reference_from_the_auxiliary_one(self):
        found = measure(by_hand(theta_r=[0.5, 0, 0], theta_r_star=[0.25, 0, 0]), SCENARIO)["rmse_body"]["leader"]
        assert (found["theta_e"], found["theta_e_star"]) == (0.5, 0.25)


class TestMeasure:
    def test_takes_inertial_axes_for_the_leader_and_body_axes_for_followers(self):
        result = measure(by_hand(x_r=[1.0, 5.0, 0], x_e=[3.0, 4.0, 0]), SCENARIO)
        assert result["rmse"]["leader"]["x_e"] == 1.0
        assert result["rmse"]["follower1"]["x_e"] == 4.0
        assert result["rmse_body"]["leader"]["x_e"] == 3.0
        assert result["rmse_inertial"]["follower1"]["x_e"] == 5.0

    def test_a_run_that_diverged_is_measured_as_far_as_it_is_finite(self):
        stop = stopped(0.01, "v is not finite: the run diverged")
        v = np.array([[0.0] * 3, [0.0] * 3, [math.inf, 0.0, 0.0]])
        x_e = np.array([[3.0] * 3, [3.0] * 3, [math.nan, 9.0, 9.0]])
        result = measure(by_hand(stop=stop, x_e=x_e, x=x_e, v=v), SCENARIO)
        assert result["rmse_body"]["leader"]["x_e"] == 3.0
        assert result["rmse_body"]["follower1"]["x_e"] == 3.0
        assert math.isfinite(result["centre_distance"]["leader"])
        assert (result["steps"], result["t_end"], result["stopped"]["t"]) == (2, 0.01, 0.01)

    def test_a_run_without_a_finite_sample_is_measured_whole(self):
        result = measure(by_hand(stop=stopped(0.0, "diverged"), v=math.nan, x_e=2.0), SCENARIO)
        assert result["rmse_body"]["leader"]["x_e"] == 2.0

    def test_chattering_is_the_mean_change_of_the_command(self):
        v_c = np.array([[0.0], [0.1], [0.0]]) * [1, 2, 0]
        result = measure(by_hand(v_c=v_c), SCENARIO)
        assert result["chattering"]["leader"]["v"] == pytest.approx(20.0)
        assert result["chattering"]["follower1"] == pytest.approx({"v": 40.0, "omega": 0.0})

    def test_says_how_long_the_condition_of_the_surfaces_fails(self):
        x_e = np.array([[1.2], [1.3], [-1.5]]) * [1, 0, 0]
        result = measure(by_hand(x_e=x_e), SCENARIO)
        # |d + x_e| = 1.3, 1.4, 1.4 against 0.7/0.3 − 1 = 1.333
        assert result["condition_violated"] == pytest.approx({"leader": 2 / 3, "follower1": 0.0, "follower2": 0.0})

    def test_energy_is_the_work_of_both_wheels_with_braking(self):
        forward, turn = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
        result = measure(by_hand(v=forward, omega=turn, torque_right=2.0, torque_left=-1.0), SCENARIO)
        leader = SCENARIO.robots["leader"]
        # N m times m/s over the radius, for 10 ms
        assert result["energy"]["leader"] == pytest.approx(3.0 / leader.wheel_radius * 0.01)
        assert result["energy"]["follower1"] == pytest.approx(3.0 * leader.half_track / leader.wheel_radius * 0.01)
        assert result["energy"]["follower2"] == 0.0

    def test_amplification_is_the_error_over_that_of_the_leader(self):
        result = measure(by_hand(x_e=[3.0, 0, 6.0], y_e=[4.0, 5.0, 8.0]), SCENARIO)
        assert result["amplification"] == pytest.approx({"follower1": 1.0, "follower2": 2.0})
        assert measure(by_hand(x_e=[0, 1.0, 1.0]), SCENARIO)["amplification"] == dict.fromkeys(
            ("follower1", "follower2")
        )

    def test_says_how_long_limits_and_avoidance_last(self):
        v_c = np.array([[2.1], [-2.1], [0.0]]) * [1, 0, 0]
        obstacle = np.array([[-1], [0], [2]]) * [1, 0, 0] + [0, -1, -1]
        result = measure(by_hand(v_c=v_c, obstacle=obstacle), SCENARIO)
        assert result["saturation"]["leader"]["v"] == pytest.approx(2 / 3)
        assert result["avoidance_s"]["leader"] == pytest.approx(0.01 * 2 / 3)

    def test_counts_the_switches_of_the_avoidance(self):
        obstacle = np.full((60, 1), -1)
        obstacle[5:8] = obstacle[17:30] = obstacle[40:] = 0
        obstacle[45:] = 1  # from one obstacle to the next it stays on
        result = measure(by_hand(samples=60, obstacle=obstacle * [1, 0, 0] - [0, 1, 1]), SCENARIO)
        assert result["avoidance_switches"] == {
            "leader": {"all": 5, "fast": 3}, "follower1": {"all": 0, "fast": 0}, "follower2": {"all": 0, "fast": 0},
        }  # fmt: skip

    def test_chattering_outside_is_that_away_from_avoidances(self):
        # steps of 5 ms: an avoidance from 1.5 to 2 s counts from 0.5 to 3 s
        t = np.arange(800)
        v_c = (t % 2)[:, None] * np.where((t > 101) & (t < 599), 0.3, 0.1)[:, None] * [1, 1, 0]
        obstacle = np.where((t >= 300) & (t < 400), 0, -1)[:, None] * [1, 0, 0] - [0, 1, 1]
        result = measure(by_hand(samples=800, v_c=v_c, obstacle=obstacle), SCENARIO)
        for robot in ("leader", "follower1"):
            assert result["chattering_outside"][robot] == pytest.approx({"v": 20.0, "omega": 0.0})
            assert result["chattering"][robot]["v"] > 40.0
        never = measure(by_hand(samples=150, obstacle=0), SCENARIO)
        assert never["chattering_outside"]["leader"] is None
        calm = measure(by_hand(samples=150, v_c=v_c[:150]), SCENARIO)
        assert calm["chattering_outside"] == calm["chattering"]

    def test_measures_each_velocity_against_its_own_limit(self):
        omega_c = np.array([[6.3], [3.0], [-6.3]]) * [1, 0, 0]
        v_c = np.array([[6.3], [3.0], [0.5]]) * [1, 0, 0]
        result = measure(by_hand(omega_c=omega_c, v_c=v_c), SCENARIO)["saturation"]["leader"]
        assert (result["omega"], result["v"]) == pytest.approx((2 / 3, 2 / 3))
        result = measure(by_hand(omega_c=np.array([[3.0], [3.0], [3.0]]) * [1, 0, 0]), SCENARIO)
        assert result["saturation"]["leader"]["omega"] == 0.0

    def test_names_the_least_gain_of_aifqsmc_only(self, measured_with_limits):
        assert measured_with_limits("aifqsmc", "run.horizon=1")["g_ais_min"] > 0.0
        assert "g_ais_min" not in measured_with_limits("smc", "run.horizon=1")

    def test_tells_where_a_run_stopped(self):
        result = measure(by_hand(stop=stopped(0.01, "it fell over")), SCENARIO)
        assert result["stopped"] == {"t": 0.01, "robot": "leader", "reason": "it fell over"}


def test_only_the_measures_wanted_are_computed(run_with_limits):
    file, trajectory = run_with_limits("smc", "run.horizon=2")
    whole = measure(trajectory, file.scenario)
    without_law = dataclasses.replace(trajectory, law_values=None, law_signals=())  # Lyapunov functions need these
    found = measure(without_law, file.scenario, ("centre_distance", "obstacles_hit"))
    ending = {"steps", "record_every", "t_end", "stopped", "wall_s"}
    assert set(found) == {"centre_distance", "obstacles_hit"} | ending
    assert found == {name: whole[name] for name in found}
