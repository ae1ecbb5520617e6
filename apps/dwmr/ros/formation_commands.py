"""Velocity commands of a formation of real robots, from their odometry: the loop's decisions without its plant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import ahead, wrap
from dwmr.core.jit import collected_errors, first_class_functions
from dwmr.scenario.command_limits import limited
from dwmr.scenario.vehicles import Omnidirectional
from dwmr.simulation.periods import Periods, Simulation
from dwmr.simulation.simulate import Stop, reason_of


class Odometry(NamedTuple):
    """What a robot measures of itself.

    Attributes:
        x, y, theta: Posture of the middle of its wheel axis, in a frame that all robots share [m, m, rad].
        v, omega: Its velocities ahead and turning [m/s, rad/s].
        v_y: Its velocity to the left, which only an omnidirectional robot has [m/s].
    """

    x: float
    y: float
    theta: float
    v: float
    omega: float
    v_y: float = 0.0


class StoppedError(RuntimeError):
    """Raised when a control law cannot go on; `stop` says why."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(f"robot {stop.robot} at t = {stop.t:.3f} s: {stop.reason}")
        self.stop = stop


class FormationCommands:
    """Velocity commands of all robots, one control period after the other; they are compiled when this is made.

    Args:
        simulation: From `simulate.prepare`. Its plant, disturbances and sensors have no part in the commands.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._periods, self._next = Periods(simulation, measured=True), 0
        self._robots = simulation.scenario.robots
        self.dt = simulation.scenario.run.dt
        with first_class_functions():
            self._periods.compute(0, 0, *self._periods.given(0, 0))

    @property
    def has_ended(self) -> bool:
        """Whether the horizon is reached."""
        return self._next == self._periods.samples

    def decide(self, odometry: Sequence[Odometry]) -> FloatArray:
        """Compute the commands of the next control period.

        Args:
            odometry: Of all robots, in the order of the scenario.

        Returns:
            Velocity of each robot ahead, to its left, and turning, within its limits, shape (n, 3) [m/s, m/s, rad/s].

        Raises:
            StoppedError: When the law reports a fault, or numbers become infinite or too large.
            DiagnosticError: When a law in Python raises an error.
        """
        periods, k = self._periods, self._next
        self._measure(odometry)
        with first_class_functions(), collected_errors() as periods.raised:
            # Not by law_errors: robots drive on while the line of an error is looked for.
            _, faulty, fault = periods.compute(k, k + 1, *periods.given(k, k + 1))
        if fault:
            reason = reason_of(fault, periods.record[k, faulty], periods.simulation.module)
            raise StoppedError(Stop(k * self.dt, list(self._robots)[faulty], reason))
        self._next += 1
        asked = np.zeros((len(self._robots), 3))
        asked[:, ::2] = periods.record[k, :, 12:14] if periods.guard is None else periods.guard[1].commands
        if periods.vehicles is not None and periods.vehicles.lateral >= 0:
            asked[:, 1] = periods.law_record[k, :, periods.vehicles.lateral]
        return np.stack([limited(one, robot) for one, robot in zip(asked, self._robots.values(), strict=True)])

    def _measure(self, odometry: Sequence[Odometry]) -> None:
        """Write what robots measure as the state of the loop, whose orientations are not wrapped."""
        state, names = self._periods.memory.plant, list(self._robots)
        for i, (one, robot) in enumerate(zip(odometry, self._robots.values(), strict=True)):
            theta = one.theta if self._next == 0 else state[i, 2] + wrap(one.theta - state[i, 2])
            state[i, :5] = (*ahead(one.x, one.y, theta, robot.d), theta, one.v, one.omega)
            if isinstance(robot.vehicle, Omnidirectional) and self._periods.vehicles is not None:
                self._periods.vehicles.state[i, 0] = one.v_y
        if self._next == 0:  # θ*_jr(0) = θ_i(0), as it is and not as the scenario says
            for i, robot in enumerate(self._robots.values()):
                if robot.formation is not None:
                    self._periods.memory.theta_star[i] = state[names.index(robot.formation.leader), 2]
