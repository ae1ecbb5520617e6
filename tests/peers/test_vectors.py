"""fuzzyctl beside what peers computed: stored systems with the outputs of the tools that their profiles imitate.

`python tests/peers/store.py` made the files, with the versions that they name.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import fuzzyctl

VECTORS = Path(__file__).parent / "vectors"
CASES = [
    pytest.param(described["profile"], case, id=f"{path.stem}-{k}")
    for path in sorted(VECTORS.glob("*.json"))
    for described in [json.loads(path.read_text())]
    for k, case in enumerate(described["cases"])
]


def rows(lines: list[str]) -> np.ndarray:
    return np.array([[float(n) for n in line.split()] for line in lines])


@pytest.mark.parametrize(("profile", "case"), CASES)
def test_the_numbers_are_the_peers(profile, case):
    system = fuzzyctl.loads("\n".join(case["text"]) + "\n", f"drawn{case['suffix']}")
    if system.method.semantics.profile != profile:
        system = fuzzyctl.as_profile(system, profile)
    theirs = rows(case["outputs"])
    ours = fuzzyctl.compile(system, backend="numpy").run(rows(case["points"]))[0].reshape(theirs.shape)
    widths = [system.number(o.upper) - system.number(o.lower) for o in system.outputs]
    for row, (a, b) in enumerate(zip(ours, theirs, strict=True)):
        for x, y, width in zip(a.tolist(), b.tolist(), widths, strict=True):
            if math.isnan(y) or math.isinf(y):
                assert x == y or (math.isnan(x) and math.isnan(y)), (row, x, y)
            else:
                assert x == pytest.approx(y, rel=1e-9, abs=1e-9 * width), row


def test_they_are_small():
    assert sum(path.stat().st_size for path in VECTORS.glob("*.json")) < 300_000
