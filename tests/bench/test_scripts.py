"""The scripts that print the figures of the docs still run; what they print is not judged here."""

from __future__ import annotations

import shutil
import sys
from importlib.machinery import PathFinder
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.bench import cores, coverage_methods, free_numbers, javascript, nan, optimisations, params, robots
from tests.bench.trials import OPTIMISATIONS, SIZES
from tests.bench.workloads import WORKLOADS
from tests.frozen.systems import SYSTEMS

pytest.importorskip("numba")


def test_the_cost_of_nan_is_measured_in_batches_and_loops() -> None:
    found = nan.cost(WORKLOADS[1], rounds=1)
    assert set(found) == {"batch", "loop"}
    assert all(0.0 < time < 1e6 for pair in found.values() for time in pair)


def test_the_gain_of_cores_is_measured_in_a_row_and_apart(monkeypatch) -> None:
    monkeypatch.setattr(cores, "ROUNDS", 1)
    assert all(0.0 < number < 1e6 for number in cores.gains(WORKLOADS[0], 1000))


def test_the_cost_of_one_more_value_is_measured(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path))
    file, name, values = params.SWEPT[0]
    text = params.with_param((params.RULES / file).read_text(encoding="utf-8"), name, values[0])
    assert 0.0 < params.seconds(text, "python") < 60.0


@pytest.mark.long  # it compiles the robots' loop twice; tests/dwmr/core/test_jit.py holds that it allocates nothing
def test_the_cost_of_counted_references_is_measured_on_the_robots_loop() -> None:
    found = robots.measured(rounds=1)
    assert set(found) == {"uncounted", "counted"}
    assert all(0.0 < time < 600.0 for times in found.values() for time in times)


@pytest.mark.long  # it compiles a loop, a kernel and a step anew; tests/properties/test_free_numbers.py holds their law
def test_the_cost_of_new_numbers_is_measured_on_one_loop(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path))
    apart, free, recorded = free_numbers.costs().values()
    assert apart(0.25) == pytest.approx(free(0.25), abs=1e-12)
    assert all(0.0 < free_numbers.milliseconds(cost, 1) < 60e3 for cost in (free, recorded))


def test_no_script_hides_a_package_of_the_same_name() -> None:
    """A script's own folder comes first on the path: numba imports `coverage`, for one."""
    folder = Path(__file__).parent
    path = [p for p in sys.path if Path(p).resolve() != folder]
    hidden = [p.stem for p in folder.glob("*.py") if PathFinder.find_spec(p.stem, path) is not None]
    assert hidden == []


def test_both_ways_to_prove_coverage_are_compared() -> None:
    pairs, *seconds = coverage_methods.compared(coverage_methods.complete(2, 3))
    assert pairs == [("covered", "covered")]
    assert all(0.0 < s < 60.0 for s in seconds)


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
class TestJavaScript:
    @pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
    def test_an_evaluation_is_measured_beside_c(self) -> None:
        found = javascript.costs(WORKLOADS[3], count=100, rounds=2)
        assert found.pop("difference") < 1e-12
        assert all(0.0 < time < 1e6 for time in found.values())

    def test_functions_are_a_unit_in_the_last_place_from_those_of_c_at_most(self) -> None:
        assert max(javascript.differences(2000).values()) <= 2.0


class TestOptimisations:
    #: Another text for each use, but for numbers that only `kernel.value` takes from a table.
    PRINTED = tuple(own for own in OPTIMISATIONS if own.name != "parameters")
    TEXTS = (*(w.text for w in WORKLOADS), *SIZES.values(), *SYSTEMS.values())

    @pytest.mark.parametrize("optimisation", PRINTED, ids=lambda own: own.name)
    def test_each_is_switched_off(self, optimisation) -> None:
        assert any(optimisations.changed_uses(optimisation, text) for text in self.TEXTS)

    @pytest.mark.parametrize("optimisation", OPTIMISATIONS, ids=lambda own: own.name)
    def test_each_has_a_row_in_the_docs(self, optimisation) -> None:
        page = Path(__file__).parents[2] / "docs/explanation/optimisations.md"
        assert f"\n| {optimisation.name} | " in page.read_text(encoding="utf-8")
