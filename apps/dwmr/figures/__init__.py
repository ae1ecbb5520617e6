"""Figures of runs: overviews, and the counterparts of the paper's figures."""

from dwmr.figures.overview import draw_errors, draw_path
from dwmr.figures.style import CANNOT_DRAW, draw_file, large_numbers

__all__ = ["CANNOT_DRAW", "draw_errors", "draw_file", "draw_path", "large_numbers"]
