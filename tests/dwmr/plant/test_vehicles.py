"""Cars and omnidirectional robots: what mechanics says of them, and their runs behind the formation of the paper."""

import math

import numpy as np
import pytest

from dwmr.control.formation import behind_sideways, follower_error, follower_position, with_leaders_orientation
from dwmr.plant.disturbances import DISTURBANCE, Load
from dwmr.plant.robot import ROBOT, State
from dwmr.plant.vehicles import ASKED, OWN, STEERING, V_Y, steering_angle, vehicle
from tests.dwmr.scenarios import shared

DT, SUBSTEPS = 0.005, 4


class Driven:
    """One vehicle without friction under held commands."""

    def __init__(self, kind, **parameters):
        robots = np.zeros(1, dtype=ROBOT)
        given = {"mass": 120.0, "inertia": 13.8, "d": 0.1, "half_track": 0.3, "wheel_radius": 0.13, "lag": 0.001}
        given |= {"wheelbase": 0.5, "steering_limit": 0.6, "steering_rate": 1.0}
        given |= {"stick_v": 0.01, "stick_omega": 0.01} | parameters
        for name, value in given.items():
            robots[name] = value
        self.robot = robots.view(np.recarray)[0]
        self.acting = np.zeros(0, dtype=DISTURBANCE).view(np.recarray)
        self.functions, self.own, self.plant = vehicle(kind), np.zeros(OWN), np.zeros(7)

    @property
    def state(self):
        return State(*self.plant)

    def drive(self, right, left, asked, seconds):
        torques, load = np.array([right, left], dtype=float), Load(0.0, 0.0, 1.0, 1.0)
        self.own[ASKED] = asked
        for k in range(round(seconds / DT)):
            self.functions.advance(k * DT, self.plant, torques, self.robot, self.acting, load, DT, SUBSTEPS, self.own)
        return self.state


class TestCar:
    def test_keeps_its_rear_axle_on_the_circle_of_its_steering_angle(self):
        car = Driven("ackermann")
        car.drive(0, 0, 0.4, 1)
        start = car.drive(5, 5, 0.4, 2)
        radius = 0.5 / math.tan(0.4)

        def centre(s):
            x, y = s.x - 0.1 * math.cos(s.theta), s.y - 0.1 * math.sin(s.theta)
            return x - radius * math.sin(s.theta), y + radius * math.cos(s.theta)

        assert centre(start) == pytest.approx((-0.1, radius), abs=1e-6)
        assert start.omega == pytest.approx(start.v / radius)

    def test_has_the_energy_that_its_drives_gave_it(self):
        car = Driven("ackermann")
        car.drive(0, 0, 0.4, 1)
        s = car.drive(5, 5, 0.4, 2)
        way = s.theta * 0.5 / math.tan(0.4)
        energy = 0.5 * 120 * s.v**2 + 0.5 * 13.8 * s.omega**2
        assert energy == pytest.approx(10 / 0.13 * way, rel=2e-3)  # less what the lag keeps back at the begin

    def test_keeps_its_energy_as_it_steers_without_drive(self):
        car = Driven("ackermann")
        before = car.drive(5, 5, 0.0, 2)
        after = car.drive(0, 0, 0.6, 1)
        drifting = 0.5 * 120 * before.v**2
        assert 0.5 * 120 * after.v**2 + 0.5 * 13.8 * after.omega**2 == pytest.approx(drifting, rel=2e-3)
        assert after.v < before.v

    def test_steers_no_faster_than_its_rate(self):
        car = Driven("ackermann")
        car.drive(0, 0, 0.6, 0.25)
        assert car.own[STEERING] == pytest.approx(0.25)
        car.drive(0, 0, 0.6, 1)
        assert car.own[STEERING] == 0.6

    @pytest.mark.parametrize(
        ("v", "omega", "angle"),
        [(1, 1, math.atan(0.5)), (-1, 1, -math.atan(0.5)), (0, 0, 0), (0, 1, 0.6), (0.1, -9, -0.6)],
    )
    def test_is_steered_to_the_curvature_of_its_command(self, v, omega, angle):
        assert steering_angle(v, omega, 0.5, 0.6) == pytest.approx(angle)


