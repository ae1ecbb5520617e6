import json

import pytest

from tests.commands import runner

run = runner("check")


@pytest.fixture
def write(tmp_path):
    def write(name, content):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


class TestCheck:
    def test_a_clean_file_says_what_it_holds(self, write, base):
        result = run(write("a.fz", base))
        assert result.exit_code == 0
        assert "a.fz: base: 6 rules, no errors" in result.output

    def test_one_rule_is_counted_as_one(self, write):
        text = (
            "system t\ninput e in [0, 1]\n  terms N P\noutput u in [0, 1] else 0\n  terms a b\nif e is N then u is a\n"
        )
        assert "a.fz: t: 1 rule, no errors" in run(write("a.fz", text)).output

    def test_all_mistakes_of_all_files_are_printed(self, write, base, changed):
        a = write("a.fz", changed(("Z |  N  P", "Z |  N  Q"), ("[0, 10]", "[0, q]")))
        b = write("b.fz", "sytem b\n")
        result = run(a, b, write("c.fz", base))
        assert result.exit_code == 1
        for part in (
            "a.fz:8:16: error[FZ202]",
            "a.fz:19:11: error[FZ203]",
            "b.fz:1:1: error[FZ101]",
            "b.fz:1:7: error[FZ212]",
            "4 errors",
            "c.fz: base",
        ):
            assert part in result.output

    def test_warnings_pass(self, write, changed):
        result = run(write("a.fz", changed(("\ninput x", "\nparam k = 1\ninput x"))))
        assert result.exit_code == 0
        assert "warning[FZ216]" in result.output
        assert "0 errors, 1 warning" in result.output

    def test_json_is_json(self, write, changed):
        result = run(write("a.fz", changed(("Z |  N  P", "Z |  N  Q"))), "--format", "json")
        (diagnostic,) = json.loads(result.output)["diagnostics"]
        assert (diagnostic["code"], diagnostic["line"], diagnostic["column"]) == ("FZ203", 19, 11)
        assert result.exit_code == 1

    @pytest.mark.parametrize(
        ("content", "code"),
        [(b"", "FZ004"), (bytes(range(256)), "FZ002"), (b"x" * 10_000_000, "FZ003"), (b"\xff\xfe", "FZ002")],
    )
    def test_what_is_no_rule_file_is_refused_without_traceback(self, write, content, code):
        result = run(write("a.fz", content))
        assert result.exit_code == 1
        assert code in result.output
        assert "Traceback" not in result.output

    def test_a_missing_file_and_a_directory_are_refused(self, tmp_path):
        result = run(tmp_path / "no.fz", tmp_path)
        assert result.exit_code == 1
        assert result.output.count("FZ001") == 2

    def test_a_hole_in_the_rules_is_found_with_a_point_in_it(self, write, changed):
        result = run(write("a.fz", changed(("N |  N  Z", "N |  .  Z"))))
        assert result.exit_code == 1
        assert "FZ401" in result.output
        assert "x = -1, y = 0" in result.output

    def test_no_file_is_wrong_usage(self):
        assert run().exit_code == 2


WARNING = ("\ninput x", "\nparam k = 1\nparam j = 2\ninput x")


class TestPolicy:
    def test_warnings_can_be_made_to_fail(self, write, changed):
        path = write("a.fz", changed(WARNING))
        result = run(path, "--deny", "warnings")
        assert result.exit_code == 1
        assert "2 errors, 0 warnings" in result.output
        assert "no errors" not in result.output

    def test_one_code_can_be_denied(self, write, changed):
        path = write("a.fz", changed(WARNING))
        assert run(path, "--deny", "FZ208").exit_code == 0
        assert run(path, "--deny", "FZ208", "--deny", "FZ216").exit_code == 1

    def test_one_code_can_be_allowed(self, write, changed):
        result = run(write("a.fz", changed(WARNING)), "--allow", "FZ216")
        assert result.exit_code == 0
        assert "FZ216" not in result.output

    def test_an_allowed_code_is_no_warning_that_fails(self, write, changed):
        path = write("a.fz", changed(WARNING))
        assert run(path, "--deny", "warnings", "--allow", "FZ216").exit_code == 0
        assert run(path, "--deny", "FZ216", "--allow", "FZ216").exit_code == 1

    def test_errors_cannot_be_allowed(self, write, changed):
        assert run(write("a.fz", changed(("Z |  N  P", "Z |  N  Q"))), "--allow", "FZ203").exit_code == 1

    def test_lines_of_the_file_come_first(self, write, changed):
        allowed = write("a.fz", changed(WARNING, after='allow FZ216 "kept for later"\n'))
        assert run(allowed, "--deny", "warnings").exit_code == 0
        denied = write("b.fz", changed(WARNING, after="deny FZ216\n"))
        assert run(denied, "--allow", "FZ216").exit_code == 1

    def test_an_unknown_code_is_wrong_usage(self, write, base):
        result = run(write("a.fz", base), "--deny", "FZ2160")
        assert result.exit_code == 2
        assert "did you mean 'FZ216'?" in result.output
        assert run(write("a.fz", base), "--allow", "warnings").exit_code == 2


