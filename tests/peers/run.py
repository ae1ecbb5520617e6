"""Draw systems, evaluate each with a live peer and with fuzzyctl under its profile, and compare.

    python tests/peers/environments.py
    python tests/peers/run.py --peer pyfuzzylite --systems 300 [--seed 1] [--points 60] [--show 3]

`--json FILE` adds the counts to a file; `rendered` makes the table of docs/explanation/peers.md from it. It ends
with 1 where numbers disagree that no rounding explains.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

from tests.peers.catalogue import PEERS, Peer
from tests.peers.comparing import Case, Tally, compare, outputs_of_peer, report
from tests.peers.drawing import Draw


def main() -> int:
    """Run the comparison that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer", choices=list(PEERS), action="append")
    parser.add_argument("--systems", type=int, default=300)
    parser.add_argument("--points", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--show", type=int, default=3, help="how many disagreeing systems to print")
    parser.add_argument("--json", type=Path, help="a file to add the counts to")
    options = parser.parse_args()
    failed = False
    for name in options.peer or list(PEERS):
        peer = PEERS[name]
        if peer.command() is None:
            print(f"{name}: not installed; run: python tests/peers/environments.py --peer {name}")
            failed = True
            continue
        tally = run(peer, options.systems, options.points, options.seed)
        print("\n".join(report(peer, tally)))
        show(tally, options.show)
        if options.json:
            known = json.loads(options.json.read_text()) if options.json.exists() else {}
            known[name] = counts(tally)
            options.json.write_text(json.dumps(known, indent=2) + "\n")
        failed = failed or bool(tally.disagreements)
    return int(failed)


def counts(tally: Tally) -> dict[str, float]:
    """Return what came out as numbers."""
    return {
        "systems": tally.systems,
        "numbers": tally.values,
        "largest": tally.largest,
        "at_jumps": tally.at_jumps,
        "emptied": tally.emptied,
        "tied": tally.tied,
        "rounded": tally.rounded,
        "disagree": len(tally.disagreements),
    }


def rendered(results: dict[str, dict[str, float]]) -> str:
    """Return the table of the documentation."""
    apart = {
        "at_jumps": "at jumps",
        "emptied": "empty sets",
        "tied": "ties",
        "rounded": "rounding",
        "disagree": "disagree",
    }
    head = ["tool", "profile", "systems", "numbers", "largest difference", *apart.values()]
    lines = ["| " + " | ".join(head) + " |", "| --- " * 2 + "| ---: " * (len(head) - 2) + "|"]
    for name, found in results.items():
        peer = PEERS[name]
        cells = [f"{name} {peer.version}", f"`{peer.profile}`", f"{found['systems']:,}", f"{found['numbers']:,}"]
        cells += [f"{found['largest']:.1e}", *(f"{found[k]:,}" for k in apart)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def run(peer: Peer, systems: int, points: int, seed: int) -> Tally:
    """Draw and compare."""
    cases = [drawn(peer, seed * 1_000_000 + k, points) for k in range(systems)]
    theirs = outputs_of_peer(peer, cases)
    tally = Tally()
    for case in cases:
        answer = theirs[case.name]
        if isinstance(answer, np.ndarray):
            compare(case, answer, tally, empties=peer.abilities.empties)
        else:
            tally.refused.append((case, answer))
    return tally


def drawn(peer: Peer, seed: int, points: int) -> Case:
    """Return the system of a seed."""
    draw = Draw(Random(seed), peer.profile, peer.abilities)
    system = draw.system()
    return Case(f"s{seed}", system, peer.text(system), draw.points(system, points))


def show(tally: Tally, count: int) -> None:
    """Print what was refused, by reason, and some disagreements."""
    for who, cases in (("peer", tally.refused), ("fuzzyctl", tally.failed)):
        for reason, times in Counter(" ".join(words.split())[:160] for _, words in cases).most_common(8):
            print(f"  {who} refused {times}: {reason}")
    seen: list[str] = []
    for d in tally.disagreements:
        if d.case.name in seen or len(seen) >= count:
            continue
        seen.append(d.case.name)
        point = " ".join(map(repr, d.case.points[d.row]))
        print(f"--- {d.case.name}, row {d.row}: inputs {point}")
        print(f"    {d.case.system.outputs[d.output].name}: ours {d.ours!r}, theirs {d.theirs!r}")
        print(d.case.text)


if __name__ == "__main__":
    sys.exit(main())
