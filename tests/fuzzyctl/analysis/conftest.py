import pytest

from fuzzyctl import load
from tests.shipped import SYSTEMS


@pytest.fixture(scope="session")
def shipped():
    return {path.stem: load(path) for path in SYSTEMS}


@pytest.fixture(scope="session")
def rules():
    return RULES
