"""SPEC files: find and read them, with every mistake at its line."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from dwmr.layers import LARGEST_FILE, read_bytes
from dwmr.scenario_file import UnknownScenarioError, find
from dwmr.scenario_mistakes import show
from dwmr.sweep.spec import Distribution, Spec
from dwmr.toml_places import key_places
from fuzzyctl.errors import Diagnostic, DiagnosticError, did_you_mean
from fuzzyctl.source import SourceText, Span

#: Tables whose keys are those of a scenario.
TABLES = ("set", "grid", "random")


@dataclass(frozen=True)
class SpecFile:
    """A SPEC together with where its keys stand.

    Args:
        spec: What it says.
        source: Its text.
        path: Its file.
        given: Keys that stand on the command line or in the program, not in the file.
    """

    spec: Spec
    source: SourceText
    path: Path
    given: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def _places(self) -> Mapping[tuple[str, ...], tuple[int, int]]:
        return key_places(self.source.text)

    def span(self, *path: str) -> Span | None:
        """Return the place of a key; of one in quotes or written as tables alike, else of its nearest parent."""
        flat = (*path[:1], *(part for one in path[1:] for part in one.split(".")))
        prefixes = [one[:k] for one in (path, flat) for k in range(len(one), 1, -1)]
        for candidate in (*prefixes, path[:1]):
            if found := self._places.get(candidate):
                return Span(self.source, *found)
        return None

    def diagnostic(self, code: str, path: tuple[str, ...], message: str, **more: Any) -> Diagnostic:
        """Return a diagnostic about a key of the file."""
        return Diagnostic(code, message, span=self.span(*path), file=self.source.name, **more)

    def scenario_path(self) -> Path:
        """Return the scenario's file: a shipped name, or a path from the folder of the SPEC.

        Raises:
            DiagnosticError: When there is none.
        """
        beside = self.path.parent / self.spec.scenario
        try:
            return beside if beside.is_file() else find(self.spec.scenario)
        except (OSError, ValueError):  # a name longer than the file system allows, or one with a null character
            message = f"scenario: {self.spec.scenario[:200]!r} is no name of a file"
        except UnknownScenarioError as error:
            message = f"scenario: {error}"
        raise DiagnosticError([self.diagnostic("FZ904", ("scenario",), message)])


def read(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    content = read_bytes(path, LARGEST_FILE, "a SPEC file holds a few lines of TOML")
    try:
        source = SourceText(str(path), content.decode("utf-8").removeprefix("\ufeff"))
    except UnicodeDecodeError as error:
        message = f"{path} is not UTF-8 text: byte {error.start} is 0x{content[error.start]:02x}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=str(path))]) from error
    try:
        data = tomllib.loads(source.text)
    except (ValueError, RecursionError) as error:
        message = "nesting is too deep" if isinstance(error, RecursionError) else str(error)
        raise DiagnosticError([Diagnostic("FZ901", f"not valid TOML: {message}", file=str(path))]) from error
    return SpecFile(_validate(data, source, path), source, path)


def _validate(data: Mapping[str, Any], source: SourceText, path: Path) -> Spec:
    flat = {**data, **{name: dict(_flat(data[name], name)) for name in TABLES if isinstance(data.get(name), dict)}}
    try:
        return Spec.model_validate(flat)
    except ValidationError as error:
        # only the text matters for places; the content is not valid yet
        places = SpecFile(Spec(scenario="paper"), source, path)
        found = dict.fromkeys(_diagnose(one, places) for one in error.errors(include_url=False))
        raise DiagnosticError(sorted(found, key=lambda d: d.span.start if d.span else -1)) from None


def _flat(table: Mapping[str, Any], name: str, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values of a table of a scenario's keys, which may be in quotes or written as tables."""
    for key, value in table.items():
        # a distribution, or what was meant for one, is a table of the SPEC and not of the scenario
        leaf = name == "random" and isinstance(value, dict) and not any(isinstance(v, dict) for v in value.values())
        if isinstance(value, dict) and value and not leaf:
            yield from _flat(value, name, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


_WORDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotes",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table such as { uniform = [0.9, 1.1] }",
}


def _diagnose(error: Any, places: SpecFile) -> Diagnostic:
    """Turn one of pydantic's errors into a diagnostic with key and value."""
    path = tuple(str(part) for part in error["loc"])
    key = ".".join(path)
    match error["type"]:
        case "extra_forbidden":
            owner: type[BaseModel] = Distribution if path[0] == "random" else Spec
            known = tuple(owner.model_fields)
            facts = (f"{key.rpartition('.')[0] or 'a SPEC'} has the keys {', '.join(known)}",)
            hint = did_you_mean(path[-1], known)
            return places.diagnostic("FZ902", path, f"unknown key {key}", facts=facts, help=hint)
        case "missing":
            return places.diagnostic("FZ903", path, f"{key} is missing")
        case "value_error":
            return places.diagnostic("FZ904", path, f"{key}: {error['ctx']['error']}")
        case "literal_error":
            expected = error["ctx"]["expected"]
            names = tuple(word.strip(" '") for word in expected.replace(" or ", ", ").split(","))
            hint = did_you_mean(str(error["input"]), names)
            message = f"{key} must be one of {expected}, got {show(error['input'])}"
            return places.diagnostic("FZ904", path, message, help=hint)
    must = _WORDS.get(error["type"], error["msg"].removeprefix("Input should be ").removeprefix("Value should "))
    return places.diagnostic("FZ904", path, f"{key} must be {must}, got {show(error['input'])}")
