"""Conversations with one server, and a clock of proofs that only the proofs move."""

import itertools

import pytest

from tests.fuzzyctl.editor.wire import with_shared_server

__all__ = ["with_shared_server"]


@pytest.fixture(autouse=True)
def time_of_proofs_by_looks_at_the_clock(monkeypatch):
    """Have each look at the clock take a millisecond: imports and a busy machine take no time from a proof."""
    monkeypatch.setattr("fuzzyctl.analysis.work.clock.now", itertools.count(step=0.001).__next__)
