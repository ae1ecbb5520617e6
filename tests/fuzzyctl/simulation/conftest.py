import pytest

import fuzzyctl


@pytest.fixture
def loop(tmp_path):
    """Load a loop from its text."""

    def load(text, name=None):
        path = tmp_path / "loop.fz"
        path.write_text(text, encoding="utf-8")
        return fuzzyctl.load(path, block=name or fuzzyctl.Loop)

    return load
