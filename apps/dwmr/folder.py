"""The folder of results: checked before the run, each file renamed into place when it is whole."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from fuzzyctl.errors import Diagnostic, DiagnosticError


def prepare_folder(folder: Path) -> None:
    """Create the folder of results and make sure that files can be written into it.

    Raises:
        DiagnosticError: When this cannot be done.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".dwmr-"):
            pass
    except OSError as error:
        raise _refused(folder, error) from error


def write(folder: Path, name: str, fill: Callable[[Path], None]) -> Path:
    """Write a file under a temporary name and rename it when it is whole.

    Args:
        folder: Where it goes.
        name: Its name; the temporary one keeps the suffix.
        fill: Writes the content to a path.

    Raises:
        DiagnosticError: When it cannot be written; nothing half-written stays.
    """
    part = folder / f".{os.getpid()}-{name}"
    try:
        fill(part)
        part.replace(folder / name)
    except OSError as error:
        raise _refused(folder / name, error) from error
    finally:
        part.unlink(missing_ok=True)
    return folder / name


def _refused(path: Path, error: OSError) -> DiagnosticError:
    message = f"{path} cannot be written: {error.strerror or error}"
    return DiagnosticError([Diagnostic("FZ909", message, file=str(path), help="name another folder with -o DIR")])
