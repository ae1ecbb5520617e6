"""From a file to a fuzzy system, read like a table of contents: read → parse → resolve → check."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from fuzzyctl.errors import Diagnostic, DiagnosticError
from fuzzyctl.lang.parser import parse
from fuzzyctl.model.checks import check_model
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.resolve import resolve
from fuzzyctl.source import SourceText

#: Largest rule file that is read, in bytes, unless the caller says otherwise.
MAX_BYTES: Final = 1 << 20


def load(path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES) -> FuzzySystem:
    """Read a fuzzy system from a rule file.

    Args:
        path: The `.fz` file.
        max_bytes: Largest size that is read.

    Returns:
        The system; its warnings, if any, are what `examine` returns.

    Raises:
        DiagnosticError: With all mistakes of the file, each with line, column and help.
    """
    return _required(examine(read_source(path, max_bytes=max_bytes)))


def loads(text: str, name: str = "<text>") -> FuzzySystem:
    """Read a fuzzy system from a text; `name` is shown in diagnostics."""
    return _required(examine(SourceText(name, text)))


def examine(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Parse, resolve and check a source.

    Returns:
        The system, None when there are errors, and all diagnostics, warnings included, in the order of their places.
    """
    tree, diagnostics = parse(source)
    system, found = resolve(tree, broken=bool(diagnostics))
    diagnostics = [*diagnostics, *found]
    if system is not None:
        diagnostics.extend(check_model(system))
    diagnostics.sort(key=lambda d: d.span.start if d.span is not None else -1)
    return (None if any(d.severity == "error" for d in diagnostics) else system), diagnostics


def read_source(path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES) -> SourceText:
    """Read a file as text.

    A byte order mark is dropped; lines may end with LF or CRLF.

    Raises:
        DiagnosticError: When the file is missing, a directory, unreadable, too large or not UTF-8 text.
    """
    name = os.fspath(path)
    try:
        with Path(name).open("rb") as file:
            data = file.read(max_bytes + 1)
    except OSError as error:
        raise DiagnosticError([_unreadable(name, error)]) from None
    if len(data) > max_bytes:
        message = f"the file is larger than {max_bytes:,} bytes"
        raise DiagnosticError([Diagnostic("FZ003", message, file=name, help="a rule file has a few kilobytes")])
    return decode(data, name)


def decode(data: bytes, name: str) -> SourceText:
    """Return bytes as a source text; raises `DiagnosticError` when they are not UTF-8 text."""
    nul = data.find(b"\x00")
    try:
        if nul >= 0:
            message = f"the file is no text: byte {nul} is NUL"
            raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="give a text file in UTF-8")])
        return SourceText(name, data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        message = f"the file is not UTF-8: byte 0x{data[error.start]:02x} in line {line}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="save it as UTF-8")]) from None


def _unreadable(name: str, error: OSError) -> Diagnostic:
    if isinstance(error, FileNotFoundError):
        return Diagnostic("FZ001", "there is no such file", file=name, help=_neighbours(name))
    if isinstance(error, IsADirectoryError):
        return Diagnostic("FZ001", "this is a directory, not a rule file", file=name, help="name the files in it")
    return Diagnostic("FZ001", f"the file cannot be read: {error.strerror}", file=name)


def _neighbours(name: str) -> str:
    """Name the rule file that was most likely meant."""
    from fuzzyctl.errors import closest

    folder = Path(name).parent
    names = sorted(p.name for p in folder.glob("*.fz")) if folder.is_dir() else []
    near = closest(Path(name).name, names)
    return f"did you mean '{folder / near}'?" if near else ""


def _required(examined: tuple[FuzzySystem | None, list[Diagnostic]]) -> FuzzySystem:
    system, diagnostics = examined
    if system is None:
        raise DiagnosticError([d for d in diagnostics if d.severity == "error"])
    return system
