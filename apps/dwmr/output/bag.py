"""Runs as rosbag2: the topics that robots under ROS 2 have, in a folder that its tools read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dwmr.control.law_text import LATERAL
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import ahead, quaternion
from dwmr.output.data import saved_samples
from dwmr.scenario.vehicle_limits import limited
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.result_files import results

if TYPE_CHECKING:
    from dwmr.scenario.model import Robot, Scenario
    from dwmr.simulation.simulate import Trajectory

#: The frame of all positions, and, behind the name of its robot, that of a robot: the middle of its wheel axis.
WORLD, BASE = "odom", "base_link"
#: Version of the metadata of bags: the last before QoS was written in another way, which ROS 2 Humble cannot read.
VERSION = 8
_HELP = "name another folder with --bag FOLDER"
#: Names that can be a part of a topic.
_NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")


def available() -> bool:
    """Return whether rosbags is installed."""
    return find_spec("rosbags") is not None


def unfit_names(robots: Iterable[str]) -> list[str]:
    """Return a message for each robot whose name cannot be that of topics."""
    return [
        f"the name '{name}' of a robot cannot be that of topics of ROS 2, which have letters, digits and '_'"
        for name in robots
        if not _NAME.fullmatch(name)
    ]


def require_new(folder: Path) -> None:
    """Refuse a folder that exists, as `ros2 bag record` does, and one that cannot be made.

    Raises:
        DiagnosticError: For such a folder.
    """
    if folder.exists() or folder.is_symlink():
        message = f"{folder} cannot be written: it exists, and a bag is a new folder"
        raise DiagnosticError([Diagnostic("FZ909", message, file=str(folder), help=_HELP)])
    with results(folder.parent, (folder.name,), _HELP):
        pass


def save(folder: Path, trajectory: Trajectory, scenario: Scenario) -> None:
    """Write a run as a bag; the folder is there when the bag is complete.

    Times are those of the run, from 0 on. Of its samples every `run.save_every`-th is written.

    Raises:
        DiagnosticError: When the folder exists, or cannot be written.
    """
    require_new(folder)
    with results(folder.parent, (folder.name,), _HELP) as files:
        files.write(folder.name, lambda path: _write(path, trajectory, scenario))
        files.publish()


def _write(path: Path, trajectory: Trajectory, scenario: Scenario) -> None:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    messages = Messages(types.types)
    with Writer(path, version=VERSION) as writer:
        writer.set_custom_data("scenario", scenario.name)
        writer.set_custom_data("controller", trajectory.controller)
        to_tf = writer.add_connection("/tf", "tf2_msgs/msg/TFMessage", typestore=types)
        topics = {
            (name, topic): writer.add_connection(f"/{name}/{topic}", kind, typestore=types)
            for name in trajectory.robots
            for topic, kind in TOPICS.items()
        }
        commands = _commands(trajectory)
        needed = [*_NEEDED, *(s.name for s in trajectory.law_signals if s.name == "v_y")]
        for k in saved_samples(trajectory, scenario):
            t = round(1e9 * float(trajectory.t[k]))
            transforms = []
            for i, (name, robot) in enumerate(scenario.robots.items()):
                row = {s: float(trajectory[s][k, i]) for s in needed}
                for topic, message in messages.of_robot(t, name, robot, row, commands[k, i]):
                    connection = topics[name, topic]
                    writer.write(connection, t, types.serialize_cdr(message, connection.msgtype))
                transforms.append(messages.transform(t, name, robot, row))
            tf = messages.types["tf2_msgs/msg/TFMessage"](transforms)
            writer.write(to_tf, t, types.serialize_cdr(tf, to_tf.msgtype))


#: Topics of each robot and their types.
TOPICS = {
    "odom": "nav_msgs/msg/Odometry",
    "cmd_vel": "geometry_msgs/msg/Twist",
    "reference": "geometry_msgs/msg/PoseStamped",
}
_NEEDED = ("x", "y", "theta", "v", "omega", "x_r", "y_r", "theta_r")


def _commands(trajectory: Trajectory) -> FloatArray:
    """Return the commands of `Messages.of_robot` before their limits, after the safety filter, (samples, n, 3)."""
    names = [s.name for s in trajectory.law_signals]
    v, omega = ("safe_v", "safe_omega") if "safe_v" in names else ("v_c", "omega_c")
    left = trajectory[LATERAL] if LATERAL in names else np.zeros_like(trajectory[v])
    return np.stack([trajectory[v], left, trajectory[omega]], axis=2)


class Messages:
    """Messages of ROS 2 about one run.

    Args:
        types: Classes of messages by their names.
    """

    def __init__(self, types: Any) -> None:
        self.types = types
        self._unknown = np.zeros(36)  # covariances

    def of_robot(
        self, t: int, name: str, robot: Robot, row: dict[str, float], command: FloatArray
    ) -> Iterator[tuple[str, Any]]:
        """Yield the topics of a robot and their messages.

        Args:
            t: Time [ns].
            name: Name of the robot.
            robot: Its settings.
            row: Its signals, by name.
            command: Velocity ahead, to the left and turning, shape (3,) [m/s, m/s, rad/s].
        """
        make = self.types
        twist = make["geometry_msgs/msg/TwistWithCovariance"](
            self._twist(row["v"], row.get("v_y", 0.0), row["omega"]), self._unknown
        )
        x, y = ahead(row["x"], row["y"], row["theta"], -robot.d)
        pose = make["geometry_msgs/msg/PoseWithCovariance"](self._pose(x, y, row["theta"]), self._unknown)
        header = self._header(t)
        yield "odom", make["nav_msgs/msg/Odometry"](header, f"{name}/{BASE}", pose, twist)
        yield "cmd_vel", self._twist(*limited(command, robot).tolist())
        target = self._pose(row["x_r"], row["y_r"], row["theta_r"])
        yield "reference", make["geometry_msgs/msg/PoseStamped"](header, target)

    def transform(self, t: int, name: str, robot: Robot, row: dict[str, float]) -> Any:
        """Return the transform from `WORLD` to a robot; arguments as for `of_robot`."""
        x, y = ahead(row["x"], row["y"], row["theta"], -robot.d)
        transform = self.types["geometry_msgs/msg/Transform"](self._vector(x, y, 0.0), self._turn(row["theta"]))
        return self.types["geometry_msgs/msg/TransformStamped"](self._header(t), f"{name}/{BASE}", transform)

    def _header(self, t: int) -> Any:
        seconds, nanoseconds = divmod(t, 1_000_000_000)
        time = self.types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
        return self.types["std_msgs/msg/Header"](time, WORLD)

    def _pose(self, x: float, y: float, theta: float) -> Any:
        return self.types["geometry_msgs/msg/Pose"](self.types["geometry_msgs/msg/Point"](x, y, 0.0), self._turn(theta))

    def _turn(self, theta: float) -> Any:
        return self.types["geometry_msgs/msg/Quaternion"](*quaternion(theta))

    def _twist(self, v: float, left: float, omega: float) -> Any:
        return self.types["geometry_msgs/msg/Twist"](self._vector(v, left, 0.0), self._vector(0.0, 0.0, omega))

    def _vector(self, x: float, y: float, z: float) -> Any:
        return self.types["geometry_msgs/msg/Vector3"](x, y, z)
