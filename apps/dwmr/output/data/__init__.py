"""Files of recorded signals: npz, CSV, MATLAB's .mat and Parquet; `load` reads each of them."""

from __future__ import annotations

from dwmr.output.data.files import FORMATS, UnreadableDataError, load, suffix
from dwmr.output.data.signals import Data

__all__ = ["FORMATS", "Data", "UnreadableDataError", "load", "suffix"]
