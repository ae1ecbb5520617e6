"""What the tools of a format evaluate though it is odd: it is read, and what others make of it is said."""

import pytest

from fuzzyctl import dumps, loads
from fuzzyctl.testing import check_text
from tests.fuzzyctl.formats.files import FORMATS


def read(name, text):
    """Return the system and its findings besides those of estimated ranges of inputs."""
    systems, found = check_text(text, name)
    return (systems[0] if systems else None), [d for d in found if "without RANGE" not in d.message]


POINT = """\
FUNCTION_BLOCK blend
VAR_INPUT
  x: REAL;
END_VAR
VAR_OUTPUT
  u: REAL;
END_VAR
FUZZIFY x
  RANGE := (0.000 .. 2.000);
  TERM low := Ramp 2.000 0.000;
  TERM high := Ramp 0.000 2.000;
END_FUZZIFY
DEFUZZIFY u
  RANGE := (0.000 .. 0.000);
  TERM a := Linear 1.000 3.000;
  TERM b := Linear -1.000 5.000;
  METHOD : COGS;
  ACCU : MAX;
  DEFAULT := nan;
END_DEFUZZIFY
RULEBLOCK
  AND : PROD;
  OR : MAX;
  ACT : PROD;
  RULE 1 : if x is low then u is a
  RULE 2 : if x is high then u is b
END_RULEBLOCK
END_FUNCTION_BLOCK
"""


class TestRangesOfOnePoint:
    def test_an_average_needs_none(self):
        system, (warning,) = read("blend.fcl", POINT)
        assert (warning.code, warning.severity) == ("FZ610", "warning")
        assert warning.message == "the RANGE of 'u' is one point; its terms lie in [3, 5]"
        assert system(x=0.5) == 3.75
        assert system(x=-1) == read("blend.fcl", POINT.replace("(0.000 .. 0.000)", "(0.000 .. 9.000)"))[0](x=-1)

    def test_an_input_needs_none_either(self):
        system, (warning,) = read(
            "blend.fcl", POINT.replace("0.000 .. 2.000", "1 .. 1").replace("0.000 .. 0.000", "0 .. 9")
        )
        assert warning.message == "the RANGE of 'x' is one point; its terms lie in [0, 2]"
        assert system(x=0.5) == 3.75

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("END_DEFUZZIFY", "  LOCK : RANGE;\nEND_DEFUZZIFY"),
            (
                "TERM a := Linear 1.000 3.000;\n  TERM b := Linear -1.000 5.000;\n  METHOD : COGS",
                "TERM a := Triangle 0 1 2;\n  TERM b := Triangle 1 2 3;\n  METHOD : COG",
            ),
        ],
    )
    def test_what_is_held_or_sampled_within_it_does(self, old, new):
        assert old in POINT
        assert "FZ304" in {d.code for d in read("blend.fcl", POINT.replace(old, new))[1]}

    def test_in_the_language_of_fuzzylite_it_is_called_empty(self):
        text = (
            "Engine: e\nInputVariable: x\n  range: 0 2\n  term: a Ramp 2 0\nOutputVariable: u\n  range: 0 0\n"
            "  defuzzifier: WeightedAverage TakagiSugeno\n  term: c Linear 1 3\nRuleBlock: r\n  activation: General\n"
            "  rule: if x is a then u is c\n"
        )
        assert "the range of 'u' is empty; [3, 5] is what its terms need" in {d.message for d in read("e.fll", text)[1]}


EMPTY = """\
FUNCTION_BLOCK q
VAR_INPUT
  x: REAL;
END_VAR
VAR_OUTPUT
  u: REAL;
END_VAR
FUZZIFY x
  TERM low := TRIAN 0 0 420;
  TERM mid := TRAPE 0 420 550 700;
  TERM fake := (0,0) (1000,0);
END_FUZZIFY
DEFUZZIFY u
  TERM a := TRIAN 0 1 2;
  TERM b := TRIAN 1 2 3;
  METHOD : COG;
  DEFAULT := 0;
END_DEFUZZIFY
RULEBLOCK r
  AND : MIN;
  ACT : MIN;
  ACCU : MAX;
  RULE 1 : IF x IS low THEN u IS a;
  RULE 2 : IF x IS mid THEN u IS b;
END_RULEBLOCK
END_FUNCTION_BLOCK
"""


