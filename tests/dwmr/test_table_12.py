"""When errors stand beside Table 12 of the paper, and how the terminal shows what is odd about a run."""

import io

import pytest
from rich.console import Console

from dwmr import find, read
from dwmr.output.report import print_report
from dwmr.results.paper_tables import beside, differences


def paper(*overrides):
    return read(find("paper"), overrides).scenario


def printed(*, robot="leader", large=0.5, number=12, why_not=""):
    run = {
        "rmse": {robot: dict.fromkeys(("x_e", "y_e", "theta_e"), large)}, "centre_distance": {robot: large},
        "obstacle_gap": {robot: None}, "robot_gap": {robot: None}, "obstacles_hit": [], "robots_hit": [],
        "avoidance_s": {robot: 0.0}, "chattering": {robot: {"v": large, "omega": large}}, "condition_violated": {},
        "saturation": {robot: dict.fromkeys(("v", "omega", "torque"), 0.0)}, "wall_s": 0.1, "stopped": None,
        "lyapunov": {robot: {}}, "drift": {robot: {"k_h_v": dict.fromkeys(("largest", "final", "growth"), large)}},
    }  # fmt: skip
    out = Console(width=120, record=True, file=io.StringIO())
    print_report(out, {"controllers": {"aifqsmc": run}}, number, why_not)
    return out.export_text()


class TestTable12:
    def test_stands_beside_the_paper_whatever_its_gains(self):
        assert beside(paper()) == (12, "")
        assert beside(paper("rules.ais_reaction.k_s=0.5", "run.save_every=1")) == (12, "")

    @pytest.mark.parametrize(
        ("override", "key"),
        [
            ("robot.mass=121", "robots.leader.mass, robots.follower1.mass, robots.follower2.mass are"),
            ("reference.period=199", "reference is"),
            ("obstacles=[]", "obstacles are"),
            ("robots.leader.x_0=0", "robots.leader.x_0 is"),
            ("robots.follower1.formation.separation=1.3", "robots.follower1.formation is"),
            ("load.mass_factor=1", "load is"),
            ("formation.leader_velocity=wheels", "formation is"),
            ("run.horizon=300", "run.horizon is"),
        ],
    )
    def test_stands_beside_no_other_run_and_says_why(self, override, key):
        number, why_not = beside(paper(override))
        assert number is None
        assert why_not == f"Table 12 is left out, it speaks of another run: {key} not the paper's"
        assert why_not in " ".join(printed(number=number, why_not=why_not).split())

    def test_a_ratio_is_explained_where_there_is_one(self):
        assert "ratio: ours / paper's" in printed()
        assert "ratio" not in printed(number=None)

    def test_is_not_missed_in_short_runs_and_other_scenarios(self):
        assert beside(paper("run.horizon=5", "robot.mass=1")) == (None, "")
        assert beside(read(find("five-robots")).scenario) == (None, "")

    def test_has_its_counterpart_for_the_undisturbed_run(self):
        assert beside(read(find("undisturbed")).scenario) == (13, "")
        number, why_not = beside(read(find("undisturbed"), ["robot.mass=121"]).scenario)
        assert number is None
        assert why_not.startswith("Table 13 is left out, it speaks of another run: robots.leader.mass")
        assert "Table 13 of the paper" in printed(number=13)
        assert "0.4604" in printed(number=13)
        assert "AIFQSMC in Gazebo" in " ".join(printed(number=13).split())
        assert "Gazebo" not in printed(number=12)

    def test_is_shown_for_a_run_with_other_bodies(self):
        assert beside(paper("robot.body.width=0.5")) == (12, "")

    def test_takes_fitted_amplitudes_for_the_papers_where_they_are_to_be_fitted(self):
        assert differences(paper("disturbances.0.v=0.2", "robot.mass=121"), fitted=True) == ()
        assert differences(paper("disturbances.0.stop=21", "robots.leader.d=0.2"), fitted=True) == (
            "disturbances", "robots.leader.d",
        )  # fmt: skip


class TestTerminal:
    @pytest.mark.parametrize("name", ["r[/red]", "[bold]r"])
    def test_shows_names_of_robots_as_they_are(self, name):
        assert printed(robot=name, number=None).count(name) == 4

    def test_shows_large_numbers_by_their_power_of_ten(self):
        text = printed(large=123456789.0, number=None)
        assert text.count("1.235e+08") == 11
        assert "+1.235e+08" in text
        assert "123456789" not in text
