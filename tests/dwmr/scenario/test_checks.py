"""What several values of a scenario must hold together."""

import subprocess
import sys

import pytest

from dwmr import read
from tests.dwmr.scenarios import PAPER, diagnostics, messages, mistakes, warned
from tests.effort import at_most


def formation(leader, bearing=2.0):
    return f'{{leader = "{leader}", separation = 1.25, bearing = {bearing}}}'


#: By override the only message, as it begins.
REFUSED = {
    "robots.follower1.formation.leader=follower1":
        "robots.follower1.formation.leader = 'follower1': a robot cannot follow itself",
    "robots.follower1.d=0": "robots.follower1.d must be > 0 m, got 0",
    "robot.actuator.acceleration=0": "robot.actuator.acceleration must be > 0 m/s², got 0",
    "robot.actuator.angular_acceleration=0": "robot.actuator.angular_acceleration must be > 0 rad/s², got 0",
    "robots.follower1.formation.separation=0": "robots.follower1.formation.separation must be > 0 m, got 0",
    "robots.follower1.formation.bearing=7": "robots.follower1.formation.bearing must be <= 2π rad, got 7",
    "robots.follower1.formation.bearing=-7": "robots.follower1.formation.bearing must be >= -2π rad, got -7",
    "robots.follower1.delay=2.0":
        "robots.follower1.delay = 2 s, but follower1 follows leader: only a robot on the reference has a delay",
    "robots.follower1.avoids_obstacles=true":
        "robots.follower1.avoids_obstacles = true, but follower1 follows leader: only a robot on the reference avoids",
    "disturbances.1.angular_frequency=2.0":
        "disturbances.1: angular_frequency has no effect on a constant disturbance; leave it out",
    "disturbances.1.phase=1.0": "disturbances.1: phase has no effect on a constant disturbance; leave it out",
    "disturbances.0.phase=6.3": "disturbances.0.phase must be <= 2π rad, got 6.3",
    "robots.leader.formation={leader='leader',separation=1,bearing=0}":
        "robots.leader.formation.leader = 'leader': a robot cannot follow itself",
    "run.controller=pid": "run.controller names an unknown controller 'pid'",
    "run.horizon=90000": "run.horizon = 90000 s",
    'obstacles=[{x=8,y=-4,radius=0.5,velocity=[1,1],path=[[1,1,1]]}]': "obstacles.0: give velocity or path, not both",
    "obstacles=[{x=0,y=9,radius=1,path=[[1,1,1],[1,2,2]]}]": "obstacles.0: path.1 is at 1 s, not after 1 s",
    "obstacles=[{x=0,y=9,radius=1,path=[[1e-6,9,9]]}]": "obstacles.0: path.0 is reached at 9e+06 m/s",
    "obstacles=[{x=0,y=9,radius=1,path=[[0,9,9]]}]": "obstacles.0.path.0.0 must be > 0",
    "obstacles=[{x=0,y=9,radius=1,path=[]}]": "obstacles.0.path",
    "obstacles=[{x=0,y=9,radius=1,velocity=[inf,0]}]": "obstacles.0.velocity.0",
}  # fmt: skip


@pytest.mark.parametrize("override", REFUSED)
def test_values_that_cannot_be_are_refused(override):
    (one,) = messages("paper", override)
    assert one.startswith(REFUSED[override])


def test_a_formation_that_leads_in_a_circle_shows_the_circle_once():
    overrides = (f"robots.leader.formation={formation('follower2')}", "robots.leader.avoids_obstacles=false")
    (one,) = messages("paper", *overrides)
    assert "leads back to leader: leader -> follower2 -> leader" in one


