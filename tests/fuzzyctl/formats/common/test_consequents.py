"""Consequents without a name: formats whose rules name terms only get terms for them, and the numbers stay."""

import pytest

from fuzzyctl import compile, loads
from tests.fuzzyctl.formats.files import FORMATS, read

SYSTEM = """
system s
and product
defuzzifier weighted_average
input x in [0, 10]
  low = triangle(-inf, 0, 10)
  high = triangle(0, 10, inf)
output u in [-50, 50] else midpoint
  {term} = constant(4)
  hill = triangle(5, 6, 9)
if x is low then u is {term}
if x is high then u is hill
if x is low then u is constant(1.5)
if x is high then u is linear(1, 2)
if x is high then u is linear(1, 2)
"""


def written_and_read(format, text):
    written, _ = FORMATS[format].write(loads(text))
    return written, read(format, written)


@pytest.mark.parametrize("format", ["fis", "fll", "fcl", "fml"])
@pytest.mark.parametrize("term", ["c1", "mf3", "plain"])
def test_numbers_stay(format, term):
    text = SYSTEM.format(term=term)
    _, back = written_and_read(format, text)
    points = [[0.0], [2.5], [7.0], [10.0]]
    found = compile(back, "python").batch(points)
    assert found == pytest.approx(compile(loads(text), "python").batch(points), rel=1e-14)
    assert len(back.outputs[0].terms) == 4  # equal ones share a term


@pytest.mark.parametrize(("format", "term", "names"), [("fml", "c1", ("c2", "c3")), ("fml", "C1", ("c1", "c2"))])
def test_names_that_are_taken_are_left_to_the_terms(format, term, names):
    written, _ = written_and_read(format, SYSTEM.format(term=term))
    assert all(f'<tskTerm name="{name}"' in written for name in names)


def test_names_of_fcl_know_no_case():
    written, _ = written_and_read("fcl", SYSTEM.format(term="C1"))
    assert "TERM C1 := 4;" in written
    assert "TERM c2 := 1.5;" in written


def test_the_middle_of_the_range_is_a_number_in_fcl():
    written, back = written_and_read("fcl", SYSTEM.format(term="plain").replace("[-50, 50]", "[-50, 60]"))
    assert "DEFAULT := 5;" in written
    assert back.number(back.outputs[0].otherwise) == 5.0


@pytest.mark.parametrize(("reads", "exact"), [("if u is hill then v is one\n", False), ("", True)])
def test_only_the_middle_of_a_core_is_a_loss_in_fml_where_rules_read_the_set(reads, exact):
    more = "output v in [0, 1] else 0\n  one = constant(1)\n"
    text = SYSTEM.format(term="plain") + more + (reads or "if x is low then v is one\n")
    _, losses = FORMATS["fml"].write(loads(text))
    assert [loss.exact for loss in losses if "the middle of its core" in str(loss)] == [exact]


SETS = """
system s
defuzzifier {defuzzifier}
input x in [0, 10] extrapolate
  low = triangle(-inf, 0, 10)
  high = triangle(0, 10, inf)
output u in [-50, 50] else midpoint
  few = triangle(5, 6, 9)
  many = trapezoid(10, 12, 14, 15)
if x is low then u is few
if x is high then u is many
"""


@pytest.mark.parametrize("format", ["fll", "fis", "fcl", "fml"])
@pytest.mark.parametrize("defuzzifier", ["center_average", "weighted_sum"])
def test_sets_count_with_the_middles_of_their_cores_in_averages_and_sums(format, defuzzifier):
    system = loads(SETS.format(defuzzifier=defuzzifier))
    text, losses = FORMATS[format].write(system)
    assert ("output 'u'", "term 'many'", True) in [(x.where, x.what, x.exact) for x in losses]
    if (format, defuzzifier) == ("fml", "weighted_sum"):
        assert "defuzzifier weighted_sum" in [x.what for x in losses if not x.exact]
        return
    back = read(format, text)
    kernel, there = compile(system, "python"), compile(back, "python")
    assert [there(x) for x in (0.0, 2.5, 7.0, 10.0)] == pytest.approx([kernel(x) for x in (0.0, 2.5, 7.0, 10.0)])
