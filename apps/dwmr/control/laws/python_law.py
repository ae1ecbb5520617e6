"""Control laws in Python: their files, and reports of the errors that they raise."""

from __future__ import annotations

import dis
import hashlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span

#: Parts of a control law.
PARTS = ("Settings", "SIGNALS", "FAULTS", "init", "step")


def load(name: str, path: Path) -> ModuleType:
    """Import the file of a control law; the compiler comes along with it.

    Raises:
        DiagnosticError: When the file cannot be imported, lacks a part of a control law, or records a signal under the
            name of another column of the data.
    """
    with reported(name, path, "imported"):
        module = _load(path, path.stat().st_mtime_ns)
    missing = [part for part in PARTS if not hasattr(module, part)]
    if missing:
        message = f"the control law {name} has no {', '.join(missing)}"
        facts = (f"a control law is a module with {', '.join(PARTS)}",)
        raise DiagnosticError([Diagnostic("FZ001", message, facts=facts, file=_shown(path))])
    with reported(name, path, "checked"):
        mistakes = list(_taken_names(name, path, [signal.name for signal in module.SIGNALS]))
    if mistakes:
        raise DiagnosticError(mistakes)
    return module


def _taken_names(name: str, path: Path, signals: list[str]) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each signal that has the name of another column of the data."""
    from dwmr.control.law_text import COLUMNS, taken_name

    for k, signal in enumerate(signals):
        if signal in COLUMNS:
            yield taken_name(f"signal '{signal}' of the control law {name}", signal, file=_shown(path))
        elif signal in signals[:k]:
            message = f"the control law {name} has two signals '{signal}'"
            yield Diagnostic("FZ905", message, help="rename one of them", file=_shown(path))


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
def reported(name: str, file: Path, verb: str, *, only_own: bool = False) -> Iterator[None]:
    """Report any error of a law as a diagnostic, and SystemExit, which would end the command silently.

    Diagnostics pass, and so does KeyboardInterrupt unless a line of the law raises it.

    Args:
        name: Name of the law.
        file: File of the law.
        verb: The step that fails: "imported", "checked", "prepared" or "run".
        only_own: Whether errors that pass through no line of the law pass.

    Raises:
        DiagnosticError: With the error and its line.
    """
    try:
        yield
    except DiagnosticError:
        raise
    except BaseException as error:  # a user's law may raise anything
        span = _span_in(file, error)
        if (only_own and span is None) or (isinstance(error, KeyboardInterrupt) and not _is_raised_by(file, error)):
            raise
        raise DiagnosticError([_broken_law(name, file, span, error, verb)]) from error


def _span_in(file: Path, error: BaseException) -> Span | None:
    """Return the part of a file that an error was raised in or passed through last, None where it is in no line."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
    line, first, last = (frames[-1].lineno, frames[-1].colno, frames[-1].end_colno) if frames else (None, None, None)
    if isinstance(error, SyntaxError) and error.filename == str(file):
        line, first, last = error.lineno, None, None
    source = SourceText(_shown(file), file.read_text(encoding="utf-8", errors="replace"))
    if not line or line > source.line_count:
        return None
    text, start = source.line_text(line), source.line_start(line)
    if first is None or last is None or frames[-1].end_lineno != line:
        return Span(source, start + len(text) - len(text.lstrip()), start + len(text))
    before, marked = (len(text.encode()[:k].decode(errors="replace")) for k in (first, last))  # bytes are counted
    return Span(source, start + before, start + marked)


def _shown(file: Path) -> str:
    """Return a path from the current folder, where the file lies below it."""
    return str(file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file)


def _is_raised_by(file: Path, error: BaseException) -> bool:
    """Return whether a `raise` of a file raised an error; Ctrl-C comes between two instructions."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None or trace.tb_frame.f_code.co_filename != str(file):
        return False
    return dis.opname[trace.tb_frame.f_code.co_code[trace.tb_lasti]] == "RAISE_VARARGS"


def _broken_law(name: str, file: Path, span: Span | None, error: BaseException, verb: str) -> Diagnostic:
    """Describe an error of a law, with its line if the file itself caused it."""
    from dwmr.core.jit import reason

    facts = (f"{type(error).__name__}: {reason(error)}",)
    help_text = ""
    if verb == "run" and isinstance(error, ZeroDivisionError):
        help_text = "keep the divisor away from 0, or return a key of FAULTS to stop a run"
    elif verb == "run" and isinstance(error, IndexError):
        help_text = "'signals' is as long as SIGNALS; 'gains', 'state' and 'next_state' are as long as init makes them"
    elif verb == "run":
        help_text = "return a key of FAULTS to stop a run"
    elif not isinstance(error, Exception):
        help_text = f"raise an error such as ValueError; {type(error).__name__} ends the command"
    message = f"the control law {name} cannot be {verb}"
    return Diagnostic("FZ001", message, span, facts=facts, help=help_text, file=_shown(file))
