"""Whole files as people and tools write them have the numbers that their definitions give."""

import pytest

from fuzzyctl import loads
from tests.fuzzyctl.formats.files import SAMPLES, lines, read, rules


def test_a_file_of_the_standard():
    system = read("fcl", SAMPLES["standard.fcl"])
    # Cold 2/3, warm 1/3, falling and rising 1/2: 100 with 0.5, and 50 with max(0.5 * 0.8, 1/3).
    assert system(temperature=17, trend=0) == pytest.approx((100 * 0.5 + 50 * 0.4) / 0.9, rel=1e-15)
    warmer = system.with_params(comfort=23)
    assert warmer(temperature=20, trend=0) > system(temperature=20, trend=0)


def test_a_file_of_jfuzzylogic():
    distance, lamp = (loads(SAMPLES["jfuzzylogic.fcl"], "t.fcl", block=name) for name in ("distance", "lamp"))
    assert distance.method.semantics.profile == "jfuzzylogic"
    assert (distance.method.conjunction, distance.method.disjunction) == ("product", "probabilistic_sum")
    # Dark 1/4, bright 1/6.
    assert lamp(lux=75) == pytest.approx(0.25 / (0.25 + 25 / 150), rel=1e-15)


def test_a_file_of_fuzzylite():
    found = lines("fcl", SAMPLES["fuzzylite.fcl"])
    assert found[0] == 'system blind_for_a_window "blind for a window"'
    assert {"semantics   fuzzylite_6", "or          einstein_sum"} <= {*found}
    assert "output motor in [-1, 1] aggregation sum defuzzifier tsukamoto" in found
    assert found[-1] == "if sun is any LOW then motor is seldom UP weight 0.05"


def test_a_file_of_jfml():
    system = read("fml", SAMPLES["mamdani.fml"])
    assert rules("fml", SAMPLES["mamdani.fml"])[0] == (
        "if (speed is fast or speed is not slow) and distance is very near then force is full"
    )
    # Only the first rule fires: 'full' up to 1, with its centre of gravity.
    assert system(speed=20, distance=5) == pytest.approx(system(speed=30, distance=0), abs=1e-12)
    assert system(speed=0, distance=50) < 2


def test_a_file_of_takagi_and_sugeno():
    # Both terms hold to 1/2, the second with weight 1/2: 1 - 2 * 0 and 0.25.
    assert read("t.xml", SAMPLES["tsk.xml"])(error=0) == pytest.approx((0.5 * 1 + 0.25 * 0.25) / 0.75, rel=1e-15)


def test_a_draft():
    system = read("fml", SAMPLES["draft.fml"])
    assert system.input("food").term("delicious").membership.kind == "ramp"
    # Nothing is poor at 10: the symmetric set at 10 remains.
    assert system(food=10) == pytest.approx(10.0, abs=1e-4)
