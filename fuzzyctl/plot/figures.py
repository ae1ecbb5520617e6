"""Figures of the caller or new ones, without pyplot, and the pictures of their axes in a notebook."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.figure import Figure
from matplotlib.text import Text
from mpl_toolkits.mplot3d import Axes3D

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.operations import Displayed
from fuzzyctl.plot.style import STYLE

#: Pixels per inch in a notebook.
DPI: Final = 96
_PICTURES: Final = re.compile("[\u2400-\u2421]")


class Panels(tuple[Axes, ...], Displayed):
    """The axes of a picture of several panels, row by row; a notebook shows the picture."""

    __slots__ = ()

    @property
    def figure(self) -> Figure:
        """The figure that the axes are part of."""
        owner = self[0].get_figure(root=True)
        assert owner is not None, "axes that are drawn are part of a figure"
        return owner

    def _repr_svg_(self) -> str:
        return svg(self.figure)

    def _repr_png_(self) -> bytes:
        return png(self.figure)


class Plot(Axes, Displayed):
    """Axes that a notebook shows as their picture."""

    def _repr_png_(self) -> bytes:
        return png(self.get_figure(root=True))


class Plot3D(Axes3D, Displayed):  # type: ignore[misc]
    """Axes of a surface that a notebook shows as their picture."""

    def _repr_png_(self) -> bytes:
        return png(self.get_figure(root=True))


@contextmanager
def styled(ax: Any) -> Iterator[None]:
    """Draw in the style of all pictures, in the caller's where the axes are the caller's.

    Raises:
        ArgumentError: For anything but axes or None.
    """
    if ax is not None and not isinstance(ax, Axes):
        raise ArgumentError(f"'ax' must be axes of matplotlib, or None, got {type(ax).__name__}")
    # Labels are texts of the user's in the caller's style, too.
    with mpl.rc_context(STYLE if ax is None else {"text.parse_math": False}):
        yield


def one(ax: Axes | None, size: tuple[float, float], *, solid: bool = False) -> Axes:
    """Return the axes to draw in: those given, or the only ones of a new figure.

    Args:
        ax: Axes, or None.
        size: Of a new figure [inches].
        solid: Whether new axes have three dimensions.
    """
    if ax is not None:
        return ax
    return Figure(figsize=size).add_subplot(axes_class=Plot3D if solid else Plot)


def place(ax: Axes | None) -> Any:
    """Return the figure for several panels: a new one, or one that takes the place of axes.

    Raises:
        ArgumentError: For axes that have no place in a grid, as those of `add_axes` have none.
    """
    if ax is None:
        return Figure()
    spec = ax.get_subplotspec()
    if spec is None:
        raise ArgumentError("'ax' must be one of the subplots of a figure: several panels take its place")
    figure = ax.figure
    ax.remove()
    return figure.add_subfigure(spec)


def sized(figure: Any, width: float, height: float) -> None:
    """Give a figure its size [inches]; a part of another figure has one."""
    if isinstance(figure, Figure):
        figure.set_size_inches(width, height)


def panels(figure: Any) -> Panels:
    """Return the axes of a figure that is drawn."""
    finish(figure)
    return Panels(figure.axes)


def finish(drawn: Any) -> None:
    """Show the texts of axes or a figure as they are: no dollar sign begins a formula, no control character acts.

    Numbers along an axis, which matplotlib writes, may be formulas: powers of ten are.
    """
    numbers = {text for tick in drawn.findobj(Tick) for text in tick.findobj(Text)}
    numbers |= {axis.offsetText for axis in drawn.findobj(Axis)}
    for text in drawn.findobj(Text):
        text.set_parse_math(text in numbers)
        # The font of pictures has no pictures of control characters.
        label = "\n".join(_PICTURES.sub("\ufffd", printable(line)) for line in text.get_text().split("\n"))
        if label != text.get_text():
            text.set_text(label)


def png(figure: Any) -> bytes:
    """Return a figure as PNG."""
    return _written(figure, "png", {})


def svg(figure: Any) -> str:
    """Return a figure as SVG: the same picture gives the same text."""
    return _written(figure, "svg", {"Date": None}).decode()


def _written(figure: Any, form: str, metadata: dict[str, Any]) -> bytes:
    file = io.BytesIO()
    with mpl.rc_context(STYLE), np.errstate(over="ignore"):
        figure.savefig(file, format=form, metadata=metadata, dpi=DPI)
    return file.getvalue()
