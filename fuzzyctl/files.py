"""Writes files whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fuzzyctl.errors import Diagnostic, DiagnosticError


@contextmanager
def written_whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside the target and move it over the target when the block ends well.

    Args:
        path: The file to write.

    Yields:
        A path with the target's suffix to write to.

    Raises:
        DiagnosticError: When the folder does not exist or cannot be written to, or the target is no regular file.
    """
    # Through a link its target is written; replacing the link itself would leave the target as it was.
    target = Path(path).resolve() if os.path.islink(path) else Path(path)
    refuse_what_is_no_file(target)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
    except OSError as error:
        raise DiagnosticError([_unwritable(target, error)]) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp makes files that only their owner may read; results are for everybody the umask allows.
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask())
        temporary.replace(target)
    except OSError as error:
        raise DiagnosticError([_unwritable(target, error)]) from None
    finally:
        temporary.unlink(missing_ok=True)


def refuse_what_is_no_file(target: Path) -> None:
    """Refuse to replace a folder, pipe or device by a file.

    Raises:
        DiagnosticError: Where such a thing stands in the place of the target.
    """
    if os.path.isdir(target):
        raise DiagnosticError([Diagnostic("FZ005", "this is a folder", file=str(target), help="name a file in it")])
    if os.path.exists(target) and not os.path.isfile(target):
        message, hint = "this is no regular file, and is not replaced by one", "name another file"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help=hint)])


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _unwritable(target: Path, error: OSError) -> Diagnostic:
    if isinstance(error, FileNotFoundError) and not target.parent.is_dir():
        message = f"there is no folder '{target.parent}'"
        return Diagnostic("FZ005", message, file=str(target), help="make it, or name another file")
    return Diagnostic("FZ005", f"the file cannot be written: {error.strerror}", file=str(target))
