"""Formations of robots as the experiments of a sweep."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.scenario import file as scenario_file
from dwmr.scenario.file import SCENARIOS, ScenarioFile
from dwmr.simulation import preflight
from fuzzyctl.diagnostics.diagnostic import DiagnosticError, UnknownNameError
from fuzzyctl.experiments import sweep_spec
from fuzzyctl.experiments.runnable import Computed, Prepared, Runnable, UsedFile
from fuzzyctl.experiments.sweep_spec import Spec, SpecFile


@dataclass(frozen=True)
class Robots(Runnable[ScenarioFile]):
    """Scenarios of robots under control laws.

    Args:
        rules_folder: Whose rule files replace those of the same name.
        known: Cache of rule files, which a process reads and proves once.
    """

    application: ClassVar[str] = "dwmr"
    seed: ClassVar[str] = "run.seed"
    common: ClassVar[Mapping[str, str]] = SCENARIOS.common
    package: ClassVar[Path | None] = Path(__file__).parents[1]

    rules_folder: Path | None = None
    known: Known = field(default_factory=Known, compare=False, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave out the cache, but keep that the rule files are proved: workers need not prove them again."""
        return type(self), (self.rules_folder, Known(proved=True))

    def find(self, name: str, folder: Path = Path()) -> Path:
        """Return the file of a scenario given as a shipped name or a path."""
        return scenario_file.find(name)

    def read(self, path: Path, overrides: Sequence[str]) -> ScenarioFile:
        """Read a scenario."""
        return scenario_file.read(path, overrides)

    def controllers(self, scenario: ScenarioFile, names: Sequence[str]) -> tuple[str, ...]:
        """Return the control laws that some names stand for, words for several laws written out."""
        result: list[str] = []
        for name in names or (scenario.scenario.run.controller,):
            if name not in laws.GROUPS and not laws.exists(name, scenario.path.parent):
                raise UnknownNameError("control law", name, (*laws.names(), *laws.GROUPS))
            result += laws.group(name)
        return tuple(dict.fromkeys(result))

    def check(self, scenario: ScenarioFile, controllers: Sequence[str]) -> Mapping[str, UsedFile]:
        """Check a scenario and its rule files, and return these by role and name, and the laws that are text."""
        rules = self.rules(scenario)
        preflight.check(scenario, controllers, rules)
        return _used(rules)

    def unread(
        self, scenario: ScenarioFile, controllers: Sequence[str], used: Mapping[str, str], key: Sequence[str]
    ) -> str:
        """Return the unused gains or rule file that a key belongs to, or an empty text."""
        tables = {
            laws.table(robot.controllers, law)[0] for law in controllers for robot in scenario.scenario.robots.values()
        }
        roles = {name.partition("/")[0] for name in used}
        at = key.index("controllers") + 1 if "controllers" in key[1:3] else 0
        if at and at < len(key) and key[at] not in (*tables, "*"):
            return f"gains of {key[at]}"
        if key[0] == "rules" and len(key) > 1 and key[1] not in (*roles, "*"):
            return f"rule file {key[1]}"
        return "run.controller" if list(key) == ["run", "controller"] else ""

    def prepare(self, scenario: ScenarioFile, controller: str, measures: Sequence[str]) -> Prepared:
        """Compile the gains and the control law of each robot."""
        # the compiler is loaded in the workers only
        from dwmr.results.metrics import measure
        from dwmr.simulation import simulate

        rules = self.rules(scenario)
        simulation = simulate.prepare(scenario, controller, rules)

        def compute() -> Computed:
            trajectory = simulate.run(simulation)
            if trajectory.stop is not None and trajectory.stop.mistake is not None:
                raise DiagnosticError([trajectory.stop.mistake])
            measures_of_run = measure(trajectory, scenario.scenario, measures)
            return Computed(dict(columns_of(measures_of_run, measures, trajectory.robots)), trajectory.wall_s)

        return Prepared(_used(rules), compute)

    def unit(self, scenario: ScenarioFile, column: str) -> str:
        """Return the unit of a measure of robots."""
        return unit_of(column)

    def own_files(self, scenario: ScenarioFile, controllers: Sequence[str]) -> Mapping[str, str]:
        """Return the checksums of the control laws that lie beside the scenario."""
        files = {law: laws.python_file(law, scenario.path.parent) for law in controllers}
        return {law: hashlib.sha256(path.read_bytes()).hexdigest() for law, path in files.items() if path is not None}

    def rules(self, scenario: ScenarioFile) -> Rules:
        """Return the rule files of a scenario."""
        folders = (*([self.rules_folder] if self.rules_folder else []), *scenario.folders)
        return Rules(scenario.scenario.rules, folders, scenario.places, self.known)


