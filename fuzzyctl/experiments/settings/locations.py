"""Locations of the keys of a scenario: a line of one of its files, or an argument of the command line."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.experiments.settings.overrides import split_key
from fuzzyctl.experiments.settings.toml_locations import key_places

#: Key by which a scenario names the one it changes.
EXTENDS = "extends"


@dataclass(frozen=True)
class Places:
    """Where the keys of a scenario stand: a line of one of its files, or an argument of the command line.

    Args:
        source: The scenario's own file.
        overrides: Arguments of the command line, by key.
        base: Places of the scenario that it extends.
        hidden: Keys whose values replace those of the base whole.
        common: By the name of a table of tables, the table whose values each of those takes over unless it has its own.
    """

    source: SourceText
    overrides: Mapping[str, str] = field(default_factory=dict)
    base: Places | None = None
    hidden: frozenset[tuple[str, ...]] = frozenset()
    common: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def _keys(self) -> Mapping[tuple[str, ...], tuple[int, int]]:
        return key_places(self.source.text)

    def _exact(self, path: tuple[str, ...]) -> Span | None:
        if found := self._keys.get(path):
            return Span(self.source, *found)
        if self.base is None or any(path[:k] in self.hidden for k in range(1, len(path) + 1)):
            return None
        return self.base._exact(path)

    def _argument(self, path: tuple[str, ...]) -> str:
        """Return the argument of the command line that gave a key, or a whole table with it."""
        heads = (".".join(path[:k]) for k in range(len(path), 0, -1))
        return next((self.overrides[head] for head in heads if head in self.overrides), "")

    def _argument_below(self, path: tuple[str, ...]) -> str:
        """Return the first argument of the command line that gave something in a table."""
        table = f"{'.'.join(path)}."
        return next((argument for key, argument in self.overrides.items() if key.startswith(table)), "")

    def given(self, *path: str) -> bool:
        """Return whether an argument of the command line gave a key, or a whole table with it."""
        return bool(self._argument(path))

    def resolve(self, path: tuple[str, ...]) -> tuple[str, Span | None, str]:
        """Return the key as its author wrote it, its place in the file, and its argument of the command line.

        A key that is taken over from a common table is found there. A table that stands nowhere, but in which an
        argument gave something, has the place of that argument; any other key that of its nearest parent.
        """
        table = self.common.get(path[0]) if len(path) > 2 else None
        common = (table, *path[2:]) if table else None
        for candidate in (path, common):
            if candidate and (argument := self._argument(candidate)):
                return ".".join(candidate), None, argument
            if candidate and (span := self._exact(candidate)):
                return ".".join(candidate), span, ""
        for candidate in (path, common):
            if candidate and (argument := self._argument_below(candidate)):
                return ".".join(path), None, argument
        for length in range(len(path) - 1, 0, -1):
            for candidate in (path[:length], common[: length - 1] if common and length >= 2 else None):
                if candidate and (span := self._exact(candidate)):
                    return ".".join(path), span, ""
        return ".".join(path), None, ""

    def texts(self) -> list[dict[str, str]]:
        """Return name and text of the scenario's file and of those it extends, as they were read."""
        own = {"file": Path(self.source.name).name, "text": self.source.text}
        return [own, *(self.base.texts() if self.base else ())]

    def did_you_mean(self, key: str, known: Collection[str]) -> str:
        """Return a help that names the known key most like the last part of a key, or an empty string.

        An argument of the command line gets the whole key, as it is written there.
        """
        table, _, name = key.rpartition(".")
        near = closest(name, known)
        in_argument = any(f"{written}.".startswith(f"{key}.") for written in self.overrides)
        whole = f"{table}.{near}" if table and in_argument else near
        return f"did you mean '{whole}'?" if near else ""

    def diagnostic(self, code: str, key: str, message: str, *, facts: Sequence[str] = (), help: str = "") -> Diagnostic:
        """Return a diagnostic about a key; its message stays as given."""
        _, span, argument = self.resolve(tuple(split_key(key)))
        file = f"--set {argument}" if argument else self.source.name
        return Diagnostic(code, message, span=span, facts=tuple(facts), help=help, file=file)