class TestObstacles:
    def test_that_overlap_are_refused_and_those_that_touch_are_not(self):
        (one,) = messages("paper", "obstacles.1.x=0.5", "obstacles.1.y=15.5")
        assert one == "obstacles.1 overlaps obstacles.0: their centres are 0.5 m apart, their radii make 1 m"
        assert read(PAPER, ["obstacles.1.x=1.0", "obstacles.1.y=15.5"])

    def test_with_a_robot_in_it_at_the_start_are_refused(self):
        (one,) = messages("paper", "robots.follower2.x_0=8.0", "robots.follower2.y_0=-4.0")
        assert one.startswith("robots.follower2 starts inside obstacles.1: (8, -4) is 0.25 m from its centre")


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
        (one,) = mistakes("paper", f"reference={text}")
        assert words in one.message
        assert one.file == f"--set reference={text}" or len(text) > 60

    def test_of_another_kind_suggests_its_keys(self):
        circle = '{kind="circle",centre_x=0,center_y=0,radius=1,period=9,direction="clockwise"}'
        unknown = next(d for d in mistakes("paper", f"reference={circle}") if d.code == "FZ902")
        assert unknown.help == "did you mean 'centre_y'?"
        assert "centre_y, radius, period, direction, start_angle" in unknown.facts[0]


class TestSteps:
    def test_beyond_which_the_integration_is_unstable_are_refused_with_those_needed(self):
        (one,) = mistakes("paper", "robot.actuator.lag=0.001", "run.substeps=1")
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
        assert any(one.startswith(f"{key}: run.dt / run.substeps = 0.00125 s") for one in messages("paper", *overrides))

    def test_that_no_number_of_substeps_mends_ask_for_a_shorter_period(self):
        assert mistakes("paper", "robot.friction.viscous_force=1e9")[0].help == "shorten run.dt to 0.000334 s or less"

    def test_are_stable_up_to_the_root_of_the_growth_factor(self):
        def growth(z):
            return abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)

        # RK4 grows beyond a step of 2.785 lags: 0.005 s in one step needs a lag of 1.7951 ms
        assert growth(-0.005 / 0.0017954) < 1.0 < growth(-0.005 / 0.001795)
        assert read(PAPER, ["robot.actuator.lag=0.0017954", "run.substeps=1"])
        assert messages("paper", "robot.actuator.lag=0.001795", "run.substeps=1")


class TestLongLists:
    def test_too_many_robots_are_refused_with_their_limit(self, tmp_path):
        start = "x_0 = 0.0\ny_0 = 0.0\ntheta_0 = 0.0\nd = 0.4\n"
        robots = "".join(f"[robots.r{k}]\n{start}" for k in range(1001))
        (tmp_path / "many.toml").write_text(f'extends = "paper"\n{robots}', encoding="utf-8")
        assert messages(tmp_path / "many.toml") == ["robots must have at most 1000 elements, has more"]

    def test_are_refused_at_once(self):
        many = ",".join(["{x=0,y=99,radius=0.1}"] * 20_000)
        with at_most(5):
            assert messages("paper", f"obstacles=[{many}]") == [
                "obstacles must have at most 1000 elements, has 20000"
            ]  # fmt: skip

    @pytest.mark.parametrize(
        "value",
        [
            f"obstacles=[{','.join(['{x=0,y=99,radius=0.1}'] * 1000)}]",
            f"obstacles=[{','.join(['{x=0,y=0,radius=-1}'] * 50)}]",
            'disturbances.0.robots=["' + '","'.join(f"unknown{k}" for k in range(1000)) + '"]',
            'reference={kind="waypoints",speed=1,points=[' + ",".join(["[1,1]"] * 1000) + "]}",
        ],
        ids=["on-one-spot", "negative", "names", "places"],
    )
    def test_of_mistakes_show_the_first_ones(self, value):
        assert len(messages("paper", value)) == 10

    def test_each_overlaps_once(self):
        found = messages("paper", "obstacles=[{x=0,y=9,radius=1},{x=0,y=9,radius=1},{x=0,y=9,radius=1}]")
        assert [one.split(":")[0] for one in found] == [
            "obstacles.1 overlaps obstacles.0", "obstacles.2 overlaps obstacles.0",
        ]  # fmt: skip


class TestNames:
    @pytest.mark.parametrize("name", ["a\u0007b", "a\u001b[31mb", "a\u202eb"])
    def test_that_cannot_be_printed_are_refused(self, tmp_path, name):
        escaped = "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in name)
        for text in (f'name = "{escaped}"', f'[robots."{escaped}"]\nx_0 = 9.0\ny_0 = 9.0\ntheta_0 = 0.0\nd = 0.1'):
            (tmp_path / "mine.toml").write_text(f'extends = "paper"\n{text}\n')
            found = diagnostics(read, tmp_path / "mine.toml")
            assert any("cannot be printed" in d.message for d in found)
            assert all(name not in f"{d}" for d in found)

    def test_of_any_script_are_taken(self):
        assert read(PAPER, ['name="läufer ρ 走"']).scenario.name == "läufer ρ 走"


