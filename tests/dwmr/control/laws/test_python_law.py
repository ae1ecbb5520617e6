"""A law in Python: run, and answers to its mistakes, with the law's file and line."""

import os
import re

import numpy as np
import pytest

from dwmr.core.jit import COMPILED
from tests.dwmr.scenarios import diagnostics, mistakes, run

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

#: What a law in Python has beside its signals.
PARTS = """from types import SimpleNamespace
Settings = init = step = None
FAULTS = {}
def S(name):
    return SimpleNamespace(name=name)
"""


class TestPythonLaw:
    def beside(self, folder, text=LAW):
        """Put the law and a scenario that names it into a folder; return the scenario."""
        (folder / "mine.py").write_text(text, encoding="utf-8")
        scenario = folder / "mine.toml"
        scenario.write_text(
            'extends = "paper"\n[run]\ncontroller = "mine"\nhorizon = 2.0\n[robot.controllers.mine]\nk = 0.5\n',
            encoding="utf-8",
        )
        return scenario

    def test_is_found_beside_the_scenario(self, tmp_path):
        trajectory = run(self.beside(tmp_path))
        assert trajectory.stop is None
        assert trajectory["twice"] == pytest.approx(2.0 * trajectory["x_e"])

    def test_may_allocate(self, tmp_path):
        text = LAW.replace("2.0 * error.x_e", "np.array([error.x_e, error.x_e]).sum()")
        trajectory = run(self.beside(tmp_path, text))
        assert trajectory["twice"] == pytest.approx(2.0 * trajectory["x_e"])

    def planned(self, folder, plan):
        """Return the scenario of a law that records its state, which a plan changes after every 100 periods."""
        text = LAW.replace("np.zeros(1), ())", "np.zeros(1), (), (), plan, 100)").replace(
            "signals[0] = 2.0 * error.x_e", "next_state[0] = signals[0] = state[0]"
        )
        return self.beside(folder, f"{text}\n\ndef plan(state, robot):\n    {plan}\n")

    def test_a_plan_is_made_in_python_and_acts_from_the_next_period_on(self, tmp_path):
        found = run(self.planned(tmp_path, "state[0] += robot.v_limit; return 0"))["twice"]
        assert found[[0, 1, 100, 101, 200, 201, 400], 0].tolist() == [0.0, 100.0, 100.0, 200.0, 200.0, 300.0, 400.0]

    def test_a_plan_may_end_the_run(self, tmp_path):
        text = "state[0] += 1.0; return 7 if state[0] == 3.0 and robot.d == 0.4 else 0"
        scenario = self.planned(tmp_path, text)
        law = tmp_path / "mine.py"
        law.write_text(law.read_text(encoding="utf-8").replace("FAULTS = {}", 'FAULTS = {7: "no way"}'), "utf-8")
        found = run(scenario)
        assert (found.stop.t, found.stop.robot, found.stop.reason) == (1.0, "follower1", "no way")
        assert len(found.t) == 201

    def test_an_error_of_a_plan_is_shown_at_its_line(self, tmp_path):
        found = run(self.planned(tmp_path, "state[0] += [1.0][int(robot.d == 0.4 and state[0] == 2.0)]; return 0"))
        assert (found.stop.t, found.stop.robot, found.stop.reason) == (
            1.0,
            "follower1",
            "IndexError: list index out of range",
        )
        mistake = found.stop.mistake
        assert mistake.span.text == "[1.0][int(robot.d == 0.4 and state[0] == 2.0)]"
        assert mistake.facts[1] == "there, of robot follower1: the plan after t = 1 s"

    def test_a_plan_that_raises_an_error_is_made_once(self, tmp_path):
        text = "CALLS.append(state); return [0][len(CALLS) == 5]"
        found = run(self.planned(tmp_path, f"{text}\n\nCALLS = []"))
        assert (found.stop.t, found.stop.robot) == (0.5, "follower1")
        assert found.t[-1] == pytest.approx(0.495)

    def test_what_is_computed_before_ctrl_c_in_a_plan_is_kept(self, tmp_path):
        text = "state[0] += 1.0; state[0] == 4.0 and signal.raise_signal(signal.SIGINT); return 0\n\nimport signal"
        found = run(self.planned(tmp_path, text))
        assert found.stop.reason == "interrupted"
        assert 0.5 < found.t[-1] <= 1.5

    @pytest.mark.parametrize("result", ["None", "'bad'", "state", "0.0", "float('nan')"])
    def test_a_plan_that_returns_no_fault_is_a_mistake(self, tmp_path, result):
        (one,) = diagnostics(run, self.planned(tmp_path, f"return {result}"))
        assert one.facts[0].startswith("TypeError: a plan returns ")
        assert one.facts[1] == "there, of robot leader: the plan after t = 0 s"

    def test_a_fault_without_a_name_is_shown_by_its_number(self, tmp_path):
        assert run(self.planned(tmp_path, "return 9")).stop.reason == "fault 9, which the law's FAULTS do not name"
        text = LAW.replace("error.theta_e_star, 0", "error.theta_e_star, 8")
        assert run(self.beside(tmp_path, text)).stop.reason == "fault 8, which the law's FAULTS do not name"

    @pytest.mark.parametrize(
        ("result", "words"),
        [
            ("1, np.zeros(1), ()", "'gains' of Law must be an array of shape (n,), got 1"),
            ("np.zeros(1), np.zeros((1, 1)), ()", "'state' of Law must be an array of shape (n,), got array([[0.]])"),
            ("np.zeros(1), np.zeros(1), 3", "'kernels' of Law must be a tuple, got 3"),
            ("np.zeros(1), np.zeros(1), (), (), 7", "'plan' of Law must be a function or None, got 7"),
            ("np.zeros(1), np.zeros(1), (), (), None, 0", "'every' of Law must be a whole number from 1 on, got 0"),
            ("np.zeros(1), np.zeros(1), (), (), None, 2.5", "'every' of Law must be a whole number from 1 on, got 2.5"),
            ("np.zeros(1), np.zeros(len(robot)), ()", "Law must have as many states for each robot"),
            ("np.zeros(len(robot)), np.zeros(1), ()", "Law must have as many gains for each robot"),
        ],
    )
    def test_whose_law_has_parts_of_wrong_types_is_refused(self, tmp_path, result, words):
        text = LAW.replace("np.array([settings.k]), np.zeros(1), ()", result)
        (one,) = diagnostics(run, self.beside(tmp_path, text))
        assert one.facts[0] == f"TypeError: {words}"

    def test_is_read_again_when_its_file_has_changed(self, tmp_path):
        before = run(self.beside(tmp_path))
        changed = self.beside(tmp_path, LAW.replace("signals[0] = 2.0", "signals[0] = 3.0"))
        os.utime(tmp_path / "mine.py", ns=(1, 1))  # a change within the resolution of the clock
        after = run(changed)
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
        scenario = self.beside(tmp_path, LAW.replace(before, after))
        (one,) = diagnostics(run, scenario)
        assert "the control law mine cannot be prepared" in one.message
        assert re.search(words, f"{one}")
        assert str(tmp_path / "mine.py") in one.place

    @pytest.mark.skipif(not COMPILED, reason="needs numba")
    def test_that_does_not_compile_is_reported_with_the_unknown_name(self, tmp_path):
        (one,) = diagnostics(run, self.beside(tmp_path, LAW.replace("gains[0] *", "nosuchgain *")))
        assert "cannot be imported" in one.message
        assert "nosuchgain" in one.facts[0]

    def test_does_not_take_the_place_of_a_shipped_law(self, tmp_path):
        (tmp_path / "mine.toml").write_text('extends = "paper"\n[run]\nhorizon = 0.01\n', encoding="utf-8")
        (tmp_path / "smc.py").write_text("raise RuntimeError", encoding="utf-8")
        assert run(tmp_path / "mine.toml", "smc").stop is None

    @pytest.mark.parametrize("name", ["yours", "../mine", "mine.py", "", "a b"])
    def test_of_another_name_or_folder_is_unknown(self, tmp_path, name):
        (tmp_path / "inner").mkdir()
        scenario = self.beside(tmp_path / "inner")
        (tmp_path / "inner" / "mine.py").rename(tmp_path / "mine.py")
        one = mistakes(scenario, f'run.controller="{name}"')[0]
        assert f"unknown controller '{name}'" in one.message or name == ""

    def test_that_breaks_is_named_with_its_line(self, tmp_path):
        (one,) = diagnostics(run, self.beside(tmp_path, "import numpy\n\n1 / 0\n"))
        assert "ZeroDivisionError" in f"{one}"
        assert one.place == f"{tmp_path / 'mine.py'}:3:1"

    @pytest.mark.skipif(not COMPILED, reason="plain Python checks indices itself")
    @pytest.mark.parametrize(("right", "wrong"), [("signals[0]", "signals[1]"), ("gains[0]", "gains[7]")])
    def test_indices_beyond_an_array_are_errors_of_the_law(self, tmp_path, right, wrong):
        (one,) = diagnostics(run, self.beside(tmp_path, LAW.replace(right, wrong)))
        assert "the control law mine cannot be run" in one.message
        assert one.facts[0].startswith("IndexError: index ")
        assert one.span.text.startswith(wrong)
        assert "'signals' is as long as SIGNALS" in one.help

    @pytest.mark.parametrize(
        "changes", [["robot.noise.x=0.01", 'robot.sensors.pose="odometry"', "obstacles.0.velocity=[0.1, 0.0]"], []]
    )
    def test_an_error_is_found_again_in_its_period(self, tmp_path, changes):
        def trajectory(text):
            return run(self.beside(tmp_path, text), "", *changes)

        whole = trajectory(LAW)
        sizes = np.abs(whole["twice"])[20:]  # later than the start
        k = 20 + int(sizes.max(axis=1).argmax())
        worst = float(sizes.max())
        condition = f"error.t < 0.0975 or abs(2.0 * error.x_e) < {worst!r}"
        broken = LAW.replace("    return error", f"    assert {condition}, 'far'\n    return error")
        ended = trajectory(broken)
        assert ended.values.tolist() == whole.values[:k].tolist()
        stop = ended.stop
        assert (stop.t, stop.reason) == (whole.t[k], "AssertionError: far")
        assert stop.mistake.span.text == condition.partition(" or ")[2]
        x_e = whole["twice"][k, whole.robots.index(stop.robot)] / 2.0
        assert f"robot {stop.robot}: x_e = {x_e:.6g}, " in stop.mistake.facts[-1]

    def test_stops_a_run_with_its_reason_and_the_last_row_is_whole(self, tmp_path):
        faulty = LAW.replace("FAULTS = {}", 'FAULTS = {1: "the gain is too large"}').replace(
            "theta_e_star, 0", "theta_e_star, 1 if gains[0] > 5.0 and error.drift_x > 0.5 else 0"
        )
        scenario = self.beside(tmp_path, faulty)
        trajectory = run(scenario, "", "robots.follower1.controllers.mine.k=6", "run.horizon=20")
        assert trajectory.stop is not None
        assert (trajectory.stop.robot, trajectory.stop.reason) == ("follower1", "the gain is too large")
        assert trajectory["x"][-1] == pytest.approx(trajectory["x"][-2], abs=0.02)
        assert (trajectory["x"][-1] != 0.0).all()
        assert (trajectory["twice"][-1] != 0.0).all()

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("x = 1\nraise RuntimeError('no luck')\n", "RuntimeError: no luck"),
            ("def f(:\n", "SyntaxError"),
            ("import nosuchmodule\n", "No module named 'nosuchmodule'"),
            ("SIGNALS = ()\n", "has no Settings, FAULTS, init, step"),
            (f"{PARTS}SIGNALS = (S('x'),)\n", "signal 'x' of the control law mine has the name of another column"),
            (f"{PARTS}SIGNALS = (S('t'),)\n", "rename it, as to t_law"),
            (f"{PARTS}SIGNALS = (S('a'), S('a'))\n", "the control law mine has two signals 'a'"),
            (f"{PARTS}SIGNALS = ('a',)\n", "cannot be checked"),
        ],
    )
    def test_that_cannot_be_imported_is_named(self, tmp_path, text, words):
        one = diagnostics(run, self.beside(tmp_path, text))[0]
        assert words in f"{one}"
        assert str(tmp_path / "mine.py") in one.place
