"""Runs behind the safety filter: crowds that do not touch, moments that are recorded, laws that are left alone."""

import io

import numpy as np
import pytest
from rich.console import Console

from dwmr.control.safety_filter import rate_bound
from dwmr.output.report import barriers, filter_cells, print_report
from dwmr.page.document import safety_filter
from dwmr.results.distances import moments, obstacle_gaps, rate_bounds, robot_gaps
from dwmr.results.metrics import errors, measure, rmse
from dwmr.scenario.outlines import centres
from tests import explanation, sizes
from tests.dwmr.scenarios import shared

SCENES = sizes.examples(20, 6)
NONE = "obstacles=[]"
FILTER = (
    "safety={alpha=1.0,lookahead=0.3,margin=0.0,velocity_error=0.1,acceleration=3.0,angular_acceleration=6.0}"
)  # fmt: skip


CROWDS, ALONE = explanation.script("avoidance/crowds.py"), explanation.script("avoidance/alone.py")


def run(law, *overrides, name="paper-with-limits"):
    return shared(name, law, *overrides)


def corners(trajectory, scenario, robot):
    """Corners of a body, shape (4, samples, 2)."""
    i, own = trajectory.robots.index(robot), scenario.robots[robot]
    x, y, theta = (trajectory[key][:, i] for key in ("x", "y", "theta"))
    half = 0.5 * own.body.width
    found = []
    for along, across in (
        (own.body.front, half),
        (-own.body.rear, half),
        (-own.body.rear, -half),
        (own.body.front, -half),
    ):
        ahead = along - own.d
        found.append([
            x + ahead * np.cos(theta) - across * np.sin(theta), y + ahead * np.sin(theta) + across * np.cos(theta)
        ])  # fmt: skip
    return np.array(found).transpose(0, 2, 1)


def to_edges(places, outline):
    """Least distance of points from the edges of bodies, shape (samples,)."""
    least = np.full(len(places), np.inf)
    for k in range(4):
        begin, edge = outline[k], outline[(k + 1) % 4] - outline[k]
        share = np.clip(np.sum((places - begin) * edge, axis=1) / np.sum(edge * edge, axis=1), 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(places - begin - share[:, None] * edge).T))
    return least


class TestCrowds:
    @pytest.mark.parametrize("number", range(SCENES))
    def test_touch_only_after_a_moment_that_is_recorded(self, number):
        found = CROWDS.outcome(number, 0, "aifqsmc")
        assert found["unexplained"] == []
        assert not found["stopped"]
        assert found["acts"] > 0.0
        if not found["infeasible"] and not found["missed"]:
            assert found["disc_gap"] >= CROWDS.SAFETY["margin"] - 1e-6
        assert found["least_gap"] >= found["disc_gap"] - 1e-9

    def test_are_as_far_apart_as_edges_and_corners_say(self):
        file, trajectory = CROWDS.run(3, 0, "aifqsmc")
        scenario, outlines = file.scenario, {n: corners(trajectory, file.scenario, n) for n in trajectory.robots}
        for name in trajectory.robots:
            gaps, places = obstacle_gaps(trajectory, scenario, name), centres(scenario, trajectory.t)
            for a, one in enumerate(scenario.obstacles):
                assert gaps[:, a] == pytest.approx(to_edges(places[:, a], outlines[name]) - one.radius, abs=1e-9)
        for first, second, near, gaps in robot_gaps(trajectory, scenario):
            a, b = outlines[first][:, near], outlines[second][:, near]
            apart = [to_edges(one, other) for mine, other in ((a, b), (b, a)) for one in mine]
            assert gaps == pytest.approx(np.min(apart, axis=0), abs=1e-9)


class TestLaws:
    @pytest.mark.parametrize("law", ALONE.LAWS)
    def test_are_left_as_they_are_where_nothing_is_near(self, law):
        free, guarded = ALONE.run(law, 5.0), ALONE.run(law, 5.0, ALONE.SAFETY)
        assert guarded.values == pytest.approx(free.values, abs=1e-8)  # but for l ω over l

    def test_hardly_notice_the_filter_in_a_wide_formation(self):
        """Followers 4 m from their leader: the discs never come into play."""
        wide = ("run.horizon=30", NONE, *(f"robots.follower{k}.formation.separation=4" for k in (1, 2)))
        free, guarded = run("aifqsmc", *wide), run("aifqsmc", *wide, FILTER)
        for signal in ("x_e", "y_e", "theta_e"):
            before, after = (rmse(errors(one[1], "leader", "body")[signal]) for one in (free, guarded))
            assert after <= 1.1 * before
        found = measure(guarded[1], guarded[0].scenario)["safety"]
        assert found["infeasible"] == found["missed"] == []

    def test_of_all_kinds_run_behind_the_filter(self):
        for law in ("smc", "fcafsmc"):
            file, trajectory = run(law, "run.horizon=10", FILTER, NONE)
            found = measure(trajectory, file.scenario)["safety"]
            assert found["infeasible"] == []
            assert min(found["disc_gap"].values()) >= 0.0

    def test_keep_apart_by_what_noise_lets_them_measure(self):
        noise = ("robot.noise.x=0.02", "robot.noise.y=0.02", "robot.noise.theta=0.02", "run.horizon=40")
        file, trajectory = run("fcafsmc", *noise, name="moving-obstacles")
        found = measure(trajectory, file.scenario)["safety"]
        assert found["infeasible"] == found["missed"] == []
        assert min(found["disc_gap"].values()) >= file.scenario.safety.margin
        assert min(found["acts"].values()) > 0.2

    def test_without_a_filter_say_nothing_of_it(self):
        file, trajectory = run("smc", "run.horizon=1", NONE)
        assert "safety" not in measure(trajectory, file.scenario)
        assert "safe_v" not in trajectory.names


