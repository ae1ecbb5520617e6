"""Fuzzy Markup Language of IEEE 1855-2016, with the spellings of earlier drafts."""

from fuzzyctl.formats.fml.reader import read
from fuzzyctl.formats.fml.writer import write

__all__ = ["read", "write"]
