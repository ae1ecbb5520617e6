"""Rules that set an output several times, for formats that know no such rules."""

import pytest

import fuzzyctl
from fuzzyctl.convert.convert import convert

FLL = """\
Engine: twice
InputVariable: x
  range: 0 10
  term: low Triangle -10 0 10
  term: high Triangle 0 10 20
{outputs}RuleBlock:
  conjunction: Minimum
  implication: Minimum
  activation: {activation}
  rule: if x is low then y is very m and z is m and y is somewhat l with 0.5
  rule: if x is high then y is l and z is l
"""
OUTPUT = """\
OutputVariable: {}
  range: 0 1
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: nan
  term: m Triangle 0.25 0.5 0.75
  term: l Triangle 0.5 0.75 1
"""


def system(activation="General"):
    text = FLL.format(outputs=OUTPUT.format("y") + OUTPUT.format("z"), activation=activation)
    return fuzzyctl.loads(text, "twice.fll")


@pytest.mark.parametrize("activation", ["General", "Threshold > 0.2"])
def test_they_become_several_rules_of_the_same_numbers(activation):
    found = convert(system(activation), "fz", points=200)
    assert found.read_back is not None
    assert [d.largest for d in found.differences] == [0.0, 0.0]
    assert len(found.read_back.rules) == 4


def test_without_carried_hedges_two_rules_are_enough():
    other = fuzzyctl.as_profile(system(), "exact")
    found = convert(other, "fz", points=200)
    assert found.read_back is not None
    assert all(d.within(1e-12) for d in found.differences)
    assert len(found.read_back.rules) == 3


def test_a_module_builds_the_same(tmp_path):
    names = {}
    exec(compile(convert(system(), "python").text, "module", "exec"), names)
    assert names["system"](x=3.0) == pytest.approx(system()(x=3.0), rel=1e-12)


def test_where_rules_are_compared_the_line_of_the_rule_is_named():
    with pytest.raises(fuzzyctl.DiagnosticError) as caught:
        convert(system("First 1 0"), "fz")
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "FZ608"
    text = str(caught.value)
    assert "twice.fll:24:26" in text
    assert "then y is very m" in text


def test_a_fis_file_has_one_number_for_each_output():
    with pytest.raises(fuzzyctl.DiagnosticError, match="rule 1 sets 'y' twice"):
        convert(system(), "fis")
