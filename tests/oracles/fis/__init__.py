"""The reader of `.fis` files before it was a translation, which the translation is compared with."""

from tests.oracles.fis.reader import read

__all__ = ["read"]
