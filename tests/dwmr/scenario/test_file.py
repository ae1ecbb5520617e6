"""Scenario files: what is read, mistakes at their lines, overrides, and scenarios that extend others."""

import hashlib
import os

import pytest

from dwmr import find, read, simulate
from fuzzyctl import ArgumentError, DiagnosticError
from fuzzyctl.experiments.scenario_layers import UnknownScenarioError
from tests.dwmr import scenarios
from tests.dwmr.process import here
from tests.dwmr.scenarios import PAPER, mistakes, warned
from tests.physics import shipped


@pytest.fixture
def edited(tmp_path):
    """A function that writes the paper's scenario with some text replaced."""
    return lambda *replacements: scenarios.edited(PAPER, tmp_path / "mine.toml", *replacements)


@pytest.fixture
def write(tmp_path):
    """A function (name, text) -> path that writes a file of the scenario's folder."""

    def write_file(name, text):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write_file


def refused(argument, message):
    """Require that an override is wrong usage."""
    assert message in here("check", "paper", "--set", argument, status=2).stderr


def test_the_name_that_was_meant_is_suggested(write):
    path = write("mine.toml", "x = 1")
    assert find(str(path)) == path
    assert "did you mean 'paper'" in here("check", "papper", status=2).stderr


class TestRead:
    def test_takes_a_shipped_name_and_a_path(self, edited):
        path = edited()
        assert read("paper") == read(find("paper"))
        assert read(str(path)) == read(path)
        with pytest.raises(UnknownScenarioError, match="did you mean 'paper'"):
            read("papper")

    @pytest.mark.parametrize("arguments", [(None,), (b"paper",), (3,), ("paper", "run.horizon=2")])
    def test_refuses_other_arguments(self, arguments):
        with pytest.raises(ArgumentError):
            read(*arguments)

    def test_a_run_refuses_other_arguments(self):
        with pytest.raises(ArgumentError, match=r"dwmr\.read"):
            simulate("paper")
        for arguments in ((3,), ("smc", "folder")):
            with pytest.raises(ArgumentError):
                simulate(read("paper"), *arguments)
        with pytest.raises(DiagnosticError, match="nosuch"):
            simulate(read("paper"), "nosuch")

    def test_holds_the_printed_numbers(self):
        scenario = read(PAPER).scenario
        leader, second = scenario.robots["leader"], scenario.robots["follower2"]
        assert (leader.x_0, leader.y_0, leader.theta_0, leader.d) == (-1.0, 1.0, 0.0, 0.1)
        assert (second.x_0, second.y_0, second.d) == (-3.0, -1.0, 0.4)
        assert [(o.x, o.y) for o in scenario.obstacles] == [(0.0, 15.5), (8.0, -4.25), (-14.5, -11.25)]
        assert [(d.kind, d.start, d.stop) for d in scenario.disturbances] == [
            ("sinusoid", 3.0, 20.0),
            ("constant", 50.0, 70.0),
            ("sinusoid", 100.0, 120.0),
            ("constant", 150.0, 170.0),
        ]
        assert scenario.run.steps == 40_000

    def test_gives_every_robot_the_common_values_unless_it_has_its_own(self, edited):
        path = edited(("[robots.follower2]", "[robots.follower2]\nmass = 90.0\nfriction = { coulomb_force = 9.0 }"))
        robots = read(path).scenario.robots
        assert [r.mass for r in robots.values()] == [120.0, 120.0, 90.0]
        assert robots["follower2"].friction.coulomb_force == 9.0
        assert robots["follower2"].friction.coulomb_torque == robots["leader"].friction.coulomb_torque


