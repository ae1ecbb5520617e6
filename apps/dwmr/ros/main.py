"""Start of the node: its parameters, the scenario that they name, and the end by Ctrl-C."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.output.bag import unfit_names
from dwmr.ros.formation_commands import FormationCommands
from dwmr.ros.node import FormationNode, Settings
from dwmr.scenario.file import UnknownScenarioError, find, read
from dwmr.simulation import preflight, simulate
from dwmr.simulation.periods import Simulation
from fuzzyctl.cli.common import show
from fuzzyctl.cli.interruptions import terminated_as_interrupted
from fuzzyctl.diagnostics.diagnostic import DiagnosticError

#: Parameters of the node and their defaults; formation.yaml has the same.
PARAMETERS: Mapping[str, str | float] = {
    "scenario": "undisturbed",
    "controller": "",
    "rules": "",
    "frame": "odom",
    "base_frame": "base_link",
    "timeout": 0.5,
    "v_limit": 1.5,
    "omega_limit": 1.0,
}


class ParameterError(ValueError):
    """Raised for parameters that cannot be used; its message has a line for each."""


def main() -> None:
    """Run the node until its scenario ends or Ctrl-C; the robots are stopped in any case."""
    try:
        rclpy: Any = import_module("rclpy")
    except ImportError:
        sys.exit("error: rclpy is not installed; it is a part of ROS 2: source /opt/ros/DISTRIBUTION/setup.bash")
    # The handlers of rclpy end the communication at once, and the robots would keep their last command.
    rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    node = rclpy.create_node("formation")
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


def run(node: Any) -> int:
    """Drive the robots until the run ends, and publish zeros whatever ends it.

    Args:
        node: Node of rclpy.

    Returns:
        Exit code: 1 for a run that ended before its horizon.

    Raises:
        ParameterError: For parameters that cannot be used.
        DiagnosticError: For mistakes in the scenario, the law or its rule files.
    """
    values = _parameters(node)
    simulation = prepare(values)
    messages = (import_module("nav_msgs.msg").Odometry, import_module("geometry_msgs.msg").Twist)
    qos = import_module("rclpy.qos").qos_profile_sensor_data
    settings = Settings(values["frame"], values["base_frame"], values["timeout"])
    node.get_logger().info(f"compiling {simulation.name}")
    commands = FormationCommands(simulation, values["v_limit"], values["omega_limit"])
    formation = FormationNode(node, tuple(simulation.scenario.robots), commands, settings, messages, qos)
    executor = import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)
    try:
        while not formation.has_ended:
            executor.spin_once(timeout_sec=0.1)
    finally:
        formation.stop()
    return 1 if formation.failed else 0


def _parameters(node: Any) -> dict[str, Any]:
    """Return the values of `PARAMETERS`."""
    wrong_type: Any = import_module("rclpy.exceptions").InvalidParameterTypeException
    values, wrong = {}, []
    for name, default in PARAMETERS.items():
        try:
            values[name] = node.declare_parameter(name, default).value
        except wrong_type:
            kind = "a number with a point, such as 1.0" if isinstance(default, float) else "a text"
            wrong.append(f"{name} has the wrong type, expected {kind}")
    if wrong:
        raise ParameterError("\n".join(wrong))
    return values


def prepare(values: Mapping[str, Any]) -> Simulation:
    """Return the run that parameters name: read, checked, proved and compiled.

    Args:
        values: Values of `PARAMETERS`.

    Raises:
        ParameterError: For parameters that cannot be used.
        DiagnosticError: For mistakes in the scenario, the law or its rule files.
    """
    wrong = []
    for name, unit in (("timeout", "s"), ("v_limit", "m/s"), ("omega_limit", "rad/s")):
        if not 0.0 < values[name] < float("inf"):
            wrong.append(f"{name} = {values[name]:g} {unit}, expected a positive number")
    if values["rules"] and not Path(values["rules"]).is_dir():
        wrong.append(f"rules = '{values['rules']}' is not a folder")
    try:
        path = find(values["scenario"])
    except UnknownScenarioError as error:
        raise ParameterError("\n".join([*wrong, str(error)])) from error
    file = read(path)
    controller = values["controller"] or file.scenario.run.controller
    if not laws.exists(controller, file.path.parent):
        known = ", ".join(laws.names())
        wrong.append(f"controller = '{controller}' is not one of {known}, and no file beside the scenario")
    wrong += unfit_names(file.scenario.robots)
    if wrong:
        raise ParameterError("\n".join(wrong))
    folders = [Path(values["rules"])] if values["rules"] else []
    rules = Rules(file.scenario.rules, (*folders, *file.folders), file.places)
    preflight.check(file, [controller], rules)
    show([*file.warnings, *rules.warnings])
    simulation = simulate.prepare(file, controller, rules)
    simulate.require_memory([simulation], file.places)
    return simulation
