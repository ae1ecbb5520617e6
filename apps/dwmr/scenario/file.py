"""Scenario files: search, reading, and diagnostics with the line of every mistake."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from dwmr.reference.path_files import LARGEST_PATH, PathRows, read_rows
from dwmr.reference.prepared import Shape, shape_of
from dwmr.scenario.checks import cross_checks
from dwmr.scenario.mistakes import diagnose, diagnose_unused
from dwmr.scenario.model import COMMON, Robot, Scenario
from dwmr.scenario.remarks import remarks, too_slow
from dwmr.scenario.vehicle_limits import turning
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import EXTENDS, KeyPath, OverrideError, Places, override, shorten
from fuzzyctl.experiments.scenario_layers import (
    LARGEST_FILE,
    Shipped,
    UnknownScenarioError,
    exists,
    merge,
    overlay,
    read_bytes,
    read_layers,
    replaced,
)
from fuzzyctl.experiments.sweep_spec import show

__all__ = ["LARGEST_FILE", "SHIPPED", "ScenarioFile", "UnknownScenarioError", "find", "read", "shipped_names"]

#: The scenarios that come with dwmr.
SCENARIOS = Shipped(Path(__file__).parents[1] / "scenarios", "begin one with 'dwmr new NAME'", {"robots": COMMON})
SHIPPED = SCENARIOS.folder
find, shipped_names = SCENARIOS.find, SCENARIOS.names


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario together with where it came from.

    Args:
        scenario: Its values.
        path: Its file.
        places: Locations of its keys.
        sha256: Of its file and, where there are any, of the files it extends and of its path's CSV.
        shape: The reference, ready for the loop.
        shapes: The same of robots with a table `reference`, by name.
        warnings: Surprising effects of its values.
        folders: Where files that it names are looked for: beside it, then beside the scenarios it extends.
        files: Its file and those of the scenarios it extends.
    """

    scenario: Scenario
    path: Path
    places: Places
    sha256: str
    shape: Shape = field(repr=False, compare=False)
    shapes: Mapping[str, Shape] = field(repr=False, compare=False)
    warnings: tuple[Diagnostic, ...] = ()
    folders: tuple[Path, ...] = ()
    files: tuple[Path, ...] = ()

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self.scenario.name

    @property
    def settings(self) -> Scenario:
        """Values by key."""
        return self.scenario

    @property
    def texts(self) -> list[dict[str, str]]:
        """Name and text of its file and of those it extends."""
        return self.places.texts()


def read(path: str | Path, overrides: Iterable[str] = ()) -> ScenarioFile:
    """Read a scenario.

    Args:
        path: A TOML file; a text may also be a shipped name.
        overrides: Arguments `key=value` with dotted keys that replace or add values.

    Raises:
        UnknownScenarioError: For a text that is neither a shipped name nor a file.
        DiagnosticError: With every mistake in the file.
        OverrideError: When an override is malformed.
        ArgumentError: For a path of another type, and for one text in place of overrides.
    """
    if not isinstance(path, str | Path):
        raise ArgumentError(f"expected the name or the path of a scenario, got {path!r:.80}")
    if isinstance(overrides, str):
        raise ArgumentError(f"'overrides' must be a list of texts key=value, got {overrides!r:.80}")
    path = find(path) if isinstance(path, str) else path
    layers = read_layers(path, SCENARIOS)
    written: dict[str, str] = {}
    try:
        data, places = merge(layers, written, SCENARIOS.common)
        robots, unused = tuple(_tables(data, "robots")), unused_keys(data)
    except RecursionError:
        raise _too_deep(path) from None
    if "name" not in layers[0].data and len(layers) > 1:  # a changed scenario is not that scenario
        data["name"] = path.stem
    for argument in overrides:
        key, value = override(data, argument)
        if key in written:
            raise OverrideError(f"--set {shorten(argument)}: {key} is given twice")
        if key == EXTENDS or key.startswith(f"{EXTENDS}."):
            raise OverrideError(f"--set {shorten(argument)}: {EXTENDS} cannot be set, only written in a scenario file")
        written[key] = value
    try:
        scenario = _validate(data, places, robots)
        idle = [key for key in unused_keys(data) if places.given(COMMON, *key)]
    except RecursionError:
        raise _too_deep(path) from None
    files = tuple(layer.path for layer in layers)
    folders = tuple(dict.fromkeys(one.parent for one in files))
    digest = hashlib.sha256(b"".join(layer.content for layer in layers))
    mistakes = list(without_effect(idle, scenario.robots, places))
    mistakes += dict.fromkeys(cross_checks(scenario, places))
    try:
        shape, shapes = _shapes(scenario, _reader(folders, places, digest.update), places)
    except DiagnosticError as error:
        raise DiagnosticError([*mistakes, *error.diagnostics]) from None
    paths = {name: shapes.get(name, shape) for name in scenario.robots}
    if not mistakes:
        mistakes += turning(scenario, paths, places)
    if mistakes:
        raise DiagnosticError(mistakes)
    # values of each robot in an extending scenario or by --set are not mistakes of the table below
    table_keys = frozenset(leaves(_tables(layers[0].data, COMMON)))
    idle = [key for key in unused if key in table_keys and not places.given(COMMON, *key)]
    warned = without_effect(idle, scenario.robots, places)
    warnings = (
        *remarks(scenario, places),
        *too_slow(scenario, paths, places),
        *(dataclasses.replace(one, severity="warning") for one in warned),
    )
    return ScenarioFile(scenario, path, places, digest.hexdigest(), shape, shapes, warnings, folders, files)


