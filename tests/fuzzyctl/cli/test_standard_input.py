"""'-' as a file, warnings that are printed once, and `--quiet`."""

import json

import pytest

from fuzzyctl.cli.main import main
from tests.commands import runner

#: Each command that reads a rule file, with what else it takes.
COMMANDS = {
    "check": [],
    "show": [],
    "prove": [],
    "prove --bounds": [],
    "eval": ["x=0.5", "y=3"],
    "why": ["x=0.5", "y=3"],
    "page": ["-o", "x.html"],
    "plot --terms": ["-o", "terms.svg"],
    "plot": ["-o", "surface.svg", "--resolution", "5"],
    "plot-surface": ["-z", "u", "--resolution", "5", "-o", "surface.svg"],
    "codegen": ["--target", "python", "-o", "code"],
    "convert": ["out.fz"],
    "compare": ["--as", "exact,matlab", "--points", "50"],
}
#: Those that print the warnings of the file.
WARNING = [c for c in COMMANDS if c not in ("show", "prove")]


@pytest.fixture
def base(base):
    """A file whose bounds are exact, so that no search goes on to its time limit."""
    return base.replace("\ninput x", "\nand product\ndefuzzifier center_average\n\ninput x", 1)


@pytest.fixture
def spare(base):
    """A file with a warning: nothing uses its param."""
    return base + "param spare = 0\nrequire u <= 2\n"


run = runner()


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


class TestStandardInput:
    @pytest.mark.parametrize("command", COMMANDS)
    def test_gives_what_the_file_gives(self, tmp_path, base, command):
        (tmp_path / "a.fz").write_text(base)
        from_file = run(*command.split(), "a.fz", *COMMANDS[command])
        (tmp_path / "out.fz").unlink(missing_ok=True)
        piped = run(*command.split(), "-", *COMMANDS[command], stdin=base)
        assert piped.exit_code == from_file.exit_code == 0
        assert piped.output.replace("<stdin>", "a.fz").replace("-  and", "a.fz  and").replace("- as", "a.fz as") == (
            from_file.output
        )

    def test_is_a_file_for_every_command_that_reads_one(self):
        # A sweep and a watch name their files, the language server is given texts, and the studio serves until Ctrl-C.
        others = {"new", "explain", "doctor", "lsp", "studio", "sweep"}
        assert set(main.list_commands(None)) - others == {*(c.split()[0] for c in COMMANDS), "fmt", "simulate"}

    def test_has_its_name_in_diagnostics(self, base):
        result = run("check", "-", stdin=base.replace("N  Z", "N  Y", 1))
        assert result.exit_code == 1
        assert "<stdin>:21:11: error[FZ203]" in result.output

    def test_uses_files_of_the_current_folder(self, tmp_path, base):
        head, rest = base.split("input y")
        (tmp_path / "part.fz").write_text("input y" + rest.split("output u")[0])
        text = f'{head}use "part.fz"\noutput u' + rest.split("output u")[1]
        assert run("check", "-", stdin=text).output == "<stdin>: base: 6 rules, no errors\n"

    @pytest.mark.parametrize("command", ["compare --changes", "compare"])
    def test_is_one_of_two_files(self, tmp_path, base, command):
        (tmp_path / "a.fz").write_text(base)
        changed = base.replace("triangle(0, 2, 3)", "triangle(0, 1, 3)")
        options = ["--points", "50"] if command == "compare" else []
        (tmp_path / "b.fz").write_text(changed)
        expected = run(*command.split(), "a.fz", "b.fz", *options)
        assert expected.stdout.count("\n") == 1 if "--changes" in command else "no difference" not in expected.stdout
        for files, text, name in ((["-", "b.fz"], base, "a.fz"), (["a.fz", "-"], changed, "b.fz")):
            piped = run(*command.split(), *files, *options, stdin=text)
            assert piped.exit_code == expected.exit_code
            assert piped.stdout == expected.stdout.replace(name, "-")

    def test_of_a_diff_has_its_mistakes_reported_with_those_of_the_file(self, tmp_path, base):
        (tmp_path / "a.fz").write_text(base.replace("[0, 10]", "[0, q]"))
        result = run("compare", "--changes", "-", "a.fz", stdin=base.replace("N  Z", "N  Y", 1))
        assert result.exit_code == 1
        for part in ("<stdin>:21:11: error[FZ203]", "a.fz:11:16: error[FZ202]"):
            assert part in result.stderr

    def test_of_a_diff_may_hold_several_systems(self, tmp_path, base):
        (tmp_path / "a.fz").write_text(base)
        two = base + base.replace("system base", "system other")
        assert run("compare", "--changes", "-", "a.fz", "--block", "base", stdin=two).exit_code == 0
        result = run("compare", "--changes", "-", "a.fz", stdin=two)
        assert result.exit_code == 2
        assert "<stdin>: error[FZ502]: system 'other'" in result.stderr

    def test_of_a_diff_has_its_allowed_codes_compared(self, tmp_path, base):
        (tmp_path / "a.fz").write_text(base)
        assert "+ diagnostic FZ208" in run("compare", "--changes", "a.fz", "-", stdin=f"{base}allow FZ208\n").stdout

    @pytest.mark.parametrize(
        "arguments",
        [["eval", "-", "--points", "-"], ["compare", "-", "-"], ["compare", "--changes", "-", "-"], ["fmt", "-", "-"]],
    )
    def test_is_read_once(self, base, arguments):
        result = run(*arguments, stdin=base)
        assert result.exit_code == 2
        assert "'-' is given twice" in result.output

    def test_is_bounded_as_files_are(self):
        result = run("check", "-", stdin=" " * ((1 << 20) + 1))
        assert result.exit_code == 1
        assert "FZ003" in result.output


