"""Runs behind the safety filter: crowds that do not touch, moments that are recorded, laws that are left alone."""

import csv
import dataclasses
import json

import numpy as np
import pytest

from dwmr import measure
from dwmr.scenario.outlines import centres
from tests import explanation, sizes
from tests.dwmr.process import here
from tests.dwmr.scenarios import changed, shared

SCENES = sizes.examples(20, 6)
NONE = "obstacles=[]"
FILTER = (
    "safety={alpha=1.0,lookahead=0.3,margin=0.0,velocity_error=0.1,acceleration=3.0,angular_acceleration=6.0}"
)  # fmt: skip


#: A filter that keeps just the discs apart.
EXACT = "safety={alpha=1.0,lookahead=0.3,margin=0.0,velocity_error=0.0,acceleration=1e6,angular_acceleration=1e6}"
KINDS = ("infeasible", "missed")
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


def sample(trajectory, k):
    """Return the part of a run at some samples."""
    parts = {name: getattr(trajectory, name)[k] for name in ("t", "values", "law_values")}
    return dataclasses.replace(trajectory, **parts)


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
        places = centres(scenario, trajectory.t)
        for k in range(0, len(trajectory.t), 100):
            now = slice(k, k + 1)
            gaps = measure(sample(trajectory, now), scenario, ["obstacle_gap", "robot_gap"])
            for name, outline in outlines.items():
                to_obstacles = [
                    to_edges(places[now, a], outline[:, now])[0] - one.radius
                    for a, one in enumerate(scenario.obstacles)
                ]
                assert gaps["obstacle_gap"][name] == pytest.approx(min(to_obstacles), abs=1e-9)
                others = [(outline[:, now], other[:, now]) for n, other in outlines.items() if n != name]
                apart = [to_edges(one, b) for pair in others for a, b in (pair, pair[::-1]) for one in a]
                assert gaps["robot_gap"][name] == pytest.approx(np.min(apart), abs=1e-9)


class TestLaws:
    @pytest.mark.parametrize("law", ALONE.LAWS)
    def test_are_left_as_they_are_where_nothing_is_near(self, law):
        free, guarded = ALONE.run(law, 5.0), ALONE.run(law, 5.0, ALONE.SAFETY)
        assert guarded.values == pytest.approx(free.values, abs=1e-8)  # but for l ω over l

    def test_hardly_notice_the_filter_in_a_wide_formation(self):
        """Followers 4 m from their leader: the discs never come into play."""
        wide = ("run.horizon=30", NONE, *(f"robots.follower{k}.formation.separation=4" for k in (1, 2)))
        free, guarded = run("aifqsmc", *wide), run("aifqsmc", *wide, FILTER)
        before, after = (measure(trajectory, file.scenario) for file, trajectory in (free, guarded))
        for signal in ("x_e", "y_e", "theta_e"):
            assert after["rmse_body"]["leader"][signal] <= 1.1 * before["rmse_body"]["leader"][signal]
        found = after["safety"]
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
        scenario, trajectory = guarded_by_hand(amounts)
        first, second = measure(dataclasses.replace(trajectory, t=t), scenario)["safety"]["infeasible"]
        assert (first["t"], first["lasted"], first["by"]) == pytest.approx((1.0, 0.7, 0.7))
        assert (second["t"], second["lasted"]) == pytest.approx((4.0, 1.0))
        assert (first["robot"], first["with"]) == ("leader", "obstacles.0")
        scenario, trajectory = guarded_by_hand(0.0 * amounts)
        assert measure(trajectory, scenario)["safety"]["infeasible"] == []

    def test_of_an_obstacle_that_runs_into_a_robot_have_time_and_place(self):
        file, trajectory = run(
            "aifqsmc", "run.horizon=8", FILTER[:-1] + ",keep_right=0.0}",
            "obstacles=[{x=8,y=1,radius=0.5,velocity=[-3,0]}]",
            "robots.leader.actuator.v_limit=0.5",
        )  # fmt: skip
        found = measure(trajectory, file.scenario)["safety"]
        (one, *_) = [moment for moment in found["infeasible"] if moment["robot"] == "leader"]
        assert one["with"] == "obstacles.0"
        assert 0.5 < one["t"] < 3.0
        assert abs(one["x"]) < 2.0
        assert one["by"] > 0.5

    def test_of_velocities_that_do_not_follow_are_those_of_a_push(self):
        push = "disturbances=[{kind='constant',start=3,stop=6,v=1.2,omega=0,force=0,torque=0,robots=['follower1']}]"
        close = "robots.follower1.formation={leader='leader',separation=2.3,bearing=3.14159}"
        file, trajectory = run("aifqsmc", "run.horizon=8", FILTER, NONE, push, close)
        found = measure(trajectory, file.scenario)["safety"]
        assert any({one["robot"], one["with"]} == {"leader", "follower1"} for one in found["missed"])
        assert all(3.0 <= one["t"] < 8.0 for one in found["missed"])

    @pytest.mark.parametrize(("share", "is_missed"), [(0.98, False), (1.02, True)])
    def test_of_rates_are_judged_by_the_bound_of_the_barrier(self, share, is_missed):
        """The leader drives straight at an obstacle: of z = 2 m and R it may approach by α (z² − R²) / 2z."""
        scenario, trajectory = guarded_by_hand(np.zeros(2))
        (obstacle, *_), robot = scenario.obstacles, scenario.robots["leader"]
        ahead, dt = scenario.safety.lookahead - robot.d, scenario.run.dt

        def missed(place, speed):
            x = np.array([place, place + speed * dt]) - ahead
            run = changed(
                trajectory,
                x=lambda old: np.stack([x, *old.T[1:]], axis=1),
                y=lambda old: np.stack([[obstacle.y] * 2, *old.T[1:]], axis=1),
            )
            found = measure(run, scenario)["safety"]
            return found["disc_gap"]["leader"], [one for one in found["missed"] if one["with"] == "obstacles.0"]

        gap, _ = missed(obstacle.x - 2.0, 0.0)
        least = 2.0 - gap  # the radii of the discs
        bound = scenario.safety.alpha * (2.0**2 - least**2) / (2.0 * 2.0)
        assert bool(missed(obstacle.x - 2.0, share * bound)[1]) == is_missed


