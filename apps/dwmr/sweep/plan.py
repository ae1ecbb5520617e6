"""Plan of a sweep over scenarios of robots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from dwmr.scenario.file import ScenarioFile
from dwmr.sweep.robots import Robots
from fuzzyctl.experiments import sweep_plan
from fuzzyctl.experiments.sweep_plan import Plan
from fuzzyctl.experiments.sweep_spec import SpecFile


def make(
    file: SpecFile, rules_folder: Path | None, overrides: Sequence[str], report: Callable[[int], None] | None = None
) -> Plan[ScenarioFile]:
    """Lay out the runs of a sweep, and check each of them with its drawn values; nothing is compiled or simulated.

    Args:
        file: The SPEC.
        rules_folder: Whose rule files replace those of the same name.
        overrides: Values for all runs, as `--set` has them.
        report: Called with how many runs of each law are checked.

    Raises:
        DiagnosticError: With the mistakes in the SPEC, or of the first runs that have any.
        OverrideError: When an override is malformed.
    """
    return sweep_plan.make(Robots(rules_folder), file, overrides, report)
