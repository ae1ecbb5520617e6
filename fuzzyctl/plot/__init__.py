"""Pictures of fuzzy systems: data and axes in, axes out.

`surface`, `terms`, `rules` and `runs` draw into `ax` where it is given, else into a figure of their own; no window
opens, and pyplot is not involved. A notebook shows their result. matplotlib is loaded by the first of them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fuzzyctl.plot.memberships import terms
    from fuzzyctl.plot.rule_viewer import rules
    from fuzzyctl.plot.surfaces import surface
    from fuzzyctl.plot.time_series import runs

_HOMES = {
    "rules": "fuzzyctl.plot.rule_viewer",
    "runs": "fuzzyctl.plot.time_series",
    "surface": "fuzzyctl.plot.surfaces",
    "terms": "fuzzyctl.plot.memberships",
}

__all__ = ["rules", "runs", "surface", "terms"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'fuzzyctl.plot' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
