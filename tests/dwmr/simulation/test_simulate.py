import os
import re

import numpy as np
import pytest

from dwmr.control import laws
from dwmr.control.formation import follower_auxiliary_rate
from dwmr.control.fuzzy_gains import Rules
from dwmr.core.jit import COMPILED
from dwmr.plant.robot import State
from dwmr.scenario.file import find, read
from dwmr.simulation import faults, simulate
from dwmr.simulation.loop import run_periods
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.shipped import rules_folder
from tests.dwmr.process import LONG

PAPER = find("paper")


def ready(law="aifqsmc", *overrides):
    file = read(PAPER, overrides)
    return simulate.prepare(file, law, Rules(file.scenario.rules, (), file.places))


class TestRun:
    def test_records_every_period_and_the_last_state(self, run_paper):
        _, trajectory = run_paper("smc", "run.horizon=1")
        assert len(trajectory.t) == 201
        assert trajectory.t[-1] == pytest.approx(1.0)
        assert trajectory["x"].shape == (201, 3)
        assert trajectory["x"][0].tolist() == [-1.0, -3.5, -3.0]

    def test_begins_with_auxiliary_orientations_of_reference_and_leader(self, run_paper):
        _, trajectory = run_paper("smc", "run.horizon=1")
        assert trajectory["theta_r_star"][0] == pytest.approx([np.arctan2(1, 2), 0.0, 0.0])

    def test_does_not_depend_on_how_often_it_reports(self, monkeypatch, run_paper):
        _, whole = run_paper("aifqsmc", "run.horizon=5")
        monkeypatch.setattr(simulate, "PERIODS_AT_A_TIME", 37)
        pieces = simulate.run(ready("aifqsmc", "run.horizon=5"))
        assert np.array_equal(whole.values, pieces.values)
        assert np.array_equal(whole.law_values, pieces.law_values)

    def test_does_not_depend_on_the_order_of_the_robots(self, tmp_path, run_paper):
        text = PAPER.read_text(encoding="utf-8")
        head, leader, rest = text.partition("[robots.leader]")
        first, follower, tail = rest.partition("[robots.follower1]")
        middle, obstacles, end = tail.partition("# ---- obstacles")
        swapped = tmp_path / "swapped.toml"
        swapped.write_text(head + follower + middle + leader + first + obstacles + end, encoding="utf-8")
        file = read(swapped, ["run.horizon=5"])
        trajectory = simulate.run(simulate.prepare(file, "smc", Rules(file.scenario.rules, (), file.places)))
        _, usual = run_paper("smc", "run.horizon=5")
        assert trajectory.robots == ("follower1", "follower2", "leader")
        assert np.array_equal(trajectory["x"][:, [2, 0, 1]], usual["x"])

    def test_stops_where_a_number_is_not_finite_and_keeps_what_was(self):
        run = ready("smc", "run.horizon=20", "disturbances.0.start=1", "disturbances.0.force=1e300")
        trajectory = simulate.run(run)
        assert trajectory.stop is not None
        assert trajectory.stop.robot == "leader"
        assert "is not finite" in trajectory.stop.reason
        assert trajectory.t[-1] == trajectory.stop.t
        assert 1.0 < trajectory.stop.t < 1.1
        assert np.isfinite(trajectory.values[:-1]).all()

    @pytest.mark.parametrize(
        ("value", "reason"),
        [
            ("disturbances.1.force=1.5e12", "v is beyond 1e+07 m/s"),
            ("disturbances.1.torque=-1.5e11", "omega is beyond 1e+07 rad/s"),
            ("robots.leader.controllers.smc={lambda_1=1,lambda_2=1,lambda_3=1,p_v=1,p_omega=1,g_v=1e14,g_omega=1}",
             "v_c is beyond 1e+12 m/s"),
        ],
    )  # fmt: skip
    def test_stops_where_a_number_grows_beyond_all_robots(self, value, reason):
        only = ('disturbances.1.robots=["leader"]', "disturbances.1.start=1", "robot.com_offset=0")
        trajectory = simulate.run(ready("smc", "run.horizon=5", *only, value))
        stop = trajectory.stop
        assert stop is not None
        assert stop.robot == "leader"
        assert reason in stop.reason
        assert stop.reason.endswith(": the run diverged")
        assert stop.t < 1.05
        assert np.isfinite(trajectory.values).all()

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    @pytest.mark.parametrize("name", faults.LARGEST)
    def test_each_signal_has_its_bound(self, name, sign):
        for share, beyond in ((0.99, False), (1.01, True)):
            values = dict.fromkeys(faults.LARGEST, 0.0) | {name: sign * share * faults.LARGEST[name]}
            state = State(values["x"], values["y"], 0.0, values["v"], values["omega"], 0.0, 0.0)
            assert faults._is_too_large(state, values["v_c"], values["omega_c"]) == beyond

    def test_a_start_far_from_the_reference_is_no_divergence(self):
        assert simulate.run(ready("aifqsmc", "run.horizon=5", "robots.leader.x_0=1e6")).stop is None

    @pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
    def test_calls_a_divergence_no_broken_guarantee(self, law):
        stop = simulate.run(ready(law, "run.horizon=20", "disturbances.0.start=1", "disturbances.0.force=1e300")).stop
        assert stop is not None
        assert "is not finite: the run diverged" in stop.reason

    def test_keeps_what_is_done_when_interrupted(self):
        def interrupt(done):
            if done > 0:  # 0 is reported when all is compiled
                raise KeyboardInterrupt

        trajectory = simulate.run(ready("smc", "run.horizon=60"), interrupt)
        assert trajectory.stop is not None
        assert trajectory.stop.reason == "interrupted"
        assert len(trajectory.t) == simulate.PERIODS_AT_A_TIME

    def test_runs_as_plain_python_to_the_same_numbers(self, run_paper):
        import subprocess
        import sys

        code = (
            "import sys; sys.modules['numba'] = None\n"
            "from dwmr.control.fuzzy_gains import Rules\nfrom dwmr.scenario.file import find, read\n"
            "from dwmr.simulation import simulate\n"
            "file = read(find('paper'), ['run.horizon=0.25'])\n"
            "rules = Rules(file.scenario.rules, (), file.places)\n"
            "for law in ('aifqsmc', 'fcafsmc', 'smc'):\n"
            "    print(repr(simulate.run(simulate.prepare(file, law, rules)).values.tolist()))\n"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=LONG)
        for law, line in zip(laws.group("all"), done.stdout.splitlines(), strict=True):
            plain = np.array(eval(line, {"__builtins__": {}}))
            assert plain == pytest.approx(run_paper(law, "run.horizon=0.25")[1].values, abs=1e-9)


