"""Files of fuzzylite are evaluated as the version computes them that wrote them; versions differ in their samples."""

import pytest

from fuzzyctl import as_profile, loads
from tests.fuzzyctl.formats.files import write

FCL = """\
//Code automatically generated with fuzzylite {version}.

FUNCTION_BLOCK hvac

VAR_INPUT
  temp: REAL;
END_VAR

VAR_OUTPUT
  fan: REAL;
END_VAR

FUZZIFY temp
  RANGE := (10.000 .. 40.000);
  TERM mild := Triangle 18.000 23.000 28.000;
  TERM hot := SShape 24.000 32.000;
END_FUZZIFY

DEFUZZIFY fan
  RANGE := (0.000 .. 100.000);
  TERM half := Triangle 20.000 50.000 80.000;
  TERM full := Triangle 70.000 100.000 100.000;
  METHOD : COG;
  ACCU : MAX;
  DEFAULT := nan;
END_DEFUZZIFY

RULEBLOCK comfort
  AND : MIN;
  OR : MAX;
  ACT : MIN;
  RULE 1 : if temp is mild then fan is half
  RULE 2 : if temp is hot then fan is full with 0.8
END_RULEBLOCK

END_FUNCTION_BLOCK
"""

FIS = """\
#Code automatically generated with fuzzylite {version}.

[System]
Name='hvac'
Type='mamdani'
Version={version}
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='temp'
Range=[10.000 40.000]
NumMFs=2
MF1='mild':'trimf',[18.000 23.000 28.000]
MF2='hot':'smf',[24.000 32.000]

[Output1]
Name='fan'
Range=[0.000 100.000]
NumMFs=2
MF1='half':'trimf',[20.000 50.000 80.000]
MF2='full':'trimf',[70.000 100.000 100.000]

[Rules]
1.000 , 1.000 (1.000) : 1
2.000 , 2.000 (0.800) : 1
"""

FLL = """\
#Code automatically generated with fuzzylite {version}.

Engine: hvac
InputVariable: temp
  range: 10.000 40.000
  term: mild Triangle 18.000 23.000 28.000
  term: hot SShape 24.000 32.000
OutputVariable: fan
  range: 0.000 100.000
  aggregation: Maximum
  defuzzifier: Centroid
  default: nan
  term: half Triangle 20.000 50.000 80.000
  term: full Triangle 70.000 100.000 100.000
RuleBlock: comfort
  conjunction: Minimum
  disjunction: Maximum
  implication: Minimum
  activation: General
  rule: if temp is mild then fan is half
  rule: if temp is hot then fan is full with 0.8
"""

FORMATS = {"fcl": FCL, "fis": FIS, "fll": FLL}


@pytest.mark.parametrize("format", FORMATS)
class TestVersions:
    def test_version_6_takes_a_hundred_samples(self, format):
        system = loads(FORMATS[format].format(version="6.0"), f"hvac.{format}")
        assert system.method.semantics.profile == "fuzzylite_6"
        # As fuzzylite 6.0 computes it of any of these files.
        assert system(temp=27) == pytest.approx(62.440469973890394, rel=1e-12)

    @pytest.mark.parametrize(("version", "samples"), [("4.0", 200), ("5.1", 200), ("6.0", 100), ("7.0", 1000)])
    def test_each_version_takes_its_own_samples_where_the_file_says_none(self, format, version, samples):
        system = loads(FORMATS[format].format(version=version), f"hvac.{format}")
        assert system.method.defuzzifier.resolution == samples
        assert system.method.semantics.profile == ("fuzzylite" if samples == 1000 else "fuzzylite_6")


@pytest.mark.parametrize("other", ["fuzzylite", "pyfuzzylite"])
def test_a_number_that_a_file_says_stays_when_another_version_computes(other):
    text = FLL.format(version="6.0").replace("Centroid", "Centroid 100")
    assert as_profile(loads(text, "hvac.fll"), other).method.defuzzifier.resolution == 100


def test_samples_are_written_so_that_every_version_takes_as_many():
    exact = as_profile(loads(FLL.format(version="7.0"), "hvac.fll"), "exact")
    assert exact.method.defuzzifier.resolution is None
    text, _ = write("fll", exact)
    assert "  defuzzifier: Centroid 1000\n" in text
