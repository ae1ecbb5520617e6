"""Style of all plots, and reproducible saving."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from typing import Any, Final

#: Okabe and Ito's colours, which survive colour-blindness; ordered so that neighbours also differ in print.
COLORS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D31")

STYLE: Final[dict[str, Any]] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": "medium",
    "figure.constrained_layout.use": True,
    "font.size": 10,
    "grid.alpha": 0.3,
    # TrueType fonts: publishers refuse the Type 3 fonts that matplotlib embeds otherwise.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "savefig.dpi": 150,
    "svg.hashsalt": "fuzzyctl",
    # Labels are texts of the user's, in which a dollar sign is a dollar sign.
    "text.parse_math": False,
}

#: Beside `STYLE`, for a dark background, which shows through; the colours that stand for values stay.
DARK: Final[dict[str, Any]] = {
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none"),
    **dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), "#d4d4d4"),
    **{f"axes3d.{axis}axis.panecolor": (1.0, 1.0, 1.0, 0.08) for axis in "xyz"},
}


@contextmanager
def saved(target: Path, dpi: float | None = None, *, svg_text: bool = False) -> Iterator[Any]:
    """Give an empty figure, and save it to a file when the block ends well.

    The same picture gives the same bytes: no date is written, and SVG identifiers do not vary.

    Args:
        target: The file; its suffix says the format.
        dpi: Pixels per inch of a PNG; None for those of the style.
        svg_text: Whether an SVG holds its texts as text in place of outlines.
    """
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    from fuzzyctl.support.writing import written_whole

    with mpl.rc_context(STYLE | ({"svg.fonttype": "none"} if svg_text else {})):
        # A new Figure, not pyplot's: no window system, no process-wide state.
        figure = Figure()
        yield figure
        metadata = (
            {"Date": None} if target.suffix == ".svg" else {"CreationDate": None} if target.suffix == ".pdf" else {}
        )
        # matplotlib's products of matrices now and then report an overflow although all their numbers are finite.
        with written_whole(target) as temporary, np.errstate(over="ignore"):
            figure.savefig(temporary, format=target.suffix[1:].lower(), metadata=metadata, dpi=dpi)


def svg(draw: Callable[[Any], object], *, dark: bool = False) -> str:
    """Return a picture as the text of an SVG.

    Args:
        draw: Draws into an empty figure.
        dark: For a dark background, in `DARK`.
    """
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE | DARK if dark else STYLE), np.errstate(over="ignore"):
        figure, text = Figure(), StringIO()
        draw(figure)
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
