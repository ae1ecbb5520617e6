"""The node's parameters, the scenario that they name, and its run."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.output.bag import unfit_names
from dwmr.ros.node import FormationCommands, FormationNode, Settings
from dwmr.scenario.file import UnknownScenarioError, find, read
from dwmr.scenario.model import Scenario
from dwmr.simulation import preflight, simulate
from dwmr.simulation.periods import Simulation
from fuzzyctl.cli.common import show
from fuzzyctl.ros.program import ParameterError, parameters, spin

#: Parameters of the node and their defaults; formation.yaml has the same.
PARAMETERS: Mapping[str, str | float] = {
    "scenario": "undisturbed",
    "controller": "",
    "rules": "",
    "frame": "odom",
    "base_frame": "base_link",
    "timeout": 0.5,
    "stamped": False,
    "v_limit": 1.5,
    "omega_limit": 1.0,
}


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
    values = parameters(node, PARAMETERS)
    simulation = prepare(values)
    twist = "TwistStamped" if values["stamped"] else "Twist"
    messages = (import_module("nav_msgs.msg").Odometry, getattr(import_module("geometry_msgs.msg"), twist))
    qos = import_module("rclpy.qos").qos_profile_sensor_data
    settings = Settings(values["frame"], values["base_frame"], values["timeout"], values["stamped"])
    node.get_logger().info(f"compiling {simulation.name}")
    commands = FormationCommands(simulation)
    formation = FormationNode(node, tuple(simulation.scenario.robots), commands, settings, messages, qos)
    try:
        spin(node, lambda: formation.has_ended)
    finally:
        formation.stop()
    return 1 if formation.failed else 0


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
        names = ", ".join(laws.names())
        wrong.append(f"controller = '{controller}' is not one of {names}, and no file beside the scenario")
    wrong += unfit_names(file.scenario.robots)
    if wrong:
        raise ParameterError("\n".join(wrong))
    if lower := _lower_limits(file.scenario, values):
        file = read(path, lower)  # the safety filter and the law's checks rely on the limits of commands
    folders = [Path(values["rules"])] if values["rules"] else []
    rules = Rules(file.scenario.rules, (*folders, *file.folders), file.places)
    preflight.check(file, [controller], rules, real=True)
    show([*file.warnings, *rules.warnings])
    return simulate.prepare(file, controller, rules)


def _lower_limits(scenario: Scenario, values: Mapping[str, Any]) -> list[str]:
    """Return overrides that lower the limits of robots to those of the node."""
    return [
        f"robots.{name}.actuator.{key}={values[key]!r}"
        for name, robot in scenario.robots.items()
        for key in ("v_limit", "omega_limit")
        if values[key] < getattr(robot.actuator, key)
    ]