class TestTermsThatAreZeroEverywhere:
    def test_one_of_an_input_is_read_and_widens_the_range(self):
        system, found = read("q.fcl", EMPTY)
        assert {d.severity for d in found} == {"warning"}
        assert "the term is 0 everywhere, so that no value belongs to it" in {d.message for d in found}
        assert system.number(system.inputs[0].upper) == 1000.0
        without = read("q.fcl", EMPTY.replace("  TERM fake := (0,0) (1000,0);\n", ""))[0]
        assert without.number(without.inputs[0].upper) == 700.0
        for x in (-3.0, 0.0, 130.0, 500.0, 800.0):
            assert system(x=x) == without(x=x)

    def test_a_rule_that_names_it_never_fires(self):
        system, _ = read("q.fcl", EMPTY.replace("x IS mid", "x IS fake"))
        assert system(x=600.0) == 0.0
        assert system(x=200.0) == pytest.approx(1.0, abs=1e-3)

    def test_one_of_an_output_is_a_mistake(self):
        _, found = read("q.fcl", EMPTY.replace("TERM b := TRIAN 1 2 3", "TERM b := (0,0) (3,0)"))
        assert [d.code for d in found if d.severity == "error"] == ["FZ302"]

    def test_another_input_does_not_take_its_range(self):
        text = EMPTY.replace("x: REAL;", "x: REAL;\n  y: REAL;")
        system, _ = read("q.fcl", text)
        assert [system.number(v.upper) for v in system.inputs] == [1000.0, 1.0]


HYBRID = """\
#Code automatically generated with fuzzylite 6.0.

[System]
Name='fan'
Type='hybrid'
Version=6.0
NumInputs=1
NumOutputs=2
NumRules=4
AndMethod='prod'
OrMethod='probor'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='heat'
Range=[0.000 10.000]
NumMFs=2
MF1='cold':'trapmf',[0.000 0.000 2.500 7.500]
MF2='hot':'trapmf',[2.500 7.500 10.000 10.000]

[Output1]
Name='speed'
Range=[0.000 30.000]
NumMFs=2
MF1='low':'trimf',[0.000 5.000 10.000]
MF2='high':'trimf',[20.000 25.000 30.000]

[Output2]
Name='level'
Range=[0.000 30.000]
NumMFs=2
MF1='low':'constant',[5.000]
MF2='high':'constant',[25.000]

[Rules]
1.000 , 1.000 0.000 (1.000) : 1
2.000 , 2.000 0.000 (1.000) : 1
1.000 , 0.000 1.000 (1.000) : 1
2.000 , 0.000 2.000 (1.000) : 1
"""


class TestFilesOfFuzzylite:
    def test_numbers_under_one_centroid_are_averaged_which_fuzzylite_does_not(self):
        system, (warning,) = read("fan.fis", HYBRID)
        assert (warning.code, warning.severity) == ("FZ609", "warning")
        assert warning.message == "the terms of 'level' are numbers or functions; their weighted average is taken"
        assert warning.facts[0].startswith("fuzzylite takes their centroid as sets")
        assert system(heat=9)["level"] == 25.0

    def test_a_rule_without_a_condition_is_read_otherwise_by_fuzzylite(self):
        text = HYBRID.replace("1.000 , 0.000 1.000", "0.000 , 0.000 1.000").replace("hybrid", "mamdani")
        text = text.replace("2.000 , 0.000 2.000 (1.000) : 1\n", "").replace("NumRules=4", "NumRules=3")
        text = text.replace("'constant',[5.000]", "'trimf',[0 5 10]").replace(
            "'constant',[25.000]", "'trimf',[20 25 30]"
        )
        _, found = read("fan.fis", text)
        (warning,) = (d for d in found if d.code == "FZ609")
        assert warning.message == "the rule has no condition, so it always acts"
        assert warning.facts == ("fuzzylite leaves such a rule out; what only such rules set is 'nan' there",)
        by_matlab = text.replace("#Code automatically generated with fuzzylite 6.0.", "").replace(
            "Version=6.0", "Version=2.0"
        )
        assert "FZ609" not in {d.code for d in read("fan.fis", by_matlab)[1]}

    def test_both_are_systems_that_can_be_printed_and_read_again(self):
        system, _ = read("fan.fis", HYBRID)
        assert loads(dumps(system))(heat=4) == system(heat=4)

    def test_what_fuzzylite_makes_of_the_average_in_a_written_file_is_a_loss(self):
        system, _ = read("fan.fis", HYBRID)
        text, losses = FORMATS["fis"].write(system)
        assert "Type='hybrid'" in text
        assert [loss.where for loss in losses if loss.what == "defuzzifier weighted_average"] == ["output 'level'"]
