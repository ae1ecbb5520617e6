"""Logs of real robots, CSV or rosbag2, and the differences of a run from them."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dwmr.config import csv_rows
from dwmr.config.csv_rows import Column
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import ahead, wrap_array, yaw
from dwmr.results.metrics import finite_part, rmse
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_layers import read_bytes

CODE = "FZ911"
#: A log beyond this is refused before it is read [bytes].
LARGEST_LOG = 256 << 20
#: A step between two samples that is longer than this many usual ones is a gap.
GAP = 5.0
#: Signals of a robot in a log; those of its state are compared with a run.
STATE, COMMANDS = ("x", "y", "theta", "v", "omega"), ("v_c", "omega_c")
POSTURE, VELOCITIES = STATE[:3], STATE[3:]
#: Latest stamp, that of a clock that counts from 1970 [s].
_LATEST = 1e10
_HELP = f"write a line 't,robot,{','.join((*STATE, *COMMANDS))}' and below it a row for each time and robot"
#: Words of the first line for each column. Behind a safety filter its commands are those that robots receive.
_HEADS = {
    "t": ("time", "stamp", "timestamp"),
    "robot": ("name",),
    "theta": ("yaw", "heading"),
    "v": ("linear", "linear_x"),
    "omega": ("angular", "angular_z", "yaw_rate"),
    "v_c": ("safe_v", "v_cmd", "cmd_v", "linear_cmd"),
    "omega_c": ("safe_omega", "omega_cmd", "cmd_omega", "angular_cmd"),
}


@dataclass(frozen=True)
class Log:
    """Log of one robot.

    Args:
        t: Stamps of its states, from the first stamp of all robots on, shape (n,) [s].
        signals: Signals of `STATE` that it has, each of shape (n,).
        command_t: Stamps of its commands, shape (k,) [s].
        commands: Commanded velocities, shape (k, 2) [m/s, rad/s].
    """

    t: FloatArray
    signals: Mapping[str, FloatArray]
    command_t: FloatArray
    commands: FloatArray

    @functools.cached_property
    def gaps(self) -> NDArray[np.int64]:
        """Numbers of the samples before gaps."""
        return np.flatnonzero(np.diff(self.t) > GAP * self.step).astype(np.int64)

    @property
    def step(self) -> float:
        """Usual time between two states [s]."""
        return float(np.median(np.diff(self.t)))


def read_logs(
    path: Path, scenario: Scenario, needed: Sequence[str] = POSTURE, horizon: float = 0.0
) -> tuple[dict[str, Log], list[Diagnostic]]:
    """Return the logs of a file by robot, and warnings of gaps, robots without a log, and logs that end early.

    Args:
        path: CSV, or the folder or storage file of a rosbag2.
        scenario: Scenario of the robots.
        needed: Signals that it must have.
        horizon: End of the run that it is compared with [s].

    Raises:
        DiagnosticError: With the mistakes of the file.
    """
    is_bag = path.is_dir() or path.suffix in (".db3", ".mcap")
    logs = _read_bag(path, scenario, needed) if is_bag else _read_csv(path, scenario, needed)
    first = min(float(log.t[0]) for log in logs.values())
    logs = {name: replace(log, t=log.t - first, command_t=log.command_t - first) for name, log in logs.items()}
    messages = [
        f"{robot} has {len(log.gaps)} gap{'s' if len(log.gaps) != 1 else ''}, "
        f"the longest {np.diff(log.t).max():.3g} s at t = {log.t[np.diff(log.t).argmax()]:.6g} s"
        for robot, log in logs.items()
        if len(log.gaps)
    ]
    messages += [f"there is no {robot}" for robot in scenario.robots if robot not in logs]
    messages += [
        f"{robot} begins at {log.t[0]:.6g} s, the run ends at {horizon:g} s: it is not compared"
        for robot, log in logs.items()
        if 0.0 < horizon < log.t[0]
    ]
    ends = {name: float(log.t[-1]) for name, log in logs.items() if log.t[-1] + GAP * log.step < horizon}
    if ends:
        parts = ", ".join(f"{name} ends at {end:.6g} s" for name, end in ends.items())
        messages.append(f"{parts}, the run at {horizon:g} s: they are compared until then")
    return logs, [Diagnostic(CODE, f"in the log: {m}", severity="warning", file=str(path)) for m in messages]


def mistake(path: Path, message: str, help: str = "", facts: tuple[str, ...] = ()) -> Diagnostic:
    """Return an error in a log that is at no line."""
    return Diagnostic(CODE, message, file=str(path), help=help, facts=facts)


def _refused(path: Path, *words: Any) -> DiagnosticError:
    return DiagnosticError([mistake(path, *words)])


def _read_csv(path: Path, scenario: Scenario, needed: Sequence[str]) -> dict[str, Log]:
    names, single = tuple(scenario.robots), len(scenario.robots) == 1
    columns = (
        Column("t", _HEADS["t"], limit=_LATEST),
        Column("robot", _HEADS["robot"], not single, words=names),
        *(Column(name, _HEADS.get(name, ()), name in needed) for name in (*STATE, *COMMANDS)),
    )
    content = read_bytes(path, LARGEST_LOG, "cut the log into parts")
    rows = csv_rows.read(str(path), content, csv_rows.Form("log", CODE, columns, _HELP))
    robots = np.array(rows.columns.get("robot", names * len(rows.lines)))
    logs = {}
    for name in dict.fromkeys(robots.tolist()):
        chosen = robots == name
        values = {k: np.array(column)[chosen] for k, column in rows.columns.items() if k != "robot"}
        t, state = values["t"], {k: values[k] for k in STATE if k in values}
        if len(t) < 2:
            raise _refused(path, f"{name} has one row; a log needs at least 2", _HELP)
        commands = [values[k] for k in COMMANDS if k in values]
        both = len(commands) == len(COMMANDS)
        logs[name] = Log(t, state, t if both else t[:0], np.array(commands).T if both else np.zeros((0, 2)))
    return logs


def _read_bag(path: Path, scenario: Scenario, needed: Sequence[str]) -> dict[str, Log]:
    """Read the topics /NAME/odom and /NAME/cmd_vel of each robot, those without /NAME if there is a single one."""
    if find_spec("rosbags") is None:
        raise _refused(path, "bags need rosbags, which is not installed", "pip install 'fuzzyctl[ros]'")
    from rosbags.highlevel import AnyReader, AnyReaderError
    from rosbags.typesys import Stores, get_typestore

    folder = path if path.is_dir() else path.parent
    prefixes = {f"/{name}": name for name in scenario.robots}
    if len(scenario.robots) == 1:
        prefixes[""] = next(iter(scenario.robots))
    series: dict[str, dict[str, list[tuple[float, ...]]]] = {n: {"odom": [], "cmd_vel": []} for n in scenario.robots}
    try:
        with AnyReader([folder], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            topics = {f"{prefix}/{part}": (name, part) for prefix, name in prefixes.items() for part in series[name]}
            wanted = [c for c in reader.connections if c.topic in topics and c.msgtype in _MESSAGES]
            for connection, stamp, data in reader.messages(wanted) if wanted else ():
                name, topic = topics[connection.topic]
                numbers = _MESSAGES[connection.msgtype](reader.deserialize(data, connection.msgtype))
                series[name][topic].append((1e-9 * stamp, *numbers))
            facts = (f"its topics are {', '.join(sorted({c.topic for c in reader.connections})[:10])}",)
    except (AnyReaderError, FileNotFoundError) as error:
        raise _refused(path, f"{folder} is not a readable bag: {error}") from error
    logs = {}
    for name, parts in series.items():
        states = np.array(parts["odom"], dtype=np.float64).reshape(-1, 1 + len(STATE))
        commands = np.array(parts["cmd_vel"], dtype=np.float64).reshape(-1, 1 + len(COMMANDS))
        if len(states) > 1:
            logs[name] = _of_bag(path, name, scenario.robots[name].d, states, commands)
    if not logs:
        message = "no robot of the scenario has two messages of odometry"
        raise _refused(path, message, "topics are /NAME/odom and /NAME/cmd_vel", facts)
    if silent := [name for name, log in logs.items() if not len(log.commands)] if "v_c" in needed else []:
        raise _refused(path, f"there are no commands of {', '.join(silent)}", "record /NAME/cmd_vel, too", facts)
    return logs


def _of_bag(path: Path, name: str, d: float, states: FloatArray, commands: FloatArray) -> Log:
    """Return the log of one robot; odometry is of the middle of its axle, a log of the point d ahead of it."""
    for rows, topic in ((states, "odom"), (commands, "cmd_vel")):
        if len(rows) and not np.isfinite(rows).all():
            k = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
            raise _refused(path, f"/{name}/{topic}: message {k + 1} has a number that is not finite")
        if len(rows) > 1 and not (steps := np.diff(rows[:, 0])).min() >= csv_rows.SHORTEST_STEP:
            k = int(steps.argmin())
            raise _refused(path, f"/{name}/{topic}: message {k + 2} has the stamp of message {k + 1} or an earlier one")
    x, y, theta = states[:, 1:4].T
    point = zip(*(ahead(*one, d) for one in zip(x.tolist(), y.tolist(), theta.tolist(), strict=True)), strict=True)
    values = (*map(np.array, point), *states[:, 3:].T)
    signals = dict(zip(STATE, values, strict=True))
    return Log(states[:, 0], signals, commands[:, 0], commands[:, 1:])


def _odometry(message: Any) -> tuple[float, ...]:
    pose, twist = message.pose.pose, message.twist.twist
    turn = pose.orientation
    theta = yaw(turn.x, turn.y, turn.z, turn.w)
    return pose.position.x, pose.position.y, theta, twist.linear.x, twist.angular.z


def _twist(message: Any) -> tuple[float, ...]:
    return message.linear.x, message.angular.z


#: Numbers of a message by its type.
_MESSAGES: dict[str, Callable[[Any], tuple[float, ...]]] = {
    "nav_msgs/msg/Odometry": _odometry,
    "geometry_msgs/msg/Twist": _twist,
    "geometry_msgs/msg/TwistStamped": lambda message: _twist(message.twist),
}


def differences(trajectory: Trajectory, logs: Mapping[str, Log]) -> dict[str, dict[str, float]]:
    """Return root mean square differences of a run from logs by robot, at the stamps of each log.

    Returns:
        x, y, theta, v, omega as far as the log has them, `distance` of the places [m], and the number of `samples`;
        without robots whose log begins after the run.
    """
    run = finite_part(trajectory)
    table: dict[str, dict[str, float]] = {}
    for robot, log in logs.items():
        i, within = run.robots.index(robot), log.t <= run.t[-1]
        if not within.any():
            continue
        apart = {k: one[within] - np.interp(log.t[within], run.t, run[k][:, i]) for k, one in log.signals.items()}
        apart["theta"] = wrap_array(apart["theta"])
        apart["distance"] = np.hypot(apart["x"], apart["y"])
        table[robot] = {k: rmse(one) for k, one in apart.items()} | {"samples": int(within.sum())}
    return table
