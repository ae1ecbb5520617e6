import dataclasses
import os
import signal
import time

import numpy as np
import pytest

from dwmr import find
from dwmr import read as read_scenario
from dwmr.sweep.robots import Robots, read_spec, unit_of
from fuzzyctl import DiagnosticError
from fuzzyctl.experiments import sweep_plan, sweep_workers
from fuzzyctl.experiments.sweep_variables import Variable, expand
from fuzzyctl.experiments.sweep_workers import Setup

SPEC = """
scenario = "paper"
controllers = ["smc", "aifqsmc"]
runs = 3
seed = 7

[set]
"run.horizon" = 1.0

[grid]
"rules.ais_reaction.k_s" = [0.4, 0.5]

[random]
"robots.*.mass" = { uniform = [100, 140] }
"robots.leader.x_0" = { normal = [0.0, 0.1], relative = "offset" }
"disturbances.*.v" = { uniform = [0.5, 2.0], relative = "factor" }
"""


def read(tmp_path, text=SPEC, name="spec.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return read_spec(path)


def made(tmp_path, text=SPEC, overrides=()):
    return sweep_plan.make(Robots(), read(tmp_path, text), overrides)


def mistakes(tmp_path, text, overrides=()):
    with pytest.raises(DiagnosticError) as caught:
        made(tmp_path, text, overrides)
    return caught.value.diagnostics


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """The plan of SPEC as it is."""
    return made(tmp_path_factory.mktemp("usual"))


@pytest.fixture(scope="module")
def paper():
    """The scenario of SPEC."""
    return read_scenario(find("paper")).scenario


class TestIdle:
    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ('"aifqsmc"]', '"fcafsmc"]', "no run reads rule file ais_reaction"),
            ('"rules.ais_reaction.k_s"', '"robot.controllers.fcafsmc.p_v"', "no run reads gains of fcafsmc"),
            ('"robots.*.mass"', '"robots.*.controllers.fcafsmc.p_v"', "random.robots.*.controllers.fcafsmc.p_v varies"),
        ],
    )  # fmt: skip
    def test_what_varies_without_effect_is_said(self, tmp_path, old, new, words):
        (one,) = made(tmp_path, SPEC.replace(old, new).replace("[100, 140]", "[0.1, 0.2]")).warnings
        assert words in one.message
        assert one.severity == "warning"
        assert one.span is not None

    def test_what_some_law_reads_is_no_matter(self, tmp_path, usual):
        assert usual.warnings == ()
        text = SPEC.replace('"rules.ais_reaction.k_s"', '"robot.controllers.aifqsmc.p_v"')
        assert made(tmp_path, text.replace('["smc", "aifqsmc"]', '["aifqsmc_without_layer"]')).warnings == ()


class TestSpec:
    @pytest.mark.parametrize(
        ("old", "new", "line", "words"),
        [
            ("seed = 7", "sed = 7", 5, "unknown key sed"),
            ('["smc", "aifqsmc"]', '["smc", "smc"]', 3, "controllers has smc 2 times"),
            ("[0.4, 0.5]", "[0.4, 0.5, 0.4]", 11, "grid.rules.ais_reaction.k_s has 0.4 2 times"),
            ("[random]", "[random]\nrobots.leader.x_0 = { choice = [1] }", 16, "robots.leader.x_0 is given twice"),
            ("seed = 7", 'measures = ["rsme"]', 5, "'rsme'"),
            ("uniform = [100, 140]", "unifrom = [100, 140]", 14, "unknown key random.robots.*.mass.unifrom"),
            ("uniform = [100, 140]", "uniform = [140, 100]", 14, "140 is greater than 100"),
            ("uniform = [100, 140]", "loguniform = [0, 1]", 14, "both values must be > 0"),
            ("uniform = [100, 140]", "uniform = [1, 2], normal = [0, 1]", 14, "exactly one of"),
            ("normal = [0.0, 0.1]", "normal = [0.0, -0.1]", 15, "standard deviation"),
        ],
    )
    def test_answers_a_mistake_at_its_line(self, tmp_path, old, new, line, words):
        assert old in SPEC
        with pytest.raises(DiagnosticError) as caught:
            read(tmp_path, SPEC.replace(old, new, 1))
        found = caught.value.diagnostics
        assert any(words in d.message and d.span is not None and d.span.line == line for d in found), found

    def test_values_of_other_types_are_no_repetition(self, tmp_path):
        read(tmp_path, SPEC.replace("[0.4, 0.5]", '[1, true, "1", 1.0]'))


