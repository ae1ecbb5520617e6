from pathlib import Path

import pytest

from fuzzyctl import load
from tests import shipped

RULES = Path(__file__).parents[3] / "rules"


@pytest.fixture(scope="session")
def shipped():
    return {path.stem: load(path) for path in shipped.SYSTEMS}


@pytest.fixture(scope="session")
def rules():
    return RULES
