"""Atomic writing of files."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError


@contextmanager
def written_whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside the target and move it over the target when the block ends well.

    Args:
        path: The file to write.

    Yields:
        A path with the target's suffix to write to.

    Raises:
        DiagnosticError: When the folder does not exist or cannot be written to, or the target is not a regular file.
    """
    target = _place(path)
    refuse_what_is_no_file(target)
    with _blaming(target), _beside(target) as temporary:
        yield temporary
        _permit(temporary, target)
        temporary.replace(target)


def write_together(texts: Mapping[Path, str]) -> None:
    """Write a set of files, such as a header and its source: all of them, or none, so that old and new ones never mix.

    Args:
        texts: The text of each file, written as UTF-8.

    Raises:
        DiagnosticError: When one of them cannot be written; all are then as they were.
    """
    targets = [_place(path) for path in texts]
    for target in targets:
        refuse_what_is_no_file(target)
    with ExitStack() as stack:
        prepared = []
        for target, text in zip(targets, texts.values(), strict=True):
            with _blaming(target):
                new = stack.enter_context(_beside(target))
                new.write_text(text, encoding="utf-8", newline="\n")
                _permit(new, target)
                old = stack.enter_context(_beside(target)) if target.exists() else None
                if old is not None:
                    shutil.copy2(target, old)
            prepared.append((target, new, old))
        _exchange(prepared)


@contextmanager
def folder_for(path: Path) -> Iterator[None]:
    """Make a folder for the files of a block, and those around it; if they stay empty they go again.

    Raises:
        DiagnosticError: When it cannot be made, or is something else.
    """
    with removed_if_empty(path):
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            message = f"the folder cannot be made: {error.strerror}"
            if isinstance(error, FileExistsError):
                message = "this is a file, and a folder is to have this name"
            help_text = "move it, or name another one"
            raise DiagnosticError([Diagnostic("FZ005", message, file=str(path), help=help_text)]) from None
        yield


@contextmanager
def removed_if_empty(folder: Path) -> Iterator[None]:
    """Remove the folders that a block makes for a folder, and around it, if they are empty at its end."""
    missing: list[Path] = []
    with suppress(OSError):
        missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        yield
    finally:
        for path in missing:  # the innermost first
            with suppress(OSError):
                path.rmdir()


def _exchange(prepared: Sequence[tuple[Path, Path, Path | None]]) -> None:
    """Move new files over their targets; where that ends early, put the old ones back."""
    done: list[tuple[Path, Path | None]] = []
    try:
        for target, new, old in prepared:
            done.append((target, old))  # before it is moved: an interrupt may come at once
            with _blaming(target):
                new.replace(target)
    except BaseException:
        for target, old in done:
            with suppress(OSError):  # the first error is the one reported
                target.unlink(missing_ok=True) if old is None else old.replace(target)
        raise


def _place(path: str | os.PathLike[str]) -> Path:
    # Through a link its target is written; replacing the link itself would leave the target as it was.
    return Path(path).resolve() if os.path.islink(path) else Path(path)


@contextmanager
def _beside(target: Path) -> Iterator[Path]:
    """Give a temporary file beside the target, which is removed if it is still there at the end."""
    handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
    os.close(handle)
    try:
        yield Path(name)
    finally:
        Path(name).unlink(missing_ok=True)


def _permit(temporary: Path, target: Path) -> None:
    # mkstemp makes files that only their owner may read; results are for everybody the umask allows.
    temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask())


@contextmanager
def _blaming(target: Path) -> Iterator[None]:
    """Raise errors of the operating system as a diagnostic of the target."""
    try:
        yield
    except OSError as error:
        raise DiagnosticError([_unwritable(target, error)]) from None


def refuse_what_is_no_file(target: Path) -> None:
    """Refuse to replace a folder, pipe or device by a file.

    Raises:
        DiagnosticError: If such a thing is in the place of the target.
    """
    if os.path.isdir(target):
        raise DiagnosticError([Diagnostic("FZ005", "this is a folder", file=str(target), help="name a file in it")])
    if os.path.exists(target) and not os.path.isfile(target):
        message, hint = "this is not a regular file, and is not replaced", "name another file"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help=hint)])


def holds(path: Path, text: str) -> bool:
    """Return whether a path is a readable file with this text."""
    try:
        return path.is_file() and path.read_bytes() == text.encode()
    except OSError:
        return False


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _unwritable(target: Path, error: OSError) -> Diagnostic:
    if isinstance(error, FileNotFoundError) and not target.parent.is_dir():
        message = f"there is no folder '{target.parent}'"
        return Diagnostic("FZ005", message, file=str(target), help="make it, or name another file")
    return Diagnostic("FZ005", f"the file cannot be written: {error.strerror}", file=str(target))
