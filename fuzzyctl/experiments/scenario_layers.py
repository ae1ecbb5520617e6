"""Scenario files and the files they extend, read and merged into one table."""

from __future__ import annotations

import stat
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.scenario_keys import EXTENDS, KeyPath, Places

#: Scenario files are small; a larger one is refused before it is read.
LARGEST_FILE = 1 << 20
#: Longest chain of scenarios that extend one another.
MOST_LAYERS = 10


class UnknownScenarioError(Exception):
    """Raised when a scenario is neither a shipped name nor a path to a file."""


@dataclass(frozen=True)
class Shipped:
    """The scenarios that come with an application, which are known by their names.

    Args:
        folder: Where they are.
        new: How to begin a file, for the diagnostic of an empty one.
        common: As in `Places`.
    """

    folder: Path
    new: str = ""
    common: Mapping[str, str] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        """Return their names."""
        return tuple(sorted(p.stem for p in self.folder.glob("*.toml")))

    def path(self, name: str) -> Path:
        """Return the file of a shipped scenario."""
        return self.folder / f"{name}.toml"

    def find(self, name: str) -> Path:
        """Return the file of a scenario given as a shipped name or a path.

        Raises:
            UnknownScenarioError: When it is neither.
        """
        base = self.beside(Path(), name)
        if base is not None:
            return base
        hint = did_you_mean(name, self.names())
        names = ", ".join(self.names())
        listing = name if len(name) <= 200 else f"{name[:197]}..."
        raise UnknownScenarioError(
            f"no scenario {listing!r}: it is neither a file nor one of the shipped scenarios: {names}"
            + (f"; {hint}" if hint else "")
        )

    def beside(self, folder: Path, name: str) -> Path | None:
        """Return a scenario by its shipped name or by its path from a folder, or None."""
        if name in self.names():
            return self.path(name)
        return folder / name if exists(folder / name) else None


@dataclass(frozen=True)
class TomlFile:
    """A file of TOML: its text, its bytes and its tables, which files of equal text share."""

    path: Path
    source: SourceText
    content: bytes
    data: dict[str, Any]


def read_layers(path: Path, shipped: Shipped) -> tuple[TomlFile, ...]:
    """Read a scenario file and those it extends, the file itself first.

    Args:
        path: The file.
        shipped: The scenarios that it may extend by name.

    Raises:
        DiagnosticError: When one of them cannot be read, is not TOML, or extends itself.
    """
    layers: list[TomlFile] = []
    following: Path | None = path
    while following is not None:
        layer = read_toml(following, "a scenario file holds a few kilobytes of TOML")
        if not layer.source.text.strip():
            message = f"{following} is empty"
            raise DiagnosticError([Diagnostic("FZ901", message, file=str(following), help=shipped.new)])
        layers.append(layer)
        following = _extended(layers, shipped)
    return tuple(layers)


def _extended(layers: Sequence[TomlFile], shipped: Shipped) -> Path | None:
    """Return the file that the last layer extends, and take the key away."""
    last = layers[-1]
    if EXTENDS not in last.data:
        return None
    name = last.data.pop(EXTENDS)
    places = Places(last.source)
    if not isinstance(name, str) or not name:
        raise DiagnosticError(
            [places.diagnostic("FZ904", EXTENDS, f"{EXTENDS} must be the name of a scenario in quotes")]
        )
    base = shipped.beside(last.path.parent, name)
    if base is None:
        facts = (f"it is neither a file beside {last.path.name} nor one of the shipped {', '.join(shipped.names())}",)
        message = f"{EXTENDS} = {name[:200]!r} names a scenario that does not exist"
        hint = did_you_mean(name, shipped.names())
        raise DiagnosticError([places.diagnostic("FZ904", EXTENDS, message, facts=facts, help=hint)])
    way = [one.path for one in layers]
    if any(base.samefile(one) for one in way):
        circle = " -> ".join(p.name for p in (*way, base))
        raise DiagnosticError([places.diagnostic("FZ904", EXTENDS, f"{EXTENDS} leads in a circle: {circle}")])
    if len(layers) >= MOST_LAYERS:
        message = f"{EXTENDS}: more than {MOST_LAYERS} scenarios upon each other"
        raise DiagnosticError([places.diagnostic("FZ904", EXTENDS, message)])
    return base


def exists(path: Path) -> bool:
    """Return whether such a file exists; False for an impossible name."""
    try:
        return path.exists()
    except (OSError, ValueError):  # a name longer than the file system allows, or one with a null character
        return False


