"""Operations of higher packages that are methods of lower ones, such as `system.plot()`, and classes shown by them.

`fuzzyctl/__init__.py` registers where each is defined, so that no package imports one above it; the module is loaded
at the first call.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

_DEFINITIONS: dict[str, str] = {}


def register(definitions: Mapping[str, str]) -> None:
    """Register operations: `package.module:function` by name."""
    _DEFINITIONS.update(definitions)


def operation(name: str) -> Callable[..., Any]:
    """Return a registered operation."""
    module, _, function = _DEFINITIONS[name].partition(":")
    operation: Callable[..., Any] = getattr(import_module(module), function)
    return operation


class Described:
    """A part of a system: its `repr` is one line in the words of rule files, where its class says `repr=False`."""

    __slots__ = ()

    def __repr__(self) -> str:
        line: str = operation("line")(self)
        return line


class Displayed:
    """An object that a notebook shows as HTML."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        html: str = operation("html")(self)
        return html


class Printed(Displayed):
    """An object that also prints as the text that commands print of it."""

    __slots__ = ()

    def __str__(self) -> str:
        text: str = operation("text")(self)
        return text
