"""What all blocks of a rule file answer in the same way."""

import math

import pytest

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ExprError, Number
from fuzzyctl.loading.examination import look_through
from fuzzyctl.model.block import Block, Param

BLOCKS = """controller law
  param K = 2
  input e in [-K, K]
  output u = K*e
  every 0.1 s

plant lag
  input u
  state x = 0
  der x = u - x
  output y = x

loop ring
  block p = lag(c.u)
  block c = law(1 - p.y)
  run 1 s
"""


def blocks(text, name="a.fz"):
    found = look_through(SourceText(name, text))
    assert not found.diagnostics
    return (*found.systems, *found.blocks)


def test_every_block_has_a_kind_inputs_and_outputs():
    law, lag, ring = blocks(BLOCKS)
    tipper = fuzzyctl.load("tipper")
    assert [b.kind for b in (tipper, law, lag, ring)] == ["system", "controller", "plant", "loop"]
    assert [len(b.inputs) for b in (tipper, law, lag, ring)] == [2, 1, 1, 0]
    assert [[o.name for o in b.outputs] for b in (law, lag, ring)] == [["u"], ["y"], []]
    assert all(isinstance(b, Block) for b in (tipper, law, lag, ring))
    assert [ring.callee(i) for i in ring.instances] == [lag, law]


def test_ranges_are_numbers_of_the_params():
    law, lag, _ = blocks(BLOCKS)
    tipper = fuzzyctl.load("tipper")
    assert law.range_of(law.inputs[0]) == (-2.0, 2.0)
    assert lag.range_of(lag.inputs[0]) == (-math.inf, math.inf)
    assert tipper.range_of(tipper.inputs[0]) == (0.0, 10.0)


def test_values_of_params_that_cannot_be_computed_are_errors():
    law, *_ = blocks(BLOCKS)
    assert law.values == {"K": 2.0}
    broken = law.model_copy(update={"params": (Param(name="K", expression=Number(1.0) / Number(0.0)),)})
    with pytest.raises(ExprError):
        _ = broken.values