class TestFormats:
    def test_sarif_is_one_log_for_all_files(self, write, changed, base):
        a = write("a.fz", changed(("Z |  N  P", "Z |  N  Q")))
        result = run(a, write("b.fz", base), write("c.fz", "sytem c\n"), "--format", "sarif")
        assert result.exit_code == 1
        (log,) = json.loads(result.stdout)["runs"]
        assert [r["ruleId"] for r in log["results"]] == ["FZ203", "FZ101", "FZ212"]

    def test_github_prints_commands_and_nothing_else(self, write, changed, base):
        a = write("a.fz", changed(WARNING))
        lines = run(a, write("b.fz", base), "--format", "github").output.splitlines()
        assert [line.split(" ")[0] for line in lines] == ["::warning", "::warning"]
        assert run(write("b.fz", base), "--format", "github").output == ""


class TestStreams:
    @pytest.mark.parametrize(
        ("program", "arguments"),
        [("fuzzyctl", "eval tipper service=1 food=2"), ("fuzzyctl", "--help"), ("dwmr", "--help"), ("dwmr", "show")],
    )
    def test_a_full_disk_is_reported_in_one_line(self, program, arguments):
        import subprocess
        import sys
        from pathlib import Path

        if not Path("/dev/full").exists():
            return
        command = [sys.executable, "-c", f"from {program}.cli.main import main; main()", *arguments.split()]
        with open("/dev/full", "w") as full:
            done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 1
        assert done.stderr == "error: the output cannot be written: No space left on device\n"


#: Each command that needs a number, with what else it takes.
COMMANDS = {
    "prove": [],
    "prove --bounds": [],
    "eval": ["x=0.5"],
    "why": ["x=0.5"],
    "codegen": ["--target", "python"],
    "compare": ["--as", "exact,matlab", "--points", "50"],
    "plot --terms": [],
}


class TestUndecidedCoverage:
    """FZ407: exit code 3 of `check`, a warning of other commands, and not reported where the file allows it."""

    TEXT = (
        "system t\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  low = gaussian(0, 1)\n"
        "  high = gaussian(1, 1)\noutput u in [0, 1]\n  terms a=0 b=1\n"
        "if x is not low then u is a\nif x is high then u is b\nrequire u >= 0\n"
    )

    @pytest.fixture(autouse=True)
    def _without_work(self, monkeypatch, tmp_path):
        monkeypatch.setattr("fuzzyctl.analysis.coverage.coverage.COVERAGE", 10)
        monkeypatch.chdir(tmp_path)

    def test_ends_with_exit_code_3(self, write):
        result = run(write("a.fz", self.TEXT))
        assert result.exit_code == 3
        assert "warning[FZ407]" in result.output
        assert "a.fz: t: 2 rules, no errors; coverage not decided\n" in result.stdout

    def test_says_so_where_it_is_quiet(self, write):
        result = run("-q", write("a.fz", self.TEXT))
        assert (result.exit_code, result.stderr) == (3, "")
        assert "a.fz: t: 2 rules, no errors; coverage not decided\n" in result.stdout

    def test_counts_less_than_an_error_and_more_than_a_clean_file(self, write, base):
        undecided = write("a.fz", self.TEXT)
        assert run(undecided, write("b.fz", base)).exit_code == 3
        assert run(undecided, write("c.fz", base.replace("N  Z", "N  Y", 1))).exit_code == 1

    @pytest.mark.parametrize(
        ("options", "code"),
        [(["--allow", "FZ407"], 0), (["--deny", "FZ407"], 1), (["--deny", "warnings"], 1), (["-q"], 3)],
    )
    @pytest.mark.parametrize("form", ["text", "json", "sarif", "github"])
    def test_has_one_exit_code_in_each_format(self, write, options, code, form):
        assert run("--format", form, *options, write("a.fz", self.TEXT)).exit_code == code

    @pytest.mark.parametrize(
        ("form", "part"),
        [("json", '"severity": "warning"'), ("sarif", '"level": "warning"'), ("github", "::warning file=a.fz,")],
    )
    def test_is_a_warning_for_machines(self, write, form, part):
        write("a.fz", self.TEXT)
        result = run("--format", form, "a.fz")
        assert "FZ407" in result.stdout
        assert part in result.stdout

    def test_of_one_system_is_said_of_that_system(self, write):
        other = self.TEXT.replace("system t", "system s").replace("output u in [0, 1]", "output u in [0, 1] else 0")
        lines = run(write("a.fz", self.TEXT + other)).stdout.splitlines()
        assert [line.partition(": ")[2] for line in lines] == [
            "t: 2 rules, no errors; coverage not decided",
            "s: 2 rules, no errors",
        ]

    @pytest.mark.parametrize("command", COMMANDS)
    def test_is_a_warning_of_other_commands(self, write, command):
        write("a.fz", self.TEXT)
        result = runner()(*command.split(), "a.fz", *COMMANDS[command])
        assert result.exit_code == 0
        assert "warning[FZ407]" in result.stderr

    @pytest.mark.parametrize(("line", "code"), [("allow", 0), ("deny", 1)])
    @pytest.mark.parametrize("command", ["check", *COMMANDS])
    def test_follows_the_lines_of_the_file(self, write, command, line, code):
        write("a.fz", f'{line} FZ407 "known"\n{self.TEXT}')
        result = runner()(*command.split(), "a.fz", *COMMANDS.get(command, []))
        assert result.exit_code == code
        assert ("FZ407" in result.stderr) == bool(code)
