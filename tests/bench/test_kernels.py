"""The kernels beside hand-written C: the same numbers.

`python tests/bench/table.py` prints what each costs, with the ratios.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzyctl

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.bench.measure import build_limits, limit
from tests.bench.nan import without_test
from tests.bench.peers import PEERS
from tests.bench.table import ROWS, rendered
from tests.bench.workloads import WORKLOADS, Workload

EACH = pytest.mark.parametrize("workload", WORKLOADS, ids=lambda w: w.name)


@pytest.fixture(scope="module")
def limits(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The hand-written C."""
    library = build_limits(tmp_path_factory.mktemp("c"))
    if library is None:
        pytest.skip("needs gcc to compile the C that kernels are measured against")
    return library


@EACH
@pytest.mark.parametrize("form", ["points", "batch"])
def test_the_c_computes_the_same(limits: Any, workload: Workload, form: str) -> None:
    points, out = workload.points(5000), np.empty(5000)
    points[[7, 11], [0, 1]] = np.nan
    limit(limits, workload, form, points, out)
    for backend in ("numba", "numpy"):
        found = fuzzyctl.compile(fuzzyctl.loads(workload.text), backend).batch(points)
        np.testing.assert_allclose(found, out, rtol=1e-12, atol=1e-12)


def test_the_table_sets_each_way_against_another() -> None:
    times = {w.name: {"fuzzylite": 1000.0, "C, batch": 2.0, "batch, compiled": 3.0} for w in WORKLOADS}
    lines = rendered(times).splitlines()
    assert "| batch, compiled | 3 (1.5) | 3 (1.5) | 3 (1.5) | 3 (1.5) | times 'C, batch' |" in lines
    assert "| fuzzylite | 1000 | 1000 | 1000 | 1000 |  |" in lines
    assert set(ROWS.values()) <= {*ROWS, ""}
    assert json.dumps(times)


def test_rows_of_other_tools_are_there_only_if_they_were_measured() -> None:
    times = {w.name: {"fuzzylite": 1000.0} for w in WORKLOADS}
    assert not set(PEERS) & set(rendered(times).split())
    times["W3"]["simpful"] = 400_000.0
    assert "| simpful |  |  | 400000 (4e+02) |  | times 'fuzzylite' |" in rendered(times).splitlines()


def test_what_nan_costs_is_measured_without_its_test() -> None:
    sources = [fuzzyctl.compile(fuzzyctl.loads(w.text), "numba").source for w in WORKLOADS]
    assert ["x0_ != x0_" in s for s in sources] == [False, True, True, True]
    assert all("x0_ != x0_" not in without_test(s) and "return v" in without_test(s) for s in sources)


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++ to see whether the comparison compiles")
def test_what_measures_fuzzylite_is_whole_c_plus_plus() -> None:
    source = Path(__file__).with_name("fuzzylite.cpp").read_text(encoding="utf-8")
    assert source.count("{") == source.count("}")
    found = subprocess.run(
        ["g++", "-std=c++11", "-fsyntax-only", "-x", "c++", "-"],
        input=source.replace("#include <fl/Headers.h>", STUB),
        text=True,
        capture_output=True,
    )
    assert found.returncode == 0, found.stderr


#: As much of fuzzylite as the comparison uses.
STUB = """
#include <cstddef>
namespace fl {
struct InputVariable { void setValue(double) {} };
struct OutputVariable {};
struct Engine {
    InputVariable* getInputVariable(int) { return nullptr; }
    OutputVariable* getOutputVariable(int) { return nullptr; }
    void process() {}
};
struct FllImporter { Engine* fromFile(const char*) { return nullptr; } };
}
"""
