"""What axes of plots look like in a notebook: their picture, light or dark as the notebook is."""

from __future__ import annotations

from typing import Any

from fuzzyctl.display.markup import page, picture_png, picture_svg
from fuzzyctl.plot.figures import Panels, Plot, Plot3D, png, svg


def html(shown: Panels | Plot | Plot3D) -> str:
    """Return the picture; one whose colours stand for values stays on white."""
    figure: Any = shown.figure if isinstance(shown, Panels) else shown.get_figure(root=True)
    texts = [ax.get_title() or ax.get_ylabel() for ax in figure.axes]
    what = ", ".join(filter(None, texts)) or "plot"
    return page("", picture_png(png(figure), what) if _has_values(figure) else picture_svg(svg(figure), what))


def _has_values(figure: Any) -> bool:
    """Whether colours stand for values anywhere, as in maps and surfaces."""
    return any(c.get_array() is not None for ax in figure.axes for c in (*ax.collections, *ax.images))
