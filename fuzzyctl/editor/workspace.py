"""Names of all rule files below some folders."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.support.reading import is_below, read_source

#: Most files that are looked into, and most names that are returned.
MAX_FILES: Final = 500
MAX_NAMES: Final = 300
#: Folders that hold copies of files.
_SKIPPED: Final = frozenset({"node_modules", "__pycache__"})


class Workspace:
    """Documents of files on disk, each read again when its time or size has changed."""

    def __init__(self) -> None:
        self._read: dict[Path, tuple[tuple[int, int], Document]] = {}

    def documents(self, folders: Iterable[Path], opened: Mapping[str, Document]) -> Iterator[Document]:
        """Yield the documents that are open, then those of the other files below some folders."""
        yield from opened.values()
        for path in rule_files(folders):
            if str(path) not in opened and (document := self._document(path)) is not None:
                yield document

    def symbols(self, folders: Iterable[Path], query: str, opened: Mapping[str, Document]) -> list[Symbol]:
        """Return the names that hold the letters of a query in their order, declared in files below some folders.

        Args:
            folders: The folders.
            query: Letters, case left out; empty for all names.
            opened: Documents that stand for files, by absolute path.
        """
        found = [
            symbol
            for document in self.documents(folders, opened)
            for symbol in document.symbols.all
            if symbol.span.source.name == document.source.name and matches(query, symbol.name)
        ]
        return sorted(found, key=lambda s: (len(s.name), s.name))[:MAX_NAMES]

    def _document(self, path: Path) -> Document | None:
        try:
            state = path.stat()
            stamp = (state.st_mtime_ns, state.st_size)
            known = self._read.get(path)
            if known is None or known[0] != stamp:
                known = (stamp, Document(read_source(path, only_regular=True), path.parent))
                self._read[path] = known
        except (OSError, DiagnosticError):  # it vanished, or is no text
            return None
        return known[1]


def rule_files(folders: Iterable[Path]) -> Iterator[Path]:
    """Yield the rule files below some folders, without hidden ones and links that lead elsewhere."""
    count = 0
    for top in folders:
        for folder, inside, names in os.walk(top):
            inside[:] = sorted(n for n in inside if n not in _SKIPPED and not n.startswith("."))
            for path in (os.path.abspath(os.path.join(folder, name)) for name in sorted(names)):
                if path.endswith(".fz") and is_below(path, top):
                    count += 1
                    if count > MAX_FILES:
                        return
                    yield Path(path)


def matches(query: str, name: str) -> bool:
    """Whether a name holds the letters of a query in their order."""
    letters = iter(name.lower())
    return all(letter in letters for letter in query.lower())
