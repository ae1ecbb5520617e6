import json
import os
import threading

import pytest

from tests.commands import runner

run = runner("fmt")


@pytest.fixture
def untidy(tmp_path, base):
    path = tmp_path / "a.fz"
    path.write_text(base.replace("  N |", "N|").replace("[0, 10]", "[ 0,10 ]"))
    return path


class TestFmt:
    def test_a_file_is_laid_out_in_place(self, untidy, base):
        result = run(untidy)
        assert result.exit_code == 0
        assert untidy.read_text() == base
        assert run(untidy).output == ""

    def test_check_changes_nothing_and_fails(self, untidy):
        before = untidy.read_text()
        assert run("--check", untidy).exit_code == 1
        assert untidy.read_text() == before
        run(untidy)
        assert run("--check", untidy).exit_code == 0

    def test_crlf_becomes_lf(self, tmp_path, base):
        path = tmp_path / "a.fz"
        path.write_bytes(base.replace("\n", "\r\n").encode())
        assert run("--check", path).exit_code == 1
        run(path)
        assert path.read_bytes() == base.encode()

    def test_a_broken_file_is_left_alone(self, tmp_path):
        path = tmp_path / "a.fz"
        path.write_text("sytem  a\n")
        result = run(path)
        assert result.exit_code == 1
        assert "FZ101" in result.output
        assert path.read_text() == "sytem  a\n"

    def test_standard_input_goes_to_standard_output(self, base):
        assert run("-", stdin=base.replace("  N |", "N |")).output == base

    def test_nothing_half_written_stays_behind(self, untidy):
        run(untidy)
        assert [p.name for p in untidy.parent.iterdir()] == ["a.fz"]


class TestDiff:
    def test_it_shows_what_would_change_and_changes_nothing(self, untidy):
        before = untidy.read_text()
        result = run("--diff", untidy)
        assert result.exit_code == 1
        assert f"--- {untidy}\n+++ {untidy}\n@@" in result.output
        assert "\n-N|  N  Z\n+  N |  N  Z\n" in result.output
        assert untidy.read_text() == before

    def test_a_terminal_shows_it_in_colour(self, untidy, monkeypatch):
        monkeypatch.setattr("fuzzyctl.cli.main.use_color", lambda stream: True)
        shown = run("--diff", untidy, color=True).stdout
        assert "\x1b[31m-N|  N  Z\x1b[0m\n\x1b[32m+  N |  N  Z\x1b[0m\n" in shown
        assert "\x1b[36m@@" in shown

    def test_a_tidy_file_has_none(self, tmp_path, base):
        path = tmp_path / "a.fz"
        path.write_text(base)
        result = run("--diff", path)
        assert (result.exit_code, result.output) == (0, "")

    @pytest.mark.parametrize("change", [str, lambda t: t.rstrip("\n"), lambda t: t.replace("\n", "\r\n")])
    def test_patch_makes_the_canonical_layout_of_it(self, untidy, base, change):
        untidy.write_bytes(change(untidy.read_text()).encode())
        diff = run("--diff", untidy).stdout_bytes
        patched = _patched(untidy.read_bytes().decode(), diff.decode())
        assert patched == base

    def test_standard_input_can_be_compared(self, base):
        assert run("--diff", "-", stdin=base).output == ""
        result = run("--diff", "-", stdin=base.replace("[0, 10]", "[ 0,10 ]"))
        assert result.exit_code == 1
        assert "+++ <stdin>" in result.output

    def test_all_files_are_shown(self, untidy, tmp_path, base):
        other = tmp_path / "b.fz"
        other.write_text(base + "\n\n")
        assert run("--diff", untidy, other).output.count("+++") == 2


def _patched(before, diff):
    """Apply a unified diff as `patch` does."""
    lines, out, at = before.split("\n"), [], 0
    ended = True
    hunks = diff.split("\n")
    assert hunks[0].startswith("--- ")
    for line in hunks[2:]:
        if line.startswith("@@"):
            start = int(line.split()[1].lstrip("-").split(",")[0]) - 1
            out += lines[at:start]
            at = start
        elif line.startswith("-"):
            assert lines[at] == line[1:]
            at += 1
        elif line.startswith("+"):
            out.append(line[1:])
        elif line.startswith(" "):
            assert lines[at] == line[1:]
            out.append(line[1:])
            at += 1
        elif line.startswith("\\"):
            ended = before.endswith("\n")
            assert not ended
    return "\n".join([*out, *(lines[at:] if ended else [""])])


class TestFormats:
    def test_github_annotates_the_first_line_that_differs(self, untidy):
        result = run("--check", "--format", "github", untidy)
        assert result.exit_code == 1
        (line,) = result.output.splitlines()
        assert line.startswith("::error file=")
        assert ",line=8," in line
        assert "title=FZ006%3A " in line

    def test_sarif_and_json_hold_the_mistakes_of_broken_files_too(self, untidy, tmp_path):
        broken = tmp_path / "b.fz"
        broken.write_text("sytem b\n")
        found = json.loads(run("--check", "--format", "json", untidy, broken).output)["diagnostics"]
        assert [d["code"] for d in found] == ["FZ006", "FZ101"]
        log = json.loads(run("--check", "--format", "sarif", untidy, broken).output)
        assert [r["ruleId"] for r in log["runs"][0]["results"]] == ["FZ006", "FZ101"]

    def test_a_format_without_check_is_wrong_usage(self, untidy):
        before = untidy.read_text()
        assert run("--format", "json", untidy).exit_code == 2
        assert run("--format", "json", "--check", "--diff", untidy).exit_code == 2
        assert untidy.read_text() == before


def test_standard_input_is_read_up_to_the_limit_of_files():
    result = run("-", stdin="#" * ((1 << 20) + 1))
    assert result.exit_code == 1
    assert "<stdin>: error[FZ003]: the file is larger than 1,048,576 bytes" in result.stderr


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")
def test_a_pipe_is_read_once(tmp_path, base):
    os.mkfifo(tmp_path / "pipe.fz")
    writer = threading.Thread(target=(tmp_path / "pipe.fz").write_text, args=[base])
    writer.start()
    result = run("--check", tmp_path / "pipe.fz")
    writer.join()
    assert (result.exit_code, result.output) == (0, "")


def test_a_blank_line_separates_the_diagnostics_of_two_files(tmp_path):
    result = run(tmp_path / "a.fz", tmp_path / "b.fz")
    first, second = result.stderr.rstrip("\n").split("\n\n")
    assert "a.fz: error[FZ001]" in first
    assert "b.fz: error[FZ001]" in second
