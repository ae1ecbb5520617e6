"""Mistakes in a scenario as diagnostics: of single values as pydantic finds them, and of several keys together."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from dwmr import controllers
from dwmr.fuzzy_gains import ROLES
from dwmr.places import COMMON, Places
from dwmr.scenario import Scenario
from fuzzyctl.errors import Diagnostic, did_you_mean

#: A run keeps every sample in memory; more than this many samples of all robots are refused.
MOST_SAMPLES = 5_000_000


def diagnose(error: ValidationError, places: Places, prefix: tuple[str, ...] = (), robots: int = 0) -> list[Diagnostic]:
    """Turn pydantic's errors into diagnostics in the order of their places.

    Args:
        error: What pydantic found.
        places: Where the keys stand.
        prefix: Key of the table that was validated.
        robots: How many robots there are; what all of them lack is missing in the common table.
    """
    # a mistake in the common table shows once, not once per robot
    found = dict.fromkeys(_diagnose(e, places, prefix) for e in _once(error.errors(include_url=False), robots))
    return sorted(found, key=lambda d: d.span.start if d.span else -1)


def _once(errors: Sequence[Any], robots: int) -> Iterable[Any]:
    """Give what every robot lacks once, as a key of the common table."""
    lacking = Counter(e["loc"][2:] for e in errors if _lacks(e))
    shown: set[Any] = set()
    for one in errors:
        tail = one["loc"][2:]
        if not _lacks(one) or lacking[tail] < max(robots, 2):
            yield one
        elif tail not in shown:
            shown.add(tail)
            yield {**one, "common": True}


def _lacks(error: Any) -> bool:
    return error["type"] == "missing" and error["loc"][:1] == ("robots",) and len(error["loc"]) > 2


def _diagnose(error: Any, places: Places, prefix: tuple[str, ...]) -> Diagnostic:
    """Turn one of pydantic's errors into a diagnostic with key, value, bound and unit."""
    path = (*prefix, *(str(p) for p in error["loc"]))
    key, span, argument = places.resolve((COMMON, *path[2:]) if error.get("common") else path)
    file = f"--set {argument}" if argument else places.source.name
    info = _field(path)
    unit = f" {info.json_schema_extra['unit']}" if info and isinstance(info.json_schema_extra, dict) else ""
    unit = "" if unit == " -" else unit
    meaning: tuple[str, ...] = ()
    if info and info.description and info.description != path[-1]:
        meaning = (f"{path[-1]} is: {info.description}{f' [{unit.strip()}]' if unit else ''}",)
    match error["type"]:
        case "extra_forbidden":
            known = _known_keys(path[:-1])
            parent = key.rpartition(".")[0] or "a scenario"
            facts = (f"{parent} has the keys {', '.join(known)}",)
            hint = did_you_mean(path[-1], known)
            return Diagnostic("FZ902", f"unknown key {key}", span, facts=facts, help=hint, file=file)
        case "missing" if len(path) > 1 and path[0] == "rules" and path[1] not in ROLES:
            return _unknown_role(places, path[1])
        case "missing":
            return Diagnostic("FZ903", f"{key} is missing", span, facts=meaning, file=file)
        case "value_error":
            message = str(error["ctx"]["error"])
            return Diagnostic("FZ904", f"{key}: {message}", span, file=file)
    must = _requirement(error) + (unit if error["type"] in _BOUNDS else "")
    return Diagnostic("FZ904", f"{key} must be {must}, got {show(error['input'])}", span, facts=meaning, file=file)


_BOUNDS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


def _requirement(error: Any) -> str:
    kind = error["type"]
    if kind in _BOUNDS:
        name, symbol = _BOUNDS[kind]
        return f"{symbol} {error['ctx'][name]:g}"
    if kind in _KINDS:
        return _KINDS[kind]
    if kind == "literal_error":
        return str(error["ctx"]["expected"])
    return f"right ({error['msg']})"


def show(value: Any) -> str:
    """Return a value of a scenario as a short text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    try:
        text = repr(value)
    except ValueError:
        return "a whole number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _field(path: tuple[str, ...]) -> Any:
    """Return pydantic's description of the field at a path of a scenario, or None."""
    owner = _type_at(path[:-1])
    return owner.model_fields.get(path[-1]) if owner is not None and path else None


