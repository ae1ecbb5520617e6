"""Evaluate the examples of the peers' documentation with the live peers, as the documentation has them.

    python tests/peers/environments.py
    python tests/peers/documentation.py

prints the largest relative difference of each and writes tests/peers/documentation/outputs.json. It ends with 1 if one
is above 1e-9.
"""

from __future__ import annotations

import json
import sys
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

import fuzzyctl
from tests.peers.catalogue import PEERS, Peer
from tests.peers.comparing import AGREEMENT, Case, differences, evaluated, outputs_of_peer, widths_of

FOLDER = Path(__file__).parent / "documentation"
OUTPUTS = FOLDER / "outputs.json"


def peer_of(path: Path) -> Peer:
    """Return the peer that an example is of."""
    return PEERS[max((n for n in PEERS if path.stem.startswith(f"{n}_")), key=len)]


def case_of(path: Path) -> Case:
    """Return an example with the points of a grid over its inputs, about 60 of them."""
    system = fuzzyctl.load(path)
    count = {1: 61, 2: 8, 3: 4}[len(system.inputs)]
    axes = [np.linspace(system.number(i.lower), system.number(i.upper), count).tolist() for i in system.inputs]
    return Case(path.stem, system, peer_of(path).text(system), list(product(*axes)))


def live(path: Path) -> np.ndarray | None:
    """Return the outputs of the peer over the points; None if it is not installed."""
    peer, case = peer_of(path), case_of(path)
    if peer.command() is None:
        return None
    outputs = outputs_of_peer(peer, [case])[case.name]
    assert isinstance(outputs, np.ndarray), outputs
    return outputs


def difference(path: Path, outputs: np.ndarray) -> float:
    """Return the largest relative difference between fuzzyctl and given outputs."""
    case = case_of(path)
    return float(differences(evaluated(case), outputs, widths_of(case.system)).max())


def main() -> int:
    """Store the outputs of the peers that are installed."""
    stored = json.loads(OUTPUTS.read_text(encoding="utf-8")) if OUTPUTS.exists() else {}
    apart = 0
    for path in sorted(FOLDER.glob("*.fz")):
        outputs, peer = live(path), peer_of(path)
        if outputs is None:
            print(f"{path.stem}: {peer.name} is not installed")
            continue
        largest = difference(path, outputs)
        apart += largest > AGREEMENT
        print(f"{path.stem}: {outputs.size} numbers of {peer.name} {peer.version}, largest difference {largest:.1e}")
        stored[path.stem] = {"version": peer.version, "outputs": [" ".join(map(repr, r)) for r in outputs.tolist()]}
    OUTPUTS.write_text(json.dumps(stored, indent=0, sort_keys=True) + "\n", encoding="utf-8")
    return int(apart > 0)


if __name__ == "__main__":
    sys.exit(main())
