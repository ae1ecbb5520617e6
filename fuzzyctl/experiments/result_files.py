"""Files of results: a folder that is filled when all are complete, tables as CSV, the summary."""

from __future__ import annotations

import csv
import json
import math
import platform
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import literal
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

    def read(self, name: str) -> bytes:
        """Return the content of a file that waits.

        Raises:
            FileNotFoundError: If it does not wait.
        """
        return ((self._parts or self.folder) / name).read_bytes()

    def drop(self, name: str) -> None:
        """Give up a file that waits."""
        if self._parts is not None:
            (self._parts / name).unlink(missing_ok=True)

    def publish(self) -> None:
        """Rename all files that wait into their place; files of an earlier run under its other names are removed.

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
    name = str(path) if len(str(path)) <= 300 else f"{str(path)[:297]}..."
    message = f"{name} cannot be written: {reason}"
    return Diagnostic("FZ909", message, file=name, help=help)


Columns = dict[str, list[Any]]


def columns_of(rows: Sequence[Mapping[str, Any]]) -> Columns:
    """Return rows by column; None for a missing value."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _uniform([row.get(name) for row in rows]) for name in names}


def _uniform(values: list[Any]) -> list[Any]:
    """Give a column one type: numbers with a fraction make all of them such, other mixtures become text."""
    kinds = {type(v) for v in values if v is not None}
    if kinds == {int, float}:
        return [None if v is None else float(v) for v in values]
    if len(kinds) > 1 or kinds & {list, tuple, dict}:
        return [None if v is None else literal(v) for v in values]
    return values


def write_csv(path: Path, columns: Mapping[str, Sequence[Any]]) -> None:
    """Write columns of equal length; numbers read back bit for bit, None is an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        if all(set(map(type, values)) <= {float, int} for values in columns.values()):
            # Nothing to quote: half the time of a file of a million numbers.
            file.writelines(f"{','.join(map(repr, row))}\n" for row in zip(*columns.values(), strict=True))
        else:
            writer.writerows([_cell(v) for v in row] for row in zip(*columns.values(), strict=True))


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else literal(value)


_PACKAGES = ("fuzzyctl", "numpy", "numba")


def write_summary(files: Results, summary: Mapping[str, Any], folder: str = "") -> None:
    """Write summary.json, behind the name of a folder inside; numbers that are not finite become null."""
    text = json.dumps(finite(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    files.write_text(f"{folder}summary.json", text)


def finite(data: Any) -> Any:
    """Return plain data with None for numbers that are not finite."""
    if isinstance(data, Mapping):
        return {k: finite(v) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [finite(v) for v in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def versions() -> dict[str, str | None]:
    """Return the versions of the software that computes a run."""
    return {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}}


def _version(package: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version  # 16 ms, which no other command needs

    try:
        return version(package)
    except PackageNotFoundError:
        return None
