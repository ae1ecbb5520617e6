"""`fuzzyctl check` on files that are none, without time for coverage, and while a file is edited."""

import json
import shutil

import pytest

from tests.commands import runner
from tests.shipped import SYSTEMS

run = runner("check")
FOLDER = SYSTEMS[0].parent


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(name, content):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize(
    ("content", "code"), [(bytes(range(256)), "FZ002"), (b"x" * 10_000_000, "FZ003"), (b"\xff\xfe", "FZ002")]
)
def test_a_file_that_is_no_rule_file_is_refused(write, content, code):
    result = run(write("a.fz", content))
    assert (result.exit_code, code in result.output) == (1, True)


def test_fixes_keep_the_byte_order_mark_and_line_ends(write):
    mark, right = b"\xef\xbb\xbf", "system s\r\nparam b = 0.8\r\nallow FZ216\r\n"
    path = write("a.fz", mark + right.replace("param b", "b").encode())
    run("--fix", path)
    assert path.read_bytes() == mark + right.encode()


def test_edits_are_data_for_programs_and_code_scanning(write):
    path = write(
        "a.fz",
        "system t;\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1] else 0\n  terms p q\nif x is a then y is p\n",
    )
    first = json.loads(run("--format", "json", path).stdout)["diagnostics"][0]
    edit = {"line": 1, "column": 9, "end_line": 1, "end_column": 10, "text": ""}
    assert first["fix"] == {"applicability": "sure", "edits": [edit]}
    result = json.loads(run("--format", "sarif", path).stdout)["runs"][0]["results"][0]
    (change,) = result["fixes"][0]["artifactChanges"]
    region = {"startLine": 1, "startColumn": 9, "endLine": 1, "endColumn": 10}
    assert change["replacements"] == [{"deletedRegion": region, "insertedContent": {"text": ""}}]


