"""When errors stand beside Table 12 of the paper, and how the terminal shows what is odd about a run."""

import dataclasses

import numpy as np
import pytest

from tests.dwmr.process import here
from tests.dwmr.scenarios import PAPER, by_hand, edited

#: Three places far from each other and from the obstacles.
APART = {"x": [0.0, 50.0, 100.0], "y": 0.0}


@pytest.fixture
def printed(recorded, tmp_path):
    """A function (*overrides, run=, scenario=) -> what `dwmr run` prints of a run in lines as long as they get."""

    def run(*overrides, run=None, scenario="paper"):
        run = run or by_hand(sigma_v=0.0, sigma_omega=0.0, **APART)
        recorded(run)
        options = [word for one in overrides for word in ("--set", one)]
        done = here("run", scenario, "--controller", run.controller, *options, "-o", tmp_path / "out", COLUMNS="120")
        return done.stdout

    return run


class TestTable12:
    def test_stands_beside_the_paper_whatever_its_gains_and_bodies(self, printed):
        text = printed("rules.ais_reaction.k_s=0.5", "run.save_every=1", "robot.body.width=0.5")
        assert "beside Table 12 of the paper" in text
        assert "ratio: ours / paper's" in text
        assert "Gazebo" not in text

    @pytest.mark.parametrize(
        ("overrides", "keys"),
        [
            (["robot.mass=121"], "robots.leader.mass, robots.follower1.mass, robots.follower2.mass are"),
            (["obstacles=[]"], "obstacles are"),
            (["run.horizon=300"], "run.horizon is"),
            (
                ["reference.period=199", "formation.leader_velocity=wheels", "load.mass_factor=1",
                 "robots.leader.x_0=0", "robots.follower1.formation.separation=1.3"],
                "reference, formation, load, robots.leader.x_0 and 1 more are",
            ),
        ],
    )  # fmt: skip
    def test_stands_beside_no_other_run_and_says_why(self, printed, overrides, keys):
        text = printed(*overrides)
        why_not = f"warning: Table 12 is left out, it speaks of another run: {keys} not the paper's"
        assert why_not in " ".join(text.split())
        assert "ratio" not in text

    @pytest.mark.parametrize(
        ("scenario", "overrides"), [("paper", ["run.horizon=5", "robot.mass=1"]), ("csv-path", [])]
    )
    def test_is_not_missed_in_short_runs_and_other_scenarios(self, printed, scenario, overrides):
        assert "Table" not in printed(*overrides, scenario=scenario)

    def test_has_its_counterpart_for_the_undisturbed_run(self, printed):
        names = ("sigma_v", "sigma_omega", "k_h_v", "k_h_omega", "beta_v", "beta_omega", "g_ais_v", "g_ais_omega")
        text = printed(scenario="undisturbed", run=by_hand("aifqsmc", **dict.fromkeys(names, 0.01), **APART))
        assert "Table 13 of the paper" in text
        assert "0.4604" in text
        assert "AIFQSMC in Gazebo" in " ".join(text.split())
        text = printed("robot.mass=121", scenario="undisturbed")
        assert "Table 13 is left out, it speaks of another run: robots.leader.mass" in " ".join(text.split())


class TestTerminal:
    def test_shows_names_of_robots_as_they_are(self, printed, tmp_path):
        names = {"follower1": "r[/red]", "follower2": "[bold]r"}
        scenario = edited(
            PAPER, tmp_path / "names.toml", *((f"[robots.{old}]", f'[robots."{new}"]') for old, new in names.items())
        )
        run = by_hand(sigma_v=0.0, sigma_omega=0.0, **APART)
        text = printed(run=dataclasses.replace(run, robots=("leader", *names.values())), scenario=scenario)
        tables = text.partition("warning:")[0]
        assert [tables.count(name) for name in names.values()] == [4, 4]

    def test_shows_large_numbers_by_their_power_of_ten(self, printed):
        large = 123456789.0
        t = 0.005 * np.arange(401)[:, None]
        names = ("sigma_v", "sigma_omega", "k_h_omega", "beta_v", "beta_omega", "g_ais_v", "g_ais_omega")
        run = by_hand(
            "aifqsmc", 401, x=[large, 2.0 * large, 4.0 * large], x_e=large, x_r=0.0, v_c=large * t, k_h_v=large * t,
            **dict.fromkeys(names, 0.01),
        )  # fmt: skip
        text = printed(run=run)
        errors, safety, effort, stability = (
            text.partition(f"{title}\n")[2].partition("\n\n")[0] for title in ("paper", "Safety", "Effort", "Stability")
        )
        for table in (errors, safety, effort, stability):
            assert table.count("1.235e+08") >= 1, table
        assert "+1.235e+08" in stability
        assert "123456789" not in text
