"""What a SPEC of dwmr keeps of each run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, field_validator

from fuzzyctl.experiments import sweep_spec
from fuzzyctl.experiments.sweep_spec import Spec, SpecFile

#: Groups of measures that a sweep can keep, as summary.json names them.
Measure = Literal[
    "rmse", "rmse_body", "rmse_inertial", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit",
    "chattering", "avoidance_s", "saturation", "condition_violated", "safety", "lyapunov", "drift", "g_ais_min",
]  # fmt: skip

#: Names of earlier versions.
RENAMED = {"clearance": "centre_distance", "collisions": "obstacles_hit"}


class RobotSpec(Spec):
    """What a SPEC file says, with the measures of robots."""

    measures: Annotated[tuple[Measure, ...], Strict(False)] = Field(
        default=("rmse", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit", "chattering"),
        description="what to keep of each run",
    )

    @field_validator("measures", mode="before")
    @classmethod
    def _renamed(cls, value: Any) -> Any:
        if not isinstance(value, list | tuple):
            return value
        return [RENAMED.get(one, one) if isinstance(one, str) else one for one in value]


def read(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    return sweep_spec.read(path, RobotSpec)
