from dataclasses import replace

import pytest

from fuzzyctl.records import record


@record(frozen=True)
class Point:
    x: float
    y: float = 0.0


@record(frozen=True, slots=True, eq=False)
class Node:
    name: str


def test_a_record_is_compared_hashed_and_shown_by_its_fields():
    assert Point(1.0) == Point(1.0, 0.0)
    assert len({Point(1.0), Point(1.0), Point(2.0)}) == 2
    assert repr(replace(Point(1.0), y=2.0)) == "Point(x=1.0, y=2.0)"


def test_a_record_that_is_not_compared_is_equal_to_itself_only():
    node = Node("a")
    assert node == node
    assert node != Node("a")
    assert len({node, Node("a")}) == 2


def test_what_may_be_written_to_is_no_record():
    with pytest.raises(AssertionError):
        record(frozen=False)
