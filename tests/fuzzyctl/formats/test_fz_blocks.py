"""Texts of controllers, plants and loops: what they hold, and what they refuse."""

import dataclasses

import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.testing import check_text

TEXT = """system rule
input e in [-1, 1]
  terms N P
output u in [-1, 1]
  terms N P
table u = e
  N P
| N P
controller inner
input x
output y = rule(x)
controller outer
input x
block a = inner(x)
output y = a.y + rule(x)
plant lag "A lag" = tf(num=[1], den=[2, 1])
loop l "A loop"
source "nowhere"
block c = outer(1 - p.y)
block p = lag(c.y)
run 1 s step 1 ms
"""


def blocks_of(text, folder=None):
    blocks, diagnostics = check_text(text, "c.fz", folder=folder)
    assert [d.message for d in diagnostics if d.severity == "error"] == []
    return {b.name: b for b in blocks}


def test_what_a_block_calls_precedes_it_once():
    text = fuzzyctl.dumps(blocks_of(TEXT)["l"])
    heads = [line for line in text.splitlines() if line.startswith(("system", "controller", "plant", "loop"))]
    assert heads == ["system rule", "controller inner", "controller outer", 'plant lag "A lag"', 'loop l "A loop"']
    assert 'source "nowhere"' in text
    assert "der x1 = 0.5 * (u - x1)" in text
    assert blocks_of(text)["l"] == blocks_of(TEXT)["l"]


def test_systems_that_call_each_other_are_written_once():
    other = TEXT.split("controller")[0].replace("rule", "other")
    called = TEXT.replace("output u in", "let z = other.u(e)\noutput u in", 1).replace("rule(x)", "rule(x) + other(x)")
    block = blocks_of(other + called)["l"]
    text = fuzzyctl.dumps(block)
    assert text.count("system other") == 1
    assert blocks_of(text)["l"] == block


def test_a_plant_in_python_keeps_its_file(tmp_path):
    (tmp_path / "cart.py").write_text('inputs = ("u",)\nstates = {"x": 1}\noutputs = ("y",)\n', encoding="utf-8")
    (tmp_path / "cart.fz").write_text('plant cart = python("cart.py")\nparam k = 2\n', encoding="utf-8")
    plant = fuzzyctl.load(tmp_path / "cart.fz", block=fuzzyctl.Plant)
    assert fuzzyctl.dumps(plant) == 'plant cart = python("cart.py")\n\nparam k = 2\n'
    assert blocks_of(fuzzyctl.dumps(plant), tmp_path)["cart"] == plant


def test_a_text_is_written_to_a_file(tmp_path):
    plant = blocks_of(TEXT)["lag"]
    fuzzyctl.dump(plant, tmp_path / "lag.fz")
    assert fuzzyctl.load(tmp_path / "lag.fz", block=fuzzyctl.Plant) == plant


def test_what_a_file_cannot_hold_is_refused():
    loop = blocks_of(TEXT)["l"]
    for wrong in (
        dataclasses.replace(loop, name="a b"),
        dataclasses.replace(loop, title='"'),
        dataclasses.replace(loop, plants=(dataclasses.replace(loop.plants[0], name="outer"),)),
    ):
        with pytest.raises(ValueOutOfBoundsError):
            fuzzyctl.dumps(wrong)
    with pytest.raises(ArgumentError, match="a FuzzySystem, Controller, Plant or Loop"):
        fuzzyctl.dumps("loop l")


def test_claims_of_a_controller_are_written():
    text = "controller c\n\ninput x in [0, 1]\n\noutput y = x\n\nrequire y in [0, 1] within 1e-9 when x > 0.5\n"
    assert fuzzyctl.dumps(blocks_of(text)["c"]) == text
