"""Plants in Python: a file with `derivative(t, x, u)` and `output(t, x)`, which is executed when its loop is run."""

from __future__ import annotations

import inspect
import math
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, listed
from fuzzyctl.model.controller import Signal
from fuzzyctl.model.plant import Plant
from fuzzyctl.support.files import read_source

#: The functions of a plant, with their arguments.
_FORMS: Final = {"derivative": ("t", "x", "u"), "output": ("t", "x")}


@final
class PythonPlant:
    """The functions of a plant in Python, called with tuples of floats, their results checked.

    Args:
        plant: The plant.
        block: Name of its block in the loop.
        span: Place of the block.

    Raises:
        DiagnosticError: For a file that cannot be executed or lacks a function.
    """

    def __init__(self, plant: Plant, block: str, span: Span | None) -> None:
        self._plant, self._block, self._span = plant, block, span
        if plant.calls:
            self._derivative, self._output = plant.calls
            return
        source = read_source(plant.python, only_regular=True)
        namespace: dict[str, Any] = {"__name__": "fuzzyctl_plant", "__file__": plant.python}
        self._guarded(lambda: exec(compile(source.text, plant.python, "exec"), namespace), "the file")  # noqa: S102 - the user's own plant, which simulate says it executes
        for name, arguments in _FORMS.items():
            help_text = f"write in it: def {name}({', '.join(arguments)})"
            if not callable(namespace.get(name)):
                raise self._mistake(f"the file has no function '{name}'", (), help_text)
            if why := _refusal(namespace[name], arguments):
                message = f"'{name}' of plant '{plant.name}' cannot be called with {', '.join(arguments)}"
                raise self._mistake(message, (f"{self._place(namespace[name])}{why}",), help_text)
        self._derivative, self._output = (namespace[name] for name in _FORMS)

    def derivative(self, t: float, x: tuple[float, ...], u: tuple[float, ...]) -> Sequence[float]:
        """Return the derivatives of the states by time."""
        return self._numbers("derivative", self._derivative, self._plant.states, t, x, u)

    def output(self, t: float, x: tuple[float, ...]) -> Sequence[float]:
        """Return the outputs."""
        return self._numbers("output", self._output, self._plant.results, t, x)

    def _numbers(
        self, name: str, function: Callable[..., Any], signals: Sequence[Signal], t: float, *given: tuple[float, ...]
    ) -> Sequence[float]:
        """Call a function and return a finite number for each signal."""
        result = self._guarded(lambda: _consumed(function(t, *given)), f"'{name}'", t, given)
        try:
            finite = all(map(math.isfinite, result))  # which refuses texts, as float does not
            numbers = () if isinstance(result, set | frozenset) else tuple(map(float, result))
        except (TypeError, ValueError, OverflowError):
            finite, numbers = True, ()
        if finite and len(numbers) == len(signals):
            return numbers
        message = f"'{name}' of plant '{self._plant.name}' returned {_shown(result)} at t = {t:.6g} s"
        if len(numbers) != len(signals):
            fact = f"expected {counted(len(signals), 'number')}, one for each of: {listed([s.name for s in signals])}"
            help_text = f"return a tuple, such as {_shown((0.0,) * len(signals))}"
        else:
            bad = [s.name for s, v in zip(signals, numbers, strict=True) if not math.isfinite(v)]
            fact = f"expected finite numbers, not so: {listed(bad)}"
            help_text = "keep arguments of sqrt and log in their domain, and divisors away from 0"
        raise self._mistake(message, (f"{self._place(function)}{fact}", *self._there(given)), help_text)

    def _guarded(
        self, call: Callable[[], Any], what: str, t: float | None = None, given: Sequence[tuple[float, ...]] = ()
    ) -> Any:
        """Call the user's code and return its result; exceptions are diagnostics."""
        try:
            return call()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - the user's code may raise anything, which is reported
            frames = traceback.extract_tb(error.__traceback__)
            of_file = [f for f in frames if f.filename == self._plant.python]
            user_frames = [f for f in frames if f.filename != __file__] if self._plant.calls else of_file
            at = f"{user_frames[-1].filename}:{user_frames[-1].lineno}: " if user_frames else ""
            when = "" if t is None else f" at t = {t:.6g} s"
            message = f"{what} of plant '{self._plant.name}' raised {type(error).__name__}{when}"
            help_text = "run the file with python" if t is None else "call it with this time and these values"
            if isinstance(error, ModuleNotFoundError):
                help_text = "install it: a plant imports installed packages, no files beside it"
            raise self._mistake(message, (f"{at}{error}", *self._there(given)), help_text) from None

    def _place(self, function: Callable[..., Any]) -> str:
        """Return the file and line of a function in the plant's file, as the begin of a fact."""
        code = getattr(function, "__code__", None)
        return f"{code.co_filename}:{code.co_firstlineno}: " if code and code.co_filename == self._plant.python else ""

    def _there(self, given: Sequence[tuple[float, ...]]) -> tuple[str, ...]:
        """Return the states and inputs that a function was called with, as a fact."""
        names = (s.name for s in (*self._plant.states, *self._plant.inputs))
        values = (v for part in given for v in part)
        signals = [f"{name} = {value:.6g}" for name, value in zip(names, values, strict=False)]
        return (f"there {listed(signals)}",) if signals else ()

    def _mistake(self, message: str, facts: tuple[str, ...], help_text: str = "") -> DiagnosticError:
        facts = (*facts, f"it is block '{self._block}'")
        return DiagnosticError([Diagnostic("FZ704", message, self._span, facts=facts, help=help_text)])


def _refusal(function: Callable[..., Any], arguments: Sequence[str]) -> str:
    """Return why a function cannot be called with these arguments; empty where it can, or where that is not known."""
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError as error:
        return str(error)
    except ValueError:
        return ""
    return ""


def _consumed(found: Any) -> Any:
    """Return a generator's values, whose computation may raise."""
    return tuple(found) if isinstance(found, Iterator) else found


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
