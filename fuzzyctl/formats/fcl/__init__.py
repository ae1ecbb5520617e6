"""Fuzzy Control Language of IEC 61131-7, with the dialects of jFuzzyLogic and fuzzylite."""

from fuzzyctl.formats.fcl.reader import read, read_all
from fuzzyctl.formats.fcl.writer import write

__all__ = ["read", "read_all", "write"]
