"""Reads and writes `.fll` files: engines of fuzzylite, pyfuzzylite and jfuzzylite in the FuzzyLite Language."""

from fuzzyctl.formats.fll.reader import read
from fuzzyctl.formats.fll.writer import write

__all__ = ["read", "write"]
