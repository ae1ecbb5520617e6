"""What several values of a scenario must hold together."""

import subprocess
import sys

import pytest

from dwmr.scenario.checks import STABLE_STEP
from dwmr.scenario.file import find, read
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from tests.effort import at_most

PAPER = find("paper")


def mistakes(*overrides):
    with pytest.raises(DiagnosticError) as caught:
        read(PAPER, overrides)
    return [d.message for d in caught.value.diagnostics]


def formation(leader, bearing=2.0):
    return f'{{leader = "{leader}", separation = 1.25, bearing = {bearing}}}'


class TestFormation:
    def test_of_a_robot_that_follows_itself_is_refused(self):
        (one,) = mistakes("robots.follower1.formation.leader=follower1")
        assert one == "robots.follower1.formation.leader = 'follower1': a robot cannot follow itself"

    def test_that_leads_in_a_circle_shows_the_circle_at_each_of_its_robots(self):
        first, second = mistakes(
            f"robots.leader.formation={formation('follower2')}", "robots.leader.avoids_obstacles=false"
        )
        assert "leads back to leader: leader -> follower2 -> leader" in first
        assert "leads back to follower2" in second

    @pytest.mark.parametrize(("value", "bound"), [("d=0", "> 0 m"), ("formation.separation=0", "> 0 m")])
    def test_without_room_is_refused(self, value, bound):
        (one,) = mistakes(f"robots.follower1.{value}")
        assert bound in one

    def test_takes_a_delay_only_on_the_reference(self):
        assert "only a robot on the reference has a delay" in mistakes("robots.follower1.delay=2.0")[0]
        assert read(PAPER, ["robots.leader.delay=2.0"]).scenario.robots["leader"].delay == 2.0

    def test_warns_of_robots_that_are_sent_to_one_place(self):
        (one,) = read(PAPER, [f"robots.follower1.formation={formation('leader', -2.356194490192345)}"]).warnings
        assert one.severity == "warning"
        assert one.message == "robots.follower2 and robots.follower1 are sent to the same place behind leader"


class TestObstacles:
    def test_that_overlap_are_refused_and_those_that_touch_are_not(self):
        (one,) = mistakes("obstacles.1.x=0.5", "obstacles.1.y=15.5")
        assert one == "obstacles.1 overlaps obstacles.0: their centres are 0.5 m apart, their radii make 1 m"
        assert read(PAPER, ["obstacles.1.x=1.0", "obstacles.1.y=15.5"])

    @pytest.mark.parametrize("robot", ["leader", "follower2"])
    def test_with_a_robot_in_it_at_the_start_are_refused(self, robot):
        (one,) = mistakes(f"robots.{robot}.x_0=8.0", f"robots.{robot}.y_0=-4.0")
        assert one.startswith(f"robots.{robot} starts inside obstacles.1: (8, -4) is 0.25 m from its centre")


class TestReference:
    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ('{kind = "circel"}', "must be one of 'eight', 'circle', 'line', 'waypoints', 'csv', got 'circel'"),
            ("{amplitude_x = 1.0}", "reference.kind is missing"),
            ("5", "reference must be a table, got 5"),
            ('{kind = "waypoints", points = [[0, 0]], speed = 1.0}', "must have at least 2 elements, has 1"),
            ('{kind = "waypoints", points = [[0, 0], [1, 1], [2, "a"]], speed = 1.0}', "points.2.1 must be a number"),
            ('{kind = "waypoints", points = [[0, 0], [1, 1], [2]], speed = 1.0}', "reference.points.2.1 is missing"),
            ('{kind = "waypoints", points = [[0, 0], [1, 2e9]], speed = 1.0}', "reference.points.1.1 must be <= 1e+09"),
            ('{kind = "waypoints", points = [[0, 0], [1, 1]]}', "give speed or duration"),
            ('{kind = "waypoints", points = [[0, 0], [1, 1]], speed = 1, duration = 1}', "speed or duration, not both"),
            ('{kind = "waypoints", points = [[0, 0], [1, 1]], closed = true, speed = 1}', "at least 3 places"),
            ('{kind = "line", start_x = 0, start_y = 0, angle = 0, sped = 1, speed = 1}', "unknown key reference.sped"),
            ('{kind = "csv", file = "nowhere.csv"}', "names a file that does not exist"),
        ],
    )  # fmt: skip
    def test_that_is_wrong_is_named_with_its_argument(self, text, words):
        with pytest.raises(DiagnosticError) as caught:
            read(PAPER, [f"reference={text}"])
        (one,) = caught.value.diagnostics
        assert words in one.message
        assert one.file == f"--set reference={text}" or len(text) > 60

    def test_of_another_kind_suggests_its_keys(self):
        with pytest.raises(DiagnosticError) as caught:
            read(PAPER, ['reference={kind="circle",centre_x=0,center_y=0,radius=1,period=9,direction="clockwise"}'])
        unknown = next(d for d in caught.value.diagnostics if d.code == "FZ902")
        assert unknown.help == "did you mean 'centre_y'?"
        assert "centre_y, radius, period, direction, start_angle" in unknown.facts[0]