class TestWarnings:
    @pytest.mark.parametrize("command", WARNING)
    def test_are_printed_once(self, tmp_path, spare, command):
        (tmp_path / "a.fz").write_text(spare)
        assert run(*command.split(), "a.fz", *COMMANDS[command]).output.count("warning[FZ216]") == 1

    def test_of_a_file_that_is_given_twice_are_printed_once(self, tmp_path, spare):
        (tmp_path / "a.fz").write_text(spare)
        assert run("compare", "a.fz", "a.fz", "--points", "50").output.count("warning[FZ216]") == 1
        checked = run("check", "a.fz", "a.fz").output
        assert checked.count("warning[FZ216]") == checked.count("no errors") == 1
        assert "0 errors, 1 warning\n" in checked
        assert run("prove", "a.fz", "a.fz").output.count("proved: ") == 1

    def test_are_printed_again_by_the_next_command(self, tmp_path, spare):
        (tmp_path / "a.fz").write_text(spare)
        assert all("warning[FZ216]" in run("eval", "a.fz", "x=0", "y=0").output for _ in range(2))

    @pytest.mark.parametrize("option", ["-q", "--quiet"])
    @pytest.mark.parametrize("command", WARNING)
    def test_are_not_printed_where_a_command_is_quiet(self, tmp_path, spare, command, option):
        (tmp_path / "a.fz").write_text(spare)
        result = run(*command.split(), "a.fz", *COMMANDS[command], option)
        assert result.exit_code == 0
        assert "warning" not in result.output

    def test_of_values_out_of_range_are_not_printed_either(self, tmp_path, base):
        (tmp_path / "a.fz").write_text(base)
        assert "FZ504" in run("eval", "a.fz", "x=5", "y=0").output
        assert run("eval", "-q", "a.fz", "x=5", "y=0").output.startswith("u = ")


class TestQuiet:
    def test_prints_errors_and_counts_what_it_prints(self, tmp_path, spare):
        (tmp_path / "a.fz").write_text(spare + "param other = missing\n")
        result = run("check", "-q", "a.fz")
        assert result.exit_code == 1
        assert "FZ216" not in result.output
        assert result.output.endswith("\n1 error, 0 warnings\n")

    def test_prints_warnings_that_are_denied(self, tmp_path, spare):
        (tmp_path / "a.fz").write_text(spare)
        result = run("check", "-q", "--deny", "warnings", "a.fz")
        assert result.exit_code == 1
        assert "error[FZ216]" in result.output

    def test_leaves_warnings_out_of_reports_too(self, tmp_path, spare):
        (tmp_path / "a.fz").write_text(spare)
        assert json.loads(run("check", "--format", "json", "-q", "a.fz").output) == {"diagnostics": []}