#: Overrides of the paper's run, and the only warning as it begins; empty for none.
WARNED = [
    ([], ""),
    ([f"robots.follower1.formation={formation('leader', -2.356194490192345)}"],
     "robots.follower2 and robots.follower1 are sent to the same place behind leader"),
    (["avoidance.largest_radius=2.75"],
     "avoidance.largest_radius = 2.75 m cuts the safety margin: obstacle 0.5 m, robots.leader.radius = 0.56 m and "
     "avoidance.margin = 1.7 m make 2.76 m"),
    (["avoidance.largest_radius=2.77"], ""),
    (["load.start=201", "load.stop=210"],
     "load.start = 201 s comes after the end of the run at 200 s: it never acts"),
    (["disturbances.2.start=201", "disturbances.2.stop=210"], "disturbances.2.start = 201 s comes after the end"),
    (["run.horizon=20"], ""),
    (["run.horizon=1.003"], "run.horizon = 1.003 s is not a multi"),
    (["disturbances.0.robots=[]"], "disturbances.0.robots = [] names no robot"),
    (['disturbances.0.robots=["leader", "leader"]'], "disturbances.0.robots names leader twice"),
    (["disturbances.0.angular_frequency=2600"], "disturbances.0.angular_frequency = 2600 rad/s"),
    (["disturbances.0.angular_frequency=2500"], ""),
    (["robots.follower2.x_0=-3.5", "robots.follower2.y_0=2.25"], ""),  # beside each other
    (["robots.follower2.x_0=-3.5", "robots.follower2.y_0=2.5"],
     "robots.follower2 starts inside robots.follower1: their bodies overlap by 0.18 m"),
    (["robots.leader.x_0=0.0", "robots.leader.y_0=14.5"], ""),
    (["robots.leader.x_0=0.0", "robots.leader.y_0=14.75"],
     "the body of robots.leader starts inside obstacles.0: they overlap by 0.09 m"),
    (["robots.follower2.theta_0=0.75", "robots.follower2.body.front=4.0"],
     "robots.follower2 starts inside robots.leader: their bodies overlap by"),
]  # fmt: skip


@pytest.mark.parametrize(("overrides", "message"), WARNED)
def test_odd_values_are_warned_of(overrides, message):
    assert [one[: len(message)] for one in warned("paper", *overrides)] == ([message] if message else [])


def test_a_horizon_in_a_file_that_ends_before_a_window_is_no_slip(tmp_path):
    (tmp_path / "mine.toml").write_text('extends = "paper"\nrun.horizon = 20.0\n', encoding="utf-8")
    assert warned(tmp_path / "mine.toml") == []


def test_checks_come_without_the_compiler():
    code = "import sys, dwmr; dwmr.read('paper'); print('numba' in sys.modules)"
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
    found = [one for one in warned("undisturbed", *overrides) if "_limit" in one]
    assert [one[: len(message)] for one in found] == ([message] if message else [])


def test_a_limit_of_acceleration_that_a_car_does_not_use_is_warned_of():
    (one,) = warned("ackermann", "robots.leader.actuator.angular_acceleration=1")
    assert one.startswith("robots.leader.actuator.angular_acceleration has no effect: robots.leader is a car")
    assert warned("ackermann", "robots.leader.actuator.acceleration=1") == []


@pytest.mark.parametrize("key", ["acceleration", "angular_acceleration"])
def test_a_limit_of_acceleration_of_0_is_shown_in_its_line(tmp_path, key):
    path = tmp_path / "mine.toml"
    path.write_text(f'extends = "paper"\n[robot.actuator]\n{key} = 0.0\n', encoding="utf-8")
    (one,) = mistakes(path)
    assert one.message.startswith(f"robot.actuator.{key} must be > 0 ")
    assert (one.span.line, one.span.source.name) == (3, str(path))