#: Commands that need a number, with their other words.
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
    """FZ407: exit code 3 of `check`, a warning of other commands, and not reported if the file allows it."""

    TEXT = (
        "system t\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  low = gaussian(0, 1)\n"
        "  high = gaussian(1, 1)\noutput u in [0, 1]\n  terms a=0 b=1\n"
        "if x is not low then u is a\nif x is high then u is b\nrequire u >= 0\n"
    )

    @pytest.fixture(autouse=True)
    def _without_work(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.coverage.coverage.COVERAGE", 10)

    @pytest.mark.parametrize(
        ("options", "code"),
        [([], 3), (["-q"], 3), (["--allow", "FZ407"], 0), (["--deny", "FZ407"], 1), (["--deny", "warnings"], 1)],
    )
    @pytest.mark.parametrize(
        ("form", "part"),
        [
            ("text", "a.fz: t: 2 rules, no errors; coverage not decided\n"),
            ("json", '"severity": "warning"'),
            ("sarif", '"level": "warning"'),
            ("github", "::warning file=a.fz,"),
        ],
    )
    def test_has_one_exit_code_in_each_format(self, write, options, code, form, part):
        write("a.fz", self.TEXT)
        result = run("--format", form, *options, "a.fz")
        assert result.exit_code == code
        assert (part in result.stdout) == (code == 3 and (form == "text" or not options))

    def test_counts_less_than_an_error_and_more_than_a_clean_file(self, write, base):
        undecided = write("a.fz", self.TEXT)
        assert run(undecided, write("b.fz", base)).exit_code == 3
        assert run(undecided, write("c.fz", base.replace("N  Z", "N  Y", 1))).exit_code == 1

    def test_of_one_system_is_reported_for_that_system(self, write):
        other = self.TEXT.replace("system t", "system s").replace("output u in [0, 1]", "output u in [0, 1] else 0")
        lines = run(write("a.fz", self.TEXT + other)).stdout.splitlines()
        assert [line.partition(": ")[2] for line in lines] == [
            "t: 2 rules, no errors; coverage not decided",
            "s: 2 rules, no errors",
        ]

    @pytest.mark.parametrize(("line", "code"), [("", 0), ("allow", 0), ("deny", 1)])
    @pytest.mark.parametrize("command", ["check", *COMMANDS])
    def test_follows_the_lines_of_the_file_and_is_a_warning_of_other_commands(self, write, command, line, code):
        write("a.fz", f'{line} FZ407 "known"\n{self.TEXT}' if line else self.TEXT)
        result = runner()(*command.split(), "a.fz", *COMMANDS.get(command, []))
        assert result.exit_code == (code if line or command != "check" else 3)
        assert ("FZ407" in result.stderr) == (line != "allow")


class TestWatch:
    @pytest.fixture
    def path(self, tmp_path):
        return shutil.copy(FOLDER / "tipper.fz", tmp_path / "tip.fz")

    @pytest.fixture
    def saves(self, monkeypatch):
        """Return a function that takes what happens while the command waits, step by step, then Ctrl-C."""

        def happen(*steps):
            rest = iter(steps)

            def wait(_seconds):
                step = next(rest, None)
                if step is None:
                    raise KeyboardInterrupt
                step()

            monkeypatch.setattr("fuzzyctl.cli.check.time.sleep", wait)

        return happen

    def watch(self, *words):
        return run("--watch", *words)

    def test_each_save_is_checked_evaluated_and_drawn(self, path, saves, tmp_path):
        picture = tmp_path / "tip.png"
        text = path.read_text()
        sizes = []

        def break_it():
            sizes.append(picture.stat().st_size)
            path.write_text(text.replace("excellent", "excelent", 1))

        def mend_it():
            assert picture.stat().st_size == sizes[0]
            path.write_text(text.replace("[0, 30]", "[0, 40]"))

        saves(lambda: None, break_it, lambda: None, mend_it)
        result = self.watch(path, "service=7", "food=8", "-o", picture)
        assert result.exit_code == 0
        assert result.stdout.count("tip = ") == 2
        assert result.stdout.count("tip.fz: tipper: 3 rules, no errors") == 2
        assert result.stderr.count("has no term") == 1

    def test_a_file_that_it_uses_counts(self, saves, tmp_path):
        used, path = tmp_path / "shared.fz", tmp_path / "a.fz"
        used.write_text("input x in [0, 1]\n  terms N P\n")
        path.write_text('system t\nuse "shared.fz"\noutput y in [0, 1] else 0\n  terms a b\nif x is N then y is a\n')
        saves(lambda: used.write_text("input x in [0, 2]\n  terms N P Q\n"), lambda: None)
        assert self.watch(path).stdout.count("t: 1 rule, no errors") == 2

    def test_a_file_that_vanishes_comes_back(self, path, saves):
        text = path.read_text()
        saves(path.unlink, lambda: path.write_text(text))
        result = self.watch(path)
        assert (result.exit_code, result.stdout.count("no errors"), "tip.fz" in result.stderr) == (0, 2, True)

    def test_loops_are_run(self, saves, tmp_path):
        saves()
        result = self.watch("water_tank", "--block", "fill", "-o", tmp_path / "out")
        assert "overshoot" in result.stdout
        assert (tmp_path / "out" / "summary.json").is_file()

    def test_wrong_usage(self, saves, tmp_path):
        assert self.watch(tmp_path / "none.fz").exit_code == 1
        saves()
        assert self.watch("water_tank", "service=1", "--block", "fill").exit_code == 2

    def test_a_guarantee_that_does_not_hold_stops_no_picture(self, path, saves, tmp_path):
        picture = tmp_path / "tip.png"
        path.write_text(path.read_text().replace("bounded(tip, 0, 30)", "bounded(tip, 0, 20)"))
        saves(lambda: None)
        result = self.watch(path, "service=7", "food=8", "-o", picture)
        assert "tip = 20.3" in result.stdout
        assert result.stderr.count("the guarantee 'bounded(tip, 0, 20)' does not hold") == 1
        assert picture.is_file()
