"""The fuzzy loop and the same in hand-written C have the same numbers; the times are for `loops.py` to print."""

import pytest

from tests.bench import loops


def test_the_loop_beside_c_is_the_same_loop(monkeypatch):
    monkeypatch.setattr(loops, "SAMPLES", 5_001)
    found = loops.beside_c(rounds=1)
    if found is None:
        pytest.skip("no C compiler")
    assert found[2] < 1e-10


def test_the_cost_is_that_of_the_loop_with_its_numbers_set():
    samples, seconds = loops.cost(rounds=1)
    assert samples == 301
    assert seconds > 0
