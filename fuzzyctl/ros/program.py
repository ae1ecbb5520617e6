"""Start and end of a node of ROS 2: its parameters, its mistakes, its period, and Ctrl-C."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from fuzzyctl.cli.common import show
from fuzzyctl.cli.streams import terminated_as_interrupted
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import closest

_KINDS = {
    str: "a text",
    bool: "true or false",
    float: "a number with a point, such as 1.0",
    list: 'a list of texts, such as ["..."]',
}
#: Parameters that ROS 2 itself gives to nodes, and the start of some.
_OF_ROS = ("use_sim_time", "start_type_description_service")
_QOS = "qos_overrides."


class ParameterError(ValueError):
    """Raised for parameters that cannot be used; its message has a line for each."""


def main(name: str, run: Callable[[Any], int]) -> None:
    """Run a node until it ends or Ctrl-C.

    Args:
        name: Of the node.
        run: Runs a node of rclpy and returns the exit code; it stops the robot at every end.
    """
    try:
        rclpy: Any = import_module("rclpy")
    except ImportError:
        sys.exit("error: rclpy is not installed; it is a part of ROS 2: source /opt/ros/DISTRIBUTION/setup.bash")
    if unknown := import_module("rclpy.utilities").remove_ros_args(args=sys.argv)[1:]:
        print(f"error: unknown argument {unknown[0]}; expected --ros-args -p NAME:=VALUE or", file=sys.stderr)
        print("       --ros-args --params-file FILE", file=sys.stderr)
        sys.exit(2)
    try:
        # The handlers of rclpy end the communication at once, and the robot would keep its last command.
        rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    except RuntimeError as error:  # arguments of ROS, or a file of parameters, that cannot be read
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    node = rclpy.create_node(name, automatically_declare_parameters_from_overrides=True)
    status = 1
    try:
        with terminated_as_interrupted():
            status = run(node)
    except DiagnosticError as error:
        show(error.diagnostics)
    except ParameterError as error:
        print(f"error: {error}", file=sys.stderr)
        status = 2
    except KeyboardInterrupt:
        status = 0
    finally:
        node.destroy_node()
        rclpy.shutdown()
    sys.exit(status)


def parameters(node: Any, defaults: Mapping[str, str | float | Sequence[str]]) -> dict[str, Any]:
    """Return the values of a node's parameters, which stay constant while it runs.

    Args:
        node: Node of rclpy that has declared what it was given.
        defaults: The default of each; a list has at least one text, which gives it its type.

    Raises:
        ParameterError: For values of another type than their default, and names that look like misspelled ones.
    """
    wrong_type: Any = import_module("rclpy.exceptions").InvalidParameterTypeException
    fixed = import_module("rcl_interfaces.msg").ParameterDescriptor(read_only=True)
    values, wrong = {}, []
    for name in node.get_parameters_by_prefix(""):
        if name in defaults:
            node.undeclare_parameter(name)  # to be declared with its type
        elif name in _OF_ROS or name.startswith(_QOS):
            continue
        elif near := closest(name, defaults):
            wrong.append(f"there is no parameter {name}; did you mean '{near}'?")
        else:
            node.get_logger().warning(f"parameter {name} has no effect; known are {', '.join(defaults)}")
    for name, default in defaults.items():
        try:
            values[name] = node.declare_parameter(name, default, fixed).value
        except wrong_type:
            wrong.append(f"{name} has the wrong type, expected {_KINDS[type(default)]}")
    if wrong:
        raise ParameterError("\n".join(wrong))
    return values


def spin(node: Any, has_ended: Callable[[], bool]) -> None:
    """Let a node work until it has ended."""
    executor = import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)
    while not has_ended():
        executor.spin_once(timeout_sec=0.1)


class Period:
    """Watches the time between two calls of a timer, which the computation takes for its period.

    Args:
        node: Node of rclpy.
        length: Of the period [s].
    """

    def __init__(self, node: Any, length: float) -> None:
        self._log, self._length = node.get_logger(), length
        self._last: int | None = None
        self._was_late = False

    def begin(self, now: int) -> None:
        """Take the time of a call [ns], and warn of the first one that comes late by half a period or more."""
        since, self._last = 0.0 if self._last is None else 1e-9 * (now - self._last), now
        if since >= 1.5 * self._length and not self._was_late:
            self._was_late = True
            self._log.warning(
                f"{since:.3g} s since the last period, {self._length:g} s expected: this computer is too slow for it, "
                "or the clock jumped; what is computed falls behind"
            )