class TestLoop:
    @pytest.mark.skipif(not COMPILED, reason="needs numba")
    def test_is_not_compiled_again_for_another_rule_file(self, tmp_path, run_paper):
        run_paper("aifqsmc", "run.horizon=1")
        before = len(run_periods.nopython_signatures)
        text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
        edited = text.replace("ZO |  ZO  PS  PM  PS  ZO", "ZO |  ZO  PS  NS  PS  ZO")
        assert edited != text
        (tmp_path / "ais_reaction.fz").write_text(edited, encoding="utf-8")
        file = read(PAPER, ["run.horizon=1"])
        run = simulate.prepare(file, "aifqsmc", Rules(file.scenario.rules, (tmp_path,), file.places))
        changed = simulate.run(run)
        assert not np.array_equal(changed.values, run_paper("aifqsmc", "run.horizon=1")[1].values)
        assert len(run_periods.nopython_signatures) == before


class TestCommandLimits:
    @pytest.mark.parametrize(
        ("limit", "asked", "reached"), [("omega_limit", "omega_c", "omega"), ("v_limit", "v_c", "v")]
    )
    def test_hold_what_the_inner_loop_is_asked_for(self, run_paper, limit, asked, reached):
        _, trajectory = run_paper("smc", "run.horizon=8", f"robot.actuator.{limit}=0.05")
        # at the start the drives turn too far before they settle
        assert np.abs(trajectory[asked][-800:]).max() > 0.2
        assert np.abs(trajectory[reached][-800:]).max() < 0.12


