"""Stores of results: delays become loops, and what they compute stays the same."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Compare, Name, Number, Where
from fuzzyctl.kernels.program.printer import SCALAR, runs, store_lines
from fuzzyctl.kernels.program.program import STATE, Item
from fuzzyctl.loading.load import look_through

X = Name("x")
LACKS = Compare("!=", X, X)


def kept(k):
    return Where(LACKS, Item(STATE, k), Item(STATE, k - 1))


def test_results_that_follow_each_other_are_a_run():
    found = runs([X, X, kept(1), kept(2), kept(3), kept(4), kept(6), Number(2.0), Item(STATE, 8), Item(STATE, 9)])
    assert [(r.first, r.count) for r in found] == [(0, 1), (1, 1), (2, 4), (6, 1), (7, 1), (8, 1), (9, 1)]
    assert [r.is_loop for r in found].count(True) == 1


@pytest.mark.parametrize(("first", "is_shifted"), [(1, True), (0, False), (3, False)])
def test_a_delay_reads_itself_and_what_stands_before_it(first, is_shifted):
    (*_, run) = runs([X] * 1 + [kept(k) for k in range(first, first + 5)])
    assert run.is_shifted == is_shifted


def test_lines_store_what_the_results_are():
    results = [X, kept(1), kept(2), kept(3), kept(4), Number(5.0)]
    names = {"C": [10.0, 11.0, 12.0, 13.0, 14.0], "x": 1.0, "result": [0.0] * 6}
    exec("\n".join(store_lines(results, SCALAR, lambda k: f"result[{k}]")), names)
    assert names["result"] == [1.0, 10.0, 11.0, 12.0, 13.0, 5.0]


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_delays_of_delays_and_states_between_them_are_those_of_python(backend):
    text = (
        "controller d\ninput x\nstate s = 1\nnext s = 0.5 * s + delay(y, 7, start=3)\nlet y = delay(x, 6)\n"
        "let z = delay(delay(y, 5), 4)\noutput u = y + 10 * z + previous(z)\noutput v = s\nevery 10 ms\n"
    )
    controller = look_through(SourceText("c.fz", text)).controllers[-1]
    rows = np.random.default_rng(1).uniform(-1, 1, 60)
    rows[30] = np.nan
    expected, found = (fuzzyctl.compile(controller, b).run(rows) for b in ("python", backend))
    np.testing.assert_array_equal(found[0], expected[0])
    np.testing.assert_array_equal(found[1], expected[1])
    step = fuzzyctl.compile(controller, backend)
    states = np.tile(expected[1], (3, 1))
    np.testing.assert_array_equal(
        step.batch([0.5, np.nan, 1.0], states)[1][1:], [expected[1], step(1.0, expected[1])[1]]
    )
