"""The paper's run computed a second time, by other means: its equations in plain Python, and scipy between samples.

Nothing of dwmr but the numbers of the scenario enters. The plant is integrated by an adaptive method of order 8 from
one control period to the next; the fuzzy systems are evaluated rule by rule from the tables as printed.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dwmr import find, read
from tests import sizes

#: Length of the run [s]; what acts from 3 to 20 s begins within the shorter one, too.
HORIZON = f"run.horizon={sizes.examples(20, 8)}"
#: Tables 2, 6 and 7: peaks of σ*, of its rate, and of the term in each cell.
SIGMA = [-0.030, -0.015, 0.0, 0.015, 0.030]
RATE = [-0.50, -0.25, 0.0, 0.25, 0.50]
PEAKS = {"NB": -1.0, "NM": -0.66, "NS": -0.33, "ZO": 0.0, "PS": 0.09, "PM": 0.18}
TABLE_2 = """
NB NM NM NS NS
NM NS ZO PS ZO
ZO PS PM PS ZO
ZO PS ZO NS NM
NS NS NM NM NB
"""
#: Tables 3 and 8: β falls through the peaks as |σ*| rises through them.
LAYER = [0.0050, 0.0162, 0.0275, 0.0387, 0.0500]


def degrees(x, peaks):
    """Return the degrees of triangles with the outer ones open: Fig. 5."""
    return [float(np.interp(x, peaks, np.eye(len(peaks))[k])) for k in range(len(peaks))]


def reaction(sigma, rate):
    """Eq. (18) over the 25 rules of Table 2."""
    consequents = [[PEAKS[cell] for cell in row.split()] for row in TABLE_2.strip().splitlines()]
    strengths = np.outer(degrees(sigma, SIGMA), degrees(rate, RATE))
    return float((strengths * np.array(consequents)).sum() / strengths.sum())


def layer(size):
    """Eq. (18) over the five rules of Table 3."""
    strengths = np.array(degrees(size, LAYER))
    return float(strengths @ np.array(LAYER[::-1]) / strengths.sum())


def turn(angle):
    """Bring an angle into one turn around zero."""
    return math.remainder(angle, 2.0 * math.pi)


class Formation:
    """The scenario's numbers and the run's state: postures and velocities, and what the controllers remember."""

    def __init__(self, scenario):
        self.scenario, self.names = scenario, list(scenario.robots)
        self.robots = list(scenario.robots.values())
        n = len(self.robots)
        self.state = np.zeros((n, 7))
        self.state[:, :3] = [(r.x_0, r.y_0, r.theta_0) for r in self.robots]
        leaders = [r.formation and self.names.index(r.formation.leader) for r in self.robots]
        self.leaders = leaders
        self.star = np.array([math.atan2(1.0, 2.0) if j is None else self.robots[j].theta_0 for j in leaders])
        self.k_h = np.full((n, 2), 0.1)
        self.sigma = np.full((n, 2), math.nan)
        self.filter = np.zeros((n, 2))
        self.side = {}

    def disturbance(self, t):
        """Section 7: what acts at a time, for all robots alike."""
        total = np.zeros(4)
        for one in self.scenario.disturbances:
            if one.start <= t < one.stop:
                shape = math.sin(one.angular_frequency * t + one.phase) if one.kind == "sinusoid" else 1.0
                total += shape * np.array([one.v, one.omega, one.force, one.torque])
        return total

    def reference(self, t, i):
        """Eq. (76) with x and y exchanged; in avoidance Eqs. (56)-(71)."""
        w = 2.0 * math.pi / 200.0
        x, y = 15.0 * math.sin(2.0 * w * t), 15.0 * math.sin(w * t)
        x_dot, y_dot = 30.0 * w * math.cos(2.0 * w * t), 15.0 * w * math.cos(w * t)
        theta, v = math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot)
        p, own = self.scenario.avoidance, self.state[i]
        near = []
        for a, obstacle in enumerate(self.scenario.obstacles):
            way = np.array([obstacle.x, obstacle.y]) - own[:2]
            gap, angle = float(np.linalg.norm(way)), math.atan2(way[1], way[0])
            closing = abs(own[3] * math.cos(own[2] - angle))
            reach = obstacle.radius + self.robots[i].radius + p.margin
            reach = min(p.largest_radius, reach + p.kappa * closing / (p.gamma * math.exp(p.rho * gap)))
            if not obstacle.radius < gap <= reach:
                self.side.pop(a, None)
                continue
            side = self.side.setdefault(a, 1.0 if turn(own[2] - angle) >= 0.0 else -1.0)
            u = way - reach / gap * way + side * np.array([-way[1], way[0]])
            near.append((gap, math.atan2(u[1], u[0])))
        if self.robots[i].avoids_obstacles and near:
            theta, v = min(near)[1], p.slowdown * v
        return x, y, theta, v

    def error(self, t, i):
        """Eqs. (4)-(6) for the leader, (44)-(51) for a follower: x_e, y_e, θ*_e, A_0, and the turn of θ*."""
        x, y, theta = self.state[i, :3]
        d, star = self.robots[i].d, self.star[i]
        frame = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
        j = self.leaders[i]
        if j is None:
            x_r, y_r, theta_r, v_r = self.reference(t, i)
            x_e, y_e = frame @ [x_r - x, y_r - y]
            drift = [v_r * math.cos(theta_r - theta), v_r * math.sin(theta_r - theta)]
            return x_e, y_e, turn(star - theta), *drift, -v_r / d * math.sin(star - theta_r)
        lead, formation, acting = self.state[j], self.robots[i].formation, self.disturbance(t)
        v, omega = lead[3] + acting[0], lead[4] + acting[1]
        length, angle = formation.separation, formation.bearing + lead[2]
        axle = lead[:2] - self.robots[j].d * np.array([math.cos(lead[2]), math.sin(lead[2])])
        place = axle + length * np.array([math.cos(angle), math.sin(angle)])
        x_e, y_e = frame @ (place - [x, y])
        moves = [v * math.cos(lead[2]) - length * omega * math.sin(angle),
                 v * math.sin(lead[2]) + length * omega * math.cos(angle)]  # fmt: skip
        sideways = -math.sin(star) * moves[0] + math.cos(star) * moves[1]
        return x_e, y_e, turn(star - theta), *(frame @ moves), sideways / d

    def command(self, error, i, dt):
        """Eqs. (9), (11)-(13), (19)-(22): the velocities asked for, and the gains after the period."""
        x_e, y_e, theta_e, a_x, a_y, a_theta = error
        g = SimpleNamespace(**self.robots[i].controllers["aifqsmc"])
        jacobian = np.array([[g.lambda_1, 0.0, 0.0], [0.0, g.lambda_2, g.lambda_3]])
        b = jacobian @ [[-1.0, y_e], [0.0, -(self.robots[i].d + x_e)], [0.0, -1.0]]
        sigma = b.T @ jacobian @ [x_e, y_e, theta_e]
        rate = np.zeros(2) if math.isnan(self.sigma[i, 0]) else (sigma - self.sigma[i]) / dt
        push = np.zeros(2)
        for k, (p, gamma, epsilon) in enumerate(
            [(g.p_v, g.gamma_v, g.epsilon_v), (g.p_omega, g.gamma_omega, g.epsilon_omega)]
        ):
            size, beta, k_h = abs(sigma[k]), layer(abs(sigma[k])), self.k_h[i, k]
            inside = size <= beta
            gain = k_h - 0.55 * reaction(sigma[k], rate[k])
            push[k] = gain * (sigma[k] / beta if inside else np.sign(sigma[k])) + p * sigma[k]
            grows = gamma * (size**2 / beta if inside else size) * np.sign(size - epsilon)
            self.k_h[i, k] = max(0.1, k_h + dt * (grows if k_h > 0.1 else 0.1))
        self.sigma[i] = sigma
        return -np.linalg.solve(b, jacobian @ [a_x, a_y, a_theta]) - push

    def torques(self, command, i, dt):
        """Eqs. (2), (75): k_p + k_d N/(1 + N/s) on both velocities, as accelerations; forces to wheels."""
        r, loop, drive = self.robots[i], self.robots[i].inner_loop, self.robots[i].actuator
        command = np.clip(command, [-drive.v_limit, -drive.omega_limit], [drive.v_limit, drive.omega_limit])
        e, n = command - self.state[i, 3:5], np.array([loop.n_v, loop.n_omega])
        derivative = n * (e - self.filter[i])
        u = np.array([loop.k_p_v, loop.k_p_omega]) * e + np.array([loop.k_d_v, loop.k_d_omega]) * derivative
        self.filter[i] += (1.0 - np.exp(-n * dt)) * (e - self.filter[i])
        force, torque = r.mass * u[0], r.inertia * u[1]
        wheels = r.wheel_radius / 2.0 * np.array([force + torque / r.half_track, force - torque / r.half_track])
        return np.clip(wheels, -drive.torque_limit, drive.torque_limit)

    def plant(self, t, state, asked, i):
        """Eqs. (1), (46) with the plant's own inertia, friction, and the lag of the drives."""
        r, f, load, acting = self.robots[i], self.robots[i].friction, self.scenario.load, self.disturbance(t)
        theta, v, omega, right, left = state[2:]
        loaded = load.start <= t < load.stop
        m, inertia = r.mass * (load.mass_factor if loaded else 1), r.inertia * (load.inertia_factor if loaded else 1)
        force = (right + left) / r.wheel_radius + acting[2] - f.viscous_force * v
        force -= f.coulomb_force * v / (abs(v) + f.stick_v)
        torque = (right - left) * r.half_track / r.wheel_radius + acting[3] - f.viscous_torque * omega
        torque -= f.coulomb_torque * omega / (abs(omega) + f.stick_omega)
        moment = m * r.com_offset
        along, turning = v + acting[0], omega + acting[1]
        return [
            along * math.cos(theta) - r.d * turning * math.sin(theta),
            along * math.sin(theta) + r.d * turning * math.cos(theta),
            turning,
            (force + moment * omega**2) / m,
            (torque - moment * v * omega) / inertia,
            (asked[0] - right) / r.actuator.lag,
            (asked[1] - left) / r.actuator.lag,
        ]

    def step(self, t, dt):
        """Let all robots decide, then move them."""
        errors = [self.error(t, i) for i in range(len(self.robots))]
        for i, error in enumerate(errors):
            asked = self.torques(self.command(error, i, dt), i, dt)
            errors[i] = (error, asked)
        for i, (error, asked) in enumerate(errors):
            self.star[i] += dt * error[5]
            # windows begin and end at multiples of the period, so that nothing jumps inside it
            end = t + dt * (1 - 1e-12)
            done = solve_ivp(
                lambda at, s, asked=asked, i=i, end=end: self.plant(min(at, end), s, asked, i),
                (t, t + dt),
                self.state[i],
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
            )
            self.state[i] = done.y[:, -1]


