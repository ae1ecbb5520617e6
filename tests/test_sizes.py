"""The test line draws some of the examples, a release all."""

import pytest

from tests import sizes


@pytest.fixture(params=[False, True])
def is_long(request, monkeypatch):
    monkeypatch.setattr(sizes, "LONG", request.param)
    return request.param


@pytest.mark.parametrize(
    ("given", "drawn"), [((60,), 10), ((9,), 4), ((6, 2), 2), ((300, 210), 210), ((2,), 2)], ids=str
)
def test_some_or_all_examples_are_drawn(is_long, given, drawn):
    assert sizes.examples(*given) == (given[0] if is_long else drawn)


def test_all_are_drawn_where_long_tests_run(request):
    assert (request.config.option.markexpr != "not long") == sizes.LONG


@pytest.mark.long
def test_long_tests_run_before_a_release_only():
    assert sizes.LONG
