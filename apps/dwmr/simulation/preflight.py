"""Preconditions of a run: gains for every robot, and guarantees proved from the rule files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from dwmr.control import laws as controllers
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.law_text import LATERAL
from dwmr.control.laws.python_law import reported
from dwmr.control.laws.settings import LawSettings
from dwmr.control.laws.text_law import TextLaw
from dwmr.control.rule_files import ROLES
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.mistakes import diagnose
from dwmr.scenario.model import Ackermann, Omnidirectional
from dwmr.scenario.vehicle_limits import curvature
from dwmr.simulation import mujoco_plant
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.experiments.scenario_keys import split_key

#: The param by which a law of cars says the greatest curvature that it asks for.
CURVATURE = "kappa_max"


def check(file: ScenarioFile, laws: Iterable[str], rules: Rules, *, real: bool = False) -> None:
    """Check a scenario and its rule files for some control laws, and its plant, without compiling anything.

    Args:
        file: The scenario.
        laws: Control laws.
        rules: Its rule files.
        real: Whether the robots are real, so that their velocity loops are not those of the scenario.

    Raises:
        DiagnosticError: With the mistakes of all robots; equal ones show once.
    """
    mujoco_plant.require(file)
    mistakes: dict[tuple[str, str, str], Diagnostic] = {}
    if not real and (unstable := next(_unstable_loops(file), None)) is not None:
        mistakes["", "", ""] = unstable
    for name in laws:
        law = None
        for robot in file.scenario.robots:
            try:
                law = law or controllers.find(name, file.path.parent, rules)
                _check(file, name, law, robot, rules)
            except DiagnosticError as error:
                for one in error.diagnostics:
                    mistakes.setdefault((one.code, one.place, one.message), one)
    if mistakes:
        raise DiagnosticError(tuple(mistakes.values()))
    unused = [role for role in file.scenario.rules if role not in ROLES and role not in rules.used]
    rules.warnings += [_unused(file, role) for role in unused]


def _unstable_loops(file: ScenarioFile) -> Iterator[Diagnostic]:
    """Find velocity loops that grow from period to period, without friction and with the load that makes it worse."""
    run, load = file.scenario.run, file.scenario.load
    for name, robot in file.scenario.robots.items():
        loop, accelerates = robot.inner_loop, robot.inner_loop.torque_reading == "acceleration"
        for channel, inertia, factor in (
            ("v", robot.mass, load.mass_factor), ("omega", robot.inertia, load.inertia_factor),
        ):  # fmt: skip
            if channel == "omega" and isinstance(robot.vehicle, Ackermann):
                continue  # its steering turns it
            gain = (1.0 if accelerates else 1.0 / inertia) / min(1.0, factor)
            k_p, k_d, n = (getattr(loop, f"{key}_{channel}") for key in ("k_p", "k_d", "n"))
            value = eigenvalue(k_p * gain, k_d * gain, n, robot.actuator.lag, run.dt, run.substeps)
            if abs(value) > 1.0 + 1e-9:
                digits = f"{value.real:.4g}" + (f" ± {abs(value.imag):.3g}i" if value.imag else "")
                message = (
                    f"run.dt = {run.dt:g} s: the velocity loop of robots.{name} in {channel} is unstable, its "
                    f"eigenvalue {digits} has the magnitude {abs(value):.4g} > 1"
                )
                facts = (
                    f"it is that of one period with k_p = {k_p:g}, k_d = {k_d:g}, n = {n:g} 1/s, a lag of "
                    f"{robot.actuator.lag:g} s and run.substeps = {run.substeps}",
                )
                help_text = f"shorten run.dt, or lower robot.inner_loop.k_d_{channel} or n_{channel}"
                yield file.places.diagnostic("FZ904", "run.dt", message, facts=facts, help=help_text)


def eigenvalue(k_p: float, k_d: float, n: float, lag: float, dt: float, substeps: int) -> complex:
    """Return the largest eigenvalue of a velocity loop from one control period to the next.

    Args:
        k_p, k_d: Gains over the inertia [1/s, -].
        n: Derivative filter [1/s].
        lag: Time constant of the torques [s].
        dt: Control period [s].
        substeps: Integration steps in it, of the Runge-Kutta method.

    Source:
        Goto, Bertol, Martins, Eq. (75), held over a period, before a lag and an integrator.
    """
    step = np.array([[0.0, 1.0, 0.0], [0.0, -1.0 / lag, 1.0 / lag], [0.0, 0.0, 0.0]]) * (dt / substeps)
    term = whole = np.eye(3)
    for order in range(1, 5):
        term = term @ step / order
        whole = whole + term
    period = np.linalg.matrix_power(whole, substeps)[:2]  # of velocity, torque and command
    command = np.array([-(k_p + k_d * n), 0.0, -k_d * n])  # by velocity, torque and filter
    share = 1.0 - math.exp(-n * dt)
    plant = np.column_stack([period[:, :2], np.zeros(2)]) + np.outer(period[:, 2], command)
    matrix = np.vstack([plant, [-share, 0.0, 1.0 - share]])
    return complex(max(np.linalg.eigvals(matrix), key=abs))


def _unused(file: ScenarioFile, role: str) -> Diagnostic:
    message = f"rules.{role} is not used: no control law of this run calls a system {role}"
    return replace(file.places.diagnostic("FZ905", f"rules.{role}", message), severity="warning")


def _check(file: ScenarioFile, name: str, law: Any, robot: str, rules: Rules) -> None:
    """Check a control law for one robot."""
    if isinstance(law, TextLaw):
        with _named(file, name):
            law.prove(settings_of(file, robot, name, law), rules, robot)
            law.require_period(file.scenario.run.dt)
            _require_sideways(file, name, law)
        rules.warnings += [d for d in _curvature(file, name, law, robot) if d not in rules.warnings]
    else:
        settings = settings_of(file, robot, name, law)
        with reported(name, Path(str(law.__file__)), "checked", only_own=True):
            settings.prove(rules, robot)


def _require_sideways(file: ScenarioFile, name: str, law: TextLaw) -> None:
    """Refuse a law that asks robots to move sideways that cannot."""
    if LATERAL not in (one.name for one in law.text.controller.results):
        return
    unable = [n for n, robot in file.scenario.robots.items() if not isinstance(robot.vehicle, Omnidirectional)]
    if not unable:
        return
    message = f"the control law {name} commands {LATERAL}, and robots that cannot move sideways are {', '.join(unable)}"
    help_text = "set robot.vehicle to one of kind 'omnidirectional', or take another law"
    raise DiagnosticError([file.places.diagnostic("FZ904", "run.controller", message, help=help_text)])


def _curvature(file: ScenarioFile, name: str, law: TextLaw, robot: str) -> Iterable[Diagnostic]:
    """Warn of a law whose param `kappa_max` [1/m] is beyond the steering of a robot that is a car."""
    values = law.values(settings_of(file, robot, name, law), robot)
    if CURVATURE in values:
        table = controllers.table(file.scenario.robots[robot].controllers, name)[0]
        key = file.places.resolve(("robots", robot, "controllers", table, CURVATURE))[0]
        yield from curvature(file.scenario, robot, key, values[CURVATURE], file.places)


@contextmanager
def _named(file: ScenarioFile, law: str) -> Iterator[None]:
    """Add the place where the scenario names a law to the mistakes in its text."""
    try:
        yield
    except DiagnosticError as error:
        key, span, argument = file.places.resolve(("run", "controller"))
        if controllers.base(law) in controllers.PAPER or file.scenario.run.controller != law:
            raise
        raise DiagnosticError([_with_name(d, law, key, span, argument) for d in error.diagnostics]) from None


def _with_name(found: Diagnostic, law: str, key: str, span: Span | None, argument: str) -> Diagnostic:
    if found.span is None or Path(found.span.source.name).stem != controllers.base(law):
        return found
    if argument or span is None:
        return replace(found, facts=(*found.facts, f"the control law of --set {argument}"))
    return replace(found, notes=(*found.notes, Note(span, f"{key} names the control law")))


def settings_of(file: ScenarioFile, robot: str, name: str, law: Any) -> LawSettings:
    """Return the gains of a robot for a control law.

    Args:
        file: The scenario.
        robot: Name of the robot.
        name: Name of the law.
        law: From `laws.find`.

    Raises:
        DiagnosticError: When the scenario gives none, or wrong ones for a user's law.
    """
    table, gains = controllers.table(file.scenario.robots[robot].controllers, name)
    key = f"robots.{robot}.controllers.{table}"
    if gains is None and not any(field.is_required() for field in law.Settings.model_fields.values()):
        gains = {}  # all have values in the law
    if gains is None:
        message = f"{key} is missing: robot {robot} has no gains for {name}"
        raise DiagnosticError([file.places.diagnostic("FZ903", key, message)])
    with reported(name, Path(str(law.__file__)), "checked", only_own=True):
        try:
            settings: LawSettings = law.Settings.model_validate(gains)
        except ValidationError as error:
            raise DiagnosticError(diagnose(error, file.places, tuple(split_key(key)), table=law.Settings)) from None
    return settings
