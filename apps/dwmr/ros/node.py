"""A node of ROS 2: odometry of all robots in, velocity commands out.

It is written against the interface of rclpy and is handed its node and its message types, so that it needs no ROS to be
imported or tested.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import ahead, wrap, yaw
from dwmr.core.jit import collected_errors, first_class_functions
from dwmr.plant.vehicles import V_Y
from dwmr.scenario.model import Omnidirectional
from dwmr.scenario.vehicle_limits import limited
from dwmr.simulation.periods import Periods, Simulation, first_directions
from dwmr.simulation.simulate import Stop, reason_of
from fuzzyctl.ros.program import Period


class Odometry(NamedTuple):
    """Measured state of a robot.

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
        return self._next == self._periods.total

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
            reason = reason_of(fault, periods.record[periods.row(k), faulty], periods.simulation.module)
            raise StoppedError(Stop(k * self.dt, list(self._robots)[faulty], reason))
        self._next += 1
        asked = np.zeros((len(self._robots), 3))
        asked[:, ::2] = periods.record[periods.row(k), :, 12:14] if periods.guard is None else periods.guard[1].commands
        if periods.world.lateral >= 0:
            asked[:, 1] = periods.law_record[periods.row(k), :, periods.world.lateral]
        return np.stack([limited(one, robot) for one, robot in zip(asked, self._robots.values(), strict=True)])

    def _measure(self, odometry: Sequence[Odometry]) -> None:
        """Write the measured states into the loop, whose orientations are not wrapped."""
        state = self._periods.memory.plant
        for i, (one, robot) in enumerate(zip(odometry, self._robots.values(), strict=True)):
            theta = one.theta if self._next == 0 else state[i, 2] + wrap(one.theta - state[i, 2])
            state[i, :5] = (*ahead(one.x, one.y, theta, robot.d), theta, one.v, one.omega)
            if isinstance(robot.vehicle, Omnidirectional):
                self._periods.memory.own[i, V_Y] = one.v_y
        if self._next == 0:  # θ*_jr(0) = θ_i(0), as it is and not as the scenario says
            self._periods.memory.theta_star[:] = first_directions(self._periods.simulation, state[:, 2])


#: Quaternions whose length is farther from 1 are not orientations.
_LENGTH = 1e-3


class Settings(NamedTuple):
    """Settings from the parameters of the node.

    Attributes:
        frame: Frame of all odometry.
        base_frame: Frame of each robot, with or without its name in front: the middle of its wheel axis.
        timeout: Largest age of odometry [s].
        stamped: Whether commands are geometry_msgs/TwistStamped.
    """

    frame: str
    base_frame: str
    timeout: float
    stamped: bool


