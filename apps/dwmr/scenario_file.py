"""Scenario files: find and read them, with every mistake at its line."""

from __future__ import annotations

import hashlib
import stat
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from dwmr.overrides import OverrideError, override, shorten
from dwmr.places import COMMON, Places
from dwmr.scenario import Scenario
from dwmr.scenario_mistakes import cross_checks, diagnose, remarks, show
from fuzzyctl.errors import Diagnostic, DiagnosticError, did_you_mean
from fuzzyctl.source import SourceText, Span

#: Scenario files are small; a larger one is refused before it is read.
LARGEST_FILE = 1 << 20

SHIPPED = Path(__file__).parent / "scenarios"


class UnknownScenarioError(Exception):
    """Raised when a scenario is neither a shipped name nor a path to a file."""


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario together with where it came from."""

    scenario: Scenario
    path: Path
    places: Places
    sha256: str
    warnings: tuple[Diagnostic, ...] = ()


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
    try:
        if path.exists():
            return path
    except OSError:  # such as a name longer than the file system allows
        pass
    hint = did_you_mean(name, shipped_names())
    known = ", ".join(shipped_names())
    shown = name if len(name) <= 200 else f"{name[:197]}..."
    raise UnknownScenarioError(
        f"no scenario {shown!r}: it is neither a file nor one of the shipped scenarios: {known}"
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
    written: dict[str, str] = {}
    for argument in overrides:
        key, given = override(data, argument)
        if key in written:
            raise OverrideError(f"--set {shorten(argument)}: {key} is given twice")
        written[key] = given
    places = Places(source, written)
    try:
        scenario = _validate(_give_every_robot_the_common_values(data, places), places)
    except RecursionError:
        raise DiagnosticError([Diagnostic("FZ901", "tables are nested too deeply", file=str(path))]) from None
    mistakes = list(dict.fromkeys(cross_checks(scenario, places)))
    if mistakes:
        raise DiagnosticError(mistakes)
    digest = hashlib.sha256(content).hexdigest()
    return ScenarioFile(scenario, path, places, digest, tuple(remarks(scenario, places)))


def _content(path: Path) -> bytes:
    def refuse(code: str, message: str, help: str = "") -> DiagnosticError:
        return DiagnosticError([Diagnostic(code, message, file=str(path), help=help)])

    if path.is_dir():
        raise refuse("FZ001", f"{path} is a folder, not a scenario file")
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            raise refuse("FZ001", f"{path} is no regular file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise refuse("FZ001", f"{path} cannot be read: {error.strerror}") from error
    if len(content) > LARGEST_FILE:
        help_text = "a scenario file holds a few kilobytes of TOML"
        size = max(len(content), about.st_size)
        raise refuse("FZ003", f"{path} has {size:,} bytes; at most {LARGEST_FILE:,} are read", help_text)
    return content


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
    except (ValueError, RecursionError) as error:  # a plain ValueError is a whole number of thousands of digits
        span = _toml_error_place(str(error), source)
        message = "nesting is too deep" if isinstance(error, RecursionError) else str(error).split(" (at ")[0]
        if not isinstance(error, RecursionError | tomllib.TOMLDecodeError):
            message = "a whole number has too many digits"
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


def _give_every_robot_the_common_values(data: Mapping[str, Any], places: Places) -> dict[str, Any]:
    """Merge the [robot] table under every robot of [robots]."""
    rest = {k: v for k, v in data.items() if k != COMMON}
    common, robots = data.get(COMMON, {}), data.get("robots")
    if not isinstance(common, dict):
        message = f"{COMMON} must be a table, got {show(common)}"
        raise DiagnosticError([places.diagnostic("FZ904", COMMON, message)])
    if isinstance(robots, dict):
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
        robots = data.get("robots")
        count = len(robots) if isinstance(robots, dict) else 0
        raise DiagnosticError(diagnose(error, places, robots=count)) from None
