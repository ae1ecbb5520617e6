"""`fuzzyctl compare` and `fuzzyctl compare --changes` as a user types them."""

import json
from pathlib import Path

import pytest

from tests.commands import runner

run = runner()
LOOP = Path(__file__).resolve().parents[3] / "rules" / "loops" / "water_tank.fz"


@pytest.fixture
def files(tmp_path, base, changed):
    first, second = tmp_path / "first.fz", tmp_path / "second.fz"
    first.write_text(base, encoding="utf-8")
    second.write_text(changed(("  Z |  N  P", "  Z |  Z  P"), after="and product\n"), encoding="utf-8")
    return first, second


class TestDiff:
    def test_prints_a_line_for_each_change_and_exits_with_1(self, files):
        result = run("compare", "--changes", *files)
        assert result.exit_code == 1
        assert result.stdout == (
            "~ setting and: min → product   (lines +21)\n~ cell x is Z and y is N then u: N → Z   (lines -19 +19)\n"
        )

    def test_says_that_nothing_was_changed(self, files):
        result = run("compare", "--changes", files[0], files[0])
        assert (result.exit_code, result.stdout) == (0, "nothing was changed\n")

    def test_json_has_the_same(self, files):
        data = json.loads(run("compare", "--changes", *files, "--format", "json").stdout)
        assert [c["what"] for c in data["systems"][0]["changes"]] == ["setting", "cell"]

    @pytest.mark.parametrize(
        ("before", "after", "reported"),
        [
            ("", "allow FZ208", "+ diagnostic FZ208: allow FZ208   (lines +1)"),
            ('allow FZ208 "why"', "", '- diagnostic FZ208: allow FZ208 "why"   (lines -1)'),
            ("allow FZ208", "deny FZ208", "~ diagnostic FZ208: allow FZ208 → deny FZ208   (lines -1 +1)"),
            (
                'allow FZ208 "a"',
                'allow FZ208 "b"',
                '~ diagnostic FZ208: allow FZ208 "a" → allow FZ208 "b"   (lines -1 +1)',
            ),
            ("allow FZ208 FZ211", "# FZ211 and more\nallow FZ211\nallow FZ208", ""),
            ("allow FZ208\ndeny FZ208", "deny FZ208", ""),
        ],
    )
    def test_what_the_files_allow_and_deny_is_compared(self, before, after, reported, tmp_path, base):
        paths = [tmp_path / "one.fz", tmp_path / "two.fz"]
        for path, lines in zip(paths, (before, after), strict=True):
            path.write_text(f"{lines}\n{base}", encoding="utf-8")
        result = run("compare", "--changes", *paths)
        assert result.stdout == (f"{reported}\n" if reported else "nothing was changed\n")
        assert result.exit_code == bool(reported)
        data = json.loads(run("compare", "--changes", *paths, "--format", "json").stdout)
        assert [c["name"] for c in data["changes"]] == (["FZ208"] if reported else [])

    def test_systems_are_paired_by_name(self, tmp_path, base):
        two = tmp_path / "two.fz"
        two.write_text(base + base.replace("system base", "system other"), encoding="utf-8")
        result = run("compare", "--changes", two, two)
        assert result.exit_code == 0
        one = tmp_path / "one.fz"
        one.write_text(base, encoding="utf-8")
        result = run("compare", "--changes", two, one)
        assert result.exit_code == 2
        assert "system 'other' is in one of the files only" in result.stderr
        assert run("compare", "--changes", two, one, "--block", "base").exit_code == 0


