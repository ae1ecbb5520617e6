"""docs/reference/performance.md shows the numbers of the files beside it, and all of them are of the same systems."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from tests.bench import fll, peers
from tests.bench.growth import STUDIES
from tests.bench.table import PEER_ROWS, ROWS, rendered
from tests.bench.workloads import WORKLOADS

FOLDER = Path(__file__).parent.parent.parent / "docs" / "reference" / "performance"


def test_the_table_of_the_page_is_that_of_the_measurement() -> None:
    times = json.loads((FOLDER / "kernels.json").read_text(encoding="utf-8"))
    assert rendered(times) in (FOLDER.parent / "performance.md").read_text(encoding="utf-8")


def test_every_way_is_in_the_measurement() -> None:
    times = json.loads((FOLDER / "kernels.json").read_text(encoding="utf-8"))
    assert all(set(ways) - set(PEER_ROWS) == set(ROWS) for ways in times.values())


def test_the_growth_is_that_of_the_studies() -> None:
    found = json.loads((FOLDER / "growth.json").read_text(encoding="utf-8"))
    assert {s: set(curves) for s, curves in found.items()} == {s: set(d["curves"]) for s, d in STUDIES.items()}
    assert all(ns > 0 for curves in found.values() for points in curves.values() for _, ns in points)
    # The claims of the page, far from noise: rules do not matter to interpolation, samples do to centroids.
    interpolated = dict(map(tuple, found["inputs"]["product, average"]))
    assert interpolated[6] < 100 * interpolated[1]
    sampled = dict(map(tuple, found["samples"]["sampled"]))
    assert sampled[1000] > 5 * sampled[10]


#: Of an output: 101 samples in place of an exact centroid, and activations up to 1e-6, which fuzzylite leaves out.
APART = {"W1": 1e-12, "W2": 1e-3, "W3": 1e-2, "W4": 1e-4}


@pytest.mark.parametrize("workload", WORKLOADS, ids=lambda w: w.name)
def test_other_tools_are_given_the_same_system(workload, tmp_path) -> None:
    text = fll.texts()[workload.name]
    path = tmp_path / "engine.fll"
    path.write_text(text, encoding="utf-8")
    systems = fuzzyctl.load(path), fuzzyctl.loads(workload.text, workload.name)
    own, theirs = (fuzzyctl.compile(s, "numpy").batch(workload.points(2000)) for s in systems)
    np.testing.assert_allclose(theirs, own, rtol=0, atol=APART[workload.name])
    read = peers.parsed(text)
    assert [v.name for v in read.variables] == [v.name for v in (*systems[0].inputs, *systems[0].outputs)]
    assert len(read.rules) == len(systems[0].rules)
    assert all(len(v.terms) == len(d.terms) for v, d in zip(read.variables, systems[0].inputs, strict=False))
