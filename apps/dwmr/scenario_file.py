"""Scenario files: find, read, override, validate, and say what is wrong at which line."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from dwmr import controllers
from dwmr.scenario import Scenario
from dwmr.toml_places import key_places
from fuzzyctl.errors import Diagnostic, DiagnosticError, did_you_mean
from fuzzyctl.source import SourceText, Span

#: Scenario files are small; a larger one is refused before it is read.
LARGEST_FILE = 1 << 20

#: A run keeps every sample in memory; more than this many samples of all robots are refused.
MOST_SAMPLES = 5_000_000

SHIPPED = Path(__file__).parent / "scenarios"

_COMMON = "robot"


class UnknownScenarioError(Exception):
    """Raised when a scenario is neither a shipped name nor a path to a file."""


class OverrideError(Exception):
    """Raised when a `--set` argument is not of the form key=value."""


@dataclass(frozen=True)
class Places:
    """Where the keys of a scenario stand: a line of its file, or an argument of the command line."""

    source: SourceText
    overrides: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def _keys(self) -> Mapping[tuple[str, ...], tuple[int, int]]:
        return key_places(self.source.text)

    def _exact(self, path: tuple[str, ...]) -> Span | None:
        found = self._keys.get(path)
        return Span(self.source, *found) if found else None

    def resolve(self, path: tuple[str, ...]) -> tuple[str, Span | None, str]:
        """Return the key as its author wrote it, its place in the file, and its argument of the command line.

        A key that a robot takes over from the common [robot] table is found there. A key that stands nowhere has the
        place of its nearest parent.
        """
        common = (_COMMON, *path[2:]) if path[:1] == ("robots",) and len(path) > 2 else None
        for candidate in (path, common):
            if candidate and ".".join(candidate) in self.overrides:
                return ".".join(candidate), None, self.overrides[".".join(candidate)]
            if candidate and (span := self._exact(candidate)):
                return ".".join(candidate), span, ""
        for length in range(len(path) - 1, 0, -1):
            for candidate in (path[:length], (_COMMON, *path[2:length]) if common and length >= 2 else None):
                if candidate and (span := self._exact(candidate)):
                    return ".".join(path), span, ""
        return ".".join(path), None, ""

    def diagnostic(self, code: str, key: str, message: str, *, facts: Sequence[str] = (), help: str = "") -> Diagnostic:
        """Return a diagnostic about a key; its message stays as given."""
        _, span, argument = self.resolve(tuple(key.split(".")))
        file = f"--set {argument}" if argument else self.source.name
        return Diagnostic(code, message, span=span, facts=tuple(facts), help=help, file=file)


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario together with where it came from."""

    scenario: Scenario
    path: Path
    places: Places
    sha256: str


def shipped_names() -> tuple[str, ...]:
    """Return the names of the scenarios that come with dwmr."""
    return tuple(sorted(p.stem for p in SHIPPED.glob("*.toml")))


def find(name: str) -> Path:
    """Return the file of a scenario given as a shipped name or a path.

    Raises:
        UnknownScenarioError: When it is neither.
    """
    if name in shipped_names():
        return SHIPPED / f"{name}.toml"
    path = Path(name)
    if path.exists():
        return path
    hint = did_you_mean(name, shipped_names())
    known = ", ".join(shipped_names())
    raise UnknownScenarioError(
        f"no scenario {name!r}: it is neither a file nor one of the shipped scenarios: {known}"
        + (f"; {hint}" if hint else "")
    )


def read(path: Path, overrides: Iterable[str] = ()) -> ScenarioFile:
    """Read a scenario file.

    Args:
        path: A TOML file.
        overrides: Arguments `key=value` with dotted keys that replace or add values.

    Raises:
        DiagnosticError: With every mistake in the file.
        OverrideError: When an override is malformed.
    """
    content = _content(path)
    text = _text(path, content)
    source = SourceText(str(path), text)
    data = _parse(source)
    written = dict(_override(data, argument) for argument in overrides)
    places = Places(source, written)
    merged = _give_every_robot_the_common_values(data)
    scenario = _validate(merged, places)
    mistakes = list(_cross_checks(scenario, places))
    if mistakes:
        raise DiagnosticError(mistakes)
    return ScenarioFile(scenario, path, places, hashlib.sha256(content).hexdigest())


def _content(path: Path) -> bytes:
    def refuse(code: str, message: str, help: str = "") -> DiagnosticError:
        return DiagnosticError([Diagnostic(code, message, file=str(path), help=help)])

    if path.is_dir():
        raise refuse("FZ001", f"{path} is a folder, not a scenario file")
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE:
            help_text = "a scenario file holds a few kilobytes of TOML"
            raise refuse("FZ003", f"{path} has {size:,} bytes; at most {LARGEST_FILE:,} are read", help_text)
        return path.read_bytes()
    except OSError as error:
        raise refuse("FZ001", f"{path} cannot be read: {error.strerror}") from error


def _text(path: Path, content: bytes) -> str:
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        message = f"{path} is not UTF-8 text: byte {error.start} is 0x{content[error.start]:02x}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=str(path))]) from error
    if not text.strip():
        help_text = f"start from a copy of {SHIPPED / 'paper.toml'}"
        raise DiagnosticError([Diagnostic("FZ901", f"{path} is empty", file=str(path), help=help_text)])
    return text.removeprefix("\ufeff")