class FormationNode:
    """Computes commands at the control period, and stops all robots while odometry of one is missing.

    Callbacks of odometry only keep the message.

    Args:
        node: Node of rclpy.
        robots: Names of the robots, which are the namespaces of their topics.
        commands: Computes the commands.
        settings: Parameters.
        messages: The types nav_msgs.msg.Odometry, and geometry_msgs.msg.Twist or TwistStamped.
        qos: Quality of service of odometry, that of sensor data.
    """

    def __init__(
        self,
        node: Any,
        robots: Sequence[str],
        commands: FormationCommands,
        settings: Settings,
        messages: tuple[Callable[[], Any], Callable[[], Any]],
        qos: Any,
    ) -> None:
        odometry, self._twist = messages
        self._node, self._robots, self._commands, self._settings = node, tuple(robots), commands, settings
        self._log = node.get_logger()
        self._latest: dict[str, Any] = {}
        self._problems: tuple[str, ...] = ()
        self._stamps: dict[str, int] = {}
        self._repeated: set[str] = set()
        self._publishers = [node.create_publisher(self._twist, f"{name}/cmd_vel", 1) for name in robots]
        for name in robots:
            node.create_subscription(odometry, f"{name}/odom", partial(self._keep, name), qos)
        self._period = Period(node, commands.dt)
        node.create_timer(commands.dt, self.tick)
        #: Whether the run has ended.
        self.has_ended = False
        #: Whether it ended before its horizon.
        self.failed = False

    def tick(self) -> None:
        """Publish the commands of one control period, or zeros."""
        if self.has_ended:
            return
        now = self._node.get_clock().now().nanoseconds
        self._period.begin(now)
        problems = tuple(p for name in self._robots if (p := self._problem(name, now)))
        if problems != self._problems:
            if problems:
                self._log.warning("robots stopped: " + "; ".join(problems))
            else:
                self._log.info("odometry of all robots is there: the run goes on")
            self._problems = problems
        if problems:
            self.stop()
            return
        self._warn_of_repeats()
        self._command()

    def _warn_of_repeats(self) -> None:
        """Warn once of each robot whose odometry two control periods see."""
        for name in self._robots:
            stamp = _nanoseconds(self._latest[name].header.stamp)
            if stamp == self._stamps.get(name) and name not in self._repeated:
                self._repeated.add(name)
                self._log.warning(
                    f"two control periods of {self._commands.dt:g} s see one stamp of {name}/odom: "
                    "publish it as often, or raise run.dt"
                )
            self._stamps[name] = stamp

    def stop(self) -> None:
        """Publish zeros to all robots."""
        self._publish([(0.0, 0.0, 0.0)] * len(self._robots))

    def _keep(self, name: str, message: Any) -> None:
        """Keep the odometry of a robot, without any computation."""
        self._latest[name] = message

    def _command(self) -> None:
        try:
            commands = self._commands.decide([_read(self._latest[name]) for name in self._robots])
        except StoppedError as error:
            self.has_ended = self.failed = True
            self.stop()
            self._log.error(f"robots stopped: {error}")
            return
        self._publish(commands.tolist())
        if self._commands.has_ended:
            self.has_ended = True
            self.stop()
            self._log.info("robots stopped: the end of the run")

    def _publish(self, commands: Sequence[Sequence[float]]) -> None:
        """Publish velocities ahead, to the left, and turning of all robots [m/s, m/s, rad/s]."""
        for name, publisher, command in zip(self._robots, self._publishers, commands, strict=True):
            message = twist = self._twist()
            if self._settings.stamped:
                message.header.stamp = self._node.get_clock().now().to_msg()
                odometry = self._latest.get(name)
                message.header.frame_id = odometry.child_frame_id if odometry else self._settings.base_frame
                twist = message.twist
            twist.linear.x, twist.linear.y, twist.angular.z = command
            publisher.publish(message)

    def _problem(self, name: str, now: int) -> str:
        """Return why the odometry of a robot cannot be used at a time [ns], an empty string where it can."""
        message, settings = self._latest.get(name), self._settings
        if message is None:
            return f"no odometry on {name}/odom"
        if abs(now - _nanoseconds(message.header.stamp)) > 1e9 * settings.timeout:
            return f"no odometry on {name}/odom with a stamp within {settings.timeout:g} s of now"
        if message.header.frame_id != settings.frame:
            return f"{name}/odom is in the frame '{message.header.frame_id}', expected '{settings.frame}'"
        if message.child_frame_id not in (settings.base_frame, f"{name}/{settings.base_frame}"):
            return f"{name}/odom is of the frame '{message.child_frame_id}', expected '{settings.base_frame}'"
        turn = message.pose.pose.orientation
        if not abs(math.hypot(turn.x, turn.y, turn.z, turn.w) - 1.0) < _LENGTH:
            return f"the orientation in {name}/odom is no unit quaternion"
        if not all(math.isfinite(number) for number in _read(message)):
            return f"a number in {name}/odom is not finite"
        return ""


def _nanoseconds(stamp: Any) -> int:
    """Return the time of a builtin_interfaces/Time [ns]."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _read(message: Any) -> Odometry:
    """Return the numbers of a nav_msgs/Odometry."""
    place, turn, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
    theta = yaw(turn.x, turn.y, turn.z, turn.w)
    return Odometry(place.x, place.y, theta, twist.linear.x, twist.angular.z, twist.linear.y)
