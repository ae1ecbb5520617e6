"""Interface of experiments: measures computed from settings with locations, under one of several controllers."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, TypeVar

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.result_files import versions
from fuzzyctl.experiments.scenario_layers import UnknownScenarioError, exists


class Scenario(Protocol):
    """Valid settings, and where they come from."""

    @property
    def name(self) -> str:
        """Name in the results."""

    @property
    def path(self) -> Path:
        """File that was read."""

    @property
    def settings(self) -> Any:
        """Values by key: mappings, sequences and pydantic models in one another."""

    @property
    def texts(self) -> Sequence[Mapping[str, str]]:
        """Name and text of each file that was read, as `file` and `text`."""

    @property
    def sha256(self) -> str:
        """Checksum of all files that were read."""

    @property
    def warnings(self) -> Sequence[Diagnostic]:
        """Differences from the author's likely expectation."""


class UsedFile(NamedTuple):
    """A file besides the scenario's own that a run rests on."""

    path: Path
    sha256: str


class Computed(NamedTuple):
    """What came out of a run.

    Attributes:
        row: Measures by column; with `stopped`, whether the run ended before its horizon, and `stop_reason`.
        wall_s: Computing time [s].
    """

    row: Mapping[str, Any]
    wall_s: float


@dataclass(frozen=True)
class Prepared:
    """A run that is checked and compiled.

    Args:
        used: The files that it rests on, by name.
        compute: Computes it; raises DiagnosticError where code of the user raises.
    """

    used: Mapping[str, UsedFile]
    compute: Callable[[], Computed]


S = TypeVar("S", bound=Scenario)


class Runnable(ABC, Generic[S]):
    """Subject of a sweep. Workers get a copy of it by pickle, so it is hashable and holds no results.

    Attributes:
        application: Its name, under which files of results hold their metadata.
        seed: Key of the first number of what a run draws itself, such as noise; each repetition has another one. Empty
            without one.
        common: By the name of a table of tables, the table whose values each of those takes over unless it sets one.
        package: Folder of the sources that compute a run, or None if versions tell them apart.
    """

    application: ClassVar[str] = "fuzzyctl"
    seed: ClassVar[str] = ""
    common: ClassVar[Mapping[str, str]] = {}
    package: ClassVar[Path | None] = None

    @abstractmethod
    def read(self, path: Path, overrides: Sequence[str]) -> S:
        """Read a scenario with replaced values, each `key=value`.

        A mistake in such a value has `--set key=value` as its file; a sweep reports it at the key of its SPEC.

        Raises:
            DiagnosticError: With every mistake.
            OverrideError: When an override is malformed.
        """

    @abstractmethod
    def prepare(self, scenario: S, controller: str, measures: Sequence[str]) -> Prepared:
        """Make a run ready; the compiler is loaded here, not before.

        Raises:
            DiagnosticError: At the first mistake.
        """

    def find(self, name: str, folder: Path = Path()) -> Path:
        """Return the file of a scenario given as a shipped name or a path.

        Args:
            name: The name or path.
            folder: The folder of the SPEC.

        Raises:
            UnknownScenarioError: When it is neither.
        """
        if not exists(Path(name)):
            raise UnknownScenarioError(f"no scenario {name[:200]!r}: there is no such file")
        return Path(name)

    def controllers(self, scenario: S, names: Sequence[str]) -> tuple[str, ...]:
        """Return the controllers that some names stand for, without names the scenario's own.

        Raises:
            UnknownNameError: For an unknown name.
        """
        return tuple(names) or ("",)

    def measures(self, scenario: S, controllers: Sequence[str]) -> tuple[str, ...]:
        """Return the measures that a SPEC may name; none where the class of the SPEC knows them."""
        return ()

    def members(self, scenario: S, controllers: Sequence[str], spec: Any) -> Sequence[Mapping[str, float]]:
        """Return values by key that are drawn from the ranges that a scenario declares; `spec.draws` of them.

        Raises:
            DiagnosticError: For a scenario without such ranges.
        """
        return ({},)

    def check(self, scenario: S, controllers: Sequence[str]) -> Mapping[str, UsedFile]:
        """Check a scenario for some controllers without compiling anything, and return the files it rests on, by name.

        Raises:
            DiagnosticError: With every mistake.
        """
        return {}

    def unread(self, scenario: S, controllers: Sequence[str], used: Mapping[str, str], key: Sequence[str]) -> str:
        """Name the owner of a key if no run of these controllers reads it; else an empty string.

        Args:
            scenario: The scenario.
            controllers: Under which it is run.
            used: Checksums of the files that the runs rest on, by name.
            key: Parts of the key.
        """
        return ""

    def is_better_large(self, scenario: S, controller: str, measure: str) -> bool:
        """Return whether large values of a measure are better than small ones."""
        return False

    def unit(self, scenario: S, column: str) -> str:
        """Return the unit of a column of the results, an empty string without one."""
        return ""

    def own_files(self, scenario: S, controllers: Sequence[str]) -> Mapping[str, str]:
        """Return the checksums of the controllers that are files of the user's own, by name."""
        return {}

    def software(self) -> dict[str, str | None]:
        """Return the versions of the software that computes a run, and a checksum of its sources."""
        if self.package is None:
            return versions()
        digest = hashlib.sha256()
        for folder in (self.package, Path(__file__).parent):
            for source in sorted(folder.rglob("*.py")):
                digest.update(source.read_bytes())
        return {**versions(), "sources": digest.hexdigest()}
