"""The reader of `.fll` files before it was a translation, which the translation is compared with."""

from tests.oracles.fll.reader import read

__all__ = ["read"]
