import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.plant.disturbances import DISTURBANCE, Load, disturbance
from dwmr.plant.robot import ROBOT, State, advance, body, derivative, pd_torques, slewed

NO_LOAD = Load(0.0, 0.0, 1.0, 1.0)
CALM = np.zeros(0, dtype=DISTURBANCE).view(np.recarray)


def state(*values):
    """A state of floats: whole numbers would have the functions compiled once more."""
    return State(*(float(v) for v in values))


def robot(**changes):
    values = {
        "mass": 120.0, "inertia": 13.8, "com_offset": -0.0865, "d": 0.1, "half_track": 0.268, "wheel_radius": 0.13,
        "stick_v": 0.01, "stick_omega": 0.01, "lag": 0.02, "torque_limit": 34.0, "v_limit": 2.0, "omega_limit": 6.28,
        "k_p_v": 40.0, "k_p_omega": 40.0, "k_d_v": 20.0, "k_d_omega": 20.0, "n_v": 10.0, "n_omega": 10.0,
        "pd_mass": 120.0, "pd_inertia": 13.8,
    } | changes  # fmt: skip
    row = np.zeros(1, dtype=ROBOT)
    for name, value in values.items():
        row[name] = value
    return row.view(np.recarray)[0]


def rate(start, right=0.0, left=0.0, acting=CALM, load=NO_LOAD, t=0.0, **changes):
    one = robot(**changes)
    return derivative(start, right, left, one, body(t, one, load), disturbance(t, acting))


class TestDerivative:
    @given(st.floats(-3, 3), st.floats(-2, 2), st.floats(-2, 2))
    def test_moves_the_reference_point_without_slipping_sideways(self, theta, v, omega):
        r = rate(state(0, 0, theta, v, omega, 0, 0))
        ahead = r.x * math.cos(theta) + r.y * math.sin(theta)
        aside = -r.x * math.sin(theta) + r.y * math.cos(theta)
        assert ahead == pytest.approx(v, abs=1e-12)
        assert aside == pytest.approx(0.1 * omega, abs=1e-12)

    def test_equal_torques_drive_straight_on(self):
        r = rate(state(0, 0, 0, 0, 0, 3.9, 3.9))
        assert r.v == pytest.approx(2 * 3.9 / 0.13 / 120.0)
        assert r.omega == 0.0

    def test_a_stronger_right_wheel_turns_left(self):
        r = rate(state(0, 0, 0, 0, 0, 3.9, -3.9))
        assert r.omega == pytest.approx(2 * 3.9 * 0.268 / 0.13 / 13.8)
        assert r.v == 0.0

    @given(st.floats(-2, 2), st.floats(-2, 2))
    def test_coriolis_terms_do_no_work(self, v, omega):
        r = rate(state(0, 0, 0, v, omega, 0, 0))
        assert 120.0 * v * r.v + 13.8 * omega * r.omega == pytest.approx(0.0, abs=1e-9)

    def test_coriolis_terms_carry_the_load(self):
        start, load = state(0, 0, 0, 0.5, 0.4, 0, 0), Load(0.0, 1.0, 1.25, 1.5)
        r = rate(start, load=load)
        moment = 1.25 * 120.0 * -0.0865
        assert r.v == pytest.approx(moment * 0.4**2 / (1.25 * 120.0))
        assert r.omega == pytest.approx(-moment * 0.4 * 0.5 / (1.5 * 13.8))

    @given(st.floats(-2, 2), st.floats(-2, 2))
    def test_friction_only_brakes(self, v, omega):
        r = rate(
            state(0, 0, 0, v, omega, 0, 0),
            coulomb_force=6.0, coulomb_torque=1.5, viscous_force=5.0, viscous_torque=2.0, com_offset=0.0,
        )  # fmt: skip
        assert v * r.v <= 0.0
        assert omega * r.omega <= 0.0

    def test_a_load_makes_it_slower_in_its_window_only(self):
        start, load = state(0, 0, 0, 0, 0, 3.9, 3.9), Load(40.0, 160.0, 1.25, 1.5)
        assert rate(start, t=40.0, load=load).v == pytest.approx(rate(start).v / 1.25)
        assert rate(start, t=160.0, load=load).v == rate(start).v
        turning = state(0, 0, 0, 0, 0, 3.9, -3.9)
        assert rate(turning, t=100.0, load=load).omega == pytest.approx(rate(turning).omega / 1.5)

    def test_velocity_disturbances_move_it_and_force_disturbances_push_it(self):
        acting = np.array([(0.0, 1.0, 0.0, 0.0, 0.2, 0.05, 12.0, 1.38)], dtype=DISTURBANCE).view(np.recarray)
        r = rate(state(0, 0, 0, 0, 0, 0, 0), acting=acting)
        assert (r.x, r.y, r.theta) == pytest.approx((0.2, 0.1 * 0.05, 0.05))
        assert (r.v, r.omega) == pytest.approx((0.1, 0.1))

    def test_torques_follow_their_commands_with_the_lag(self):
        r = rate(state(0, 0, 0, 0, 0, 1.0, 2.0), right=3.0, left=-4.0)
        assert (r.torque_right, r.torque_left) == pytest.approx((2.0 / 0.02, -6.0 / 0.02))


