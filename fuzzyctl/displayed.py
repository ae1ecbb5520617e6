"""Objects that notebooks and `print` show as `fuzzyctl.display` writes them."""

from __future__ import annotations

from fuzzyctl.operations import operation


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
