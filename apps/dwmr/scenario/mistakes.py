"""Diagnostics of single values of a scenario, made from pydantic's errors."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from types import UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from dwmr.control.rule_files import ROLES
from dwmr.scenario.model import COMMON, FULL_TURN, Robot, Scenario
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.scenario_keys import EXTENDS, Places
from fuzzyctl.experiments.sweep_spec import BOUNDS, length, requirement, show
from fuzzyctl.support.files import rules_folder

#: Mistakes of the elements of one list that are reported; a list with more of them is another list.
MOST_OF_A_LIST = 10


def diagnose(
    error: ValidationError,
    places: Places,
    prefix: tuple[str, ...] = (),
    robots: int = 0,
    known: Sequence[str] = (),
    table: type[BaseModel] | None = None,
) -> list[Diagnostic]:
    """Turn pydantic's errors into diagnostics in the order of their places.

    Args:
        error: What pydantic found.
        places: Locations of the keys.
        prefix: Key of the table that was validated.
        robots: How many robots there are; what all of them lack is missing in the common table.
        known: The robots that files name; an incomplete one that only the command line names is a slip of its name.
        table: Type of the validated table if scenarios do not know it, as of the gains of a law in Python.
    """
    # a mistake in the common table shows once, not once per robot
    errors = _few_of_each_list([e for e in error.errors(include_url=False) if not _miscounted(e, error)])
    misspelt = dict.fromkeys(e["loc"][1] for e in errors if known and _lacks(e) and e["loc"][1] not in known)
    errors = [e for e in errors if e["loc"][:1] != ("robots",) or e["loc"][1:2] == () or e["loc"][1] not in misspelt]
    diagnostics = dict.fromkeys(_unknown_robot(places, str(name), known) for name in misspelt)
    diagnostics |= dict.fromkeys(_diagnose(e, places, prefix, table) for e in _once(errors, robots - len(misspelt)))
    return sorted(diagnostics, key=lambda d: d.span.start if d.span else -1)


def diagnose_unused(
    error: ValidationError, places: Places, unused: Collection[tuple[str, ...]]
) -> Iterable[Diagnostic]:
    """Turn pydantic's errors about the common table into diagnostics, where no robot takes the value.

    Args:
        error: What pydantic found in the common table alone, which need not be complete.
        places: Locations of the keys.
        unused: Keys of the common table that no robot takes; the others are seen at the robots.
    """
    for one in error.errors(include_url=False):
        loc = tuple(str(p) for p in one["loc"])
        if one["type"] != "missing" and any(loc[:k] in unused for k in range(1, len(loc) + 1)):
            yield _diagnose(one, places, (COMMON,))


def _unknown_robot(places: Places, name: str, known: Sequence[str]) -> Diagnostic:
    key = next((k for k in places.overrides if f"{k}.".startswith(f"robots.{name}.")), f"robots.{name}")
    facts = (f"there are {', '.join(known)}",)
    hint = did_you_mean(name, known)
    return places.diagnostic("FZ902", key, f"there is no robot {name!r}", facts=facts, help=hint)


def _miscounted(one: Any, error: ValidationError) -> bool:
    """Return whether a list counts as too short only because some of its elements are wrong."""
    depth = len(one["loc"])
    return one["type"] == "too_short" and any(
        e["loc"][:depth] == one["loc"] for e in error.errors() if e["loc"][depth:]
    )


def _few_of_each_list(errors: Sequence[Any]) -> list[Any]:
    """Keep at most `MOST_OF_A_LIST` mistakes of the elements of one list."""
    counts: Counter[Any] = Counter()
    few = []
    for one in errors:
        depth = next((k for k, part in enumerate(one["loc"]) if isinstance(part, int)), None)
        head = None if depth is None else one["loc"][:depth]
        counts[head] += 1
        if head is None or counts[head] <= MOST_OF_A_LIST:
            few.append(one)
    return few


def _once(errors: Sequence[Any], robots: int) -> Iterable[Any]:
    """Give what every robot lacks once, as a key of the common table."""
    lacking = Counter(e["loc"][2:] for e in errors if _lacks(e))
    tails: set[Any] = set()
    for one in errors:
        tail = one["loc"][2:]
        if not _lacks(one) or lacking[tail] < max(robots, 2):
            yield one
        elif tail not in tails:
            tails.add(tail)
            yield {**one, "common": True}


def _lacks(error: Any) -> bool:
    return error["type"] == "missing" and error["loc"][:1] == ("robots",) and len(error["loc"]) > 2


def _diagnose(error: Any, places: Places, prefix: tuple[str, ...], table: type[BaseModel] | None = None) -> Diagnostic:
    """Turn one of pydantic's errors into a diagnostic with key, value, bound and unit."""
    typed = (*prefix, *(str(p) for p in error["loc"]))
    path = _as_written(typed)
    if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
        path = (*path, "kind")
    key, span, argument = places.resolve((COMMON, *path[2:]) if error.get("common") else path)
    file = f"--set {argument}" if argument else places.source.name
    info = _field(typed) if table is None else table.model_fields.get(typed[-1])
    unit = f" {info.json_schema_extra['unit']}" if info and isinstance(info.json_schema_extra, dict) else ""
    unit = "" if unit == " -" else unit
    meaning: tuple[str, ...] = ()
    if info and info.description and info.description != path[-1]:
        meaning = (f"{path[-1]} is: {info.description}{f' [{unit.strip()}]' if unit else ''}",)
    match error["type"]:
        case "extra_forbidden":
            keys = _known_keys(typed[:-1]) if table is None else tuple(table.model_fields)
            parent = key.rpartition(".")[0] or "a scenario"
            facts = (f"{parent} has the keys {', '.join(keys)}",)
            hint = _elsewhere(path[-1]) if len(typed) == 1 else ""
            hint = hint or places.did_you_mean(key, keys)
            return Diagnostic("FZ902", f"unknown key {key}", span, facts=facts, help=hint, file=file)
        case "missing" if len(path) > 1 and path[0] == "rules" and path[1] not in ROLES:
            return unknown_role(places, path[1])
        case "missing" | "union_tag_not_found":
            return Diagnostic("FZ903", f"{key} is missing", span, facts=meaning, file=file)
        case "union_tag_invalid":
            kinds = error["ctx"]["expected_tags"]
            message = f"{key} must be one of {kinds}, got {show(error['ctx']['tag'])}"
            hint = did_you_mean(str(error["ctx"]["tag"]), tuple(k.strip(" '") for k in kinds.split(",")))
            return Diagnostic("FZ904", message, span, help=hint, file=file)
        case "too_short" | "too_long" | "string_too_short":
            return Diagnostic("FZ904", f"{key} {length(error)}", span, facts=meaning, file=file)
        case "value_error":
            message = str(error["ctx"]["error"])
            return Diagnostic("FZ904", f"{key}: {message}", span, file=file)
    must = requirement(error, _bound) + (unit if error["type"] in BOUNDS else "")
    return Diagnostic("FZ904", f"{key} must be {must}, got {show(error['input'])}", span, facts=meaning, file=file)


