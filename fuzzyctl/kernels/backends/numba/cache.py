"""Where compiled kernels are kept."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def cache_folder() -> Path:
    """Return the folder for compiled kernels: $FUZZYCTL_CACHE_DIR, or what is usual on the platform."""
    named = os.environ.get("FUZZYCTL_CACHE_DIR")
    if named:
        return Path(named)
    home = Path.home()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "fuzzyctl" / "Cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "fuzzyctl"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "fuzzyctl"