class TestAdvance:
    def test_converges_with_the_substeps(self):
        one, start = robot(coulomb_force=6.0, viscous_force=5.0), state(0, 0, 0.3, 0.5, 0.4, 2.0, 1.0)
        coarse = advance(0.0, start, 5.0, 4.0, one, CALM, NO_LOAD, 0.005, 4)
        fine = advance(0.0, start, 5.0, 4.0, one, CALM, NO_LOAD, 0.005, 64)
        assert tuple(coarse) == pytest.approx(tuple(fine), abs=1e-7)

    def test_agrees_with_an_adaptive_integrator(self):
        from scipy.integrate import solve_ivp

        one, start = robot(viscous_force=5.0, viscous_torque=2.0), state(0, 0, 0.3, 0.5, 0.4, 2.0, 1.0)

        def rhs(t, y):
            return list(derivative(state(*y), 5.0, 4.0, one, body(0.0, one, NO_LOAD), disturbance(t, CALM)))

        exact = solve_ivp(rhs, (0.0, 0.5), list(start), rtol=1e-10, atol=1e-12).y[:, -1]
        reached = start
        for k in range(100):
            reached = advance(k * 0.005, reached, 5.0, 4.0, one, CALM, NO_LOAD, 0.005, 4)
        assert tuple(reached) == pytest.approx(tuple(exact), abs=1e-8)


class TestPdTorques:
    def test_gives_the_printed_law_to_the_nominal_robot(self):
        right, left, _, _ = pd_torques(0.01, 0.0, 0.0, 0.0, robot(), 0.005)
        force = (right + left) / 0.13
        assert force / 120.0 == pytest.approx(40.0 * 0.01 + 20.0 * 10.0 * 0.01)
        assert right == left

    def test_turns_with_the_wheels_apart(self):
        right, left, _, _ = pd_torques(0.0, 0.01, 0.0, 0.0, robot(), 0.005)
        torque = (right - left) * 0.268 / 0.13
        assert torque / 13.8 == pytest.approx(2.4)
        assert right == -left

    def test_gains_read_as_forces_do_not_know_the_mass(self):
        as_acceleration, *_ = pd_torques(0.001, 0.0, 0.0, 0.0, robot(), 0.005)
        as_force, *_ = pd_torques(0.001, 0.0, 0.0, 0.0, robot(pd_mass=1.0, pd_inertia=1.0), 0.005)
        assert as_acceleration == pytest.approx(120.0 * as_force)

    def test_derivative_fades_for_a_constant_error(self):
        filter_v = filter_omega = 0.0
        for _ in range(1000):
            right, left, filter_v, filter_omega = pd_torques(0.01, 0.0, filter_v, filter_omega, robot(), 0.005)
        assert filter_v == pytest.approx(0.01)
        assert (right + left) / 0.13 / 120.0 == pytest.approx(0.4)

    @given(st.floats(-10, 10), st.floats(-10, 10))
    def test_respects_the_limit(self, e_v, e_omega):
        right, left, _, _ = pd_torques(e_v, e_omega, 0.0, 0.0, robot(), 0.005)
        assert max(abs(right), abs(left)) <= 34.0


class TestSlewed:
    def test_is_the_limited_command_itself_without_a_limit_of_acceleration(self):
        assert slewed(0.1 + 0.2, 1.0, 0.7, math.inf, 0.005) == 0.1 + 0.2
        assert slewed(-3.0, 1.0, 0.7, math.inf, 0.005) == -1.0

    @given(st.floats(-10, 10), st.floats(-1, 1), st.floats(0.01, 100))
    def test_goes_towards_the_command_and_no_faster_than_its_rate(self, command, before, rate):
        after = slewed(command, 1.0, before, rate, 0.005)
        wanted = max(-1.0, min(1.0, command))
        assert abs(after - before) <= rate * 0.005 * (1 + 1e-9)
        assert abs(wanted - after) == pytest.approx(max(0.0, abs(wanted - before) - rate * 0.005), abs=1e-12)