def warned(*overrides):
    return [w.message for w in read(PAPER, overrides).warnings]


class TestSteps:
    def test_beyond_which_the_integration_is_unstable_are_refused_with_those_needed(self):
        with pytest.raises(DiagnosticError) as caught:
            read(PAPER, ["robot.actuator.lag=0.001", "run.substeps=1"])
        (one,) = caught.value.diagnostics
        assert one.message.startswith("robot.actuator.lag: run.dt / run.substeps = 0.005 s is too long")
        assert "lag of the torques of 0.001 s" in one.message
        assert one.help == "set run.substeps to 2 or more"
        assert one.file == "--set run.substeps=1"
        assert read(PAPER, ["robot.actuator.lag=0.001", "run.substeps=2"])

    @pytest.mark.parametrize(
        ("overrides", "key"),
        [
            (["robot.friction.viscous_force=1e6"], "robot.friction.viscous_force"),
            (["robots.leader.friction.viscous_torque=1e5"], "robots.leader.friction.viscous_torque"),
            (["load.mass_factor=1e-5"], "robot.friction.viscous_force"),
            (["load.inertia_factor=1e-5"], "robot.friction.viscous_torque"),
        ],
    )
    def test_of_friction_too(self, overrides, key):
        assert any(one.startswith(f"{key}: run.dt / run.substeps = 0.00125 s") for one in mistakes(*overrides))

    def test_that_no_number_of_substeps_mends_ask_for_a_shorter_period(self):
        with pytest.raises(DiagnosticError) as caught:
            read(PAPER, ["robot.friction.viscous_force=1e9"])
        assert caught.value.diagnostics[0].help == "shorten run.dt to 0.000334 s or less"

    def test_are_stable_up_to_the_root_of_the_growth_factor(self):
        def growth(z):
            return abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)

        assert growth(-STABLE_STEP) < 1.0 < growth(-STABLE_STEP - 0.001)


class TestLongLists:
    def test_are_refused_at_once(self):
        many = ",".join(["{x=0,y=99,radius=0.1}"] * 20_000)
        with at_most(5):
            (one,) = mistakes(f"obstacles=[{many}]")
            assert one == "obstacles must have at most 1000 elements, has 20000"

    def test_on_one_spot_are_said_a_few_times(self):
        many = ",".join(["{x=0,y=99,radius=0.1}"] * 1000)
        assert len(mistakes(f"obstacles=[{many}]")) == 10

    @pytest.mark.parametrize(
        "value",
        [
            'disturbances.0.robots=["' + '","'.join(f"unknown{k}" for k in range(1000)) + '"]',
            'reference={kind="waypoints",speed=1,points=[' + ",".join(["[1,1]"] * 1000) + "]}",
        ],
    )
    def test_of_names_and_places_are_said_a_few_times(self, value):
        assert len(mistakes(value)) == 10

    def test_each_overlaps_once(self):
        found = mistakes("obstacles=[{x=0,y=9,radius=1},{x=0,y=9,radius=1},{x=0,y=9,radius=1}]")
        assert [one.split(":")[0] for one in found] == [
            "obstacles.1 overlaps obstacles.0", "obstacles.2 overlaps obstacles.0",
        ]  # fmt: skip

    def test_of_mistakes_show_the_first_ones(self):
        found = mistakes(f"obstacles=[{','.join(['{x=0,y=0,radius=-1}'] * 50)}]")
        assert len(found) == 10
        assert all(f"obstacles.{k}.radius must be > 0 m" in one for k, one in enumerate(found))


class TestNames:
    @pytest.mark.parametrize("name", ["a\u0007b", "a\u001b[31mb", "a\u202eb"])
    def test_that_cannot_be_printed_are_refused(self, tmp_path, name):
        escaped = name.encode("ascii", "backslashreplace").decode()
        for text in (f'name = "{name}"', f'[robots."{name}"]\nx_0 = 9.0\ny_0 = 9.0\ntheta_0 = 0.0\nd = 0.1'):
            (tmp_path / "mine.toml").write_text(f'extends = "paper"\n{text}\n'.replace(name, escape(name)))
            with pytest.raises(DiagnosticError) as caught:
                read(tmp_path / "mine.toml")
            assert any("cannot be printed" in d.message for d in caught.value.diagnostics), escaped
            assert all(name not in f"{d}" for d in caught.value.diagnostics)

    def test_of_any_script_are_taken(self):
        assert read(PAPER, ['name="läufer ρ 走"']).scenario.name == "läufer ρ 走"


