"""Which module shows which type: `html` for notebooks, `text` for `print`, `line` for the `repr` of parts."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Final

from fuzzyctl.diagnostics.terminal import printable

#: Modules by the name of the type, so that no type is loaded to show another one.
_MODULES: Final = {
    "BlockTrace": "traces",
    "Controller": "blocks",
    "Experiment": "runs",
    "FuzzySystem": "systems",
    "Kernel": "kernels",
    "Loop": "blocks",
    "Panels": "pictures",
    "Plant": "blocks",
    "Plot": "pictures",
    "Plot3D": "pictures",
    "Proved": "verdicts",
    "Refuted": "verdicts",
    "Run": "runs",
    "Trace": "traces",
    "Undecided": "verdicts",
    "Verdicts": "verdicts",
}


def html(shown: object) -> str:
    """Return what a notebook shows of an object of these types."""
    found: str = _module(shown).html(shown)
    return found


def text(shown: object) -> str:
    """Return what `print` prints of an object of these types; the last line does not end."""
    found: str = _module(shown).text(shown)
    return found.removesuffix("\n")


def line(shown: object) -> str:
    """Return the `repr` of a part of a system."""
    found: str = import_module("fuzzyctl.display.parts").line(shown)
    return printable(f"{type(shown).__name__}({found})")


def _module(shown: object) -> Any:
    name = next(kind.__name__ for kind in type(shown).__mro__ if kind.__name__ in _MODULES)
    return import_module(f"fuzzyctl.display.{_MODULES[name]}")