class TestAvoidance:
    def test_uses_the_radius_of_the_robot_that_avoids(self, run_paper):
        _, usual = run_paper("smc", "run.horizon=52")
        _, wide = run_paper("smc", "run.horizon=52", "robots.follower1.radius=3.0")
        assert (usual["obstacle"] >= 0).any()
        assert np.array_equal(usual.values, wide.values)
        _, wider = run_paper("smc", "run.horizon=52", "robots.leader.radius=1.0")
        assert (wider["obstacle"] >= 0).sum() > (usual["obstacle"] >= 0).sum()


class TestFormationTree:
    def test_a_follower_may_lead_another(self, tmp_path):
        chain = """
[robots.follower3]
x_0 = -5.0
y_0 = -1.0
theta_0 = 0.0
d = 0.4
formation = { leader = "follower2", separation = 1.25, bearing = 3.0 }

"""
        head, mark, tail = PAPER.read_text(encoding="utf-8").partition("# ---- obstacles")
        path = tmp_path / "four.toml"
        path.write_text(head + chain + mark + tail, encoding="utf-8")
        file = read(path, ["run.horizon=40"])
        trajectory = simulate.run(simulate.prepare(file, "aifqsmc", Rules(file.scenario.rules, (), file.places)))
        assert trajectory.stop is None
        assert np.abs(trajectory["x_e"][-1]).max() < 0.05


class TestLeaderVelocity:
    @pytest.mark.parametrize(("known", "share"), [("ground", 1.0), ("wheels", 0.0)])
    def test_is_what_turns_the_auxiliary_orientation_of_a_follower(self, run_paper, known, share):
        """A sinusoid acts on the leader from 3 s on; only `ground` lets its followers know."""
        file, run = run_paper("aifqsmc", "run.horizon=5", f"formation.leader_velocity={known}")
        v, omega = (run[name][:-1, 0] + share * run[f"d_{name}"][:-1, 0] for name in ("v", "omega"))
        assert np.abs(run["d_omega"][:, 0]).max() > 0.01
        for i, name in ((1, "follower1"), (2, "follower2")):
            place = file.scenario.robots[name]
            rate = np.vectorize(follower_auxiliary_rate)(
                run["theta"][:-1, 0], v, omega, run["theta_r_star"][:-1, i], place.d,
                place.formation.separation, place.formation.bearing,
            )  # fmt: skip
            assert np.diff(run["theta_r_star"][:, i]) == pytest.approx(file.scenario.run.dt * rate, abs=1e-12)


class TestDisturbedRobots:
    def test_only_the_named_ones_feel_a_disturbance(self, run_paper):
        _, trajectory = run_paper("smc", "run.horizon=6", 'disturbances.0.robots=["follower2"]')
        assert not trajectory["d_v"][:, :2].any()
        assert trajectory["d_v"][:, 2].any()


