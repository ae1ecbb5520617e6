import json
from pathlib import Path

import pytest

from fuzzyctl import as_profile, load
from fuzzyctl.model.profiles import PROFILES
from tests.commands import runner

TIPPER = """system tip
input service in [0, 10]
  poor = triangle(-inf, 0, 5)
  good = triangle(5, 10, inf)
output tip in [0, 30]{}
  cheap = triangle(0, 5, 10)
  generous = triangle(20, 25, 30)
if service is poor then tip is cheap
if service is good then tip is generous
require bounded(tip, 0, 30)
"""

run = runner()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "a.fz"
    path.write_text(TIPPER.format(" else 7"))
    return str(path)


def test_each_command_computes_by_the_profile(file, tmp_path):
    of_file = json.loads(run("eval", file, "service=2", "--format", "json").output)
    as_matlab = json.loads(run("eval", file, "service=2", "--format", "json", "--as", "matlab").output)
    assert (of_file["semantics"], as_matlab["semantics"]) == ("exact", "matlab")
    as_left = json.loads(run("eval", file, "service=2", "--format", "json", "--as", "jfuzzylogic").output)
    assert as_left["outputs"]["tip"] != of_file["outputs"]["tip"]
    assert json.loads(run("show", file, "--format", "json", "--as", "octave").output)["knobs"]["merge"] == "places"
    assert (
        json.loads(run("why", file, "service=2", "--format", "json", "--as", "simpful").output)["semantics"]
        == "simpful"
    )
    for command in (("prove", "--bounds"), ("prove",)):
        assert "fuzzylite" in run(*command, file, "--format", "json", "--as", "fuzzylite").output
    for command in (("plot-surface",), ("plot", "--terms")):
        result = run(*command, file, "--as", "matlab", "-o", str(tmp_path / f"{command[0]}.svg"))
        assert result.exit_code == 0, result.output
    out = tmp_path / "c"
    result = run("codegen", file, "--target", "c", "-o", str(out), "--as", "matlab", "--format", "json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.output)["semantics"] == "matlab"


def test_a_file_with_gaps_is_evaluated_as_its_tool_does(tmp_path):
    path = tmp_path / "gap.fz"
    path.write_text(TIPPER.format(""))
    assert "FZ401" in run("eval", str(path), "service=5").output
    assert run("eval", str(path), "service=5", "--as", "matlab").output == "tip = 15.0\n"
    assert run("eval", str(path), "service=5", "--as", "simpful").output == "tip = 0.0\n"


def test_what_is_no_profile_is_wrong_usage(file):
    result = run("eval", file, "service=2", "--as", "matlap")
    assert result.exit_code == 2
    assert "did you mean 'matlab'" in result.output


def test_a_system_that_a_tool_cannot_evaluate_is_refused_with_the_reason(file, tmp_path):
    path = tmp_path / "sugeno.fz"
    path.write_text(TIPPER.format(" else 7").replace("\ninput", "\ndefuzzifier weighted_average\ninput", 1))
    result = run("eval", str(path), "service=2", "--as", "scikit_fuzzy")
    assert result.exit_code == 1
    assert "scikit-fuzzy 0.5 has no 'weighted_average'" in result.output


BLOCK = """
rules night and product implication product
if service is good and service is poor then tip is cheap
"""


class TestRuleBlocks:
    """Norms stay under every profile; that a tool has none of its own for a block is said."""

    @pytest.fixture
    def blocks(self, tmp_path):
        path = tmp_path / "blocks.fz"
        path.write_text(TIPPER.format(" else 7") + BLOCK)
        return str(path)

    @pytest.mark.parametrize("command", [["eval", "service=2"], ["check"], ["show"], ["why", "service=2"]])
    def test_a_tool_without_blocks_gets_a_hint(self, blocks, command):
        result = run(command[0], blocks, *command[1:], "--as", "matlab")
        assert result.exit_code == 0, result.output
        assert "blocks.fz:12:7: hint[FZ609]" in result.output
        assert "leaves rule block 'night' its own conjunction product, implication product" in result.output

    @pytest.mark.parametrize(("own", "named"), [("fuzzylite_6", "fuzzylite"), ("octave_0_4", "octave")])
    def test_another_version_of_the_own_tool_gets_a_hint(self, tmp_path, own, named):
        path = tmp_path / "tip.fz"
        path.write_text(f"semantics {own}\n{TIPPER.format(' else 7')}")
        versions = [PROFILES[p].tool for p in (named, own)]
        result = run("eval", str(path), "service=2", "--as", named)
        assert f"profile '{named}' computes as {versions[0]}, and 'tip' is of {versions[1]}" in result.output
        assert f"leave the profile out, or name '{own}'" in result.output
        assert "FZ609" not in run("eval", str(path), "service=2", "--as", own).output
        assert "FZ609" not in run("eval", str(path), "service=2", "--as", "pyfuzzylite").output

    @pytest.mark.parametrize("profile", ["exact", "fuzzylite", "fuzzylite_6", "pyfuzzylite", "jfuzzylogic"])
    def test_a_tool_with_blocks_does_not(self, blocks, profile):
        assert "FZ609" not in run("eval", blocks, "service=2", "--as", profile).output

    def test_a_block_whose_norms_are_those_of_the_system_does_not(self, blocks):
        path = Path(blocks)
        path.write_text(path.read_text().replace(" and product implication product", " and min"))
        assert "FZ609" not in run("eval", blocks, "service=2", "--as", "matlab").output

    def test_each_side_of_a_comparison_is_said(self, blocks):
        result = run("compare", blocks, "--as", "simpful,exact,octave", "--points", "10")
        reported = [f"'{name}' leaves rule block" in result.output for name in ("simpful", "octave", "exact")]
        assert reported == [True, True, False]

    def test_the_numbers_are_those_of_the_block(self, blocks):
        system = load(blocks)
        assert as_profile(system, "matlab").rule_methods == system.rule_methods


class TestCheck:
    """What is proved depends on numerics; what is wrong with the text does not."""

    @pytest.fixture
    def gap(self, tmp_path):
        path = tmp_path / "gap.fz"
        path.write_text(TIPPER.format(""))
        return str(path)

    def test_a_gap_is_an_error_where_the_tool_has_no_value_for_it(self, gap):
        for profile in ((), ("--as", "exact")):
            result = run("check", gap, *profile)
            assert result.exit_code == 1
            assert "FZ401" in result.output
        result = run("check", gap, "--as", "matlab")
        assert result.exit_code == 0, result.output
        assert "gap.fz: tip: 2 rules, no errors" in result.output

    def test_a_guarantee_is_refuted_by_the_numbers_of_the_tool(self, gap):
        # Where no rule fires simpful has 0, MATLAB the middle.
        with open(gap, "a") as file:
            file.write("require tip >= 1\n")
        assert run("check", gap, "--as", "matlab").exit_code == 0
        result = run("check", gap, "--as", "simpful", "--format", "json")
        assert result.exit_code == 1
        (found,) = [d for d in json.loads(result.output)["diagnostics"] if d["severity"] == "error"]
        assert (found["code"], found["line"]) == ("FZ402", 11)

    def test_a_system_that_the_tool_cannot_evaluate_is_refused_with_its_file(self, file, tmp_path):
        path = tmp_path / "sugeno.fz"
        path.write_text(TIPPER.format(" else 7").replace("\ninput", "\ndefuzzifier weighted_average\ninput", 1))
        result = run("check", file, str(path), "--as", "scikit_fuzzy")
        assert result.exit_code == 1
        assert f"{path}:6:8: error[FZ214]: profile 'scikit_fuzzy' cannot evaluate output 'tip'" in result.output
        assert f"{file}: tip: 2 rules, no errors" in result.output

    def test_what_is_no_profile_is_wrong_usage(self, file):
        assert run("check", file, "--as", "matlap").exit_code == 2


CIRCLE = """system c
semantics fuzzylite
input x in [0, 10]
  a = triangle(-inf, 0, 10)
  b = triangle(0, 10, inf)
output u in [0, 1]
  n = triangle(0, 0.2, 0.5)
  p = triangle(0.5, 0.8, 1)
output v in [0, 1]
  n = triangle(0, 0.2, 0.5)
  p = triangle(0.5, 0.8, 1)
if x is a then u is n, v is n
if v is n then u is p
if u is n then v is p
if x is b then u is p, v is n
"""


def test_a_circle_that_degrees_may_have_is_an_error_with_its_place_where_values_are_read(tmp_path):
    path = tmp_path / "circle.fz"
    path.write_text(CIRCLE)
    for arguments in (["check", str(path)], ["eval", str(path), "x=3"]):
        assert run(*arguments).exit_code == 0
        result = run(*arguments, "--as", "matlab")
        assert result.exit_code == 1
        assert "circle.fz:13:4: error[FZ217]: outputs depend on each other in a circle" in result.output
        assert "under profile 'matlab'" in result.output


WITHOUT_CONDITION = """[System]
Name='fan'
Type='sugeno'
Version=2.0
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
DefuzzMethod='wtaver'

[Input1]
Name='heat'
Range=[0 10]
NumMFs=1
MF1='low':'trimf',[0 5 10]

[Output1]
Name='power'
Range=[0 30]
NumMFs=2
MF1='low':'constant',[5]
MF2='high':'constant',[25]

[Rules]
0, 1 (1) : 1
0, 2 (1) : 1
"""


class TestRulesWithoutCondition:
    """fuzzylite leaves out rules of a `.fis` file that have no condition; here they act under its profiles, too."""

    @pytest.fixture
    def fan(self, tmp_path):
        path = tmp_path / "fan.fis"
        path.write_text(WITHOUT_CONDITION)
        return str(path)

    @pytest.mark.parametrize("command", [["eval", "heat=5"], ["check"], ["why", "heat=5"]])
    @pytest.mark.parametrize("profile", ["fuzzylite", "fuzzylite_6"])
    def test_each_is_reported_under_a_profile_of_fuzzylite(self, fan, command, profile):
        result = run(command[0], fan, *command[1:], "--as", profile)
        assert result.exit_code == 0, result.output
        assert "fan.fis:26:1: warning[FZ609]" in result.output
        assert "fan.fis:27:1: warning[FZ609]" in result.output
        assert f"under profile '{profile}' it acts all the same" in result.output
        assert "leaves such a rule out; what only such rules set is 'nan' there" in result.output

    def test_a_comparison_reports_them(self, fan):
        result = run("compare", fan, "--as", "matlab,fuzzylite", "--points", "10")
        assert "fan.fis:26:1: warning[FZ609]" in result.output

    def test_other_profiles_act_so_themselves(self, fan):
        assert "FZ609" not in run("eval", fan, "heat=5").output
        assert "FZ609" not in run("eval", fan, "heat=5", "--as", "octave").output

    def test_a_file_of_fuzzylite_reports_them_once(self, fan):
        path = Path(fan)
        path.write_text(
            path.read_text().replace("Version=2.0", "Version=6.0")
            + "#Code automatically generated with fuzzylite 6.0.\n"
        )
        assert run("eval", fan, "heat=5", "--as", "fuzzylite").output.count("warning[FZ609]") == 2

    def test_rule_files_have_a_hedge_that_fuzzylite_has_too(self, tmp_path):
        path = tmp_path / "tip.fz"
        text = TIPPER.format("")
        path.write_text(text.replace(" is ", " is any ", 1))
        result = run("eval", str(path), "service=2", "--as", "fuzzylite")
        assert result.exit_code == 0, result.output
        assert "FZ609" not in result.output
