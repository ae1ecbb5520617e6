"""How many examples of a law tests draw: some in the test line, all before a release.

`python -m pytest -m "long or not long"` draws all, and runs the tests marked `long`.
"""

from __future__ import annotations

#: Whether all is drawn; tests/conftest.py sets it before any test is imported.
LONG = False


def examples(everything: int, some: int | None = None) -> int:
    """Return a number of examples: everything before a release, in the test line some, by default a quarter."""
    if LONG:
        return everything
    return max(min(4, everything), everything // 4) if some is None else some
