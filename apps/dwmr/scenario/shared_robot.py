"""Common [robot] table of a scenario: its merge into every robot, and warnings of values without effect."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from dwmr.config.shipped import COMMON
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import KeyPath, Places
from fuzzyctl.experiments.scenario_layers import overlay, replaced
from fuzzyctl.experiments.value_errors import show


def give(data: Mapping[str, Any], places: Places) -> dict[str, Any]:
    """Merge the [robot] table under every robot of [robots].

    Raises:
        DiagnosticError: When [robot] is no table.
    """
    rest = {k: v for k, v in data.items() if k != COMMON}
    common, robots = data.get(COMMON, {}), data.get("robots")
    if not isinstance(common, dict):
        message = f"{COMMON} must be a table, got {show(common)}"
        raise DiagnosticError([places.diagnostic("FZ904", COMMON, message)])
    if isinstance(robots, dict):
        rest["robots"] = {n: overlay(common, own) if isinstance(own, dict) else own for n, own in robots.items()}
    return rest


def unused(data: Mapping[str, Any]) -> tuple[KeyPath, ...]:
    """Return the keys below [robot] for which every robot has its own value."""
    common, robots = data.get(COMMON), data.get("robots")
    if not isinstance(common, dict) or not isinstance(robots, dict) or not robots:
        return ()
    own = [frozenset(replaced(common, one)) if isinstance(one, dict) else frozenset() for one in robots.values()]
    return tuple(key for key in leaves(common) if all(_below(key, keys) for keys in own))


def leaves(table: Mapping[str, Any], prefix: KeyPath = ()) -> Iterator[KeyPath]:
    """Yield the keys of the values of a table and of its tables."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from leaves(value, (*prefix, key))
        else:
            yield (*prefix, key)


def _below(key: KeyPath, heads: frozenset[KeyPath]) -> bool:
    return any(key[:k] in heads for k in range(1, len(key) + 1))


def without_effect(keys: Iterable[KeyPath], robots: Iterable[str], places: Places) -> Iterator[Diagnostic]:
    """Describe values of [robot] that no robot takes.

    Args:
        keys: From `unused`.
        robots: Names of the robots.
        places: Where the keys stand.
    """
    first = next(iter(robots))
    for key in keys:
        tail = ".".join(key)
        message = f"{COMMON}.{tail} is used by no robot: each has its own"
        help_text = f"set robots.{first}.{tail}, or robots.*.{tail} in a sweep"
        yield places.diagnostic("FZ904", f"{COMMON}.{tail}", message, help=help_text)
