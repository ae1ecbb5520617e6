"""The scenarios that come with dwmr."""

from __future__ import annotations

from pathlib import Path

from fuzzyctl.experiments.scenario_layers import Shipped

#: Table whose values every robot takes over unless it has its own.
COMMON = "robot"

SCENARIOS = Shipped(Path(__file__).parents[1] / "scenarios", "begin one with 'dwmr new NAME'", {"robots": COMMON})
SHIPPED = SCENARIOS.folder
find, shipped_names = SCENARIOS.find, SCENARIOS.names
