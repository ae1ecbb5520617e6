"""The examples of the peers' documentation give the peers' numbers under their profiles."""

from __future__ import annotations

import json

import numpy as np
import pytest

import fuzzyctl
from tests.peers.comparing import AGREEMENT, SKIPPED
from tests.peers.documentation import FOLDER, OUTPUTS, difference, live, peer_of

STORED = json.loads(OUTPUTS.read_text(encoding="utf-8"))
EXAMPLES = sorted(FOLDER.glob("*.fz"))


def stored(name: str) -> np.ndarray:
    return np.array([[float(n) for n in row.split()] for row in STORED[name]["outputs"]])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_the_numbers_are_the_peers(path):
    assert STORED[path.stem]["version"] == peer_of(path).version
    assert not (stored(path.stem) == SKIPPED).any()
    assert difference(path, stored(path.stem)) <= AGREEMENT


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_the_live_peers_still_give_them(path):
    outputs = live(path)
    if outputs is None:
        pytest.skip(f"{peer_of(path).name} is not installed: python tests/peers/environments.py")
    assert difference(path, outputs) <= AGREEMENT


def test_scikit_fuzzy_prints_this_tip():
    tipping = fuzzyctl.load(FOLDER / "scikit_fuzzy_tipping.fz")
    assert tipping(quality=6.5, service=9.8) == pytest.approx(19.847607361963192, rel=1e-14)


#: MATLAB's page "Defuzzification Methods": trapezoids scaled by 0.9, 0.5 and 0.1, over -10:0.1:10.
MATLAB = """
system region
semantics matlab
implication product
defuzzifier {kind}(resolution=201)
input on in [0, 1]
  yes = ramp(0, 1)
output x in [-10, 10]
  left = trapezoid(-10, -8, -2, 2)
  middle = trapezoid(-5, -3, 2, 4)
  right = trapezoid(2, 3, 8, 9)
if on is yes then x is left weight 0.9
if on is yes then x is middle weight 0.5
if on is yes then x is right weight 0.1
"""


@pytest.mark.parametrize(("kind", "printed"), [("mom", -5.0), ("som", -2.0), ("lom", -8.0)])
def test_matlabs_manual_prints_these_maxima(kind, printed):
    assert fuzzyctl.loads(MATLAB.format(kind=kind))(on=1.0) == pytest.approx(printed, abs=1e-12)


@pytest.mark.parametrize(("kind", "expected"), [("som", 0.0), ("mom", 6.5), ("lom", 13.0)])
def test_maxima_of_scikit_fuzzy_are_those_of_its_universe(kind, expected):
    """As scikit-fuzzy 0.5 gives them for `linspace(0, 25, 26)`, whose ends are samples."""
    system = fuzzyctl.loads(
        f"""system s
semantics scikit_fuzzy
and min
implication min
aggregation max
defuzzifier {kind}(resolution=26)
input x in [0, 1]
  on = rectangle(0, 1)
output u in [0, 25]
  low = triangle(0, 0, 13)
  mid = triangle(4, 13, 21)
if x is on then u is low
if x is on then u is mid
"""
    )
    assert system(x=0.5) == expected
