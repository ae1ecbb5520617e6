"""What notebooks and `print` show of an object: written by `fuzzyctl.display`, which is loaded when it is asked."""

from __future__ import annotations


class Described:
    """A part of a system: its `repr` is one line in the words of rule files, where its class says `repr=False`."""

    __slots__ = ()

    def __repr__(self) -> str:
        from fuzzyctl.display.display import line

        return line(self)


class Displayed:
    """An object that a notebook shows as HTML."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        from fuzzyctl.display.display import html

        return html(self)


class Printed(Displayed):
    """An object that also prints as the text that commands print of it."""

    __slots__ = ()

    def __str__(self) -> str:
        from fuzzyctl.display.display import text

        return text(self)