def _parse(source: SourceText) -> dict[str, Any]:
    try:
        return tomllib.loads(source.text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        span = _toml_error_place(str(error), source)
        message = str(error).split(" (at ")[0] or "nesting is too deep"
        raise DiagnosticError(
            [Diagnostic("FZ901", f"not valid TOML: {message}", span=span, file=source.name)]
        ) from error


def _toml_error_place(message: str, source: SourceText) -> Span | None:
    """Find the place in `... (at line 3, column 7)`; Python 3.14 has attributes for it, 3.11 has not."""
    head, _, tail = message.partition("(at line ")
    if not head or not tail:
        return None
    line, _, column = tail.rstrip(")").partition(", column ")
    start = sum(len(s) for s in source.text.splitlines(keepends=True)[: int(line) - 1]) + int(column) - 1
    start = min(start, max(0, len(source.text) - 1))
    return Span(source, start, start + 1)


def _override(data: dict[str, Any], argument: str) -> tuple[str, str]:
    """Set one value; return the full key and the argument that set it."""
    key, equals, value = argument.partition("=")
    parts = [p.strip() for p in key.split(".")]
    if not equals or not all(parts):
        raise OverrideError(f"--set {argument}: expected key=value with a dotted key, such as run.horizon=20")
    node: Any = data
    for k, part in enumerate(parts[:-1]):
        node = _child(node, part, ".".join(parts[: k + 1]), argument)
    if isinstance(node, list):
        node[_index(node, parts[-1], argument)] = _value(value)
    elif isinstance(node, dict):
        node[parts[-1]] = _value(value)
    else:
        raise OverrideError(f"--set {argument}: {'.'.join(parts[:-1])} is a value, not a table")
    return ".".join(parts), argument


def _child(node: Any, part: str, key: str, argument: str) -> Any:
    if isinstance(node, list):
        return node[_index(node, part, argument)]
    if isinstance(node, dict):
        return node.setdefault(part, {})
    raise OverrideError(f"--set {argument}: {key.rpartition('.')[0]} is a value, not a table")


def _index(items: list[Any], part: str, argument: str) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        raise OverrideError(f"--set {argument}: {part!r} is no index here; there are {len(items)}, counted from 0")
    return int(part)


def _value(text: str) -> Any:
    """Read a value as TOML does; a bare word is text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()


def _give_every_robot_the_common_values(data: Mapping[str, Any]) -> dict[str, Any]:
    """Merge the [robot] table under every robot of [robots]."""
    rest = {k: v for k, v in data.items() if k != _COMMON}
    common, robots = data.get(_COMMON, {}), data.get("robots")
    if isinstance(robots, dict) and isinstance(common, dict):
        rest["robots"] = {n: _merge(common, own) if isinstance(own, dict) else own for n, own in robots.items()}
    return rest


def _merge(common: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(common)
    for key, value in own.items():
        below = merged.get(key)
        merged[key] = _merge(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
    return merged


def _validate(data: Mapping[str, Any], places: Places) -> Scenario:
    try:
        return Scenario.model_validate(data)
    except ValidationError as error:
        raise DiagnosticError(diagnose(error, places)) from None


def diagnose(error: ValidationError, places: Places, prefix: tuple[str, ...] = ()) -> list[Diagnostic]:
    """Turn pydantic's errors into diagnostics in the order of their places.

    Args:
        error: What pydantic found.
        places: Where the keys stand.
        prefix: Key of the table that was validated.
    """
    # a mistake in the common table shows once, not once per robot
    found = dict.fromkeys(_diagnose(e, places, prefix) for e in error.errors(include_url=False))
    return sorted(found, key=lambda d: d.span.start if d.span else -1)


def _diagnose(error: Any, places: Places, prefix: tuple[str, ...]) -> Diagnostic:
    """Turn one of pydantic's errors into a diagnostic with key, value, bound and unit."""
    path = (*prefix, *(str(p) for p in error["loc"]))
    key, span, argument = places.resolve(path)
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
        case "missing":
            return Diagnostic("FZ903", f"{key} is missing", span, facts=meaning, file=file)
        case "value_error":
            message = str(error["ctx"]["error"])
            return Diagnostic("FZ904", f"{key}: {message}", span, file=file)
    must = _requirement(error) + (unit if error["type"] in _BOUNDS else "")
    return Diagnostic("FZ904", f"{key} must be {must}, got {_show(error['input'])}", span, facts=meaning, file=file)


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


def _show(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _field(path: tuple[str, ...]) -> Any:
    """Return pydantic's description of the field at a path of a scenario, or None."""
    owner = _type_at(path[:-1])
    return owner.model_fields.get(path[-1]) if owner is not None and path else None


def _known_keys(path: tuple[str, ...]) -> tuple[str, ...]:
    """Return the keys that the table at a path may have."""
    owner = _type_at(path)
    keys = tuple(owner.model_fields) if owner is not None else ()
    return keys if path else (_COMMON, *keys)


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


def _cross_checks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check what concerns several keys at once."""
    names = tuple(scenario.robots)
    laws = controllers.names()
    if scenario.run.controller not in laws:
        yield _unknown(places, "run.controller", scenario.run.controller, "controller", laws)
    for name, robot in scenario.robots.items():
        for law in robot.controllers.__pydantic_extra__ or {}:
            if law not in laws:
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


def _follows_itself(scenario: Scenario, name: str) -> bool:
    seen = {name}
    formation = scenario.robots[name].formation
    while formation is not None and formation.leader in scenario.robots:
        if formation.leader in seen:
            return formation.leader == name
        seen.add(formation.leader)
        formation = scenario.robots[formation.leader].formation
    return False


def _unknown(places: Places, key: str, name: str, kind: str, known: tuple[str, ...]) -> Diagnostic:
    message = f"{key} names an unknown {kind} {name!r}"
    return places.diagnostic(
        "FZ904", key, message, facts=(f"there are {', '.join(known)}",), help=did_you_mean(name, known)
    )
