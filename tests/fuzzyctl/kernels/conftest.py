from pathlib import Path

import pytest

from fuzzyctl import load, loads

RULES = Path(__file__).parents[3] / "rules"


@pytest.fixture(scope="session")
def ais():
    return load(RULES / "ais_reaction.fz")


@pytest.fixture(scope="session")
def adaptive():
    return load(RULES / "fcafsmc.fz")


@pytest.fixture(scope="session")
def tipper():
    return load(RULES / "tipper.fz")


@pytest.fixture(scope="session")
def gappy():
    """Two inputs of different universes, two outputs, and a region where nothing fires."""

    def build(otherwise="else nan", other="else midpoint"):
        return loads(
            f"""
system gappy
and product
defuzzifier weighted_average
input speed in [0, 10]
  low = triangle(-inf, 1, 3)
  high = triangle(5, 8, inf)
input turn in [-1, 1]
  low = triangle(-inf, -0.5, 0.5)
  high = triangle(-0.5, 0.5, inf)
output brake in [0, 100] {otherwise}
  low = singleton(10)
  high = singleton(90)
output lamp in [0, 3] {other}
  low = singleton(1)
  high = singleton(2)
if speed is low and turn is low then brake is low, lamp is high
if speed is high then brake is high
if turn is high then lamp is low weight 0.5
"""
        )

    return build
