"""What peers are known to do otherwise and profiles on purpose do not, each as a small system.

    python tests/peers/known_bugs.py

asks the live peers again, and ends with 1 where one computes another number now.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

import fuzzyctl
from fuzzyctl import FuzzySystem
from tests.peers.catalogue import PEERS
from tests.peers.comparing import SKIPPED, Case, outputs_of_peer


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
        text = self.text.replace("LOW\n", LOW)
        return fuzzyctl.loads(f"system bug\nsemantics {PEERS[self.peer].profile}\n{text}")


#: Systems without their head; LOW is the input that most of them have.
LOW = "input a in [0, 10] extrapolate\n  low = triangle(0, 2, 4)\n"
_ONE_RULE = """
defuzzifier centroid
LOW
output y in [0, 10]
  left = triangle(0, 2, 4)
if a is low then y is left
"""
_FORMULA = """
defuzzifier weighted_average
input a in [0, 10]
  low = trapezoid(-inf, 0, 10, inf)
output y in [0, 10]
  f = function({})
if a is low then y is f
"""
_LONE = """
{norm}
defuzzifier weighted_average
LOW
  mid = triangle(2, 4, 6)
output y in [0, 10]
  small = constant(1)
  large = constant(9)
if a is low then y is small
if a is mid then y is large
"""
_JUMP = """
defuzzifier weighted_average
input a in [0, 10] extrapolate
  edge = {term}
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
LOW
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
_INVERTED = """
LOW
output y in [0, 10] else nan aggregation sum defuzzifier tsukamoto
  only = {term}
if a is low then y is only
"""
_CORNER = """
LOW
output y in [0, 10] else nan defuzzifier centroid(resolution=4)
  only = rectangle(1.2500001, 6)
if a is low then y is only
"""
_EMPTY = """
implication bounded_difference
LOW
output y in [0, 10] else 7 defuzzifier {kind}(resolution=4)
  only = triangle(2, 5, 8, height=0.4)
if a is low then y is only
"""
_HEDGED = """
LOW
output y in [0, 10] else 7 aggregation sum defuzzifier weighted_sum
  only = constant(5)
if a is low then y is not only
"""
_NEVER = """
LOW
output y in [0, 10] else 7 aggregation max defuzzifier tsukamoto
  up = ramp(0, 10)
  down = concave(8, 2)
if y is down then y is down
if a is low then y is up
"""
_TIED = """
activation highest(count=2)
LOW
output y in [0, 10] else nan aggregation sum defuzzifier weighted_average
  one = constant(1)
  two = constant(2)
  four = constant(4)
  eight = constant(8)
if a is low then y is one
if a is low then y is two
if a is low then y is four
if a is low then y is eight
"""
#: A point that the peer stops at with an error.
STOPS = SKIPPED
NAN = float("nan")
BUGS = (
    Bug("octave", "with a single rule the aggregation", _ONE_RULE, (1.0,), 2.0, 5.0),
    Bug(
        "octave", "the drastic product of a single degree", _LONE.format(norm="and drastic_product"), (3.0,), 5.0, STOPS
    ),
    Bug(
        "simpful",
        "a triangle or trapezoid with a vertical",
        _JUMP.format(term="triangle(4, 4, 8)"),
        (3.0,),
        1.0,
        6.333333333333333,
    ),
    Bug("simpful", "a double Gaussian with its means", _REVERSED, (5.0,), 3.1515313709599613, 4.020325350385163),
    Bug("scikit_fuzzy", "its bisector ignores", _HALVES, (1.0,), 5.0 + 2.0**0.5, 5.0 + 6.0**0.5),
    Bug("pyfuzzylite", "a NaN input", _NAN, (NAN, 1.0), NAN, 7.0),
    Bug("pyfuzzylite", "a rule that uses an output before any rule", _NEVER, (1.0,), 5.0, 7.0),
    Bug("fuzzylite", "if hedges change the activations", _HEDGED, (2.0,), 7.0, 0.0),
    Bug(
        "fuzzylite",
        "if hedges change the activations",
        _HEDGED.replace("weighted_sum", "weighted_average"),
        (2.0,),
        7.0,
        NAN,
    ),
    Bug("fuzzylite", "its tolerance of 1e-6", _CORNER, (2.0,), 3.75, 2.5),
    Bug(
        "fuzzylite",
        "Tsukamoto's method ignores heights",
        _INVERTED.format(term="ramp(0, 10, height=0.5)"),
        (0.5,),
        5.0,
        2.5,
    ),
    Bug(
        "fuzzylite",
        "Tsukamoto's method inverts the upper half",
        _INVERTED.format(term="s_shape(0, 10)"),
        (1.5,),
        10.0 - 10.0 * 0.125**0.5,
        6.123724356957945,
    ),
    Bug(
        "fuzzylite",
        "Tsukamoto's method inverts the upper half",
        _INVERTED.format(term="concave(2, 8)"),
        (1.0,),
        2.0,
        0.5,
    ),
    Bug(
        "fuzzylite",
        "Tsukamoto's method gives the end of the range for a sigmoid",
        _INVERTED.format(term="sigmoid(5, 1)"),
        (2.0,),
        float("inf"),
        10.0,
    ),
    Bug("fuzzylite", "if active rules give an empty", _EMPTY.format(kind="som"), (1.0,), 7.0, 1.25),
    Bug("fuzzylite", "if active rules give an empty", _EMPTY.format(kind="centroid"), (1.0,), 7.0, NAN),
    Bug("fuzzylite", "among equal activations", _TIED, (2.0,), 1.5, 2.5),
    Bug("fuzzylite", "formulas treat numbers closer", _FORMULA.format("eq(a, 2)"), (2.0000005,), 0.0, 1.0),
    Bug("fuzzylite", "formulas treat numbers closer", _FORMULA.format("eq(0 / a, 0 / a)"), (0.0,), 0.0, 1.0),
    Bug(
        "fuzzylite",
        "if a list of points has an x twice, the first",
        _JUMP.format(term="piecewise(0, 0, 2, 0.5, 2, 1, 4, 0)"),
        (2.0,),
        5.0,
        11.0 / 3.0,
    ),
    Bug(
        "pyfuzzylite",
        "if a list of points has an x twice, the last",
        _JUMP.format(term="piecewise(0, 0, 2, 1, 2, 0.5, 4, 0)"),
        (2.0,),
        5.0,
        11.0 / 3.0,
    ),
    Bug("fuzzylite", "a pi_shape without", _JUMP.format(term="pi_shape(2, 2, 3, 4)"), (2.0,), 5.0, 1.0),
    Bug("pyfuzzylite", "a pi_shape without", _JUMP.format(term="pi_shape(2, 2, 3, 4)"), (2.0,), 5.0, 1.0),
    Bug("pyfuzzylite", "formulas limit sums of truth values", _FORMULA.format("eq(a, 2) + eq(2, a)"), (2.0,), 2.0, 1.0),
    Bug("pyfuzzylite", "formulas limit sums of truth values", _FORMULA.format("eq(0 / a, 0 / a)"), (0.0,), 0.0, 1.0),
)


def main() -> int:
    """Print what the peers compute now, and return 1 where it is not what is stored."""
    changed = 0
    for bug in BUGS:
        peer = PEERS[bug.peer]
        if peer.command() is None:
            print(f"{bug.peer}: not installed")
            continue
        case = Case("bug", bug.system, peer.text(bug.system), [bug.point])
        found = float(np.ravel(outputs_of_peer(peer, [case])["bug"])[0])
        ours = bug.system(**dict(zip([i.name for i in bug.system.inputs], bug.point, strict=True)))
        same = np.isclose(found, bug.theirs, rtol=1e-12, equal_nan=True)
        changed += not same
        print(f"{bug.peer}: {bug.says} ...: {found!r}, here {ours!r}{'' if same else f'; it was {bug.theirs!r}'}")
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main())