class TestCompare:
    def test_names_the_point_the_values_and_the_causes(self, files):
        result = run("compare", *files, "--points", "200")
        assert result.exit_code == 0
        assert "u: largest difference" in result.stdout
        assert "at x = " in result.stdout
        assert "explains" in result.stdout

    def test_within_fails_where_they_differ_by_more(self, files):
        assert run("compare", *files, "--points", "200", "--within", "1e-6").exit_code == 1
        assert run("compare", files[0], files[0], "--points", "200", "--within", "0").exit_code == 0

    def test_json_has_the_same(self, files):
        data = json.loads(run("compare", *files, "--points", "200", "--format", "json").stdout)
        (output,) = data["pairs"][0]["outputs"]
        assert output["largest"] > 0.1
        assert sum(c["explains"] for c in output["causes"]) == pytest.approx(1.0, abs=1e-6)

    @pytest.mark.parametrize(
        ("option", "value", "message"),
        [("--as", "matlab,exakt", "did you mean 'exact'?"), ("--within", "nan", "nan"), ("--within", "-1", "-1")],
    )
    def test_options_that_mean_nothing_are_wrong_usage(self, files, option, value, message):
        result = run("compare", *files, option, value)
        assert result.exit_code == 2
        assert message in result.stderr

    def test_a_point_where_only_one_has_a_value_stands_beside_the_largest_difference(self, tmp_path, changed):
        first, second = tmp_path / "first.fz", tmp_path / "second.fz"
        hole = ("  Z |  N  P", "  Z |  .  .")
        first.write_text(changed(hole, ("[-2, 2]", "[-2, 2] else nan")), encoding="utf-8")
        second.write_text(changed(hole, ("[-2, 2]", "[-2, 2] else 0.5"), after="and product\n"), encoding="utf-8")
        result = run("compare", first, second, "--points", "200")
        assert "u: largest difference" in result.stdout
        assert "and: min → product  explains 100 %" in result.stdout
        assert "points only one has a value, such as x = 0, y = 0: nan and 0.5" in result.stdout
        assert "    gone with else: nan → 0.5" in result.stdout
        assert run("compare", first, second, "--within", "100", "--points", "200").exit_code == 1
        data = json.loads(run("compare", first, second, "--points", "200", "--format", "json").stdout)
        (output,) = data["pairs"][0]["outputs"]
        assert output["gap"]["first"] is None
        assert [c["name"] for c in output["gap"]["causes"]] == ["else"]
        assert output["largest"] > 0

    def test_one_file_needs_two_profiles(self, files):
        result = run("compare", files[0])
        assert result.exit_code == 2
        assert "--as" in result.stderr

    def test_one_file_is_compared_with_itself_under_other_semantics(self, files):
        result = run("compare", files[0], "--as", "exact,matlab,pyfuzzylite", "--points", "200")
        assert result.exit_code == 0, result.output
        assert result.stdout.count("largest difference") == 2
        assert "as matlab" in result.stdout

    def test_what_no_single_setting_explains_is_said(self, files, monkeypatch):
        monkeypatch.setattr("fuzzyctl.comparison.explanation.parts", lambda *_: iter(()))
        assert "the rest: several of what differs at once  explains 100 %" in run("compare", *files).stdout

    def test_a_point_outside_of_the_range_of_the_first_is_marked(self, tmp_path, base):
        first, second = tmp_path / "first.fz", tmp_path / "second.fz"
        first.write_text(base, encoding="utf-8")
        wider = base.replace("in [0, 10]", "in [0, 30]").replace("N@0 P@10", "N@0 P@30")
        second.write_text(wider.replace("  P |  Z  P", "  P |  N  N"), encoding="utf-8")
        assert "y is outside its range there, [0, 10]" in run("compare", first, second).stdout

    def test_names_the_blocks_that_are_not_compared(self, tmp_path):
        text, other, law = LOOP.read_text(encoding="utf-8"), tmp_path / "other.fz", tmp_path / "law.fz"
        other.write_text(text.replace("= 8\n", "= 7\n"), encoding="utf-8")
        law.write_text(text.partition("\nplant ")[0], encoding="utf-8")
        left_out = "\n\nsystems only; not compared: fuzzy_pi, tank, fill"
        assert run("compare", LOOP, other, "--points", "9").stdout.endswith(f"{left_out}; --loops compares runs\n")
        assert run("compare", LOOP, law, "--points", "9").stdout.endswith(f"{left_out}\n")
