"""FuzzyLite Language: `.fll` files of engines of fuzzylite, pyfuzzylite and jfuzzylite."""

from fuzzyctl.formats.fll.reader import read
from fuzzyctl.formats.fll.writer import write

__all__ = ["read", "write"]
