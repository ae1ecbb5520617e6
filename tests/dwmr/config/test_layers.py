"""A scenario that extends another: what it takes over, and where its mistakes stand."""

import hashlib

import pytest

from dwmr.scenario.file import find, read
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.scenario_keys import OverrideError

PAPER = find("paper")


@pytest.fixture
def write(tmp_path):
    """A function (name, text) -> path that writes a file of the scenario's folder."""

    def write_file(name, text):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write_file


def mistakes(path, *overrides):
    with pytest.raises(DiagnosticError) as caught:
        read(path, overrides)
    return caught.value.diagnostics


class TestExtends:
    def test_takes_over_what_it_does_not_give(self, write):
        path = write("mine.toml", 'extends = "paper"\nname = "mine"\n[robot]\nmass = 90.0\n[robots.leader]\nd = 0.2\n')
        scenario, paper = read(path).scenario, read(PAPER).scenario
        assert scenario.name == "mine"
        assert [r.mass for r in scenario.robots.values()] == [90.0] * 3
        assert (scenario.robots["leader"].d, scenario.robots["leader"].x_0) == (0.2, -1.0)
        assert scenario.disturbances == paper.disturbances
        assert paper.robots["leader"].mass == 120.0

    def test_has_a_name_of_its_own(self, write):
        assert read(write("mine.toml", 'extends = "paper"\n')).scenario.name == "mine"
        assert read(write("other.toml", 'extends = "mine.toml"\nname = "x"\n')).scenario.name == "x"
        assert mistakes(write("alone.toml", "[run]\ndt = 0.1\n"))[0].message == "name is missing"

    def test_replaces_lists_whole_and_adds_robots(self, write):
        text = """extends = "paper"
obstacles = [{ x = 40.0, y = 0.0, radius = 1.0 }]
[robots.fourth]
x_0 = -5.0
y_0 = 1.0
theta_0 = 0.0
d = 0.4
formation = { leader = "follower1", separation = 1.25, bearing = 3.0 }
"""
        scenario = read(write("mine.toml", text)).scenario
        assert [o.x for o in scenario.obstacles] == [40.0]
        assert list(scenario.robots) == ["leader", "follower1", "follower2", "fourth"]
        assert scenario.robots["fourth"].friction == scenario.robots["leader"].friction

    def test_replaces_a_table_of_another_kind_and_merges_one_of_the_same(self, write):
        line = '[reference]\nkind = "line"\nstart_x = 0.0\nstart_y = 0.0\nangle = 0.0\nspeed = 0.5\n'
        assert read(write("a.toml", f'extends = "paper"\n{line}')).scenario.reference.speed == 0.5
        eight = '[reference]\nkind = "eight"\nperiod = 300.0\n'
        assert read(write("b.toml", f'extends = "paper"\n{eight}')).scenario.reference.amplitude_x == 15.0

    def test_reaches_over_several_files_beside_each_other(self, write):
        write("base.toml", 'extends = "paper"\n[run]\nhorizon = 30.0\nsubsteps = 2\n')
        top = write("top.toml", 'extends = "base.toml"\n[run]\nhorizon = 10.0\n')
        run = read(top, ["run.save_every=7"]).scenario.run
        assert (run.horizon, run.substeps, run.dt, run.save_every) == (10.0, 2, 0.005, 7)

    def test_is_part_of_the_checksum(self, write):
        base = write("base.toml", 'extends = "paper"\n')
        top = write("top.toml", 'extends = "base.toml"\n')
        first = read(top).sha256
        assert first == hashlib.sha256(top.read_bytes() + base.read_bytes() + PAPER.read_bytes()).hexdigest()
        base.write_text('extends = "paper"\n# changed\n', encoding="utf-8")
        assert read(top).sha256 != first
        assert read(PAPER).sha256 == hashlib.sha256(PAPER.read_bytes()).hexdigest()

    def test_finds_rule_files_beside_the_scenario_that_is_extended(self, tmp_path):
        (tmp_path / "below").mkdir()
        (tmp_path / "below" / "base.toml").write_text('extends = "paper"\n', encoding="utf-8")
        (tmp_path / "top.toml").write_text('extends = "below/base.toml"\n', encoding="utf-8")
        assert read(tmp_path / "top.toml").folders == (tmp_path, tmp_path / "below", PAPER.parent)


class TestMistakes:
    def test_stand_in_the_file_that_made_them(self, write):
        base = write("base.toml", 'extends = "paper"\n[robot]\nmass = -1.0\n')
        top = write("top.toml", 'extends = "base.toml"\n\n[run]\ndt = "fast"\n')
        in_base, in_top = sorted(mistakes(top), key=lambda d: d.place)
        assert (in_base.place, in_base.message) == (f"{base}:3:1", "robot.mass must be > 0 kg, got -1.0")
        assert (in_top.place, in_top.message) == (f"{top}:4:1", "run.dt must be a number, got 'fast'")

    def test_in_a_list_stand_where_the_list_was_replaced(self, write):
        top = write("top.toml", 'extends = "paper"\nobstacles = [{ x = 40.0, y = 0.0, radius = -1.0 }]\n')
        (one,) = mistakes(top)
        assert one.place == f"{top}:2:1"

    def test_of_an_override_beat_the_files(self, write):
        top = write("top.toml", 'extends = "paper"\n[robot]\nmass = 100.0\n')
        assert mistakes(top, "robot.mass=-1")[0].file == "--set robot.mass=-1"

    @pytest.mark.parametrize(
        ("value", "words"),
        [
            ('"papper"', "names a scenario that does not exist"),
            ('"nowhere.toml"', "names a scenario that does not exist"),
            ('"\\u0000"', "names a scenario that does not exist"),
            ('""', "must be the name of a scenario"),
            ("5", "must be the name of a scenario"),
            ('"mine.toml"', "leads in a circle: mine.toml -> mine.toml"),
            ('"other.toml"', "leads in a circle: mine.toml -> other.toml -> mine.toml"),
        ],
    )
    def test_of_the_key_itself_stand_at_it(self, write, value, words):
        write("other.toml", 'extends = "mine.toml"\n')
        path = write("mine.toml", f"name = 'x'\nextends = {value}\n")
        (one,) = mistakes(path)
        assert words in one.message
        assert one.span.line == (1 if "other" in value else 2)

    def test_suggest_the_shipped_scenario_that_was_meant(self, write):
        assert mistakes(write("mine.toml", 'extends = "papper"\n'))[0].help == "did you mean 'paper'?"

    def test_include_too_many_files_upon_each_other(self, write):
        for k in range(12):
            write(f"s{k}.toml", f'extends = "s{k + 1}.toml"\n')
        path = write("s12.toml", 'extends = "paper"\n')
        assert "more than 10 scenarios" in mistakes(path.with_name("s0.toml"))[0].message

    def test_include_the_key_as_an_override(self):
        with pytest.raises(OverrideError, match="extends cannot be set"):
            read(PAPER, ["extends=paper"])
