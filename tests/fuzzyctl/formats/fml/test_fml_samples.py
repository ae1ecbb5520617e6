"""Whole files as tools write them."""

from pathlib import Path

import pytest

from fuzzyctl import load
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fml import read, write
from fuzzyctl.model.rule import Is, Or

HERE = Path(__file__).parent


def test_a_file_of_jfml():
    system = load(HERE / "mamdani.fml")
    slow = Is(variable="speed", term="slow", hedges=("not",))
    moving = Or(operands=(Is(variable="speed", term="fast"), slow))
    assert system.rules[0].antecedent.operands[0] == moving
    # Only the first rule fires: 'full' up to 1, with its centre of gravity.
    assert system(speed=20, distance=5) == pytest.approx(system(speed=30, distance=0), abs=1e-12)
    assert system(speed=0, distance=50) < 2


def test_a_file_of_takagi_and_sugeno():
    # Both terms hold to 1/2, the second with weight 1/2: 1 - 2 * 0 and 0.25.
    assert load(HERE / "tsk.xml")(error=0) == pytest.approx((0.5 * 1 + 0.25 * 0.25) / 0.75, rel=1e-15)


def test_a_draft():
    system = load(HERE / "draft.fml")
    assert system.input("food").term("delicious").membership.kind == "ramp"
    # Nothing is poor at 10: the symmetric set at 10 remains.
    assert system(food=10) == pytest.approx(10.0, abs=1e-4)


@pytest.mark.parametrize("path", [*sorted(HERE.glob("*.fml")), *sorted(HERE.glob("*.xml"))], ids=lambda p: p.stem)
def test_what_is_read_can_be_written_and_read_again(path):
    system = load(path)
    text, losses = write(system)
    assert [x for x in losses if not x.exact] == []
    again, _ = read(SourceText("again.fml", text))
    assert again.rules == system.rules