def escape(text):
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in text)


class TestRemarks:
    def test_the_paper_has_none(self):
        assert warned() == []

    def test_a_bound_that_cuts_the_safety_margin(self):
        (one,) = warned("avoidance.largest_radius=2.75")
        assert one == (
            "avoidance.largest_radius = 2.75 m cuts the safety margin: obstacle 0.5 m, robots.leader.radius = 0.56 m "
            "and avoidance.margin = 1.7 m make 2.76 m"
        )
        assert warned("avoidance.largest_radius=2.77") == []

    @pytest.mark.parametrize(("key", "stop"), [("load", 0), ("disturbances.2", 0)])
    def test_windows_after_the_end(self, key, stop):
        (one,) = warned(f"{key}.start=201", f"{key}.stop=210")
        assert one == f"{key}.start = 201 s comes after the end of the run at 200 s: it never acts"

    def test_no_windows_of_a_run_cut_short_on_purpose(self, tmp_path):
        assert warned("run.horizon=20") == []
        (tmp_path / "mine.toml").write_text('extends = "paper"\nrun.horizon = 20.0\n', encoding="utf-8")
        assert read(tmp_path / "mine.toml").warnings == ()

    @pytest.mark.parametrize(
        ("robots", "words"), [("[]", "names no robot"), ('["leader", "leader"]', "names leader twice")]
    )
    def test_lists_of_robots(self, robots, words):
        (one,) = warned(f"disturbances.0.robots={robots}")
        assert words in one

    def test_sinusoids_too_fast_for_the_integration(self):
        (one,) = warned("disturbances.0.angular_frequency=2600")
        assert "beyond π/h = 2513 rad/s" in one
        assert warned("disturbances.0.angular_frequency=2500") == []

    def test_bodies_that_start_in_one_another(self):
        assert warned("robots.follower2.x_0=-3.5", "robots.follower2.y_0=2.25") == []  # beside each other
        (one,) = warned("robots.follower2.x_0=-3.5", "robots.follower2.y_0=2.5")
        assert one == "robots.follower2 starts inside robots.follower1: their bodies overlap by 0.18 m"
        assert warned("robots.leader.x_0=0.0", "robots.leader.y_0=14.5") == []
        (one,) = warned("robots.leader.x_0=0.0", "robots.leader.y_0=14.75")
        assert one == "the body of robots.leader starts inside obstacles.0: they overlap by 0.09 m"

    def test_bodies_that_start_in_one_another_although_their_circles_do_not(self):
        (one,) = warned("robots.follower2.theta_0=0.75", "robots.follower2.body.front=4.0")
        assert one.startswith("robots.follower2 starts inside robots.leader: their bodies overlap by")

    def test_a_frequency_without_effect_is_refused(self):
        (one,) = mistakes("disturbances.1.angular_frequency=2.0")
        assert one == "disturbances.1: angular_frequency has no effect on a constant disturbance; leave it out"

    @pytest.mark.parametrize(("bearing", "bound"), [("7", "<= 2π rad, got 7"), ("-7", ">= -2π rad, got -7")])
    def test_a_bearing_beyond_a_full_turn_is_reported_with_the_turn(self, bearing, bound):
        (one,) = mistakes(f"robots.follower1.formation.bearing={bearing}")
        assert one == f"robots.follower1.formation.bearing must be {bound}"


def test_checks_come_without_the_compiler():
    code = "import sys, dwmr.scenario.remarks; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            ("robots.leader.actuator.v_limit=0.5",),
            "robots.leader.actuator.v_limit = 0.5 m/s is below the 1.054 m/s that the path asks for at (0, 0), t = 0 "
            "s: it falls behind or off the path",
        ),
        (
            ("robots.leader.actuator.omega_limit=0.1",),
            "robots.leader.actuator.omega_limit = 0.1 rad/s is below the 0.1832 rad/s that the path asks for at",
        ),
        (("robots.leader.actuator.v_limit=1.06", "robots.follower1.actuator.v_limit=0.1"), ""),
    ],
)
def test_limits_below_the_velocities_of_the_path_are_warned_of(overrides, message):
    said = [one.message for one in read(find("undisturbed"), overrides).warnings if "_limit" in one.message]
    assert [one[: len(message)] for one in said] == ([message] if message else [])
