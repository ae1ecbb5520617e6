"""Plants in Python: a file with `derivative(t, x, u)` and `output(t, x)`, which is executed when its loop is run."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.model.plant import Plant
from fuzzyctl.support.reading import read_source

_FORMS: Final = {"derivative": "def derivative(t, x, u)", "output": "def output(t, x)"}


@final
class PythonPlant:
    """The functions of a plant in Python, called with tuples of floats, their results checked.

    Args:
        plant: The plant.
        block: Name of its block in the loop.
        span: Where the block is.

    Raises:
        DiagnosticError: For a file that cannot be executed or lacks a function.
    """

    def __init__(self, plant: Plant, block: str, span: Span | None) -> None:
        self._plant, self._block, self._span = plant, block, span
        if plant.calls:
            self._derivative, self._output = plant.calls
            return
        source = read_source(plant.python)
        namespace: dict[str, Any] = {"__name__": "fuzzyctl_plant", "__file__": plant.python}
        self._guarded(lambda: exec(compile(source.text, plant.python, "exec"), namespace), "the file")  # noqa: S102 - the user's own plant, which simulate says it executes
        for name, form in _FORMS.items():
            if not callable(namespace.get(name)):
                raise self._mistake(f"the file has no function '{name}'", (), f"write in it: {form}")
        self._derivative, self._output = (namespace[name] for name in _FORMS)

    def derivative(self, t: float, x: tuple[float, ...], u: tuple[float, ...]) -> Sequence[float]:
        """Return the derivatives of the states by time."""
        found = self._guarded(lambda: _consumed(self._derivative(t, x, u)), "'derivative'", t)
        return self._numbers(found, len(self._plant.states), "derivative", t)

    def output(self, t: float, x: tuple[float, ...]) -> Sequence[float]:
        """Return the outputs."""
        found = self._guarded(lambda: _consumed(self._output(t, x)), "'output'", t)
        return self._numbers(found, len(self._plant.results), "output", t)

    def _guarded(self, call: Callable[[], Any], what: str, t: float | None = None) -> Any:
        """Return what a call of the user's code returns; what it raises is a diagnostic."""
        try:
            return call()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - the user's code may raise anything, which is reported
            frames = traceback.extract_tb(error.__traceback__)
            own = frames[1:][-1:] if self._plant.calls else [f for f in frames if f.filename == self._plant.python]
            at = f"{own[-1].filename}:{own[-1].lineno}: " if own else ""
            when = "" if t is None else f" at t = {t:.6g} s"
            message = f"{what} of plant '{self._plant.name}' raised {type(error).__name__}{when}"
            help_text = "call the functions once" if self._plant.calls else "run the file with python"
            if isinstance(error, ModuleNotFoundError):
                help_text = "install it: a plant imports installed packages, no files beside it"
            raise self._mistake(message, (f"{at}{error}",), help_text) from None

    def _numbers(self, found: Any, count: int, function: str, t: float) -> Sequence[float]:
        try:
            undefined = any(map(math.isnan, found))  # which refuses texts, as float does not
            numbers = () if isinstance(found, set | frozenset) else tuple(map(float, found))
        except (TypeError, ValueError, OverflowError):
            undefined, numbers = False, ()
        if len(numbers) != count:
            message = f"'{function}' of plant '{self._plant.name}' returned {_shown(found)} at t = {t:.6g} s"
            raise self._mistake(
                message, (f"expected {counted(count, 'number')}, one for each of: {self._names(function)}",)
            )
        if undefined:
            message = f"'{function}' of plant '{self._plant.name}' returned {_shown(found)} at t = {t:.6g} s"
            help_text = "keep arguments of sqrt and log in their domain, and divisors away from 0"
            raise self._mistake(message, (f"expected numbers for: {self._names(function)}",), help_text)
        return numbers

    def _names(self, function: str) -> str:
        signals = self._plant.states if function == "derivative" else self._plant.results
        return ", ".join(s.name for s in signals)

    def _mistake(self, message: str, facts: tuple[str, ...], help_text: str = "") -> DiagnosticError:
        facts = (*facts, f"it is block '{self._block}'")
        return DiagnosticError([Diagnostic("FZ704", message, self._span, facts=facts, help=help_text)])


def _consumed(found: Any) -> Any:
    """Return what a generator yields, which may raise only then."""
    return tuple(found) if isinstance(found, Iterator) else found


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
