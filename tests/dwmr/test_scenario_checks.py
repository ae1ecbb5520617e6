"""What several values of a scenario must hold together."""

import pytest

from dwmr.scenario_file import find, read
from fuzzyctl.errors import DiagnosticError

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
