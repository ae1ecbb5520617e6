"""Control laws, one file each.

A control law is a module with

- `Settings`, a frozen pydantic model of its gains;
- `SIGNALS`, a tuple of `Signal`: what `step` records;
- `FAULTS`, messages by the fault numbers that `step` may return;
- `init(settings, rules, robot) -> Law`, the flat gains, the initial state and the gain kernels of one robot;
- `step`, decorated with `control_law`.

`names` and `find` look at the files of this folder, so that a new law is a new file and nothing else.
"""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def names() -> tuple[str, ...]:
    """Return the names of all control laws, without importing them."""
    return tuple(sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name != "settings"))


def find(name: str) -> ModuleType:
    """Import a control law by its name; the compiler comes along with it."""
    return importlib.import_module(f"{__name__}.{name}")