class TestVariables:
    def test_a_star_stands_for_every_robot_and_every_element(self, tmp_path, paper):
        keys = [one.key for one in expand(read(tmp_path), paper)]
        assert keys == [
            "robots.leader.mass", "robots.follower1.mass", "robots.follower2.mass", "robots.leader.x_0",
            "disturbances.0.v", "disturbances.1.v", "disturbances.2.v", "disturbances.3.v",
        ]  # fmt: skip

    DOTTED = """
extends = "paper"
[robots."r.1"]
x_0 = -3.0
y_0 = -1.0
theta_0 = 0.0
d = 0.4
formation = { leader = "leader", separation = 2.5, bearing = 3.0 }
"""

    @pytest.mark.parametrize("key", ["'robots.\"r.1\".x_0'", 'robots."r.1".x_0', "\"robots.'r.1'.x_0\""])
    def test_a_name_with_a_dot_is_written_in_quotes(self, tmp_path, key):
        (tmp_path / "dotted.toml").write_text(self.DOTTED, encoding="utf-8")
        spec = f'scenario = "dotted.toml"\n[random]\n{key} = {{ uniform = [0.5, 0.6], relative = "offset" }}\n'
        (run,) = made(tmp_path, spec).runs
        assert list(run.values) == ['robots."r.1".x_0']
        assert -2.5 <= run.values['robots."r.1".x_0'] <= -2.4
        assert read_scenario(run.path, run.overrides).scenario.robots["r.1"].x_0 == run.values['robots."r.1".x_0']

    def test_a_mistake_about_a_name_with_a_dot_stands_at_its_line(self, tmp_path):
        (tmp_path / "dotted.toml").write_text(self.DOTTED, encoding="utf-8")
        (found,) = mistakes(tmp_path, 'scenario = "dotted.toml"\n[random]\nrobots."r.1".mass = { choice = [-1.0] }\n')
        assert found.span.line == 3
        assert "mass must be > 0 kg, got -1.0" in found.message

    def test_a_draw_depends_on_seed_repetition_and_key_alone(self, tmp_path):
        distribution = read(tmp_path).spec.random["robots.*.mass"]
        one = Variable("robots.leader.mass", "robots.*.mass", distribution)
        other = dataclasses.replace(one, key="robots.follower1.mass")
        draws = {one.draw(1, 0), one.draw(1, 1), one.draw(2, 0), other.draw(1, 0)}
        assert len(draws) == 4
        assert one.draw(1, 0) == dataclasses.replace(one, written="robots.leader.mass").draw(1, 0)

    @pytest.mark.parametrize(
        ("distribution", "mean", "deviation"),
        [
            ("normal = [3.0, 0.5]", 3.0, 0.5),
            ("choice = [1.0, 2.0, 6.0]", 3.0, (14 / 3) ** 0.5),
            ("loguniform = [1.0, 7.389056098930650]", 3.194528049465325, 1.789661),
            ("uniform = [2.0, 4.0], relative = 'factor'", 360.0, 240 / 12**0.5),
            ("uniform = [2.0, 4.0], relative = 'offset'", 123.0, 2 / 12**0.5),
        ],
    )
    def test_draws_have_the_distribution_that_is_named(self, tmp_path, paper, distribution, mean, deviation):
        file = read(tmp_path, SPEC.replace("uniform = [100, 140]", distribution))
        one = expand(file, paper)[0]
        drawn = np.array([one.draw(3, k) for k in range(4000)])
        assert drawn.mean() == pytest.approx(mean, abs=4 * deviation / 4000**0.5)
        assert drawn.std() == pytest.approx(deviation, rel=0.05)


