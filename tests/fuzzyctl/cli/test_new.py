import pytest

import fuzzyctl
from fuzzyctl.cli.new import starter
from fuzzyctl.support.shipped import shipped_files
from tests.commands import runner


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


run = runner()


class TestNew:
    def test_the_file_is_clean_formatted_and_can_be_evaluated(self, folder):
        result = run("new", "heater")
        assert (result.exit_code, result.output) == (0, "wrote heater.fz\n")
        assert run("check", "--deny", "warnings", "heater.fz").output == "heater.fz: heater: 9 rules, no errors\n"
        assert run("fmt", "--check", "heater.fz").exit_code == 0
        system = fuzzyctl.load("heater.fz")
        assert system.name == "heater"
        # Colder and falling: more power.
        assert system(error=-5, change=-1) > system(error=0, change=0) > system(error=5, change=1)

    def test_its_param_can_be_set(self):
        run("new", "heater")
        assert "power" in run("eval", "heater.fz", "error=15", "change=0", "--set", "reach=20").output

    def test_the_text_is_in_its_canonical_layout_whatever_the_name(self):
        for name in ("a", "ünïcode_" * 20):
            assert starter(name).count(f"system {name} ") == 1
            assert fuzzyctl.loads(starter(name)).name

    def test_a_file_is_never_overwritten(self, folder):
        (folder / "heater.fz").write_text("mine")
        result = run("new", "heater")
        assert result.exit_code == 1
        assert "heater.fz: error[FZ005]: there is already a file of this name" in result.output
        assert "name another file with -o FILE, or replace it with --force" in result.output
        assert (folder / "heater.fz").read_text() == "mine"

    def test_another_file_can_be_named(self, folder):
        assert run("new", "heater", "-o", "other.fz").exit_code == 0
        assert [p.name for p in folder.iterdir()] == ["other.fz"]

    def test_a_missing_folder_is_a_diagnostic(self, folder):
        result = run("new", "heater", "-o", "no/heater.fz")
        assert result.exit_code == 1
        assert "error[FZ005]: there is no folder 'no'" in result.output

    @pytest.mark.parametrize("name", ["my heater", "1st", "and", "", "a-b", "../up", "x" * 201])
    def test_what_is_no_name_is_wrong_usage(self, name, folder):
        result = run("new", "--", name)
        assert result.exit_code == 2
        assert list(folder.iterdir()) == []

    def test_the_rules_of_names_are_named(self):
        said = "'1st' is not a name: a name has letters, digits and _, and does not begin with a digit"
        assert said in " ".join(run("new", "1st").output.split())

    def test_a_name_that_would_do_is_proposed(self):
        assert "'my_heater' would do" in run("new", "my heater").output

    @pytest.mark.parametrize("name", ["system", "table", "abs", "x", "ö" * 100])
    def test_every_other_name_makes_a_clean_file(self, name):
        result = run("new", name)
        assert result.exit_code == 0, result.output
        assert run("check", "--deny", "warnings", f"{name}.fz").exit_code == 0

    def test_a_name_too_long_for_the_file_system_is_no_traceback(self):
        result = run("new", "ö" * 200)
        assert result.exit_code == 1
        assert "FZ005" in result.output


class TestCopies:
    def test_a_shipped_file_is_copied_under_a_new_name(self, folder):
        assert run("new", "tip", "--from", "tipper").output == "wrote tip.fz\n"
        assert fuzzyctl.load("tip.fz").name == "tip"
        assert fuzzyctl.load("tip")(service=7, food=8) == fuzzyctl.load("tipper")(service=7, food=8)

    @pytest.mark.parametrize("base", sorted(shipped_files()))
    def test_a_copy_is_whole(self, base, folder):
        assert run("new", "copy", "--from", base).exit_code == 0
        assert set(shipped_files()[base].parent.glob("*")) >= {
            shipped_files()[base].parent / p.name for p in folder.iterdir() if p.name != "copy.fz"
        }
        result = run("check", "copy.fz")
        assert result.exit_code == 0, result.output

    def test_used_files_of_the_same_text_may_be_there(self, folder):
        run("new", "one", "--from", "aifqsmc")
        assert run("new", "two", "--from", "aifqsmc").output == "wrote two.fz\n"
        (folder / "immune_channel.fz").write_text("mine")
        result = run("new", "three", "--from", "aifqsmc")
        assert (result.exit_code, (folder / "three.fz").exists()) == (1, False)
        assert "immune_channel.fz: error[FZ005]: three.fz uses a file of this name" in result.output

    def test_mistakes_are_said_and_nothing_is_written(self, folder):
        assert "did you mean 'tipper'?" in run("new", "x", "--from", "tiper").output
        assert run("new", "immune_channel", "--from", "aifqsmc").exit_code == 2
        assert list(folder.iterdir()) == []