class TestOwnLaw:
    LAW = """
from dwmr.core.interfaces import Law, Signal, control_law
from dwmr.control.laws.settings import LawSettings
from dwmr.config.quantities import quantity
import numpy as np

SIGNALS = (Signal("twice", "m", "twice the error"),)
FAULTS = {}

class Settings(LawSettings):
    k: float = quantity("gain", "1/s", gt=0)

def init(settings, rules, robot):
    return Law(np.array([settings.k]), np.zeros(1), ())

@control_law()
def step(error, dt, gains, state, kernels, next_state, signals):
    signals[0] = 2.0 * error.x_e
    return error.drift_x + gains[0] * error.x_e, error.drift_theta + error.theta_e_star, 0
"""

    def beside(self, folder, text=LAW):
        """Put the law and a scenario that names it into a folder; return the scenario."""
        (folder / "mine.py").write_text(text, encoding="utf-8")
        scenario = folder / "mine.toml"
        scenario.write_text(
            'extends = "paper"\n[run]\ncontroller = "mine"\nhorizon = 2.0\n[robot.controllers.mine]\nk = 0.5\n',
            encoding="utf-8",
        )
        return scenario

    def ready(self, scenario):
        file = read(scenario)
        return simulate.prepare(file, "mine", Rules(file.scenario.rules, (), file.places))

    def test_is_found_beside_the_scenario(self, tmp_path):
        trajectory = simulate.run(self.ready(self.beside(tmp_path)))
        assert trajectory.stop is None
        assert trajectory["twice"] == pytest.approx(2.0 * trajectory["x_e"])

    def test_may_allocate(self, tmp_path):
        text = self.LAW.replace("2.0 * error.x_e", "np.array([error.x_e, error.x_e]).sum()")
        trajectory = simulate.run(self.ready(self.beside(tmp_path, text)))
        assert trajectory["twice"] == pytest.approx(2.0 * trajectory["x_e"])

    def test_is_read_again_when_its_file_has_changed(self, tmp_path):
        before = simulate.run(self.ready(self.beside(tmp_path)))
        changed = self.beside(tmp_path, self.LAW.replace("signals[0] = 2.0", "signals[0] = 3.0"))
        os.utime(tmp_path / "mine.py", ns=(1, 1))  # a change within the resolution of the clock
        after = simulate.run(self.ready(changed))
        assert after["twice"] == pytest.approx(1.5 * before["twice"])

    @pytest.mark.parametrize(
        ("before", "after", "words"),
        [
            ("np.zeros(1), ())", "np.zeros(0))", "TypeError: .*missing 1 required positional argument: 'kernels'"),
            ("Law(np.array([settings.k]), np.zeros(1), ())", "None", "TypeError: init returns NoneType, not Law"),
            ("settings.k]", "settings.q]", "AttributeError: .*q"),
        ],
    )
    def test_whose_init_is_broken_is_named_with_its_line(self, tmp_path, before, after, words):
        scenario = self.beside(tmp_path, self.LAW.replace(before, after))
        with pytest.raises(DiagnosticError, match="the control law mine cannot be prepared") as caught:
            self.ready(scenario)
        assert re.search(words, str(caught.value))
        assert str(tmp_path / "mine.py") in caught.value.diagnostics[0].place

    @pytest.mark.skipif(not COMPILED, reason="needs numba")
    def test_that_does_not_compile_is_reported_with_the_unknown_name(self, tmp_path):
        with pytest.raises(DiagnosticError, match="cannot be imported") as caught:
            self.ready(self.beside(tmp_path, self.LAW.replace("gains[0] *", "nosuchgain *")))
        assert "nosuchgain" in caught.value.diagnostics[0].facts[0]

    def test_does_not_take_the_place_of_a_shipped_law(self, tmp_path):
        (tmp_path / "smc.py").write_text("raise RuntimeError", encoding="utf-8")
        file = read(find("paper"))
        rules = Rules(file.scenario.rules, (tmp_path,), file.places)
        assert laws.find("smc", tmp_path, rules).text.path == rules_folder() / "smc.fz"

    def test_of_another_folder_is_unknown(self, tmp_path):
        scenario = self.beside(tmp_path)
        (tmp_path / "mine.py").rename(tmp_path / "yours.py")
        with pytest.raises(DiagnosticError, match="unknown controller 'mine'") as found:
            read(scenario)
        (one,) = found.value.diagnostics
        assert one.facts[-1] == "there is no mine.fz or mine.py beside the scenario"

    @pytest.mark.parametrize("name", ["../mine", "mine.py", "", "a b"])
    def test_is_looked_for_by_names_only(self, tmp_path, name):
        (tmp_path / "inner").mkdir()
        (tmp_path / "mine.py").write_text(self.LAW, encoding="utf-8")
        assert not laws.exists(name, tmp_path / "inner")
        assert not laws.exists(name, tmp_path)

    def test_that_breaks_is_named_with_its_line(self, tmp_path):
        scenario = self.beside(tmp_path, "import numpy\n\n1 / 0\n")
        with pytest.raises(DiagnosticError, match="ZeroDivisionError") as caught:
            self.ready(scenario)
        assert caught.value.diagnostics[0].place == f"{tmp_path / 'mine.py'}:3:1"

    @pytest.mark.skipif(not COMPILED, reason="plain Python checks indices itself")
    @pytest.mark.parametrize(("right", "wrong"), [("signals[0]", "signals[1]"), ("gains[0]", "gains[7]")])
    def test_indices_beyond_an_array_are_errors_of_the_law(self, tmp_path, right, wrong):
        run = self.ready(self.beside(tmp_path, self.LAW.replace(right, wrong)))
        with pytest.raises(DiagnosticError, match="the control law mine cannot be run") as caught:
            simulate.run(run)
        (one,) = caught.value.diagnostics
        assert one.facts[0].startswith("IndexError: index ")
        assert one.span.text.startswith(wrong)
        assert "'signals' is as long as SIGNALS" in one.help

    @pytest.mark.parametrize(
        "changes", [["robot.noise.x=0.01", 'robot.sensors.pose="odometry"', "obstacles.0.velocity=[0.1, 0.0]"], []]
    )
    def test_an_error_is_found_again_in_its_period(self, tmp_path, changes):
        def trajectory(text):
            file = read(self.beside(tmp_path, text), changes)
            return simulate.run(simulate.prepare(file, "mine", Rules(file.scenario.rules, (), file.places)))

        whole = trajectory(self.LAW)
        sizes = np.abs(whole["twice"])[20:]  # later than the start
        k = 20 + int(sizes.max(axis=1).argmax())
        worst = float(sizes.max())
        condition = f"error.t < 0.0975 or abs(2.0 * error.x_e) < {worst!r}"
        broken = self.LAW.replace("    return error", f"    assert {condition}, 'far'\n    return error")
        ended = trajectory(broken)
        assert ended.values.tolist() == whole.values[:k].tolist()
        stop = ended.stop
        assert (stop.t, stop.reason) == (whole.t[k], "AssertionError: far")
        assert stop.mistake.span.text == condition.partition(" or ")[2]
        x_e = whole["twice"][k, whole.robots.index(stop.robot)] / 2.0
        assert f"robot {stop.robot}: x_e = {x_e:.6g}, " in stop.mistake.facts[-1]

    def test_stops_a_run_with_its_reason_and_the_last_row_is_whole(self, tmp_path):
        faulty = self.LAW.replace("FAULTS = {}", 'FAULTS = {1: "the gain is too large"}').replace(
            "theta_e_star, 0", "theta_e_star, 1 if gains[0] > 5.0 and error.drift_x > 0.5 else 0"
        )
        scenario = self.beside(tmp_path, faulty)
        file = read(scenario, ["robots.follower1.controllers.mine.k=6", "run.horizon=20"])
        run = simulate.prepare(file, "mine", Rules(file.scenario.rules, (), file.places))
        trajectory = simulate.run(run)
        assert trajectory.stop is not None
        assert (trajectory.stop.robot, trajectory.stop.reason) == ("follower1", "the gain is too large")
        assert trajectory["x"][-1] == pytest.approx(trajectory["x"][-2], abs=0.02)
        assert (trajectory["x"][-1] != 0.0).all()
        assert (trajectory["twice"][-1] != 0.0).all()
