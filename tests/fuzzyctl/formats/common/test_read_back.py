"""What differs between a system and what its text is read as is a loss, and nothing else is."""

import pytest

from fuzzyctl.expr import Number
from fuzzyctl.formats.common.losses import losses_of
from fuzzyctl.loading.load import loads
from fuzzyctl.model.variable import Hold

SYSTEM = loads("""
system s "Title"
source "Book"
param k = 2
input x "Label" in [0, 1] unit "m"
  low = gaussian(0, 1)
  high = gaussian(1, 1)
output y in [0, 1] else 0.5
  low = triangle(0, 0, 1)
  high = triangle(0, 1, 1)
require bounded(y, 0, 1)
if x is low and x is not high then y is low
if x is high or x is not low then y is high weight (k / 4)
""")


def lost(back, system=SYSTEM, **options):
    return list(dict.fromkeys((x.where, x.what, x.exact) for x in losses_of(system, back, **options)))


def other_method(**changes):
    return SYSTEM.model_copy(update={"method": SYSTEM.method.model_copy(update=changes)})


def other_output(**changes):
    return SYSTEM.model_copy(update={"outputs": (SYSTEM.outputs[0].model_copy(update=changes),)})


PARAMS = ("system 's'", "params k", True)


def test_a_system_differs_from_itself_by_its_params_which_become_values():
    assert lost(SYSTEM) == [PARAMS]


def test_a_text_that_cannot_be_read_is_a_loss_of_all():
    assert lost(None) == [("system 's'", "the system", False)]


def test_words_for_people_change_no_number():
    plain = loads("""
        system s
        input x in [0, 1]
          low = gaussian(0, 1)
          high = gaussian(1, 1)
        output y in [0, 1] else 0.5
          low = triangle(0, 0, 1)
          high = triangle(0, 1, 1)
        if x is low and x is not high then y is low
        if x is high or x is not low then y is high weight 0.5
    """)
    of_system = [("system 's'", word, True) for word in ("the title", "the source", "guarantees")]
    assert lost(plain) == [*of_system, ("input 'x'", "the label", True), ("input 'x'", "the unit", True), PARAMS]


@pytest.mark.parametrize(
    ("back", "where", "what"),
    [
        (other_method(conjunction="product"), "system 's'", "and min"),
        (other_method(disjunction="bounded_sum"), "system 's'", "or max"),
        (other_method(implication="product"), "system 's'", "implication min"),
        (other_method(aggregation="sum"), "output 'y'", "aggregation max"),
        (other_output(otherwise=Number(0.25)), "output 'y'", "else a value"),
        (other_output(otherwise="nan"), "output 'y'", "else a value"),
        (other_output(otherwise=Hold()), "output 'y'", "else a value"),
    ],
)
def test_what_is_read_otherwise_changes_numbers(back, where, what):
    assert lost(back) == [PARAMS, (where, what, False)]


@pytest.mark.parametrize(
    ("own", "read", "what"),
    [
        ("midpoint", Number(0.5), ("else midpoint", True)),
        (Number(0.5), "midpoint", None),
        (None, "nan", ("that some rule always fires", True)),
        ("error", "nan", ("else error", False)),
        (Hold(), Hold(start=Number(0.5)), None),
        (Hold(), Hold(start="nan"), ("what it holds at first", False)),
    ],
)
def test_what_an_output_is_where_no_rule_fires_is_compared_by_its_value(own, read, what):
    found = lost(other_output(otherwise=read), other_output(otherwise=own))
    assert found == [PARAMS, *([("output 'y'", *what)] if what is not None else [])]


def test_nan_may_be_as_good_as_an_error():
    back, system = other_output(otherwise="nan"), other_output(otherwise="error")
    assert lost(back, system, nan_for_error=True)[1:] == [("output 'y'", "else error", True)]


def test_a_clamp_that_is_gone_matters_where_terms_go_on_beyond_the_range():
    free = SYSTEM.model_copy(update={"inputs": (SYSTEM.inputs[0].model_copy(update={"extrapolate": True}),)})
    assert lost(free)[1:] == [("input 'x'", "clamped to its range", False)]
    assert lost(SYSTEM, free)[1:] == [("input 'x'", "values outside the range", False)]
    assert lost(SYSTEM, other_output(clamped=True))[1:] == [("output 'y'", "clamped to its range", False)]


def test_rules_are_compared_in_the_order_of_the_text():
    turned = SYSTEM.model_copy(update={"blocks": SYSTEM.rules[::-1]})
    assert lost(turned, rules=[1, 0]) == [PARAMS]
