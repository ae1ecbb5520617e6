"""docs/reference/performance.md shows the numbers of the files beside it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from bench.growth import STUDIES
from bench.table import ROWS, rendered

FOLDER = Path(__file__).parent.parent.parent / "docs" / "reference" / "performance"


def test_the_table_of_the_page_is_that_of_the_measurement() -> None:
    times = json.loads((FOLDER / "kernels.json").read_text(encoding="utf-8"))
    assert rendered(times) in (FOLDER.parent / "performance.md").read_text(encoding="utf-8")


def test_every_way_is_in_the_measurement() -> None:
    times = json.loads((FOLDER / "kernels.json").read_text(encoding="utf-8"))
    assert all(set(ways) == set(ROWS) for ways in times.values())


def test_the_growth_is_that_of_the_studies() -> None:
    found = json.loads((FOLDER / "growth.json").read_text(encoding="utf-8"))
    assert {s: set(curves) for s, curves in found.items()} == {s: set(d["curves"]) for s, d in STUDIES.items()}
    assert all(ns > 0 for curves in found.values() for points in curves.values() for _, ns in points)
    # The claims of the page, far from noise: rules do not matter to interpolation, samples do to centroids.
    interpolated = dict(map(tuple, found["inputs"]["product, average"]))
    assert interpolated[6] < 100 * interpolated[1]
    sampled = dict(map(tuple, found["samples"]["sampled"]))
    assert sampled[1000] > 5 * sampled[10]
