"""Registry of the formats besides `.fz`, by name and by suffix, imported on demand.

The package `fuzzyctl.formats.NAME` has two functions:

    read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]
    write(system: FuzzySystem) -> tuple[str, list[Loss]]

and, if a file may hold several systems, `read_all(source) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]`.
`read` gives all mistakes at once, and a system only without errors. Loading makes the checks of `model.checks`, and
takes errors that are usual in people's files as warnings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import PurePath
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, order=True)
class Loss:
    """One part of a system that a written file does not say, or says in another way.

    Args:
        where: The part of the system, such as `output 'tip'`, `rule 3` or `system 'tipper'`.
        what: The part itself, such as `hedge 'seldom'`, `param 'k_s'` or `guarantees`.
        why: The substitute in the format, one line without a full stop.
        exact: Whether the written file still computes the same numbers, as it does without titles, units and params.
    """

    where: str
    what: str
    why: str
    exact: bool = False

    def __str__(self) -> str:
        return f"{self.where}: {self.what}: {self.why}"


Read = tuple[tuple[FuzzySystem, ...], list[Diagnostic]]


@dataclass(frozen=True)
class Format:
    """A file format of other tools.

    Args:
        name: Its name, which is also that of the package that reads and writes it.
        title: Its name for people.
        suffixes: Suffixes of its files in small letters, the usual one first.
        several: Whether a file may hold several systems.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    several: bool = False

    def _function(self, name: str) -> Callable[..., Any]:
        function: Callable[..., Any] = getattr(import_module(f"fuzzyctl.formats.{self.name}"), name)
        return function

    def read(self, source: SourceText) -> Read:
        """Return the systems of a source without errors, and all diagnostics."""
        if self.several:
            result: Read = self._function("read_all")(source)
            return result
        system, diagnostics = self._function("read")(source)
        return ((system,) if system is not None else ()), diagnostics

    def write(self, system: FuzzySystem) -> tuple[str, list[Loss]]:
        """Return a system as a text of this format, with its losses."""
        written: tuple[str, list[Loss]] = self._function("write")(system)
        return written


#: The formats by name.
FORMATS: Final[dict[str, Format]] = {
    f.name: f
    for f in (
        Format("fll", "FuzzyLite Language", (".fll",)),
        Format("fis", "fuzzy inference system of MATLAB and Octave", (".fis",)),
        Format("fcl", "Fuzzy Control Language of IEC 61131-7", (".fcl",), several=True),
        Format("fml", "Fuzzy Markup Language of IEEE 1855", (".fml", ".xml")),
    )
}

#: All suffixes of rule files.
SUFFIXES: Final = (".fz", *(suffix for f in FORMATS.values() for suffix in f.suffixes))


def format_of(name: str) -> Format | None:
    """Return the format of a file by the suffix of its name; None for `.fz` and for every other suffix."""
    suffix = PurePath(name).suffix.lower()
    return next((f for f in FORMATS.values() if suffix in f.suffixes), None)
