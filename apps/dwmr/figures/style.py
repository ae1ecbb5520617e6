"""Style of all figures: colours for colour-blind readers and for print, sizes, names of the control laws."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from fuzzyctl.plot.style import COLORS
from fuzzyctl.plot.style import STYLE as PLOTS

if TYPE_CHECKING:
    from pathlib import Path

    from fuzzyctl.experiments.result_files import Results

#: Told apart with any colour vision; widths and dashes tell them apart without colour.
COLOURS = COLORS[:6]
DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1)), (0, (6, 1.5, 1.5, 1.5)))

STYLE = PLOTS | {
    "font.size": 9,
    "axes.titlesize": 10,
    "grid.alpha": 1.0,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    # Each figure chooses its layout, and labels hold formulas.
    "figure.constrained_layout.use": False,
    "text.parse_math": True,
}

TITLES = {"smc": "SMC", "aifqsmc": "AIFQSMC", "fcafsmc": "FCAFSMC"}


#: What matplotlib raises for numbers that no axis can hold, such as those of a run that diverged.
CANNOT_DRAW = (ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError, MemoryError)


@contextmanager
def large_numbers() -> Iterator[None]:
    """Keep overflows on the way to a picture quiet: the picture comes out, or one of `CANNOT_DRAW` does."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)
        warnings.simplefilter("ignore", UserWarning)
        yield


def draw_file(files: Results, name: str, draw: Callable[[Path], None]) -> str:
    """Draw a picture into a file of results.

    Returns:
        The reason why it cannot be drawn, in which case the file is dropped; else an empty text.
    """
    try:
        with large_numbers():
            files.write(name, draw)
    except CANNOT_DRAW as error:
        files.drop(name)
        return str(error) or type(error).__name__
    return ""
