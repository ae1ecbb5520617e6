"""Format `.fis`: fuzzy inference systems of MATLAB, Octave's fuzzy-logic-toolkit and fuzzylite."""

from fuzzyctl.formats.fis.reader import read
from fuzzyctl.formats.fis.writer import write

__all__ = ["read", "write"]
