import pytest

from fuzzyctl import load
from fuzzyctl.support.shipped import rules_folder
from tests.shipped import SYSTEMS


@pytest.fixture(scope="session")
def shipped():
    return {path.stem: load(path) for path in SYSTEMS}


@pytest.fixture(scope="session")
def rules():
    return rules_folder()
