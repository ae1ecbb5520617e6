"""Operations of higher packages that are methods of lower ones, such as `system.plot()` and `_repr_html_`.

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
