import pytest

from fuzzyctl import load
from tests.shipped import SYSTEMS, rules_folder


@pytest.fixture(scope="session")
def shipped():
    return {path.stem: load(path) for path in SYSTEMS}


@pytest.fixture(scope="session")
def rules():
    return rules_folder()
