import pytest
from click.testing import CliRunner

from fuzzyctl.cli.main import main


def run(*arguments, stdin=None):
    return CliRunner().invoke(main, ["fmt", *map(str, arguments)], input=stdin)


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
