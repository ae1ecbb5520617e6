"""From syntax tree to model: names get their meaning, tables become rules; the only place that knows both sides."""

from fuzzyctl.resolve.system import resolve

__all__ = ["resolve"]
