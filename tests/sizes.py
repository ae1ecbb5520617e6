"""How many examples of a law tests draw: some in the test line, all before a release.

`python -m pytest -m "long or not long"` draws all, and runs the tests marked `long`.
"""

from __future__ import annotations

from typing import Any

import pytest

#: Whether all is drawn; tests/conftest.py sets it before any test is imported.
LONG = False


#: Backends of a law that other tests hold compiled code to in the test line: numba takes a second for each kernel.
BACKENDS = ("python", "numpy", pytest.param("numba", marks=pytest.mark.long))


def examples(everything: int, some: int | None = None) -> int:
    """Return a number of examples: everything before a release, in the test line some, by default a sixth."""
    if LONG:
        return everything
    return max(min(4, everything), everything // 6) if some is None else some


def some(everything: list[Any], share: int) -> list[Any]:
    """Return parameters of a law: before a release all, in the test line the first of each `share` of them."""
    marks = [[pytest.mark.long] if k % share else [] for k in range(len(everything))]
    rows = (row if isinstance(row, tuple) else (row,) for row in everything)
    return [pytest.param(*row, marks=mark) for row, mark in zip(rows, marks, strict=True)]
