"""Texts that tests vary: inputs of different ranges, shared term names, a shoulder."""

import pytest

BASE = """\
system base "Base"

input x in [-1, 1]
  N = triangle(-inf, -1, 0)
  Z = triangle(-1, 0, 1)
  P = triangle(0, 1, inf)

input y in [0, 10] unit "m"
  terms N@0 P@10

output u in [-2, 2]
  N = triangle(-3, -2, 0)
  Z = triangle(-2, 0, 2)
  P = triangle(0, 2, 3)

table u = x x y
       N  P
  N |  N  Z
  Z |  N  P
  P |  Z  P
"""


@pytest.fixture
def base():
    return BASE


@pytest.fixture
def changed():
    """The base text with replacements made, which must all apply."""

    def change(*pairs, after=""):
        text = BASE
        for old, new in pairs:
            assert old in text, old
            text = text.replace(old, new, 1)
        return text + after

    return change
