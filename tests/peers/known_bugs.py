"""What peers are known to do otherwise and profiles on purpose do not, each as a small system.

    python tests/peers/known_bugs.py

asks the live peers again.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from peers.catalogue import PEERS
from peers.comparing import SKIPPED, Case, outputs_of_peer

import fuzzyctl
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True)
class Bug:
    """A number of a peer that is not imitated.

    Args:
        peer: The peer.
        says: How the entry of the profile's `not_imitated` begins.
        text: The system, as a rule file.
        point: The inputs.
        ours: What it is here.
        theirs: What the peer computes.
    """

    peer: str
    says: str
    text: str
    point: tuple[float, ...]
    ours: float
    theirs: float

    @property
    def system(self) -> FuzzySystem:
        """The system under the peer's profile."""
        return fuzzyctl.loads(f"system bug\nsemantics {PEERS[self.peer].profile}\n{self.text}")


_ONE_RULE = """
defuzzifier centroid
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [0, 10]
  left = triangle(0, 2, 4)
if a is low then y is left
"""
_LONE = """
{norm}
defuzzifier weighted_average
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
  mid = triangle(2, 4, 6)
output y in [0, 10]
  small = constant(1)
  large = constant(9)
if a is low then y is small
if a is mid then y is large
"""
_UPRIGHT = """
defuzzifier weighted_average
input a in [0, 10] extrapolate
  edge = triangle(4, 4, 8)
  low = triangle(0, 2, 4)
output y in [0, 10]
  small = constant(1)
  large = constant(9)
if a is edge then y is large
if a is low then y is small
"""
_REVERSED = """
defuzzifier weighted_average
input a in [0, 10] extrapolate
  hill = gaussian2(6, 1, 4, 1)
  low = triangle(0, 5, 10)
output y in [0, 10]
  small = constant(1)
  large = constant(9)
if a is hill then y is large
if a is low then y is small
"""
_NAN = """
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
input b in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [0, 10] else 7 aggregation sum defuzzifier weighted_average
  small = constant(1)
if a is low then y is small
"""
_HALVES = """
defuzzifier bisector
input a in [0, 4]
  low = triangle(0, 1, 4)
output y in [0, 10]
  left = triangle(0, 1, 2)
  right = triangle(5, 7, 9)
if a is low then y is left
if a is low then y is right
"""
#: A point that the peer stops at with an error.
STOPS = SKIPPED
NAN = float("nan")
BUGS = (
    Bug("octave", "with a single rule the aggregation", _ONE_RULE, (1.0,), 2.0, 5.0),
    Bug(
        "octave", "the drastic product of a single degree", _LONE.format(norm="and drastic_product"), (3.0,), 5.0, STOPS
    ),
    Bug("simpful", "a triangle or trapezoid with an upright", _UPRIGHT, (3.0,), 1.0, 6.333333333333333),
    Bug("simpful", "a double Gaussian whose means", _REVERSED, (5.0,), 3.1515313709599613, 4.020325350385163),
    Bug("scikit_fuzzy", "its bisector forgets", _HALVES, (1.0,), 5.0 + 2.0**0.5, 5.0 + 6.0**0.5),
    Bug("pyfuzzylite", "an input that is NaN", _NAN, (NAN, 1.0), NAN, 7.0),
)


def main() -> None:
    """Print what the peers compute now."""
    for bug in BUGS:
        peer = PEERS[bug.peer]
        if peer.command() is None:
            print(f"{bug.peer}: not installed")
            continue
        case = Case("bug", bug.system, peer.text(bug.system), [bug.point])
        found = outputs_of_peer(peer, [case])["bug"]
        ours = bug.system(**dict(zip([i.name for i in bug.system.inputs], bug.point, strict=True)))
        print(f"{bug.peer}: {bug.says} ...: {found.tolist()}, here {ours!r}")


if __name__ == "__main__":
    main()
