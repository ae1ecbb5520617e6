"""How loops are compared with UPAFuzzySystems, which the script installs and tests do not."""

import pytest

import fuzzyctl
from gallery import beside_upa, pages


@pytest.mark.parametrize("name", beside_upa.LOOPS)
def test_its_loops_are_those_of_the_gallery(name):
    *loops, signal = beside_upa.LOOPS[name]
    found = {loop.name: loop for loop in pages.loops_of(pages.entries()[name])}
    assert list(found) == loops
    assert signal in fuzzyctl.simulate(found[loops[0]]).names


def test_outputs_are_compared_at_each_sample(monkeypatch):
    monkeypatch.setitem(beside_upa.LOOPS, "upa_motor", ("exact_motor", "motor.y"))
    run = fuzzyctl.simulate(fuzzyctl.load(pages.HERE / "upa_motor" / "upa_motor.fz", block="exact_motor"))
    outputs = [float(y) for y in run["motor.y"]]
    outputs[200] += 0.25
    row = beside_upa.compared({"upa_motor": (1e6, outputs)}).splitlines()[-1]
    assert row.startswith("| exact_motor | 1000000.00 |")
    assert row.endswith("| 0.785398163 | 0.785398163 | 2.5e-01 |")


def test_samples_that_are_missing_are_an_error():
    with pytest.raises(ValueError, match="shorter"):
        beside_upa.compared({"upa_motor": (1.0, [0.0])})
