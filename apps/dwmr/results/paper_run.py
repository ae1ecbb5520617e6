"""Comparison of a scenario with those behind Tables 12 and 13 of the paper."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dwmr.results.metrics import TABLE_12_HORIZON
from dwmr.scenario.model import Robot, Scenario

#: Keys of a robot that the paper prints; what it does not print is fitted to its table.
_PRINTED = ("x_0", "y_0", "theta_0", "d", "radius", "avoids_obstacles", "formation", "delay", "sensors", "noise")
#: Keys of a robot that its errors do not depend on, or by design may differ: the measures' outline, the gains.
_FREE = ("body", "controllers")
#: Numbers of the paper's tables by the shipped scenario behind them.
_TABLES = {
    "paper": 12,
    "paper-with-limits": 12,
    "paper-constant-gain": 12,
    "paper-ideal-loop": 12,
    "undisturbed": 13,
    "experiment": 13,
}
#: Keys that are listed before the rest is counted.
_MOST_SHOWN = 4


def differences(scenario: Scenario, fitted: bool = False, shipped: str = "paper") -> tuple[str, ...]:
    """Return the keys in which a run is not the paper's, its gains and rule files aside.

    Args:
        scenario: What is run.
        fitted: Whether what the paper does not print may differ: amplitudes, bodies and drives.
        shipped: Name of the scenario that is the paper's run.
    """
    from dwmr.scenario.file import find, read

    paper = read(find(shipped)).scenario
    found = [
        key
        for key in ("reference", "formation", "obstacles", "avoidance", "load")
        if getattr(scenario, key) != getattr(paper, key)
    ]
    found += [f"run.{key}" for key in ("horizon", "plant") if getattr(scenario.run, key) != getattr(paper.run, key)]
    if _disturbances(scenario, fitted) != _disturbances(paper, fitted):
        found.append("disturbances")
    return (*found, *_robots(scenario, paper, fitted))


def beside(scenario: Scenario) -> tuple[int | None, str]:
    """Return the number of the paper's table that errors are shown beside, and why of none where one is expected."""
    number = _TABLES.get(scenario.name)
    if number is None or scenario.run.horizon < TABLE_12_HORIZON:
        return None, ""
    found = differences(scenario, shipped=scenario.name)
    return (None, f"Table {number} is left out, it speaks of another run: {said(found)}") if found else (number, "")


def said(found: tuple[str, ...]) -> str:
    """Return that some keys are not the paper's."""
    shown = ", ".join(found[:_MOST_SHOWN])
    more = f" and {len(found) - _MOST_SHOWN} more" if len(found) > _MOST_SHOWN else ""
    verb = "is" if len(found) == 1 and found[0] not in ("obstacles", "disturbances") else "are"
    return f"{shown}{more} {verb} not the paper's"


def _disturbances(scenario: Scenario, fitted: bool) -> list[Any]:
    if not fitted:
        return list(scenario.disturbances)
    return [(one.kind, one.start, one.stop, one.robots) for one in scenario.disturbances]


def _robots(scenario: Scenario, paper: Scenario, fitted: bool) -> Iterable[str]:
    """Give the keys of the paper's robots that differ, and the names of robots that it has not."""
    keys = _PRINTED if fitted else tuple(k for k in Robot.model_fields if k not in _FREE)
    for name in dict.fromkeys((*paper.robots, *scenario.robots)):
        if name not in paper.robots or name not in scenario.robots:
            yield f"robots.{name}"
            continue
        mine, theirs = scenario.robots[name], paper.robots[name]
        yield from (f"robots.{name}.{key}" for key in keys if getattr(mine, key) != getattr(theirs, key))
