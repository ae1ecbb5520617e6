"""Parameters of a calibration: values that the paper does not print, with plausible bounds, and scenarios with them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from dwmr.scenario.file import SHIPPED, ScenarioFile
from dwmr.scenario.model import Scenario
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.scenario_keys import Places, override


class Parameter(NamedTuple):
    """A value to fit.

    Attributes:
        keys: Keys of the scenario that take the value; `sinusoid` and `constant` in them stand for the disturbances of
            that kind.
        low, high: Bounds, in the unit of the keys.
        unit: Of the value.
        why: Reason for the bounds.
        step: Between two values that are tried.
    """

    keys: tuple[str, ...]
    low: float
    high: float
    unit: str
    why: str
    step: float = 0.001


#: SMC's gain is 0.1 m/s and fails in the paper, AIFQSMC's reaches 0.65 m/s and does not.
_V = "up to AIFQSMC's 0.65 m/s no law could fail alone; more than 0.4 m/s is half of the reference's speed"
_OMEGA = "the reference itself turns at up to 0.18 rad/s; a little more than that"
PARAMETERS: dict[str, Parameter] = {
    "sinusoid_v": Parameter(("disturbances.sinusoid.v",), -0.4, 0.4, "m/s", _V),
    "sinusoid_omega": Parameter(("disturbances.sinusoid.omega",), -0.25, 0.25, "rad/s", _OMEGA),
    "constant_v": Parameter(("disturbances.constant.v",), -0.4, 0.4, "m/s", _V),
    "constant_omega": Parameter(("disturbances.constant.omega",), -0.25, 0.25, "rad/s", _OMEGA),
    # every other partition is compiled anew, which takes as long as the three runs
    "half_width": Parameter(("rules.fcafsmc.half_width",), 0.1, 1.0, "m, rad", "σ* of the runs under FCAFSMC", 0.05),
    "frequency": Parameter(("disturbances.sinusoid.angular_frequency",), 0.4, 6.3, "rad/s", "1 to 16 s"),
    "force": Parameter(("disturbances.sinusoid.force", "disturbances.constant.force"), -100.0, 100.0, "N", "drives"),
    "torque": Parameter(("disturbances.sinusoid.torque", "disturbances.constant.torque"), -25.0, 25.0, "N m", "drives"),
    "v_limit": Parameter(("robot.actuator.v_limit",), 1.5, 3.0, "m/s", "the robot's own limit is 2 m/s"),
    "omega_limit": Parameter(("robot.actuator.omega_limit",), 1.74, 6.28, "rad/s", "simulator's and robot's limit"),
    "load": Parameter(("load.mass_factor", "load.inertia_factor"), 1.0, 1.8, "-", "the robot carries up to 100 kg"),
    "friction": Parameter(("robot.friction.coulomb_force",), 0.0, 40.0, "N", "rolling resistance up to 3 %"),
}
#: Amplitudes, frequency and partition, which are not printed and have no other source.
USUAL = ("sinusoid_v", "sinusoid_omega", "constant_v", "constant_omega", "frequency", "half_width")


def keys(scenario: Scenario, name: str, places: Places) -> list[str]:
    """Return the keys of a scenario that a parameter sets.

    Raises:
        DiagnosticError: When the scenario has no disturbance of the parameter's kind.
    """
    result: list[str] = []
    for key in PARAMETERS[name].keys:
        table, kind, field = (*key.split("."), "")[:3]
        if table != "disturbances":
            result.append(key)
            continue
        numbers = [k for k, one in enumerate(scenario.disturbances) if one.kind == kind]
        if not numbers:
            message = f"disturbances: there is none of kind {kind!r}, so there is no {name} to fit"
            help_text = "name others with --parameters"
            raise DiagnosticError([places.diagnostic("FZ904", "disturbances", message, help=help_text)])
        result += [f"disturbances.{k}.{field}" for k in numbers]
    return result


def present(scenario: Scenario, names: Sequence[str], places: Places) -> tuple[float, ...]:
    """Return the values that a scenario has now; of several disturbances or robots the first counts.

    Raises:
        DiagnosticError: When the scenario has no such value.
    """
    return tuple(_value(scenario, keys(scenario, name, places)[0], places) for name in names)


def _value(scenario: Scenario, key: str, places: Places) -> float:
    table, *rest = key.split(".")
    if table == "disturbances":
        return float(getattr(scenario.disturbances[int(rest[0])], rest[1]))
    if table == "rules":
        role, name = rest
        if role not in scenario.rules or name not in scenario.rules[role].params:
            message = f"{key} is missing: there is no present value to begin with"
            raise DiagnosticError([places.diagnostic("FZ903", key, message)])
        return scenario.rules[role].params[name]
    node: object = next(iter(scenario.robots.values())) if table == "robot" else scenario.load
    for part in rest:
        node = getattr(node, part)
    assert isinstance(node, float)
    return node


def overrides(scenario: Scenario, values: Mapping[str, float], places: Places) -> tuple[str, ...]:
    """Return the arguments `key=value` that give a scenario the values of some parameters."""
    return tuple(f"{key}={value!r}" for name, value in values.items() for key in keys(scenario, name, places))


def scenario_text(file: ScenarioFile, values: Mapping[str, float], path: Path, head: str) -> str:
    """Return the text of a scenario with other values.

    Args:
        file: The scenario it extends.
        values: Values by parameter.
        path: Place of the text.
        head: Comment for its first lines.
    """
    data: dict[str, Any] = {}
    if any(key.startswith("disturbances.") for name in values for key in keys(file.scenario, name, file.places)):
        # lists replace those below, so all disturbances are written with all of their keys
        disturbances = file.scenario.disturbances
        data["disturbances"] = [one.model_dump(exclude_none=True, exclude_unset=True) for one in disturbances]
    for name, value in values.items():
        for key in keys(file.scenario, name, file.places):
            override(data, f"{key}={value!r}")
    lines = [f"# {line}".rstrip() for line in head.splitlines()]
    lines += ["", f'extends = "{_base(file.path, path.parent)}"', f'name = "{path.stem}"', *_toml_tables(data, "")]
    return "\n".join(lines) + "\n"


def _base(path: Path, folder: Path) -> str:
    """Return how a file in a folder names the scenario it extends."""
    if path.parent == SHIPPED:
        return path.stem
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()


def _toml_tables(data: Mapping[str, Any], prefix: str) -> list[str]:
    """Return the lines of tables and lists of tables, in TOML."""
    lines: list[str] = []
    values = {k: v for k, v in data.items() if not isinstance(v, dict | list)}
    if values:
        lines += ["", f"[{prefix}]", *_toml_values(values)]
    for key, value in data.items():
        full = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            lines += _toml_tables(value, full)
        elif isinstance(value, list):
            for one in value:
                lines += ["", f"[[{full}]]", *_toml_values(one)]
    return lines


def _toml_values(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_toml_value(value)}" for key, value in table.items()]


def _toml_value(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml_value(v) for v in value)}]"
    return repr(value)
