"""Measures of a run as columns of the results, and their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

#: Units of what is kept of a run, by the last part of its column, and of its first part where that has one for all.
_UNITS = {
    "t_end": "s", "x_e": "m", "y_e": "m", "theta_e": "rad", "theta_e_star": "rad", "theta_e_unwrapped": "rad",
}  # fmt: skip
_GROUP_UNITS = {
    "centre_distance": "m", "obstacle_gap": "m", "robot_gap": "m", "avoidance_s": "s", "g_ais_min": "m/s, rad/s",
}  # fmt: skip
_CHATTERING = {"v": "m/s²", "omega": "rad/s²"}
#: Lists of moments of the safety filter; a column has how many concern a robot.
_MOMENTS = ("infeasible", "missed")


def row(measures: Mapping[str, Any], wanted: Sequence[str], robots: Sequence[str]) -> Iterator[tuple[str, Any]]:
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


def unit(column: str) -> str:
    """Return the unit of a column, or nothing for what has none or is a value of the scenario."""
    group, last = column.partition(".")[0], column.rpartition(".")[2]
    if column.startswith("safety.disc_gap."):
        return "m"
    if group == "chattering":
        return _CHATTERING.get(last, "")
    if group in _GROUP_UNITS:
        return _GROUP_UNITS[group]
    return _UNITS.get(last, "") if group.startswith("rmse") or column == "t_end" else ""