class TestOmnidirectionalRobot:
    def test_keeps_momentum_and_spin_when_nothing_acts(self):
        robot = Driven("omnidirectional", com_offset=-0.08)

        def momenta():
            s, u, c = robot.state, robot.own[V_Y], -0.08
            v_x, v_y = s.v, u + c * s.omega
            turned = np.array([[math.cos(s.theta), -math.sin(s.theta)], [math.sin(s.theta), math.cos(s.theta)]])
            spin = 13.8 - 120 * c**2
            return 120 * turned @ [v_x, v_y], spin * s.omega

        robot.drive(3, -1, 2, 1)
        robot.drive(0, 0, 0, 0.1)  # until the lag is over
        (p_x, p_y), spin = momenta()
        robot.drive(0, 0, 0, 3)
        assert robot.state.omega != 0
        assert momenta()[0] == pytest.approx([p_x, p_y], rel=1e-6)
        assert momenta()[1] == pytest.approx(spin)

    def test_goes_to_its_left_without_turning(self):
        robot = Driven("omnidirectional")
        s = robot.drive(0, 0, 2, 1)
        assert (s.x, s.theta, s.v, s.omega) == (0, 0, 0, 0)
        assert s.y == pytest.approx(0.5 * 2 / 0.13 / 120, rel=5e-3)


def test_the_error_behind_a_leader_that_moves_sideways_is_the_motion_of_its_place():
    theta_i, v, u, omega, theta_j, star, h = 0.7, 0.4, 0.3, 0.2, -0.2, 0.1, 1e-6

    def place(t):
        x = (v * math.cos(theta_i) - u * math.sin(theta_i)) * t
        y = (v * math.sin(theta_i) + u * math.cos(theta_i)) * t
        return follower_position(x, y, theta_i + omega * t, 0.0, 1.25, 2.3)

    plain = follower_error(0, 0, theta_i, v, omega, 0.0, 1.0, 2.0, theta_j, star, 0.4, 1.25, 2.3)
    error = behind_sideways(plain, u, theta_i, theta_j, star)
    (x0, y0), (x1, y1) = place(-h), place(h)
    v_x, v_y = (x1 - x0) / (2 * h), (y1 - y0) / (2 * h)
    c, s = math.cos(theta_j), math.sin(theta_j)
    assert (error.drift_x, error.drift_y) == pytest.approx((c * v_x + s * v_y, c * v_y - s * v_x))
    across = v_y * math.cos(star) - v_x * math.sin(star)
    assert error.drift_theta == pytest.approx(across / 0.4)
    kept = with_leaders_orientation(error, theta_i, omega, theta_j)
    assert (kept.theta_e_star, kept.drift_theta) == pytest.approx((0.9, omega))


def run(name, law="", *overrides):
    return shared(name, law, "run.horizon=60", *overrides)[1]


class TestRuns:
    @pytest.mark.parametrize(("name", "most"), [("ackermann", 0.25), ("omnidirectional", 0.15)])
    def test_the_formation_comes_together_and_stays(self, name, most):
        trajectory = run(name, "", "obstacles=[]")
        assert trajectory.stop is None
        settled = trajectory.t > 40
        assert np.abs(trajectory["x_e"][settled]).max() < most
        assert np.abs(trajectory["y_e"][settled]).max() < most

    def test_a_car_that_starts_the_wrong_way_round_comes_to_its_place(self):
        trajectory = run("ackermann", "", "obstacles=[]", "robots.follower1.theta_0=3.0")
        settled = trajectory.t > 40
        assert np.abs(trajectory["x_e"][settled, 1]).max() < 0.25
        assert np.abs(trajectory["y_e"][settled, 1]).max() < 0.25
        assert trajectory["v_c"].min() >= 0

    def test_a_car_turns_within_its_limits(self):
        trajectory = run("ackermann", "aifqsmc")
        angle = trajectory["steering"]
        assert np.abs(angle).max() <= 0.6
        assert np.abs(np.diff(angle, axis=0)).max() <= 1.0 * DT + 1e-12
        assert np.tan(angle) * trajectory["v"] / 0.5 == pytest.approx(trajectory["omega"], abs=1e-9)

    def test_a_law_without_a_lateral_command_drives_four_wheels_as_two(self):
        as_two = run("omnidirectional", "aifqsmc")
        settled = as_two.t > 40
        assert np.abs(as_two["v_y"][settled]).max() < 0.01  # what turning leaves to the inner loop
        two = run("undisturbed", "aifqsmc", "obstacles=[]")
        assert as_two["x"][settled] == pytest.approx(two["x"][settled], abs=0.02)

    def test_formations_of_several_kinds_keep_together(self):
        car = 'robots.follower1.vehicle={kind="ackermann",wheelbase=0.5,steering_limit=0.6,steering_rate=1.0}'
        trajectory = run("undisturbed", "aifqsmc", "obstacles=[]", car)
        assert np.abs(trajectory["x_e"][trajectory.t > 40]).max() < 0.25
        assert np.all(trajectory["steering"][:, [0, 2]] == 0)
