"""Compilation of the loop's functions."""

from pathlib import Path

from dwmr.core import jit


def test_checksum_of_compiled_sources_leaves_out_packages_that_exist():
    package = Path(jit.__file__).parents[1]
    assert [one for one in jit.NEVER_COMPILED if not (package / one / "__init__.py").exists()] == []
