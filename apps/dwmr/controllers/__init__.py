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
import traceback
from pathlib import Path
from types import ModuleType

from fuzzyctl.errors import Diagnostic, DiagnosticError

_PARTS = ("Settings", "SIGNALS", "FAULTS", "init", "step")


def names() -> tuple[str, ...]:
    """Return the names of all control laws, without importing them."""
    return tuple(sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name != "settings"))


def find(name: str) -> ModuleType:
    """Import a control law by its name; the compiler comes along with it.

    Raises:
        DiagnosticError: When the file cannot be imported, or lacks a part of a control law.
    """
    try:
        module = importlib.import_module(f"{__name__}.{name}")
    except Exception as error:  # a law of one's own may raise anything
        raise DiagnosticError([_broken(name, error)]) from error
    missing = [part for part in _PARTS if not hasattr(module, part)]
    if missing:
        message = f"the control law {name} has no {', '.join(missing)}"
        facts = (f"a control law is a module with {', '.join(_PARTS)}",)
        raise DiagnosticError([Diagnostic("FZ001", message, facts=facts, file=str(module.__file__))])
    return module


def _broken(name: str, error: Exception) -> Diagnostic:
    """Describe what a law's file raised, with its line where the file itself is to blame."""
    file = next((str(p) for f in __path__ if (p := Path(f) / f"{name}.py").exists()), name)
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    line = error.lineno if isinstance(error, SyntaxError) and error.filename == file else lines[-1] if lines else None
    said = next((text.strip() for text in str(error).splitlines() if text.strip()), "no reason given")
    facts = (f"{type(error).__name__}: {said}",)
    place = file if line is None else f"{file}:{line}"
    return Diagnostic("FZ001", f"the control law {name} cannot be imported", facts=facts, file=place)
