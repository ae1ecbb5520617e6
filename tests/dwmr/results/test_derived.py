import numpy as np
import pytest

from dwmr.core.geometry import wrap_array
from dwmr.results import derived
from dwmr.results.metrics import distances

SHORT = "run.horizon=5"


@pytest.fixture(scope="module")
def around(run_paper):
    """A run that avoids an obstacle on its start."""
    file, trajectory = run_paper("aifqsmc", "run.horizon=10", "obstacles=[{x=3.0, y=2.0, radius=0.5}]")
    return file.scenario, trajectory


class TestRates:
    def test_are_backward_differences_with_zero_first(self):
        assert derived.rate(np.array([1.0, 3.0, 2.0]), 0.5).tolist() == [0.0, 4.0, -2.0]

    def test_of_sigma_are_those_the_law_has_used(self, run_paper):
        _, trajectory = run_paper("aifqsmc", SHORT)
        ours = derived.rate(trajectory["sigma_omega"], 0.005)
        assert ours == pytest.approx(trajectory["sigma_dot_omega"], abs=1e-9)


class TestVelocityError:
    def test_is_what_is_asked_for_less_the_velocity_over_ground(self, run_paper):
        _, trajectory = run_paper("smc", SHORT)
        k = 900  # 4.5 s: the sinusoid of the scenario acts
        assert trajectory["d_v"][k, 0] != 0.0
        ground = trajectory["v"][k, 0] + trajectory["d_v"][k, 0]
        assert derived.velocity_error(trajectory, "v")[k, 0] == pytest.approx(trajectory["v_c"][k, 0] - ground)


class TestCompensation:
    def test_of_smc_is_the_switching_term(self, run_paper):
        file, trajectory = run_paper("smc", SHORT)
        portion = derived.compensation(trajectory, file.scenario, "omega")
        assert np.array_equal(portion, -0.1 * np.sign(trajectory["sigma_omega"]))

    def test_of_aifqsmc_is_the_gain_times_the_saturated_sigma(self, run_paper):
        file, trajectory = run_paper("aifqsmc", SHORT)
        portion = derived.compensation(trajectory, file.scenario, "v")
        for k in (0, 400, 1000):
            share = trajectory["sigma_v"][k, 1] / trajectory["beta_v"][k, 1]
            wanted = -trajectory["g_ais_v"][k, 1] * np.clip(share, -1.0, 1.0)
            assert portion[k, 1] == pytest.approx(wanted)

    def test_of_fcafsmc_is_its_fuzzy_gain(self, run_paper):
        file, trajectory = run_paper("fcafsmc", SHORT)
        assert np.array_equal(derived.compensation(trajectory, file.scenario, "v"), -trajectory["f_v"])


class TestFormationError:
    def test_of_a_follower_in_its_place_is_zero(self, run_paper):
        file, trajectory = run_paper("aifqsmc", SHORT)
        separation, bearing = derived.formation_error(trajectory, file.scenario, "follower1")
        # the position error in the robot's frame is the same distance, seen from the follower
        gap = np.hypot(trajectory["x_e"][:, 1], trajectory["y_e"][:, 1])
        assert np.all(np.abs(separation) <= gap + 1e-9)
        assert separation[0] < -1.0  # it begins too far behind
        assert np.all(np.abs(bearing) <= np.pi)

    def test_refuses_a_robot_that_follows_none(self, run_paper):
        file, trajectory = run_paper("aifqsmc", SHORT)
        with pytest.raises(ValueError, match="leader follows no robot"):
            derived.formation_error(trajectory, file.scenario, "leader")


class TestAvoidance:
    def test_radii_are_those_the_loop_has_used(self, around):
        scenario, trajectory = around
        active = trajectory["obstacle"][:, 0] >= 0
        assert active.any()
        radii = derived.avoidance_radii(trajectory, scenario, "leader")[:, 0]
        assert radii[active] == pytest.approx(trajectory["avoidance_radius"][active, 0])
        assert np.array_equal(active, distances(trajectory, scenario, "leader")[:, 0] <= radii)

    def test_blending_vectors_point_where_the_reference_does(self, around):
        scenario, trajectory = around
        active = trajectory["obstacle"][:, 0] >= 0
        vector = derived.blending(trajectory, scenario, "leader").sum(axis=0)
        direction = np.arctan2(vector[active, 1], vector[active, 0])
        assert wrap_array(direction - trajectory["theta_r"][active, 0]) == pytest.approx(
            np.zeros(active.sum()), abs=1e-9
        )
        assert np.all(vector[~active] == 0.0)

    def test_the_path_keeps_its_direction(self, around, run_paper):
        _, trajectory = around
        free = run_paper("aifqsmc", "run.horizon=10", "obstacles=[]")[1]
        original = derived.path_orientation(trajectory, "leader")
        assert original == pytest.approx(wrap_array(free["theta_r"][:, 0]), abs=1e-3)
        assert np.abs(trajectory["theta_r"][:, 0] - free["theta_r"][:, 0]).max() > 0.3


def test_windows_end_with_the_run():
    assert derived.windows([(3.0, 20.0), (50.0, 70.0), (4.0, 5.0)], 10.0) == [(3.0, 10.0), (4.0, 5.0)]