def _shapes(scenario: Scenario, rows: Callable[[str, str], PathRows], places: Places) -> tuple[Shape, dict[str, Shape]]:
    """Return the reference of the scenario, and those of robots with a table `reference`."""
    references = {name: robot.reference for name, robot in scenario.robots.items() if robot.reference is not None}
    shape = shape_of(scenario.reference, rows, places)
    return shape, {name: shape_of(one, rows, places, f"robots.{name}.reference") for name, one in references.items()}


def _too_deep(path: Path) -> DiagnosticError:
    return DiagnosticError([Diagnostic("FZ901", "tables are nested too deeply", file=str(path))])


def _reader(folders: Sequence[Path], places: Places, note: Callable[[bytes], object]) -> Callable[[str, str], PathRows]:
    """Return a function that reads the CSV file of a key, looked for in some folders; `note` receives its content."""

    def rows(key: str, name: str) -> PathRows:
        for folder in folders:
            if exists(folder / name):
                content = read_bytes(folder / name, LARGEST_PATH, "a path needs a row every few seconds")
                note(content)
                return read_rows(str(folder / name), content)
        message = f"{key} = {name[:200]!r} names a file that does not exist"
        facts = (f"looked in {', '.join(str(f) for f in folders)}",)
        raise DiagnosticError([places.diagnostic("FZ904", key, message, facts=facts)])

    return rows


def _tables(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    table = data.get(key)
    return table if isinstance(table, dict) else {}


def _validate(data: Mapping[str, Any], places: Places, known: Sequence[str]) -> Scenario:
    """Return the scenario of some data; `known` are the robots that its files name."""
    whole = give(data, places)
    mistakes: list[Diagnostic] = []
    scenario = None
    try:
        scenario = Scenario.model_validate(whole)
    except ValidationError as error:
        mistakes += diagnose(error, places, robots=len(_tables(whole, "robots")), known=known)
    try:
        Robot.model_validate(_tables(data, COMMON))
    except ValidationError as error:
        mistakes += diagnose_unused(error, places, unused_keys(data))
    if scenario is None or mistakes:
        raise DiagnosticError(mistakes)
    return scenario


def give(data: Mapping[str, Any], places: Places) -> dict[str, Any]:
    """Merge the [robot] table under every robot of [robots].

    Raises:
        DiagnosticError: When [robot] is not a table.
    """
    rest = {k: v for k, v in data.items() if k != COMMON}
    common, robots = data.get(COMMON, {}), data.get("robots")
    if not isinstance(common, dict):
        message = f"{COMMON} must be a table, got {show(common)}"
        raise DiagnosticError([places.diagnostic("FZ904", COMMON, message)])
    if isinstance(robots, dict):
        rest["robots"] = {
            n: overlay(common, values) if isinstance(values, dict) else values for n, values in robots.items()
        }
    return rest


def unused_keys(data: Mapping[str, Any]) -> tuple[KeyPath, ...]:
    """Return the keys below [robot] for which every robot has another value."""
    common, robots = data.get(COMMON), data.get("robots")
    if not isinstance(common, dict) or not isinstance(robots, dict) or not robots:
        return ()
    replacements = [
        frozenset(replaced(common, one)) if isinstance(one, dict) else frozenset() for one in robots.values()
    ]
    return tuple(key for key in leaves(common) if all(_below(key, keys) for keys in replacements))


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
        keys: From `unused_keys`.
        robots: Names of the robots.
        places: Locations of the keys.
    """
    first = next(iter(robots))
    for key in keys:
        tail = ".".join(key)
        message = f"{COMMON}.{tail} is used by no robot: each has its own"
        help_text = f"set robots.{first}.{tail}, or robots.*.{tail} in a sweep"
        yield places.diagnostic("FZ904", f"{COMMON}.{tail}", message, help=help_text)
