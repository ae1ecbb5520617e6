from pathlib import Path

import pytest

from fuzzyctl import load

RULES = Path(__file__).parents[3] / "rules"


@pytest.fixture(scope="session")
def shipped():
    return {path.stem: load(path) for path in sorted(RULES.glob("*.fz"))}


@pytest.fixture(scope="session")
def rules():
    return RULES
