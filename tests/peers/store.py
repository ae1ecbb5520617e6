"""Store systems with the outputs of live peers, so that the tests need no peer.

    python tests/peers/store.py [--peer pyfuzzylite]

chooses among drawn systems those that show what the others do not, leaves out points where rounding decides, and writes
tests/peers/vectors/PEER.json: the text that the peer took, or a rule file where it takes none, points and outputs.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

from fuzzyctl import FuzzySystem, dumps
from tests.peers.catalogue import PEERS, Peer
from tests.peers.comparing import AGREEMENT, SKIPPED, Case, differences, evaluated, outputs_of_peer, widths_of
from tests.peers.run import drawn
from tests.reference.interpreter import literals

VECTORS = Path(__file__).parent / "vectors"
#: Points of each stored system.
POINTS = 10


def main() -> None:
    """Store the vectors that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer", choices=list(PEERS), action="append")
    parser.add_argument("--systems", type=int, default=150, help="how many to choose from")
    parser.add_argument("--keep", type=int, default=20, help="how many to keep at most")
    options = parser.parse_args()
    VECTORS.mkdir(exist_ok=True)
    for name in options.peer or list(PEERS):
        peer = PEERS[name]
        if peer.command() is None:
            print(f"{name}: not installed; run: python tests/peers/environments.py --peer {name}")
            continue
        kept = chosen(peer, options.systems, options.keep)
        described = {"peer": name, "version": peer.version, "profile": peer.profile, "cases": kept}
        path = VECTORS / f"{name}.json"
        path.write_text(json.dumps(described, indent=0) + "\n")
        print(f"{path.name}: {len(kept)} systems, {path.stat().st_size:,} bytes")


def chosen(peer: Peer, systems: int, keep: int) -> list[dict]:
    """Return systems on which all agree; each shows something that those before do not."""
    cases = [drawn(peer, 99_000_000 + k, POINTS) for k in range(systems)]
    theirs = outputs_of_peer(peer, cases)
    clean = [(c, theirs[c.name]) for c in cases if isinstance(theirs[c.name], np.ndarray)]
    clean = [(c, t) for c, t in clean if not (t == SKIPPED).any() and np.isfinite(t).any() and _agree(c, t)]
    left = {c.name: (c, t, set(features(c.system))) for c, t in clean}
    kept, seen = [], set()
    while left and len(kept) < keep:
        name = max(left, key=lambda n: len(left[n][2] - seen) / (1 + len(left[n][0].text) / 1000))
        case, values, shows = left.pop(name)
        if not shows - seen:
            break
        seen |= shows
        kept.append(
            {
                "suffix": peer.suffix if peer.suffix != ".json" else ".fz",
                "text": (case.text if peer.suffix != ".json" else dumps(case.system)).splitlines(),
                "points": [" ".join(map(repr, p)) for p in case.points],
                "outputs": [" ".join(map(repr, row)) for row in values.tolist()],
            }
        )
    return kept


def _agree(case: Case, theirs: np.ndarray) -> bool:
    return bool((differences(evaluated(case), theirs, widths_of(case.system)) <= AGREEMENT).all())


def features(system: FuzzySystem) -> Iterator[str]:
    """Yield what a system shows."""
    method = system.method
    yield from (f"and {method.conjunction}", f"or {method.disjunction}", f"implication {method.implication}")
    yield f"activation {method.activation.kind}"
    for output in system.outputs:
        own = output.defuzzifier or method.defuzzifier
        yield f"{own.kind} with {output.aggregation or method.aggregation}" if own.over_rules else own.kind
        yield f"aggregation {output.aggregation or method.aggregation}"
        yield f"else {type(output.otherwise).__name__}"
        if output.clamped:
            yield "clamp"
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            yield f"{type(variable).__name__} {term.membership.kind}"
    for rule in system.rules:
        yield from (f"hedge {h}" for i in literals(rule.antecedent) for h in i.hedges)
        yield from (f"consequent hedge {h}" for c in rule.consequents for h in c.hedges)
        if any(i.variable in [o.name for o in system.outputs] for i in literals(rule.antecedent)):
            yield "chained"


if __name__ == "__main__":
    main()
