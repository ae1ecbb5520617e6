"""Preconditions of a run: gains for every robot, and guarantees proved from the rule files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pydantic import ValidationError

from dwmr.control import laws as controllers
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws.settings import LawSettings
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.mistakes import diagnose
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.settings.overrides import split_key


def check(file: ScenarioFile, laws: Iterable[str], rules: Rules) -> None:
    """Check a scenario and its rule files for some control laws, without compiling anything.

    Args:
        file: The scenario.
        laws: Names of the control laws.
        rules: Rule files of the scenario.

    Raises:
        DiagnosticError: With the mistakes of all robots; what robots have in common shows once.
    """
    found: dict[tuple[str, str, str], Diagnostic] = {}
    for law in laws:
        for robot in file.scenario.robots:
            try:
                settings = settings_of(file, robot, law)
                with controllers.reported(law, controllers.own_file(law, file.path.parent), "checked", only_own=True):
                    settings.prove(rules, robot)
            except DiagnosticError as error:
                for one in error.diagnostics:
                    found.setdefault((one.code, one.place, one.message), one)
    if found:
        raise DiagnosticError(tuple(found.values()))


def settings_of(file: ScenarioFile, robot: str, law: str) -> LawSettings:
    """Return the gains of a robot for a control law.

    Raises:
        DiagnosticError: When the scenario gives none, or wrong ones for a law of one's own.
    """
    name, given = controllers.table(file.scenario.robots[robot].controllers, law)
    key = f"robots.{robot}.controllers.{name}"
    if isinstance(given, LawSettings):
        return given
    if given is None:
        message = f"{key} is missing: robot {robot} has no gains for {law}"
        raise DiagnosticError([file.places.diagnostic("FZ903", key, message)])
    module = controllers.find(law, file.path.parent)
    with controllers.reported(law, Path(str(module.__file__)), "checked", only_own=True):
        try:
            settings: LawSettings = module.Settings.model_validate(given)
        except ValidationError as error:
            raise DiagnosticError(diagnose(error, file.places, tuple(split_key(key)))) from None
    return settings
