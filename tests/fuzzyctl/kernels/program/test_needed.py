"""The statements that some results of a program depend on."""

import pytest

from fuzzyctl import loads
from fuzzyctl.expr import Binary, Name, Number
from fuzzyctl.kernels.inference.inference import evaluation
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program import traversal
from fuzzyctl.kernels.program.program import Accumulate, Assign, Item, Program, Refuse


def needed(program, wanted):
    return traversal.needed(program.body, [program.results[k] for k in wanted])


def assigned(name, *names):
    value = Number(1.0)
    for other in names:
        value = Binary("+", value, Name(other))
    return Assign(name, value)


BODY = (assigned("a", "x"), assigned("b", "y"), assigned("c", "a"), assigned("d", "b", "c"), Refuse(Name("b"), "v"))


@pytest.mark.parametrize(
    ("wanted", "kept"), [([0], ["a", "c"]), ([1], ["a", "b", "c", "d"]), ([2], []), ([0, 2], ["a", "c"])]
)
def test_what_a_result_is_made_of_is_kept_in_order(wanted, kept):
    program = Program(("x", "y"), 0, (), BODY, (Name("c"), Name("d"), Name("x")))
    assert [s.name for s in needed(program, wanted)] == kept


def test_a_loop_is_kept_for_any_of_its_sums_with_what_its_entries_read():
    loop = Accumulate(
        2, "k", (Assign("w", Binary("*", Name("a"), Item("t", "k"))),), (assigned("s", "w"), assigned("n"))
    )
    program = Program(("x",), 0, (("t", (1.0, 2.0)),), (assigned("a", "x"), loop), (Name("n"), Name("x")))
    assert needed(program, [0]) == program.body
    assert needed(program, [1]) == ()


TWO = """
system two
defuzzifier weighted_average
input e in [0, 1]
  terms A B
output u in [0, 1]
  terms lo=0 hi=1
output v in [0, 1]
  terms lo=0 hi=1
if e is A then u is hi
if e is B then v is hi
"""


def test_an_output_of_a_system_needs_less_than_both():
    whole = evaluation(plan(loads(TWO)))
    for wanted in ([0], [1]):
        assert 0 < len(needed(whole, wanted)) < len(whole.body)