class TestMoments:
    def test_are_spans_of_time(self):
        t = np.arange(0.0, 5.0, 0.1)
        amounts = np.where((t > 0.95) & (t < 1.25) | (t > 1.45) & (t < 1.65) | (t > 3.95), 0.5, 0.0)
        amounts[15] = 0.7
        first, second = moments(t, amounts)
        assert (first["t"], first["lasted"], first["by"], first["sample"]) == pytest.approx((1.0, 0.7, 0.7, 10))
        assert (second["t"], second["lasted"]) == pytest.approx((4.0, 1.0))
        assert moments(t, 0.0 * t) == []

    def test_of_an_obstacle_that_runs_into_a_robot_have_time_and_place(self):
        file, trajectory = run(
            "aifqsmc", "run.horizon=8", FILTER, "obstacles=[{x=8,y=1,radius=0.5,velocity=[-3,0]}]",
            "robots.leader.actuator.v_limit=0.5",
        )  # fmt: skip
        found = measure(trajectory, file.scenario)["safety"]
        (one, *_) = [moment for moment in found["infeasible"] if moment["robot"] == "leader"]
        assert one["with"] == "obstacles.0"
        assert 0.5 < one["t"] < 3.0
        assert abs(one["x"]) < 2.0
        assert one["by"] > 0.5
        line = barriers({"safety": found})[0]
        assert line.startswith("no command within the limits keeps ")

    def test_of_velocities_that_do_not_follow_are_those_of_a_push(self):
        push = "disturbances=[{kind='constant',start=3,stop=6,v=1.2,omega=0,force=0,torque=0,robots=['follower1']}]"
        close = "robots.follower1.formation={leader='leader',separation=2.3,bearing=3.14159}"
        file, trajectory = run("aifqsmc", "run.horizon=8", FILTER, NONE, push, close)
        found = measure(trajectory, file.scenario)["safety"]
        assert any({one["robot"], one["with"]} == {"leader", "follower1"} for one in found["missed"])
        assert all(3.0 <= one["t"] < 8.0 for one in found["missed"])

    def test_of_rates_are_judged_by_the_bound_of_the_filter(self):
        distance = np.linspace(0.1, 3.0, 30)
        assert rate_bounds(2.0, distance, 1.0) == pytest.approx([rate_bound(2.0, d, 1.0) for d in distance])


def test_tables_of_a_run_have_what_the_filter_did():
    file, trajectory = run("fcafsmc", "run.horizon=2", name="moving-obstacles")
    found = {"fcafsmc": measure(trajectory, file.scenario)}
    share = 100.0 * found["fcafsmc"]["safety"]["acts"]["follower2"]
    assert filter_cells(found["fcafsmc"], "follower2")[1:] == [f"{share:.1f}", "0", "0"]
    text = io.StringIO()
    print_report(Console(file=text, width=100), {"controllers": found}, None)
    assert "Safety filter" in text.getvalue()
    assert f">{share:.1f}<" in safety_filter(found)
    assert safety_filter({"fcafsmc": {}}) == ""


def test_report_names_five_moments_and_counts_the_others():
    one = {"robot": "a", "with": "b", "t": 1.0, "lasted": 0.5, "x": 0.0, "y": 2.0, "by": 0.25}
    lines = barriers({"safety": {"infeasible": [one] * 7, "missed": [one]}})
    assert lines[0] == "no command within the limits keeps a away from b at t = 1.00 s, (0.00, 2.00) m, for 0.50 s, " \
        "0.25 m/s at most"  # fmt: skip
    assert lines[5] == "2 more such moments are under safety.infeasible of summary.json"
    assert lines[6].startswith("a comes nearer to b than its command allows at t = 1.00 s")
