"""Resolution: from syntax tree to model; names get their meaning, tables become rules."""

from fuzzyctl.resolve.system import resolve

__all__ = ["resolve"]
