"""Params are computed whatever their order; one without a value costs only those that need it."""

from itertools import permutations

import pytest

from fuzzyctl.expr import Binary, Name, Number
from fuzzyctl.model.block import Param, ParamValues


def param(name, *parts):
    """A param that is the sum of numbers and others."""
    terms = [Name(p) if isinstance(p, str) else Number(float(p)) for p in parts]
    whole = terms[0]
    for term in terms[1:]:
        whole = Binary("+", whole, term)
    return Param(name=name, expression=whole)


def test_any_order_gives_the_same_values():
    given = [param("a", 1), param("b", "a", 2), param("c", "a", "b"), param("d", 5)]
    for order in permutations(given):
        found = ParamValues(order)
        assert found.values == {"a": 1, "b": 3, "c": 4, "d": 5}
        assert not found.errors
        assert not found.failed


def test_a_long_chain_needs_no_recursion():
    chain = [param(f"p{k}", f"p{k + 1}", 1) for k in range(5000)] + [param("p5000", 0)]
    assert ParamValues(chain).values["p0"] == 5000


def test_a_circle_is_reported_once_and_named():
    found = ParamValues([param("a", "b"), param("b", "c"), param("c", "a"), param("d", "a"), param("e", 1)])
    (error,) = found.errors
    assert str(error) == "param 'a' depends on itself: a → b → c → a"
    assert found.failed == {"a", "b", "c", "d"}
    assert found.values == {"e": 1}


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (Param(name="a", expression=Number(float("inf"))), "param 'a' is infinite"),
        (Param(name="a", expression=Binary("/", Number(1.0), Number(0.0))), "division by zero"),
        (Param(name="a", expression=Name("nothing")), "nothing"),
    ],
    ids=["infinite", "quotient", "name"],
)
def test_one_cause_is_reported_once(bad, words):
    found = ParamValues([bad, param("b", "a"), param("c", 1)])
    (error,) = found.errors
    assert words in str(error)
    assert found.failed == {"a", "b"}
    assert found.values == {"c": 1}


def test_what_may_be_missing_is_no_mistake():
    found = ParamValues([param("a", "nothing"), param("b", "a"), param("c", 1)], partial=True)
    assert not found.errors
    assert found.values == {"c": 1}
    assert found.lacks(Name("b"))
    assert found.lacks(Name("other"))
    assert not found.lacks(Binary("+", Name("c"), Name("pi")))
