"""Let hypothesis draw systems beside a live peer, and reduce one that disagrees to a small one.

    python tests/peers/shrink.py --peer pyfuzzylite --examples 100

ends with 1 and the smallest system found where numbers disagree that no rounding explains.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.peers.catalogue import PEERS, Peer
from tests.peers.comparing import Case, Tally, compare, outputs_of_peer
from tests.peers.drawing import Draw


def main() -> int:
    """Run hypothesis as the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer", choices=list(PEERS), required=True)
    parser.add_argument("--examples", type=int, default=100)
    parser.add_argument("--points", type=int, default=8)
    options = parser.parse_args()
    peer = PEERS[options.peer]
    if peer.command() is None:
        print(f"{peer.name}: not installed; run: python tests/peers/environments.py --peer {peer.name}")
        return 1
    return search(peer, options.examples, options.points)


def search(peer: Peer, examples: int, points: int) -> int:
    """Return 1 where a system disagrees, after printing the smallest."""
    worst: list[Case] = []

    @settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.randoms(use_true_random=False))
    def agree(random: Random) -> None:
        case = drawn(peer, random, points)
        tally = Tally()
        theirs = outputs_of_peer(peer, [case])[case.name]
        if isinstance(theirs, np.ndarray):
            compare(case, theirs, tally, empties=peer.abilities.empties)
        if tally.disagreements or tally.failed:
            worst.append(case)
        assert not tally.disagreements
        assert not tally.failed

    try:
        agree()
    except AssertionError:
        print(worst[-1].text)
        print("\n".join(" ".join(map(repr, p)) for p in worst[-1].points))
        return 1
    print(f"{peer.name}: {examples} systems drawn by hypothesis agree")
    return 0


def drawn(peer: Peer, random: Random, points: int) -> Case:
    """Draw a case."""
    draw = Draw(random, peer.profile, peer.abilities)
    system = draw.system()
    return Case("h", system, peer.text(system), draw.points(system, points))


if __name__ == "__main__":
    sys.exit(main())