def guarded_by_hand(amounts):
    """Robots that rest far from all else behind a filter without a margin, whose leader's shortfalls are given."""
    file, run = shared("paper-with-limits", "smc", "run.horizon=0.01", EXACT)
    samples = len(amounts)
    parts = {name: np.repeat(getattr(run, name)[:1], samples, axis=0) for name in ("values", "law_values")}
    run = dataclasses.replace(run, t=file.scenario.run.dt * np.arange(samples), **parts)
    far = np.array([-100.0, -200.0, -300.0])
    shortfall = np.stack([amounts, 0.0 * amounts, 0.0 * amounts], axis=1)
    return file.scenario, changed(run, x=far, y=far, theta=0.0, safe_shortfall=shortfall, safe_conflict=3.0)


def test_tables_of_a_run_have_what_the_filter_did(recorded, tmp_path):
    file, run = shared("moving-obstacles", "fcafsmc", "run.horizon=2")
    amounts = 0.25 * (np.arange(401) % 40 < 4)
    shortfall = np.stack([0.0 * amounts, amounts, 0.0 * amounts], axis=1)
    run = changed(run, safe_shortfall=shortfall, safe_conflict=0.0)
    run = dataclasses.replace(run, t=10.0 * run.t)  # moments that are apart
    recorded(run)
    found = measure(run, file.scenario)["safety"]
    acts, gap = (found[name]["follower2"] for name in ("acts", "disc_gap"))
    moments = {kind: [sum(n in (m["robot"], m["with"]) for m in found[kind]) for n in run.robots] for kind in KINDS}
    assert moments["infeasible"][1] == 11
    options = ("moving-obstacles", "--controller", "fcafsmc", "--set", "run.horizon=2")
    text = here("run", *options, "-o", tmp_path / "out").stdout
    rows = [row.split() for row in text.partition("Safety filter")[2].partition("Effort")[0].splitlines()]
    (row,) = [row for row in rows if "follower2" in row]
    assert row[-4:] == [f"{gap:.2f}", f"{100.0 * acts:.1f}", *(str(moments[kind][2]) for kind in KINDS)]
    said = " ".join(text.split())
    (first, *_) = found["infeasible"]
    place = f"at t = {first['t']:.2f} s, ({first['x']:.2f}, {first['y']:.2f}) m, for {first['lasted']:.2f} s, 0.25 m/s"
    assert f"no command within the limits keeps {first['robot']} away from {first['with']} {place} at most" in said
    assert said.count("no command within the limits keeps") == 5
    assert f"{len(found['infeasible']) - 5} more such moments are under safety.infeasible of summary.json" in said
    assert ("comes nearer to" in said) == bool(found["missed"])
    here("report", *options, "-o", tmp_path / "page.html")
    assert f">{100.0 * acts:.1f}<" in (tmp_path / "page.html").read_text(encoding="utf-8")
    spec = 'scenario = "moving-obstacles"\ncontrollers = ["fcafsmc"]\nmeasures = ["safety"]\n'
    (tmp_path / "spec.toml").write_text(spec, encoding="utf-8")
    here("sweep", tmp_path / "spec.toml", "--jobs", "1", "--set", "run.horizon=2", "-o", tmp_path / "swept")
    with (tmp_path / "swept" / "results.csv").open(newline="", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    for kind in KINDS:
        assert [int(row[f"safety.{kind}.{name}"]) for name in run.robots] == moments[kind]
    assert (float(row["safety.acts.follower2"]), float(row["safety.disc_gap.follower2"])) == (acts, gap)
    units = json.loads((tmp_path / "swept" / "sweep.json").read_text(encoding="utf-8"))["columns"]
    assert [units[f"safety.{name}.leader"] for name in ("disc_gap", "acts")] == [{"unit": "m"}, {"unit": ""}]
