"""Benchmark of control laws: the search of gains, the intervals, and the command."""

import json
import math

import numpy as np
import pytest

from dwmr.sweep import bench
from tests.dwmr.process import here

QUICK = ("--controller", "smc,kanayama", "--budget", "3", "--training", "1", "--runs", "2", "--set", "run.horizon=3")


def searched(cost, budget=40, seed=1, law="smc"):
    """Return all factors of two gains that the search tries, and their costs."""
    search = bench.candidates({"a": 1.0, "b": 2.0}, budget, seed, law)
    tried = [next(search)]
    for _ in range(budget - 1):
        tried.append(search.send(cost(tried[-1])))
    with pytest.raises(StopIteration):
        search.send(0.0)
    return tried


class TestCandidates:
    def test_begin_with_the_given_gains_and_end_near_the_best(self):
        tried = searched(lambda one: abs(math.log(one[0] / 2.0)) + abs(math.log(one[1] / 0.5)))
        assert tried[0].tolist() == [1.0, 1.0]
        assert all(1.0 / bench.REACH <= factor <= bench.REACH for one in tried[:20] for factor in one)
        assert tried[-1] == pytest.approx([2.0, 0.5], rel=0.4)

    def test_depend_on_seed_and_law_alone(self):
        first, again, law, seed = (searched(np.sum, **k)[5].tolist() for k in ({}, {}, {"law": "x"}, {"seed": 2}))
        assert first == again
        assert len({tuple(one) for one in (first, law, seed)}) == 3

    def test_gains_without_a_finite_cost_are_not_taken(self):
        tried = searched(lambda one: 1.0 if one.tolist() == [1.0, 1.0] else math.inf)
        assert np.abs(np.log(tried[20:])).max() <= math.log(bench.LOCAL_REACH) + 1e-12


def test_bootstrap_holds_the_mean_and_shrinks_with_the_number_of_runs():
    values = np.random.default_rng(3).normal(1.0, 1.0, 400)
    few, many = (bench.bootstrap_interval(list(values[:n]), 0) for n in (25, 400))
    assert few[0] < np.mean(values[:25]) < few[1]
    assert many[1] - many[0] == pytest.approx(2.0 * 1.96 * np.std(values) / 20.0, rel=0.1)
    assert many[1] - many[0] < 0.5 * (few[1] - few[0])


def test_differences_are_paired_and_leave_out_runs_that_one_law_does_not_finish():
    one = dict.fromkeys(bench.MEASURES, 1.0)
    runs = {"a": [one, one, None], "b": [one | {"error": 3.0}, None, one | {"error": 100.0}]}
    found = {(e.controller, e.measure): e for e in bench.entries("s", runs, 0)}
    assert (found["b", "error"].difference, found["b", "error"].low) == (2.0, None)
    assert (found["b", "error"].mean, found["b", "error"].n) == (51.5, 2)
    assert found["a", "error"].difference is None


def test_the_conclusion_names_laws_by_the_intervals_of_their_errors():
    intervals = {"b": (-2.0, -1.0), "c": (0.5, 1.0), "d": (-0.5, 0.5), "e": (-4.0, -3.0), "f": None}
    one = bench.Entry("here", "a", "error", "m", 3, 1.0, None, None, None)
    entries = [one, bench.Entry("here", "b", "energy", "kJ", 3, 1.0, 1.0, 1.0, 1.0)]
    for law, ends in intervals.items():
        entries.append(bench.Entry("here", law, "error", "m", 3, 1.0, sum(ends or (0,)) / 2, *(ends or (None, None))))
    wanted = ["less error than a: e, b", "more error than a: c", "no clear difference from a: d"]
    assert list(bench.conclusions(entries)) == wanted


def test_numbers_have_powers_of_ten_only_where_they_are_far_from_one():
    values = (1234.4, -123.44, 0.012344, 1.2344e-7, 1.2344e8, None)
    assert [bench._number(one, "+") for one in values] == ["+1234", "-123", "+0.0123", "+1.23e-07", "+1.23e+08", ""]


class TestCommand:
    def test_is_repeatable_and_tunes_every_law_equally(self):
        first, again = (here("bench", "undisturbed", *QUICK, "--format", "json").stdout for _ in range(2))
        assert first == again
        said = here("bench", "undisturbed", *QUICK).stdout
        assert "error than smc: kanayama" in said
        found = json.loads(first)
        for law, key in (("smc", "g_v"), ("kanayama", "k_x")):
            tuned = found["tuned"]["undisturbed"][law]
            assert tuned["evaluations"] == 3
            assert tuned["cost"] <= tuned["start"]
            assert key in tuned["gains"]
        (difference,) = [e for e in found["entries"] if (e["controller"], e["measure"]) == ("kanayama", "error")]
        assert difference["n"] == 2
        assert difference["low"] <= difference["difference"] <= difference["high"]

    def test_an_interruption_keeps_the_laws_that_are_done(self, monkeypatch):
        tune = bench.Bench.tune

        def interrupted(self, law, report):
            if law == "kanayama":
                raise KeyboardInterrupt
            return tune(self, law, report)

        monkeypatch.setattr(bench.Bench, "tune", interrupted)
        done = here("bench", "undisturbed", *QUICK, "--format", "json", status=130)
        assert "interrupted: done are undisturbed: smc" in done.stderr
        assert {e["controller"] for e in json.loads(done.stdout)["entries"]} == {"smc"}

    def test_runs_that_stop_are_counted(self):
        falls = ("--set", "disturbances=[{kind='constant',start=1.0,stop=2.0,v=0.0,omega=0.0,force=1e300,torque=0.0}]")
        done = here("bench", "undisturbed", *QUICK, *falls, status=1)
        assert "warning: undisturbed, smc: 2 of 2 runs stopped and are left out" in done.stderr
