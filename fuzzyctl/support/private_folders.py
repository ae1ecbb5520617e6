"""The folder of compiled code, which is used only where no other user can write to it."""

from __future__ import annotations

import os
import stat
import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

#: What to do about a folder that cannot be trusted.
REPAIR: Final = "Remove the folder, or set FUZZYCTL_CACHE_DIR to a folder of your own"

#: Dangers that were warned of in this process.
_WARNED: Final[set[str]] = set()


def cache_folder() -> Path:
    """Return the folder for compiled code: $FUZZYCTL_CACHE_DIR, or the usual one of the platform."""
    named = os.environ.get("FUZZYCTL_CACHE_DIR")
    if named:
        return Path(named)
    home = Path.home()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "fuzzyctl" / "Cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "fuzzyctl"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "fuzzyctl"


def is_private(root: Path, *parts: str) -> bool:
    """Return whether a folder can be trusted; one that does not exist is made for the user alone.

    The folder and those above it up to `root` must belong to the user or to root, and no other user may write to them.
    A folder that cannot be trusted is warned of once. On a platform without owners, every folder is trusted.

    Args:
        root: The folder of all caches.
        parts: The folders below it, from the top down.

    Raises:
        OSError: When the folder can neither be found nor made.
    """
    root.mkdir(mode=0o700, parents=True, exist_ok=True)
    folders = [root]
    for part in parts:
        folders.append(folders[-1] / part)
        folders[-1].mkdir(mode=0o700, exist_ok=True)
    danger = next(dangers(folders), None)
    if danger is not None:
        _warn(danger)
    return danger is None


def dangers(folders: Iterable[Path]) -> Iterator[str]:
    """Yield for each reason why a folder cannot be trusted a clause that names the folder; the folder is not changed.

    Raises:
        OSError: When a folder cannot be found.
    """
    for folder in folders:
        for reason in _reasons(folder):
            yield f"the cache folder {folder!s} {reason}, who could have it run their code"


def _reasons(folder: Path) -> Iterator[str]:
    if not hasattr(os, "geteuid"):
        return
    about = folder.stat()
    if not {about.st_uid, folder.lstat().st_uid} <= {os.geteuid(), 0}:
        yield "belongs to another user"
    shared = about.st_mode & stat.S_IWGRP and not _is_own_group(about.st_gid)
    if about.st_mode & stat.S_IWOTH or shared:
        yield "can be written to by other users"


def _is_own_group(group: int) -> bool:
    """Return whether a group has the user as its only member, as on systems that make folders writable for it."""
    import grp
    import pwd

    try:
        user, result = pwd.getpwuid(os.geteuid()), grp.getgrgid(group)
    except KeyError:  # a user or group without an entry, as in containers
        return False
    return user.pw_gid == group and user.pw_name == result.gr_name and set(result.gr_mem) <= {user.pw_name}


def _warn(danger: str) -> None:
    if danger in _WARNED:
        return
    _WARNED.add(danger)
    warnings.warn(f"compiled code is not kept: {danger}. {REPAIR}", RuntimeWarning, stacklevel=2)
