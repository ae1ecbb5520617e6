"""Start and end of a node of ROS 2: its parameters, its mistakes, and Ctrl-C."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from fuzzyctl.cli.common import show
from fuzzyctl.cli.interruptions import terminated_as_interrupted
from fuzzyctl.diagnostics.diagnostic import DiagnosticError

_KINDS = {str: "a text", float: "a number with a point, such as 1.0", list: 'a list of texts, such as ["..."]'}


class ParameterError(ValueError):
    """Raised for parameters that cannot be used; its message has a line for each."""


def main(name: str, run: Callable[[Any], int]) -> None:
    """Run a node until it ends or Ctrl-C.

    Args:
        name: Of the node.
        run: Runs a node of rclpy and returns the exit code; it stops what it drives, whatever ends it.
    """
    try:
        rclpy: Any = import_module("rclpy")
    except ImportError:
        sys.exit("error: rclpy is not installed; it is a part of ROS 2: source /opt/ros/DISTRIBUTION/setup.bash")
    # The handlers of rclpy end the communication at once, and what is driven would keep its last command.
    rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    node = rclpy.create_node(name)
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
    """Return the values of a node's parameters.

    Args:
        node: Node of rclpy.
        defaults: The default of each; a list has at least one text, which gives it its type.

    Raises:
        ParameterError: For values of another type than their default.
    """
    wrong_type: Any = import_module("rclpy.exceptions").InvalidParameterTypeException
    values, wrong = {}, []
    for name, default in defaults.items():
        try:
            values[name] = node.declare_parameter(name, default).value
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
