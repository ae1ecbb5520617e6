"""Which module shows which type: `html` for notebooks, `text` for `print`, `line` for the `repr` of parts."""

from __future__ import annotations

from importlib import import_module
from typing import Final

from fuzzyctl.diagnostics.terminal import printable

#: Module and prefix of the functions by the name of the type, so that no type is loaded to show another one.
_PRESENTERS: Final = {
    "BlockTrace": "traces.trace",
    "Controller": "systems.block",
    "Experiment": "notebook.experiment",
    "FuzzySystem": "systems.system",
    "Kernel": "notebook.kernel",
    "Loop": "systems.block",
    "Panels": "notebook.plot",
    "Plant": "systems.block",
    "Plot": "notebook.plot",
    "Plot3D": "notebook.plot",
    "Proved": "notebook.verdict",
    "Refuted": "notebook.verdict",
    "Run": "notebook.run",
    "Trace": "traces.trace",
    "Undecided": "notebook.verdict",
    "Verdicts": "notebook.verdict",
}


def html(value: object) -> str:
    """Return an object of these types as HTML for a notebook."""
    return _presented(value, "html")


def text(value: object) -> str:
    """Return an object of these types as text for `print`, without a line end."""
    return _presented(value, "text").removesuffix("\n")


def line(part: object) -> str:
    """Return the `repr` of a part of a system."""
    text: str = import_module("fuzzyctl.display.parts").line(part)
    return printable(f"{type(part).__name__}({text})")


def _presented(value: object, form: str) -> str:
    name = next(kind.__name__ for kind in type(value).__mro__ if kind.__name__ in _PRESENTERS)
    module, _, prefix = _PRESENTERS[name].partition(".")
    text: str = getattr(import_module(f"fuzzyctl.display.{module}"), f"{prefix}_{form}")(value)
    return text
