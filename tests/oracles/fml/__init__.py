"""The reader of FML before it became a translation."""

from tests.oracles.fml.reader import read

__all__ = ["read"]