class TestMistakes:
    def test_name_line_key_value_bound_and_unit(self, edited):
        (one,) = mistakes(edited(("mass = 120.0", "mass = -1.0")))
        assert one.code == "FZ904"
        assert one.message == "robot.mass must be > 0 kg, got -1.0"
        assert one.span.source.line_text(one.span.line).startswith("mass = -1.0")

    def test_come_all_at_once(self, edited):
        found = mistakes(
            edited(("mass = 120.0", "mass = -1.0"), ("dt = 0.005", 'dt = "fast"'), ("x = 8.0", "xx = 8.0"))
        )
        assert [d.message.split(",")[0] for d in found] == [
            "run.dt must be a number",
            "robot.mass must be > 0 kg",
            "obstacles.1.x is missing",
            "unknown key obstacles.1.xx",
        ]

    def test_suggest_the_key_that_was_meant(self, edited):
        found = mistakes(edited(("wheel_radius", "weel_radius")))
        unknown = next(d for d in found if d.code == "FZ902")
        assert unknown.message == "unknown key robot.weel_radius"
        assert unknown.help == "did you mean 'wheel_radius'?"

    def test_of_the_common_table_show_once(self, edited):
        assert len(mistakes(edited(("lag = 0.001", "lag = 0.0")))) == 1

    @pytest.mark.parametrize("value", ["nan", "inf", "true", '"120"'])
    def test_include_what_is_no_finite_number(self, edited, value):
        (one,) = mistakes(edited(("mass = 120.0", f"mass = {value}")))
        assert one.message.startswith("robot.mass must be a ")

    def test_in_an_override_name_the_argument(self):
        (one,) = mistakes(PAPER, "robots.leader.mass=-1")
        assert one.span is None
        assert one.file == "--set robots.leader.mass=-1"
        assert one.message == "robots.leader.mass must be > 0 kg, got -1"

    def test_include_unknown_robots_and_windows_that_end_before_they_begin(self, edited):
        place = 'leader = "leader", separation = 1.25, bearing = 2'
        assert mistakes(edited((place, place.replace('"leader"', '"laeder"'))))[0].help == "did you mean 'leader'?"
        (one,) = mistakes(edited(("stop = 20.0", "stop = 2.0")))
        assert "stop = 2 s lies before start = 3 s" in one.message

    def test_in_the_toml_itself_point_at_the_place(self, edited):
        (one,) = mistakes(edited(("dt = 0.005", "dt = = 0.005")))
        assert one.code == "FZ901"
        assert one.span.source.line_text(one.span.line).startswith("dt = = 0.005")

    def test_in_toml_that_ends_too_early_point_at_its_last_line(self, tmp_path):
        (tmp_path / "x.toml").write_text("name = 'x'\na = [\n\n", encoding="utf-8")
        (one,) = mistakes(tmp_path / "x.toml")
        assert (one.code, one.place) == ("FZ901", f"{tmp_path / 'x.toml'}:2:5")

    @pytest.mark.parametrize(
        ("content", "code"),
        [(b"", "FZ901"), (b"\xff\xfe\x00binary", "FZ002"), (b"#" * 10_000_000, "FZ003"), (b"x = 1", "FZ902")],
    )
    def test_include_files_that_are_no_scenarios(self, tmp_path, content, code):
        path = tmp_path / "x.toml"
        path.write_bytes(content)
        assert code in {d.code for d in mistakes(path)}

    @pytest.mark.parametrize("above", ["", 'extends = "paper"\n'])
    def test_include_tables_nested_too_deeply(self, tmp_path, above):
        (tmp_path / "x.toml").write_text(f"{above}[robot.{'.'.join(['a'] * 3000)}]\nx = 1\n", encoding="utf-8")
        (one,) = mistakes(tmp_path / "x.toml")
        assert (one.code, one.message) == ("FZ901", "tables are nested too deeply")

    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")
    @pytest.mark.parametrize("name", ["mine.toml", "base.toml", "path.csv", "own.fz"])
    def test_include_pipes(self, write, tmp_path, name):
        write("mine.toml", "")
        texts = {
            "base.toml": 'extends = "base.toml"\n',
            "path.csv": 'extends = "paper"\n[reference]\nkind = "csv"\nfile = "path.csv"\n',
            "own.fz": 'extends = "paper"\n[rules.ais_reaction]\nfile = "own.fz"\n',
        }
        (tmp_path / name).unlink(missing_ok=True)
        os.mkfifo(tmp_path / name)
        if name in texts:
            write("mine.toml", texts[name])
        assert "is not a regular file" in here("check", tmp_path / "mine.toml", status=1).stderr

    def test_include_what_is_no_file(self, tmp_path):
        assert mistakes(tmp_path)[0].code == "FZ001"
        (one,) = mistakes("/dev/zero")
        assert "not a regular file" in one.message

    def test_that_every_robot_has_show_once(self, edited):
        (one,) = mistakes(edited(("mass = 120.0 ", "#")))
        assert one.message == "robot.mass is missing"
        assert "[robot]" in one.span.source.line_text(one.span.line)

    @pytest.mark.parametrize("key", ["robots.leader.x_0", "obstacles.0.y", "robot.noise.v", "reference.amplitude_x"])
    def test_include_places_and_lengths_beyond_all_maps(self, key):
        assert any(f"{key} must be <= 1e+09" in d.message for d in mistakes(PAPER, f"{key}=1.1e9"))