def _known_keys(path: tuple[str, ...]) -> tuple[str, ...]:
    """Return the keys that the table at a path may have."""
    owner = _type_at(path)
    keys = tuple(owner.model_fields) if owner is not None else ()
    return keys if path else (COMMON, *keys)


def _type_at(path: tuple[str, ...]) -> type[BaseModel] | None:
    """Return the model of the table at a path of a scenario."""
    current: Any = Scenario
    for part in path:
        if _is_model(current):
            field_there = current.model_fields.get(part)
            current = field_there.annotation if field_there else None
        else:
            current = next((a for a in reversed(get_args(current)) if a is not Ellipsis), None)
        if get_origin(current) in (Union, UnionType):
            current = next((a for a in get_args(current) if a is not type(None)), None)
    return current if _is_model(current) else None


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def cross_checks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check what concerns several keys at once."""
    names = tuple(scenario.robots)
    laws, folder = controllers.names(), Path(places.source.name).parent
    if not controllers.exists(scenario.run.controller, folder):
        yield _unknown(places, "run.controller", scenario.run.controller, "controller", laws)
    for role in scenario.rules:
        if role not in ROLES:
            yield _unknown_role(places, role)
    for a, obstacle in enumerate(scenario.obstacles):
        reach = scenario.avoidance.largest_radius
        if reach <= obstacle.radius:
            message = (
                f"avoidance.largest_radius = {reach:g} m does not exceed obstacles.{a}.radius = {obstacle.radius:g} m: "
                "no robot would ever avoid it"
            )
            yield places.diagnostic("FZ904", "avoidance.largest_radius", message)
    for name, robot in scenario.robots.items():
        for law in robot.controllers.__pydantic_extra__ or {}:
            if not controllers.exists(law, folder):
                yield _unknown(places, f"robots.{name}.controllers.{law}", law, "controller", laws)
        if robot.formation is not None and robot.formation.leader not in names:
            yield _unknown(places, f"robots.{name}.formation.leader", robot.formation.leader, "robot", names)
        elif robot.formation is not None and robot.avoids_obstacles:
            key = f"robots.{name}.avoids_obstacles"
            message = f"{key} = true, but {name} follows {robot.formation.leader}: only a robot on the reference avoids"
            yield places.diagnostic("FZ904", key, message)
        elif _follows_itself(scenario, name):
            message = f"robots.{name}.formation.leader leads back to {name}; some robot must follow the reference"
            yield places.diagnostic("FZ904", f"robots.{name}.formation.leader", message)
    for k, one in enumerate(scenario.disturbances):
        for robot_name in one.robots or ():
            if robot_name not in names:
                yield _unknown(places, f"disturbances.{k}.robots", robot_name, "robot", names)
    samples = scenario.run.steps * len(names)
    if samples > MOST_SAMPLES:
        message = (
            f"run.horizon = {scenario.run.horizon:g} s makes {samples:,} samples; at most {MOST_SAMPLES:,} are kept"
        )
        yield places.diagnostic("FZ904", "run.horizon", message, help="shorten run.horizon or lengthen run.dt")


def remarks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Warn of what a run does otherwise than its author may think."""
    run = scenario.run
    reached = run.steps * run.dt
    if abs(reached - run.horizon) > 1e-9 * run.horizon:
        message = (
            f"run.horizon = {run.horizon:g} s is no multiple of run.dt = {run.dt:g} s: the run ends at {reached:.6g} s"
        )
        yield dataclasses.replace(places.diagnostic("FZ904", "run.horizon", message), severity="warning")


def _follows_itself(scenario: Scenario, name: str) -> bool:
    seen = {name}
    formation = scenario.robots[name].formation
    while formation is not None and formation.leader in scenario.robots:
        if formation.leader in seen:
            return formation.leader == name
        seen.add(formation.leader)
        formation = scenario.robots[formation.leader].formation
    return False


def _unknown_role(places: Places, role: str) -> Diagnostic:
    key, facts = f"rules.{role}", (f"the roles are {', '.join(ROLES)}",)
    return places.diagnostic("FZ902", key, f"unknown key {key}", facts=facts, help=did_you_mean(role, ROLES))


def _unknown(places: Places, key: str, name: str, kind: str, known: tuple[str, ...]) -> Diagnostic:
    message = f"{key} names an unknown {kind} {name!r}"
    return places.diagnostic(
        "FZ904", key, message, facts=(f"there are {', '.join(known)}",), help=did_you_mean(name, known)
    )