@pytest.fixture(scope="module")
def independent():
    """Postures and velocities of the first seconds, shape (samples, robots, 5)."""
    scenario = read(find("paper-with-limits"), [HORIZON]).scenario
    formation, dt = Formation(scenario), scenario.run.dt
    states = []
    for k in range(scenario.run.steps + 1):
        states.append(formation.state[:, :5].copy())
        formation.step(k * dt, dt)
    return np.array(states)


def test_an_independent_run_agrees(independent, run_with_limits):
    _, trajectory = run_with_limits("aifqsmc", HORIZON)
    assert np.abs(trajectory.values[:, :, :3] - independent[:, :, :3]).max() < 1e-6


def test_velocities_converge_as_the_integration_steps_shrink(independent, run_with_limits):
    """The largest difference is where friction turns round with a robot that stops, at about 3.1 s.

    Its force has a kink there. A step that holds the kink is off by the square of its length times where in it the kink
    lies, and not by the fourth power: a quarter of the step gives about a sixteenth of the difference.
    """
    off = {}
    for substeps in (4, 16, 64):
        _, trajectory = run_with_limits("aifqsmc", HORIZON, f"run.substeps={substeps}")
        off[substeps] = np.abs(trajectory.values[:, :, :5] - independent).max()
    assert off[16] < off[4] / 4
    assert off[64] < 1e-8