class TestPlan:
    def test_another_key_leaves_the_draws_of_the_others(self, tmp_path, usual):
        more = SPEC.replace("[random]", '[random]\n"robot.inertia" = { uniform = [10, 14] }')
        for one, other in zip(usual.runs, made(tmp_path, more).runs, strict=True):
            assert one.values.items() <= other.values.items()

    def test_repetitions_have_noise_of_their_own_unless_it_is_given(self, tmp_path, usual):
        assert len({run.values["run.seed"] for run in usual.runs}) == 3
        assert all("run.seed" not in run.values for run in made(tmp_path, SPEC.replace("runs = 3", "")).runs)
        assert all("run.seed" not in run.values for run in made(tmp_path, overrides=["run.seed=4"]).runs)

    def test_a_draw_out_of_bounds_names_run_key_and_value(self, tmp_path):
        found = mistakes(tmp_path, SPEC.replace("[100, 140]", "[-140, 140]"))
        assert found[0].span.line == 14
        assert "run " in found[0].message
        assert "robots." in found[0].message
        assert "must be > 0 kg, got -" in found[0].message

    def test_a_gain_without_a_guarantee_names_run_and_value(self, tmp_path):
        (found,) = mistakes(tmp_path, SPEC.replace("[0.4, 0.5]", "[0.4, 0.56]"))[:1]
        assert "run 6: the guarantee 'k_h_min - k_s * f >= G_min within 1e-12' does not hold" in found.message
        assert any("rules.ais_reaction.k_s = 0.56" in fact for fact in found.facts)

    @pytest.mark.parametrize(
        ("old", "new", "line", "words"),
        [
            ('"robots.leader.x_0"', '"robots.leadr.x_0"', 15, "no number in the scenario"),
            ('"robots.*.mass"', '"robots.*.mas"', 14, "nothing in the scenario has this key"),
            ('"robots.*.mass"', '"robot.*.mass"', 14, "has this key give robots.*.KEY in place of robot.KEY"),
            ('"run.horizon" = 1.0', '"robot.controllers.*.k" = 1', 8, "or draw robots.*.controllers.*.k in [random]"),
            ('"run.horizon" = 1.0', '"robot.controllers.pid.k" = 1', 8, "names an unknown controller 'pid'"),
            ('"robots.*.mass"', '"robot.d"', 14, "robot.d is used by no robot"),
            ('"run.horizon" = 1.0', '"robot.d" = 0.3', 8, "robot.d is used by no robot"),
            ('"rules.ais_reaction.k_s"', '"rules.ais_reaction.k_t"', 11, "has no param 'k_t'"),
            ('"run.horizon" = 1.0', '"run.horizon" = -1.0', 8, "must be > 0 s"),
            ('"run.horizon" = 1.0', '"rules.ais_reaction.k_s" = 0.3', 11, "given by [set] already"),
            ('["smc", "aifqsmc"]', '["smc", "pid"]', 3, "no control law 'pid'"),
            ('"paper"', '"papper"', 2, "did you mean 'paper'"),
        ],
    )
    def test_answers_a_mistake_at_its_line(self, tmp_path, old, new, line, words):
        assert old in SPEC
        found = mistakes(tmp_path, SPEC.replace(old, new, 1))
        said = [(f"{d.message} {d.help}", d.span.line if d.span else 0) for d in found]
        assert any(words in text and at == line for text, at in said), said


class TestWork:
    def setup_of(self, found):
        return Setup(Robots(), tuple(sorted(found.used.items())), ("rmse", "obstacles_hit"))

    def test_keeps_the_measures_of_the_run(self, tmp_path, measured):
        text = SPEC.replace("runs = 3", "").split("[grid]")[0]
        found = made(tmp_path, text)
        outcome = sweep_workers.work(self.setup_of(found), found.runs[0])
        expected = measured("smc", "run.horizon=1.0")
        assert outcome.row["rmse.follower1.y_e"] == expected["rmse"]["follower1"]["y_e"]
        assert (outcome.row["t_end"], outcome.row["stopped"], outcome.row["obstacles_hit.leader"]) == (1.0, False, 0)
        assert "centre_distance.leader" not in outcome.row

    def test_a_rule_file_that_changes_is_noticed(self, usual):
        setup = Setup(Robots(), tuple((name, "0" * 64) for name in usual.used), ("rmse",))
        aifqsmc = next(run for run in usual.runs if run.controller == "aifqsmc")
        assert "boundary_layer.fz changed" in sweep_workers.work(setup, aifqsmc).problem


class TestResults:
    def test_know_their_units(self):
        units = {name: unit_of(name) for name in ("rmse.leader.theta_e", "chattering.f.v", "robot_gap.f", "run")}
        assert units == {"rmse.leader.theta_e": "rad", "chattering.f.v": "m/s²", "robot_gap.f": "m", "run": ""}


def test_a_sweep_that_is_terminated_while_it_checks_says_so(dwmr, tmp_path, monkeypatch):
    def terminated(*arguments):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(600.0)  # until the signal arrives

    (tmp_path / "spec.toml").write_text(SPEC, encoding="utf-8")
    monkeypatch.setattr("fuzzyctl.experiments.sweep_plan.make", terminated)
    assert dwmr("sweep", tmp_path / "spec.toml") == (130, "", "interrupted\n")