def _bound(value: float) -> str:
    """Write a bound; of angles it is a full turn."""
    return f"{'-' * (value < 0)}2π" if abs(value) == FULL_TURN else f"{value:g}"


def _field(path: tuple[str, ...]) -> Any:
    """Return pydantic's description of the field at a path of a scenario, or None."""
    owner = _type_at(path[:-1])
    return owner.model_fields.get(path[-1]) if owner is not None and path else None


def _known_keys(path: tuple[str, ...]) -> tuple[str, ...]:
    """Return the keys that the table at a path may have."""
    owner = _type_at(path)
    keys = tuple(owner.model_fields) if owner is not None else ()
    return keys if path else (EXTENDS, COMMON, *keys)


def _elsewhere(key: str) -> str:
    """Name the table of a scenario, or the rule file, that has a key given outside of any table, if just one has."""
    owners = [table for table in _known_keys(()) if key in _known_keys((table,))]
    owners += [f"rules.{role}" for role in ROLES if re.search(rf"(?m)^param +{re.escape(key)}\b", _shipped(role))]
    return f"did you mean '{owners[0]}.{key}'?" if len(owners) == 1 else ""


def _shipped(role: str) -> str:
    """Return the text of the shipped rule file of a role; an empty string without one."""
    path = rules_folder() / f"{role}.fz"
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def _as_written(path: tuple[str, ...]) -> tuple[str, ...]:
    """Take out the kind of a reference, vehicle or formation, which pydantic names in between."""
    for k, part in enumerate(path[1:], 1):
        if (path[k - 1], part) in _KINDS:
            return (*path[:k], *path[k + 1 :])
    return path


def _type_at(path: tuple[str, ...]) -> type[BaseModel] | None:
    """Return the model of the table at a path of a scenario."""
    current: Any = Scenario
    if path[:1] == (COMMON,):  # as every robot
        path = ("robots", *path)
    for part in path:
        if isinstance(current, _Kinds):
            current = next((m for m in current.models if _kind(m) == part), None)
        elif _is_model(current):
            field_there = current.model_fields.get(part)
            current = field_there.annotation if field_there else None
        else:
            current = next((a for a in reversed(get_args(current)) if a is not Ellipsis), None)
        if get_origin(current) in (Union, UnionType):
            options = [a for a in get_args(current) if a is not type(None)]
            current = options[0] if len(options) == 1 else _Kinds(options)
    return current if _is_model(current) else None


class _Kinds:
    """Sections that `kind` chooses from."""

    def __init__(self, models: Sequence[Any]) -> None:
        self.models = models


def _kind(model: Any) -> str:
    return str(get_args(model.model_fields["kind"].annotation)[0])


#: Pairs of a table and a kind of it.
_KINDS = {("reference", _kind(m)) for m in get_args(Scenario.model_fields["reference"].annotation)}
_KINDS |= {
    (key, _kind(m))
    for key in ("vehicle", "formation")
    for m in get_args(Robot.model_fields[key].annotation)
    if m is not type(None)
}


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def unknown_role(places: Places, role: str) -> Diagnostic:
    """Describe a table of [rules] that no control law asks for."""
    key, facts = f"rules.{role}", (f"the roles are {', '.join(ROLES)}",)
    # An argument of the command line that gives a value of the table is where the table is named.
    place = next((k for k in places.overrides if f"{k}.".startswith(f"{key}.")), key)
    return places.diagnostic("FZ902", place, f"unknown key {key}", facts=facts, help=places.did_you_mean(key, ROLES))
