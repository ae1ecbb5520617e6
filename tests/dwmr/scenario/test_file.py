import pytest
from pydantic import ValidationError

from dwmr.scenario.file import LARGEST_FILE, UnknownScenarioError, find, read, shipped_names
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.scenario_keys import OverrideError

PAPER = find("paper")


def mistakes(path, *overrides):
    with pytest.raises(DiagnosticError) as caught:
        read(path, overrides)
    return caught.value.diagnostics


@pytest.fixture
def edited(tmp_path):
    """A function that writes the paper's scenario with some text replaced."""

    def edit(*replacements):
        text = PAPER.read_text(encoding="utf-8")
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return edit


class TestFind:
    def test_knows_the_shipped_scenarios_and_paths(self, tmp_path):
        (tmp_path / "mine.toml").write_text("x = 1")
        assert "paper" in shipped_names()
        assert find(str(tmp_path / "mine.toml")) == tmp_path / "mine.toml"

    def test_suggests_the_name_that_was_meant(self):
        with pytest.raises(UnknownScenarioError, match="did you mean 'paper'"):
            find("papper")


class TestRead:
    def test_gives_a_frozen_scenario(self):
        scenario = read(PAPER).scenario
        with pytest.raises(ValidationError):
            scenario.run.dt = 0.1

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

    def test_include_unknown_robots_controllers_and_leaders_in_a_circle(self, edited):
        text = edited(
            (
                'leader = "leader", separation = 1.25, bearing = 2',
                'leader = "follower1", separation = 1.25, bearing = 2',
            )
        )
        assert "a robot cannot follow itself" in mistakes(text)[0].message
        text = edited(
            ('leader = "leader", separation = 1.25, bearing = 2', 'leader = "laeder", separation = 1.25, bearing = 2')
        )
        assert mistakes(text)[0].help == "did you mean 'leader'?"
        assert "unknown controller 'pid'" in mistakes(PAPER, "run.controller=pid")[0].message

    def test_include_a_window_that_ends_before_it_begins(self, edited):
        (one,) = mistakes(edited(("stop = 20.0", "stop = 2.0")))
        assert "stop = 2 s lies before start = 3 s" in one.message

    def test_include_a_follower_that_should_avoid_obstacles(self):
        (one,) = mistakes(PAPER, "robots.follower1.avoids_obstacles=true")
        assert "only a robot on the reference avoids" in one.message

    def test_include_runs_too_long_to_keep(self):
        (one,) = mistakes(PAPER, "run.horizon=90000")
        assert "at most 5,000,000 are kept" in one.message

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
        [(b"", "FZ901"), (b"\xff\xfe\x00binary", "FZ002"), (b"#" * (LARGEST_FILE + 1), "FZ003"), (b"x = 1", "FZ902")],
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

    def test_include_folders(self, tmp_path):
        assert mistakes(tmp_path)[0].code == "FZ001"


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

    @pytest.mark.parametrize("argument", ["horizon", "=3", "run..dt=1", "obstacles.9.x=1", "name.x=1", "obstacles.x=1"])
    def test_that_reach_nothing_are_refused(self, argument):
        with pytest.raises(OverrideError, match="--set"):
            read(PAPER, [argument])

    def test_name_keys_in_quotes_as_toml_does(self, edited):
        robots = read(PAPER, ['robots."leader".mass=3', "robots . 'follower1'.mass = 4"]).scenario.robots
        assert [r.mass for r in robots.values()] == [3, 4, 120.0]
        path = edited(("[robots.follower2]", '[robots."a.b=c"]'))
        assert read(path, ['robots."a.b=c".mass=5']).scenario.robots["a.b=c"].mass == 5
        with pytest.raises(OverrideError, match="expected key=value"):
            read(PAPER, ['robots."leader.mass=3'])

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
        with pytest.raises(OverrideError, match="extends cannot be set, only written in a scenario file"):
            read(PAPER, [argument])


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

    @pytest.mark.parametrize("name", shipped_names())
    def test_do_not_occur_in_shipped_scenarios(self, name):
        assert not [w for w in read(find(name)).warnings if "used by no robot" in w.message]
