"""Folder of results: checked before the run, and filled at once when all files are complete."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.writing import removed_if_empty


class Results:
    """Files on their way into a folder of results.

    Args:
        folder: Where they go; it exists.
        names: Names of all files that a run may leave there, or in folders inside: `FOLDER/NAME`.
        help: What to do where files cannot be written.
    """

    def __init__(self, folder: Path, names: Sequence[str], help: str) -> None:
        self.folder, self.names, self.help = folder, tuple(names), help
        self._parts: Path | None = None

    def write(self, name: str, fill: Callable[[Path], None]) -> None:
        """Write a file beside the others that wait; `fill` writes the content to a path.

        Raises:
            DiagnosticError: When it cannot be written.
        """
        try:
            if self._parts is None:
                self._parts = Path(tempfile.mkdtemp(dir=self.folder, prefix=".results-"))
            (self._parts / name).parent.mkdir(exist_ok=True)
            fill(self._parts / name)
        except OSError as error:
            raise _refused(self.folder / name, error, self.help) from error

    def write_text(self, name: str, text: str) -> None:
        """Write a file of text in UTF-8 beside the others that wait.

        Raises:
            DiagnosticError: When it cannot be written.
        """
        self.write(name, lambda path: _write_text(path, text))

    def drop(self, name: str) -> None:
        """Give up a file that waits."""
        if self._parts is not None:
            (self._parts / name).unlink(missing_ok=True)

    def publish(self) -> None:
        """Rename all files that wait into their place; what an earlier run left under other names of a run goes.

        Raises:
            DiagnosticError: When this cannot be done.
        """
        if self._parts is None:
            return
        try:
            for name in self.names:
                if not (self._parts / name).exists():
                    (self.folder / name).unlink(missing_ok=True)
            for name in self.names:
                if (self._parts / name).exists():
                    (self.folder / name).parent.mkdir(exist_ok=True)
                    (self._parts / name).replace(self.folder / name)
        except OSError as error:
            raise _refused(self.folder, error, self.help) from error

    def discard(self) -> None:
        """Remove what still waits."""
        if self._parts is not None:
            shutil.rmtree(self._parts, ignore_errors=True)


@contextmanager
def results(folder: Path, names: Sequence[str], help: str = "name another folder with -o DIR") -> Iterator[Results]:
    """Offer a folder of results; a folder that was made for it and stays empty goes again.

    Args:
        folder: Where they go.
        names: Names of all files that a run may leave there.
        help: What to do where files cannot be written.

    Raises:
        DiagnosticError: When files cannot be written there.
    """
    with removed_if_empty(folder):
        _prepare(folder, names, help)
        files = Results(folder, names, help)
        try:
            yield files
        finally:
            files.discard()


@contextmanager
def one_file(path: Path) -> Iterator[Results]:
    """Offer the way to a single file.

    Raises:
        DiagnosticError: When it cannot be written.
    """
    with results(path.parent, (path.name,), "name another file with -o FILE") as files:
        yield files


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _prepare(folder: Path, names: Sequence[str], help: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".results-"):
            pass
    except FileExistsError:
        raise DiagnosticError([_diagnostic(folder, "it is not a folder", help)]) from None
    except OSError as error:
        raise _refused(folder, error, help) from error
    in_the_way = [path for name in names if (path := folder / name).exists() and not path.is_file()]
    if in_the_way:
        kinds = {True: "it is a folder", False: "it is not a regular file"}
        raise DiagnosticError([_diagnostic(path, kinds[path.is_dir()], help) for path in in_the_way])
    inner = dict.fromkeys((folder / name).parent for name in names)
    no_folders = [path for path in inner if path.exists() and not path.is_dir()]
    if no_folders:
        raise DiagnosticError([_diagnostic(path, "it is a file", help) for path in no_folders])


def _refused(path: Path, error: OSError, help: str) -> DiagnosticError:
    return DiagnosticError([_diagnostic(path, error.strerror or str(error), help)])


def _diagnostic(path: Path, reason: str, help: str) -> Diagnostic:
    shown = str(path) if len(str(path)) <= 300 else f"{str(path)[:297]}..."
    message = f"{shown} cannot be written: {reason}"
    return Diagnostic("FZ909", message, file=shown, help=help)
