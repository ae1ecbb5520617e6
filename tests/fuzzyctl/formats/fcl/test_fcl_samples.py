"""Whole files as people and tools write them."""

from pathlib import Path

import pytest

from fuzzyctl import load, load_all
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fcl import read_all, write

HERE = Path(__file__).parent


def test_a_file_of_the_standard():
    system = load(HERE / "standard.fcl")
    # Cold 2/3, warm 1/3, falling and rising 1/2: 100 with 0.5, and 50 with max(0.5 * 0.8, 1/3).
    assert system(temperature=17, trend=0) == pytest.approx((100 * 0.5 + 50 * 0.4) / 0.9, rel=1e-15)
    warmer = system.with_params(comfort=23)
    assert warmer(temperature=20, trend=0) > system(temperature=20, trend=0)


def test_a_file_of_jfuzzylogic():
    distance, lamp = load_all(HERE / "jfuzzylogic.fcl")
    assert (distance.name, lamp.name) == ("distance", "lamp")
    assert distance.method.semantics.profile == "jfuzzylogic"
    assert (distance.method.conjunction, distance.method.disjunction) == ("product", "probabilistic_sum")
    # Dark 1/4, bright 1/6.
    assert lamp(lux=75) == pytest.approx(0.25 / (0.25 + 25 / 150), rel=1e-15)


def test_a_file_of_fuzzylite():
    system = load(HERE / "fuzzylite.fcl")
    assert system.title == "blind for a window"
    assert system.method.semantics.profile == "fuzzylite_6"
    assert system.method.disjunction == "einstein_sum"
    assert system.output("motor").defuzzifier.kind == "tsukamoto"
    assert [c.hedges for r in system.rules for c in r.consequents] == [(), (), (), (), ("seldom",)]


@pytest.mark.parametrize("path", sorted(HERE.glob("*.fcl")), ids=lambda p: p.stem)
def test_what_is_read_can_be_written_and_read_again(path):
    for system in load_all(path):
        text, losses = write(system)
        assert [x for x in losses if not x.exact] == []
        again, _ = read_all(SourceText("again.fcl", text))
        assert again[0].rules == system.rules
        assert [v.terms for v in again[0].outputs] == [v.terms for v in system.outputs]
