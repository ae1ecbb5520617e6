import pytest
from click.testing import CliRunner

from fuzzyctl.cli.main import main
from tests.bench import startup

TWO = """system {name}
aggregation sum
param k = {k}
input x in [0, 1]
  a = ramp(0, k)
output y in [0, 1] else 0
  b = triangle(0, 1, 1)
  c = triangle(0, 0, 1)
if x is a then y is b
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.fz").write_text(TWO.format(name="s", k=1), encoding="utf-8")
    (tmp_path / "two.fz").write_text(TWO.format(name="s", k=1) + TWO.format(name="t", k=1), encoding="utf-8")
    halving = TWO.format(name="s", k=1).replace("aggregation", "defuzzifier bisector\naggregation")
    (tmp_path / "half.fz").write_text(halving, encoding="utf-8")
    (tmp_path / "bad.fz").write_text(TWO.format(name="s", k=0), encoding="utf-8")
    return lambda *arguments: CliRunner().invoke(main, arguments)


ONE_SYSTEM = [
    ["eval", "x=0.5"],
    ["why", "x=0.5"],
    ["prove", "--bounds"],
    ["plot", "--terms"],
    ["convert", "-", "--to", "fz"],
]
ALL_SYSTEMS = [["show"], ["prove"]]


class TestChoice:
    @pytest.mark.parametrize("command", ONE_SYSTEM, ids=lambda c: c[0])
    def test_commands_on_one_system_ask_which(self, run, command):
        found = run(command[0], "two.fz", *command[1:])
        assert found.exit_code == 2
        assert "the file holds several systems, and none is chosen" in found.output
        assert run(command[0], "two.fz", *command[1:], "--block", "t").exit_code == 0

    @pytest.mark.parametrize("command", ALL_SYSTEMS, ids=lambda c: c[0])
    def test_the_others_take_all_or_the_one_named(self, run, command):
        assert run(*command, "two.fz").exit_code == 0
        assert run(*command, "two.fz", "--block", "t").exit_code == 0
        assert "the file holds no block 'u'" in run(*command, "two.fz", "--block", "u").output


class TestSettings:
    @pytest.mark.parametrize("command", [*ONE_SYSTEM, *ALL_SYSTEMS, ["codegen", "--target", "c"]], ids=lambda c: c[0])
    def test_a_setting_that_does_not_fit_is_blamed_on_the_command_line(self, run, command):
        found = run(command[0], "one.fz", *command[1:], "--set", "k=0")
        assert found.exit_code == 1
        assert "with --set k=0" in found.output
        assert "help: give --set another value" in found.output

    @pytest.mark.parametrize("command", [["eval", "x=0.5"], *ALL_SYSTEMS], ids=lambda c: c[0])
    def test_a_profile_that_does_not_fit_is_not(self, run, command):
        found = run(command[0], "half.fz", *command[1:], "--set", "k=0.5", "--as", "simpful")
        assert found.exit_code == 1
        assert "FZ214" in found.output
        assert "--set" not in found.output


def test_warnings_are_printed_beside_errors_only_where_one_system_is_wanted(run):
    assert "FZ208" in run("eval", "bad.fz", "x=0.5").output
    assert "FZ208" not in run("show", "bad.fz").output
    for command in ("eval", "show"):
        assert "FZ30" in run(command, "bad.fz").output


def test_both_files_of_a_comparison_report_their_errors(run):
    found = run("compare", "--changes", "bad.fz", "missing.fz")
    assert found.exit_code == 1
    assert "bad.fz" in found.output
    assert "missing.fz" in found.output


POINT = ["service=7", "food=8"]


@pytest.mark.parametrize(
    "command",
    [
        *(["eval", *POINT], ["why", *POINT], ["check"], ["prove"], ["show"], ["codegen", "--target", "c"]),
        ["prove", "--bounds", "--timeout", "0.01"],  # the search takes more than a minute while its calls are counted
    ],
    ids=lambda c: c[0],
)
def test_a_file_is_parsed_and_planned_once(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = startup.walk([command[0], startup.TIPPER, *command[1:]])
    assert found["fuzzyctl/lang/parser.py", "parse"] == 1
    assert found["fuzzyctl/kernels/plan/build.py", "_plan"] == 1
