"""Control laws, one file each.

A control law is a module with

- `Settings`, a frozen pydantic model of its gains;
- `SIGNALS`, a tuple of `Signal`: what `step` records;
- `FAULTS`, messages by the fault numbers that `step` may return;
- `init(settings, rules, robot) -> Law`, the flat gains, the initial state and the gain kernels of one robot;
- `step`, decorated with `control_law`.

`names` and `find` look at the files of this folder, and at the file beside the scenario that bears the name of a law
of one's own, so that a new law is a new file and nothing else. A law named BASE_without_PART is an ablation: BASE with
one part switched off, with the gains of BASE where the scenario gives it none.
"""

from __future__ import annotations

import dis
import hashlib
import importlib
import importlib.util
import os
import pkgutil
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

_PARTS = ("Settings", "SIGNALS", "FAULTS", "init", "step")
_WITHOUT = "_without_"

#: Words that stand for several laws on the command line.
GROUPS = ("all", "ablations")


def names() -> tuple[str, ...]:
    """Return the names of all control laws of this folder, without importing them."""
    return tuple(sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name != "settings"))


def base(name: str) -> str:
    """Return the law whose gains a law falls back on: of an ablation the law it is taken from, else itself."""
    return name.partition(_WITHOUT)[0]


def table(tables: Any, law: str) -> tuple[str, Any]:
    """Return name and content of the table a law has its gains from, of a robot's `controllers`; None if there is none.

    An ablation without a table of its own has that of the law it is taken from.
    """
    own = getattr(tables, law, None)
    return (law, own) if own is not None else (base(law), getattr(tables, base(law), None))


def group(name: str) -> tuple[str, ...]:
    """Return the laws a word of the command line stands for.

    Args:
        name: "all" for every law that stands on its own, "ablations" for those with a part switched off, each beside
            the law it is taken from; or the name of one law.
    """
    if name == "all":
        return tuple(n for n in names() if base(n) == n)
    if name == "ablations":
        return tuple(dict.fromkeys(one for n in names() if base(n) != n for one in (base(n), n)))
    return (name,)


def exists(name: str, folder: Path) -> bool:
    """Return whether there is a law of this name here, or as NAME.py in the folder of a scenario."""
    return name in names() or _own(name, folder) is not None


def find(name: str, folder: Path | None = None) -> ModuleType:
    """Import a control law by its name; the compiler comes along with it.

    Args:
        name: Name of the law.
        folder: Folder of the scenario, where a law of one's own may lie as NAME.py. The laws here come first.

    Raises:
        DiagnosticError: When the file cannot be imported, or lacks a part of a control law.
    """
    own = None if folder is None else own_file(name, folder)
    with reported(name, own, "imported"):
        module = importlib.import_module(f"{__name__}.{name}") if own is None else _load(own, own.stat().st_mtime_ns)
    missing = [part for part in _PARTS if not hasattr(module, part)]
    if missing:
        message = f"the control law {name} has no {', '.join(missing)}"
        facts = (f"a control law is a module with {', '.join(_PARTS)}",)
        raise DiagnosticError([Diagnostic("FZ001", message, facts=facts, file=str(module.__file__))])
    return module


def own_file(name: str, folder: Path) -> Path | None:
    """Return the file of a law of one's own; None for a law of this folder, or where there is no such file."""
    return None if name in names() else _own(name, folder)


def _own(name: str, folder: Path) -> Path | None:
    """Return the file of a law of one's own, or None; only a name that Python could import is looked for."""
    path = folder / f"{name}.py"
    # Not Path.is_file, which raises for names that are too long.
    return path.resolve() if name.isidentifier() and os.path.isfile(path) else None


@cache
def _load(path: Path, changed: int) -> ModuleType:
    """Execute the file of a law once for each time it was changed.

    Cached machine code names the module of its function, so the module is registered, under the same name in every
    process, before its functions are compiled.
    """
    name = f"dwmr_law_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:16]}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        sys.modules.pop(name, None)
        raise
    return module


@contextmanager
def reported(name: str, own: Path | None, verb: str, *, only_own: bool = False) -> Iterator[None]:
    """Report what a law raises as a diagnostic: any error, and SystemExit, which would end the command silently.

    Diagnostics pass, and so does KeyboardInterrupt unless a line of the law raises it.

    Args:
        name: Name of the law.
        own: File of the law; None to look for it here.
        verb: What cannot be done with the law: "imported", "checked", "prepared" or "run".
        only_own: Whether errors that pass through no line of the law pass.

    Raises:
        DiagnosticError: With the error and its line.
    """
    file = str(own) if own is not None else _shipped_file(name)
    try:
        yield
    except DiagnosticError:
        raise
    except BaseException as error:  # a law of one's own may raise anything
        lines = _lines_in(file, error)
        if (only_own and not lines) or (isinstance(error, KeyboardInterrupt) and not _is_raised_by(file, error)):
            raise
        raise DiagnosticError([_broken_law(name, file, lines, error, verb)]) from error


def _shipped_file(name: str) -> str:
    """Return the file of a law of this folder, the name where there is none."""
    here = (str(p) for f in __path__ if (p := Path(f) / f"{name}.py").exists())
    return next(here, name)


def _lines_in(file: str, error: BaseException) -> list[int]:
    """Return the lines of a file that an error passed through, the last one nearest to where it was raised."""
    if isinstance(error, SyntaxError) and error.filename == file:
        return [error.lineno] if error.lineno is not None else []
    frames = traceback.extract_tb(error.__traceback__)
    return [f.lineno for f in frames if f.filename == file and f.lineno is not None]


def _is_raised_by(file: str, error: BaseException) -> bool:
    """Return whether a `raise` of a file raised an error; Ctrl-C comes between two instructions."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None or trace.tb_frame.f_code.co_filename != file:
        return False
    return dis.opname[trace.tb_frame.f_code.co_code[trace.tb_lasti]] == "RAISE_VARARGS"


def _broken_law(name: str, file: str, lines: list[int], error: BaseException, verb: str) -> Diagnostic:
    """Describe what a law raised, with its line where the file itself is to blame."""
    from dwmr.core.jit import reason

    facts = (f"{type(error).__name__}: {reason(error)}",)
    help_text = (
        ""
        if isinstance(error, Exception)
        else f"raise an error such as ValueError; {type(error).__name__} ends the command"
    )
    if verb == "run":
        help_text = "return a key of FAULTS to stop a run"
    place = f"{file}:{lines[-1]}" if lines else file
    return Diagnostic("FZ001", f"the control law {name} cannot be {verb}", facts=facts, help=help_text, file=place)