class TestOverrides:
    def test_reach_tables_lists_common_values_and_rule_params(self):
        scenario = read(
            PAPER,
            [
                "run.horizon=20",
                "obstacles.1.x=9.5",
                "robot.mass=100",
                "robots.leader.mass=110",
                "rules.ais_reaction.k_s=0.5",
            ],
        ).scenario
        assert scenario.run.horizon == 20
        assert scenario.obstacles[1].x == 9.5
        assert [r.mass for r in scenario.robots.values()] == [110, 100, 100]
        assert scenario.rules["ais_reaction"].params["k_s"] == 0.5

    @pytest.mark.parametrize("argument", ["horizon", "=3", "run..dt=1", "obstacles.9.x=1", "name.x=1"])
    def test_that_reach_nothing_are_refused(self, argument):
        refused(argument, "--set")

    def test_name_keys_in_quotes_as_toml_does(self, edited):
        robots = read(PAPER, ['robots."leader".mass=3', "robots . 'follower1'.mass = 4"]).scenario.robots
        assert [r.mass for r in robots.values()] == [3, 4, 120.0]
        path = edited(("[robots.follower2]", '[robots."a.b=c"]'))
        assert read(path, ['robots."a.b=c".mass=5']).scenario.robots["a.b=c"].mass == 5
        refused('robots."leader.mass=3', "expected key=value")

    def test_of_a_misspelt_robot_say_so_once(self):
        (one,) = mistakes(PAPER, "robots.folower1.mass=5")
        assert (one.code, one.message) == ("FZ902", "there is no robot 'folower1'")
        assert one.help == "did you mean 'follower1'?"
        assert one.file == "--set robots.folower1.mass=5"

    def test_may_add_a_whole_robot(self):
        more = "robots.third={x_0=5.0, y_0=5.0, theta_0=0.0, d=0.4, delay=3.0}"
        assert list(read(PAPER, [more]).scenario.robots) == ["leader", "follower1", "follower2", "third"]

    @pytest.mark.parametrize("argument", ['extends="paper"', "extends=undisturbed", "extends.x=1"])
    def test_cannot_change_what_a_scenario_extends(self, argument):
        refused(argument, "extends cannot be set, only written in a scenario file")


class TestCommonValuesThatNoRobotTakes:
    @pytest.mark.parametrize(
        ("argument", "message"),
        [
            ("robot.d=0", "robot.d must be > 0 m, got 0"),
            ("robot.d=-1", "robot.d must be > 0 m, got -1"),
            ('robot.x_0="a"', "robot.x_0 must be a number, got 'a'"),
            ("robot.theta_0=nan", "robot.theta_0 must be a finite number, got nan"),
            ("robot={d=0}", "robot.d must be > 0 m, got 0"),
        ],
    )
    def test_are_checked_all_the_same(self, argument, message):
        found = [d for d in mistakes(PAPER, argument) if not d.message.endswith("is missing")]
        assert [(d.message, d.file) for d in found if d.code == "FZ904"] == [(message, f"--set {argument}")]

    def test_are_checked_in_a_file_too(self, edited):
        (one,) = mistakes(edited(("mass = 120.0", "mass = 120.0\nd = 0.0")))
        assert one.message == "robot.d must be > 0 m, got 0.0"
        assert one.span.source.line_text(one.span.line).startswith("d = 0.0")

    def test_are_refused_on_the_command_line(self):
        (one,) = mistakes(PAPER, "robot.d=0.9")
        assert one.message == "robot.d is used by no robot: each has its own"
        assert one.help == "set robots.leader.d, or robots.*.d in a sweep"
        assert one.file == "--set robot.d=0.9"

    def test_are_refused_inside_of_tables(self, edited):
        own = [(f"[robots.{n}]", f"[robots.{n}]\nactuator.lag = 0.03") for n in ("leader", "follower1", "follower2")]
        (one,) = mistakes(edited(*own), "robot.actuator.lag=0.05")
        assert one.message.startswith("robot.actuator.lag is used by no robot")
        assert read(edited(*own), ["robot.actuator.v_limit=1.5"]).scenario.robots["leader"].actuator.v_limit == 1.5

    def test_are_warned_of_in_a_file(self, edited):
        (one,) = read(edited(("mass = 120.0", "mass = 120.0\nd = 0.2"))).warnings
        assert one.severity == "warning"
        assert one.message.startswith("robot.d is used by no robot")
        assert one.span.source.line_text(one.span.line).startswith("d = 0.2")

    def test_are_no_slip_where_all_robots_are_given_their_own_above(self):
        given = [f"robots.{name}.mass=90" for name in ("leader", "follower1", "follower2")]
        assert read(PAPER, given).warnings == ()

    @pytest.mark.parametrize("name", shipped())
    def test_do_not_occur_in_shipped_scenarios(self, name):
        assert warned(name) == []


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


class TestMistakesOfExtends:
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