def merge(
    layers: Sequence[TomlFile], overrides: Mapping[str, str], common: Mapping[str, str]
) -> tuple[dict[str, Any], Places]:
    """Lay the files of a scenario over one another, the first on top.

    Tables are merged key by key; lists and other values replace those below, and so does a table of another `kind`.

    Args:
        layers: From `read_layers`.
        overrides: Keys given on the command line, for the places.
        common: As in `Places`.
    """
    data: dict[str, Any] = {}
    places: Places | None = None
    for layer in reversed(layers):
        hidden = frozenset(replaced(data, layer.data))
        data = overlay(data, layer.data)
        top = layer is layers[0]
        places = Places(layer.source, overrides if top else {}, places, hidden, common)
    assert places is not None
    return data, places


def overlay(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table laid over another one; neither is changed, nor shared where it could be."""
    merged = {k: _copy(v) for k, v in below.items()}
    for key, value in above.items():
        under = merged.get(key)
        merged[key] = overlay(under or {}, value) if _mergeable(under, value) else _copy(value)
    return merged


def _mergeable(under: Any, value: Any) -> bool:
    both = isinstance(under, dict) and isinstance(value, dict)
    return both and value.get("kind", under.get("kind")) == under.get("kind")


def replaced(below: Mapping[str, Any], above: Mapping[str, Any], prefix: KeyPath = ()) -> Iterator[KeyPath]:
    """Yield the keys below which the lower table is replaced."""
    for key, value in above.items():
        under = below.get(key)
        if _mergeable(under, value):
            yield from replaced(below[key], value, (*prefix, key))
        elif under is not None:
            yield (*prefix, key)


def _copy(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _copy(v) for k, v in value.items()}
    return [_copy(v) for v in value] if isinstance(value, list) else value


def read_bytes(path: Path, largest: int, help_text: str) -> bytes:
    """Read a regular file of limited size.

    Raises:
        DiagnosticError: When it is not a regular file, or cannot be read.
    """

    def refuse(code: str, message: str, help: str = "") -> DiagnosticError:
        return DiagnosticError([Diagnostic(code, message, file=str(path), help=help)])

    if path.is_dir():
        raise refuse("FZ001", f"{path} is a folder, not a file")
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            raise refuse("FZ001", f"{path} is not a regular file")
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as error:
        raise refuse("FZ001", f"{path} cannot be read: {error.strerror}") from error
    if len(content) > largest:
        size = max(len(content), about.st_size)
        raise refuse("FZ003", f"{path} has {size:,} bytes; at most {largest:,} are read", help_text)
    return content


def read_toml(path: Path, help_text: str) -> TomlFile:
    """Read a file of TOML.

    Args:
        path: The file.
        help_text: What such a file holds, for one that is too large.

    Raises:
        DiagnosticError: When it cannot be read, or is not TOML.
    """
    content = read_bytes(path, LARGEST_FILE, help_text)
    try:
        source = SourceText(str(path), content.decode("utf-8").removeprefix("\ufeff"))
    except UnicodeDecodeError as error:
        message = f"{path} is not UTF-8 text: byte {error.start} is 0x{content[error.start]:02x}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=str(path))]) from error
    try:
        return TomlFile(path, source, content, dict(_tables(source.text)))
    except (ValueError, RecursionError) as error:  # a plain ValueError is a whole number of thousands of digits
        span = _toml_error_place(str(error), source)
        message = "nesting is too deep" if isinstance(error, RecursionError) else str(error).split(" (at ")[0]
        if not isinstance(error, RecursionError | tomllib.TOMLDecodeError):
            message = "a whole number has too many digits"
        raise DiagnosticError(
            [Diagnostic("FZ901", f"not valid TOML: {message}", span=span, file=source.name)]
        ) from error


@lru_cache(maxsize=2 * MOST_LAYERS)
def _tables(text: str) -> Mapping[str, Any]:
    """Parse a text once: a sweep reads the same files for each run. The result is shared, so nothing may change it."""
    return tomllib.loads(text)


def _toml_error_place(message: str, source: SourceText) -> Span | None:
    """Find the place in `... (at line 3, column 7)`; Python 3.14 has attributes for it, 3.11 has not."""
    if message.endswith("(at end of document)"):
        end = len(source.text.rstrip())
        return Span(source, max(0, end - 1), end)
    head, _, tail = message.partition("(at line ")
    if not head or not tail:
        return None
    line, _, column = tail.rstrip(")").partition(", column ")
    start = sum(len(s) for s in source.text.splitlines(keepends=True)[: int(line) - 1]) + int(column) - 1
    start = min(start, max(0, len(source.text) - 1))
    return Span(source, start, start + 1)
