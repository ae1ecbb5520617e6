"""The reader of `.fcl` files before it was a translation, which the translation is compared with."""

from tests.oracles.fcl.reader import read

__all__ = ["read"]