def _used(rules: Rules) -> dict[str, UsedFile]:
    """Return the rule files that were read, by role and name, and the control laws that are text."""
    files = {f"{role}/{used.path.name}": UsedFile(used.path, used.sha256) for role, used in rules.used.items()}
    return files | {f"law/{name}": UsedFile(used.path, used.sha256) for name, used in rules.laws.items()}


#: Units of the measures of a run, by the last part of its column, and of its first part where that has one for all.
_UNITS = {
    "t_end": "s", "x_e": "m", "y_e": "m", "theta_e": "rad", "theta_e_star": "rad", "theta_e_unwrapped": "rad",
}  # fmt: skip
_GROUP_UNITS = {
    "centre_distance": "m", "obstacle_gap": "m", "robot_gap": "m", "avoidance_s": "s", "g_ais_min": "m/s, rad/s",
    "energy": "J",
}  # fmt: skip
_ARRIVAL = {"t": "s", "distance": "m"}
_CHATTERING = {"v": "m/s²", "omega": "rad/s²"}
#: Lists of moments of the safety filter; a column has how many concern a robot.
_MOMENTS = ("infeasible", "missed")


def columns_of(measures: Mapping[str, Any], wanted: Sequence[str], robots: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield columns and values of a run: how it ended, then the measures wanted, keys of tables joined by dots.

    Args:
        measures: From `metrics.measure`.
        wanted: Groups to keep; one that the control law does not have is left out.
        robots: Names of the robots.
    """
    stopped = measures["stopped"] or {}
    yield "t_end", measures["t_end"]
    yield "stopped", bool(stopped)
    yield "stop_robot", stopped.get("robot")
    yield "stop_reason", stopped.get("reason")
    for group in wanted:
        if group in ("obstacles_hit", "robots_hit"):
            hits = [name for hit in measures[group] for name in hit.get("robots", [hit.get("robot")])]
            yield from ((f"{group}.{robot}", hits.count(robot)) for robot in robots)
        elif group == "safety" and group in measures:
            ends = {kind: [(one["robot"], one["with"]) for one in measures[group][kind]] for kind in _MOMENTS}
            counts = {kind: {n: sum(n in pair for pair in ends[kind]) for n in robots} for kind in _MOMENTS}
            yield from _flat(group, measures[group] | counts)
        elif group in measures:
            yield from _flat(group, measures[group])


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, below in value.items():
            yield from _flat(f"{key}.{name}", below)
    else:
        yield key, value


def unit_of(column: str) -> str:
    """Return the unit of a column, or an empty text, also for values of the scenario."""
    group, last = column.partition(".")[0], column.rpartition(".")[2]
    if column.startswith("safety.disc_gap."):
        return "m"
    if group in ("chattering", "chattering_outside"):
        return _CHATTERING.get(last, "")
    if group == "arrival":
        return _ARRIVAL.get(last, "")
    if group in _GROUP_UNITS:
        return _GROUP_UNITS[group]
    return _UNITS.get(last, "") if group.startswith("rmse") or column == "t_end" else ""


#: Groups of measures that a sweep can keep, as summary.json names them.
Measure = Literal[
    "rmse", "rmse_body", "rmse_inertial", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit",
    "arrival", "chattering", "chattering_outside", "avoidance_s", "avoidance_switches", "saturation", "energy",
    "amplification",
    "condition_violated", "safety", "lyapunov", "drift", "g_ais_min",
]  # fmt: skip


class RobotSpec(Spec):
    """A SPEC file with the measures of robots."""

    measures: Annotated[tuple[Measure, ...], Strict(False)] = Field(
        default=("rmse", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit", "chattering"),
        description="what to keep of each run",
    )


def read_spec(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    return sweep_spec.read(path, RobotSpec)
