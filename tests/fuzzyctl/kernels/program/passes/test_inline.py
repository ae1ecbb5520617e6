"""Fewer names, the same steps."""

import pytest

from fuzzyctl.expr import ZERO, Binary, Call, Compare, Name, Number, Where
from fuzzyctl.kernels.program.passes.inline import inlined
from fuzzyctl.kernels.program.program import Accumulate, Assign, Program, Refuse

X, A, B = Name("x"), Name("a"), Name("b")


def program(*body, results):
    return Program(("x",), 0, (), body, results)


def plus(a, b):
    return Binary("+", a, b)


ONE_MORE = Assign("a", plus(X, Number(1.0)))


def test_what_is_needed_once_is_written_there():
    found = inlined(program(ONE_MORE, Assign("b", Binary("*", A, X)), results=(plus(B, X),)))
    assert found.body == ()
    assert found.results == (plus(Binary("*", plus(X, Number(1.0)), X), X),)


def test_what_is_needed_twice_keeps_its_name():
    given = program(ONE_MORE, Assign("b", Binary("*", A, A)), results=(A, Call("exp", (B,))))
    assert inlined(given) == given


@pytest.mark.parametrize("use", [Call("min", (A, X)), Call("exp", (A,)), Where(Compare("<", A, X), X, ZERO)], ids=str)
def test_what_printers_write_twice_or_take_as_a_name_keeps_it(use):
    assert inlined(program(ONE_MORE, results=(use,))) == program(ONE_MORE, results=(use,))


def test_the_values_of_a_choice_are_written_in():
    condition = Compare("<", X, ZERO)
    found = inlined(program(ONE_MORE, results=(Where(condition, A, ZERO),)))
    assert found == program(results=(Where(condition, plus(X, Number(1.0)), ZERO),))


def test_a_condition_of_a_refusal_keeps_the_name_that_it_reads():
    given = program(ONE_MORE, Refuse(Compare("<", A, ZERO), "u"), results=(X,))
    assert inlined(given) == given


def test_loops_are_left_alone():
    loop = Accumulate(3, "k", (), (Assign("b", A),))
    given = program(ONE_MORE, loop, results=(B,))
    assert inlined(given) is given


def test_a_long_chain_is_not_nested_without_end():
    body = [Assign("v0", X)] + [Assign(f"v{k + 1}", plus(Name(f"v{k}"), X)) for k in range(2000)]
    found = inlined(program(*body, results=(Name("v2000"),)))
    assert 0 < len(found.body) < 500
    value = found.results[0]
    depth = 0
    while isinstance(value, Binary):
        value, depth = value.left, depth + 1
    assert depth < 200
