"""A law of one's own as text: run, recorded and swept, and answers to its mistakes."""

import hashlib
import json
import pickle

import numpy as np
import pytest

from dwmr import read
from dwmr.simulation import simulate
from dwmr.sweep.robots import Robots
from fuzzyctl.analysis.induction import prover
from tests.dwmr.process import here, in_short
from tests.dwmr.scenarios import diagnostics, mistakes, run

LAW = """controller mine "Proportional control with a slow integral"
input x_e unit "m"
input y_e unit "m"
input theta_e_star unit "rad"
input drift_x
input drift_theta unit "rad/s"
param k in (0, 5] = 0.5 unit "1/s"
param start in [-1, 1] = 0
state sum in [-1, 1] = start
next sum = clamp(sum + 0.1 * dt * x_e, -1, 1)
output omega_c = drift_theta + 0.6 * y_e + 1 * theta_e_star
output slow "the integral" unit "m/s" = sum
output v_c unit "m/s" = drift_x + k * x_e + slow
require abs(slow) <= 1
"""
SCENARIO = 'extends = "paper"\n[run]\ncontroller = "mine"\nhorizon = 1.0\n'


@pytest.fixture
def beside(tmp_path):
    """A function that puts a law and a scenario that names it into a folder, and returns the scenario."""

    def write(text=LAW, more=""):
        (tmp_path / "mine.fz").write_text(text, encoding="utf-8")
        (tmp_path / "mine.toml").write_text(SCENARIO + more, encoding="utf-8")
        return tmp_path / "mine.toml"

    return write


class TestColumns:
    @pytest.mark.parametrize("name", ["v", "t"])
    def test_keep_their_names(self, beside, name):
        (found,) = diagnostics(run, beside(LAW.replace("slow", name)))
        assert found.code == "FZ905"
        assert found.message == f"output '{name}' has the name of another column of the data"
        assert found.help == f"rename it, as to {name}_law"


class TestWorkers:
    def test_do_not_prove_again(self, beside, monkeypatch):
        sweep = Robots()
        scenario = sweep.read(beside(), ())
        sweep.check(scenario, ["mine", "aifqsmc"])
        copied = pickle.loads(pickle.dumps(sweep))
        for name in ("fuzzyctl.analysis.induction.prover.verdicts", "fuzzyctl.prove", "fuzzyctl.output_bounds"):
            monkeypatch.setattr(name, None)
        for law in ("mine", "aifqsmc"):
            assert copied.prepare(scenario, law, ()).used == sweep.check(scenario, [law])


class TestRun:
    def test_records_its_other_outputs_with_unit_and_label(self, beside):
        found = run(beside())
        assert found.stop is None
        (signal,) = found.law_signals
        assert (signal.name, signal.unit, signal.doc) == ("slow", "m/s", "the integral")
        summed = np.cumsum(0.1 * 0.005 * found["x_e"], axis=0)
        assert found["slow"][1:] == pytest.approx(summed[:-1], abs=1e-12)

    def test_gains_and_starts_come_from_the_scenario_else_from_the_text(self, beside):
        text = run(beside())
        assert text["v_c"][0, 0] != pytest.approx(text["x_e"][0, 0])
        more = "[robot.controllers.mine]\nk = 1\n[robots.follower1.controllers.mine]\nstart = 0.25\n"
        own = run(beside(more=more))
        assert own["slow"][0].tolist() == [0.0, 0.25, 0.0]
        difference = own["v_c"][0] - text["v_c"][0]
        assert difference == pytest.approx(0.5 * text["x_e"][0] + np.array([0.0, 0.25, 0.0]))

    def test_a_number_that_sets_how_many_states_there_are_is_compiled_in(self, beside):
        text = LAW.replace("k * x_e + slow", "k * delay(x_e, n) + slow").replace("param k", "param n = 2\nparam k")
        found = run(beside(text), "", "robot.controllers.mine.n=2")
        assert found["v_c"][0, 0] != found["v_c"][1, 0]

    def test_an_output_that_has_no_value_stops_the_run(self, beside):
        stop = run(beside(LAW.replace("drift_x + k", "drift_x + sqrt(-1 - x_e * x_e) + k"))).stop
        assert stop is not None
        assert "v_c is not finite" in stop.reason


V_C = 'output v_c unit "m/s" = drift_x + k * x_e + slow\n'
#: What is wrong: the text replaced, what takes its place, and what the answer holds.
MISTAKES = {
    "no such input": ("y_e", "y_err", ["input 'y_err' is not a signal of the formation", "y_e [m]"]),
    "a unit of an input": ('x_e unit "m"', 'x_e unit "mm"', ["input 'x_e' has the unit mm, and the formation gives m"]),
    "a missing command": ("output v_c", "output v", ["controller 'mine' has no output 'v_c'", "omega_c [rad/s]"]),
    "a unit of a command": (V_C, 'output v_c unit "m" = x_e\n', ["output 'v_c' has the unit m, ", "takes m/s"]),
    "another period": ("require", "every 10 ms\nrequire", ["the law runs every 0.01 s", "run.dt is 0.005 s"]),
    "a broken line": ("param k in (0, 5] = 0.5", "param k in (0, 5] =", ["mine.fz:7:"]),
    "a claim": ("<= 1\n", "<= 0.5\n", ["the guarantee 'abs(slow) <= 0.5' does not hold"]),
    "no controller": (LAW, "plant p\nstate x = 0\nder x = 0\noutput y = x\n", ["the file holds no controller"]),
}  # fmt: skip


class TestMistakes:
    @pytest.mark.parametrize("what", MISTAKES)
    def test_are_answered_with_the_place_in_the_text_and_in_the_scenario(self, beside, what):
        old, new, words = MISTAKES[what]
        assert old in LAW
        shown = here("check", beside(LAW.replace(old, new)), status=1).stderr
        for word in [*words, "mine.fz"]:
            assert word in shown
        assert what == "no controller" or "mine.toml:3" in shown

    def test_of_gains_are_answered_with_their_key(self, beside):
        for override, words in (
            ("robot.controllers.mine.k=9", "robot.controllers.mine.k must be in (0, 5] 1/s, got 9"),
            ("robot.controllers.mine.q=9", "robot.controllers.mine.q: mine.fz has no param 'q'"),
        ):
            (one,) = diagnostics(run, beside(), "", override)
            assert words in one.message
            assert one.file == f"--set {override}"

    def test_two_files_of_one_name_are_refused(self, beside):
        scenario = beside()
        scenario.with_name("mine.py").write_text("", encoding="utf-8")
        (one,) = diagnostics(run, scenario)
        assert "in two files, mine.py and mine.fz" in one.message

    def test_a_part_that_the_law_does_not_have_cannot_be_left_out(self, beside):
        (one,) = diagnostics(run, beside(), "mine_without_luck")
        assert "has no param 'luck', which mine_without_luck sets to 0" in one.message


class TestProofs:
    def test_that_hold_for_some_values_only_are_for_these(self, beside):
        scenario = beside(LAW.replace("require", "require k <= 1\nrequire"))
        assert run(scenario).stop is None
        assert "k <= 1" in f"{diagnostics(run, scenario, '', 'robot.controllers.mine.k=2')[0]}"

    def test_one_holds_for_all_values_of_params_that_no_start_depends_on(self, beside, monkeypatch):
        free, prove = [], prover.verdicts

        def counted(controller, timeout, progress=None, free_params=()):
            free.append((timeout, tuple(free_params)))
            return prove(controller, timeout, progress, free_params)

        monkeypatch.setattr(prover, "verdicts", lambda *a, free=(), **k: counted(*a, free_params=free, **k))
        monkeypatch.setattr("fuzzyctl.analysis.prove.TIMEOUT", 5.0)
        more = "[robots.leader.controllers.mine]\nk = 4\n[robots.follower1.controllers.mine]\nstart = 0.5\n"
        run(beside(more=more))
        assert free == [(0.5, ("k",)), (0.5, ("k",))]  # once for each start


def test_a_sweep_is_not_resumed_after_its_law_changed_and_keeps_what_it_has(beside, tmp_path):
    beside()
    spec = 'scenario = "mine.toml"\nmeasures = ["rmse"]\n[grid]\n"robot.controllers.mine.k" = [0.5, 0.6]\n'
    (tmp_path / "spec.toml").write_text(spec, encoding="utf-8")
    alone = ("--jobs", "1", "--set", "run.horizon=0.1")
    in_short("sweep", "spec.toml", *alone, "-o", "swept", cwd=tmp_path)
    kept = {p.name: p.read_bytes() for p in (tmp_path / "swept").iterdir()}
    beside(LAW.replace("0.6 * y_e", "0.7 * y_e"))
    done = in_short("sweep", "spec.toml", *alone, "-o", "swept", "--resume", cwd=tmp_path, status=1)
    assert "changed: file mine.fz" in done.stderr
    assert {p.name: p.read_bytes() for p in (tmp_path / "swept").iterdir()} == kept


GAIN = """\
system my_gain "Gain of the lateral error"
defuzzifier center_average
param most = 0.8
input e in [-1, 1] unit "m"
  terms N Z P
output k in [-most, most] unit "rad/s"
  terms left none right
table k = e
     N    Z    P
  |  left none right
require k <= most
"""
WITH_GAIN = 'use "my_gain.fz"\n' + LAW.replace("0.6 * y_e", "push") + "output push = my_gain(y_e)\nrequire push <= 1\n"
ROLE = '[rules.my_gain]\nfile = "my_gain.fz"\n'


def described(scenario, *folders):
    """Return the summary of a short run."""
    rules = [word for folder in folders for word in ("--rules", folder)]
    options = ("--set", "run.horizon=0.05", "--format", "json", "-o", scenario.parent / "out")
    return json.loads(here("run", scenario, *rules, *options).stdout)


class TestAGainOfOnesOwn:
    @pytest.fixture
    def scenario(self, beside, tmp_path):
        (tmp_path / "my_gain.fz").write_text(GAIN, encoding="utf-8")
        return beside(WITH_GAIN, ROLE)

    def test_has_its_params_from_the_scenario_and_its_checksum_in_the_summary(self, scenario):
        usual = run(scenario, "", "run.horizon=0.05")
        weak = run(scenario, "", "run.horizon=0.05", "rules.my_gain.most=0.1")
        assert np.abs(weak["push"]).max() == pytest.approx(np.abs(usual["push"]).max() / 8.0, rel=0.2)
        assert described(scenario)["rules"]["my_gain"]["file"] == "my_gain.fz"

    def test_is_replaced_by_a_file_of_another_folder(self, scenario, tmp_path):
        (tmp_path / "other").mkdir()
        (tmp_path / "other" / "my_gain.fz").write_text(GAIN.replace("input e", "input q").replace("= e", "= q"))
        found = diagnostics(lambda: run(scenario, folders=(tmp_path / "other",)))
        assert "does not fit the role my_gain" in found[0].message

    def test_of_another_folder_stands_in_the_summary_of_the_law(self, scenario, tmp_path):
        (tmp_path / "other").mkdir()
        other = tmp_path / "other" / "my_gain.fz"
        other.write_text(GAIN.replace("0.8", "0.7"), encoding="utf-8")
        law, usual, changed = scenario.with_name("mine.fz"), described(scenario), described(scenario, other.parent)
        assert list(usual["laws"]["mine.fz"]["files"]) == ["mine.fz", "my_gain.fz"]
        files = changed["laws"]["mine.fz"]["files"]
        assert list(files) == ["mine.fz", "my_gain/my_gain.fz"]
        assert files["my_gain/my_gain.fz"] == changed["rules"]["my_gain"]["sha256"]
        whole = hashlib.sha256(law.read_bytes() + other.read_bytes()).hexdigest()
        assert changed["laws"]["mine.fz"]["sha256"] == whole

    def test_is_proved_with_the_law_and_by_itself(self, scenario, tmp_path):
        (one, *_) = diagnostics(run, scenario, "", "rules.my_gain.most=1.5")
        assert "'push <= 1' does not hold" in one.message
        (tmp_path / "my_gain.fz").write_text(GAIN.replace("k <= most", "k <= 0.1"), encoding="utf-8")
        assert "'k <= 0.1' does not hold" in diagnostics(run, scenario)[0].message

    def test_is_a_warning_in_a_run_that_does_not_call_it(self, scenario):
        options = ("--controller", "smc", "--set", "run.horizon=0.05", "-o", scenario.parent / "out")
        unused = "rules.my_gain is not used: no control law of this run calls a system my_gain"
        assert unused in here("run", scenario, *options).stderr

    def test_is_an_unknown_key_where_only_shipped_laws_are_named(self, scenario):
        assert "unknown key rules.my_gain" in mistakes(scenario, "run.controller=smc")[0].message


class TestWhatALawSees:
    SEES = """\
controller mine
input theta_e
input v_r unit "m/s"
input omega_r unit "rad/s"
input v unit "m/s"
input omega unit "rad/s"
input t unit "s"
output v_c = v_r
output omega_c = omega_r
output angle = theta_e
output seen_v = v
output seen_omega = omega
output now = t
"""

    def test_are_the_velocities_of_the_reference_the_wheels_and_the_time(self, beside):
        file = read(beside(self.SEES, "[load]\nmass_factor = 1.0\n"), ["run.horizon=1"])
        found = simulate.simulate(file)
        shape, leader = file.shape, 0
        assert found["now"][:, leader] == pytest.approx(found.t)
        assert np.array_equal(found["seen_v"], found["v"])
        assert np.array_equal(found["seen_omega"], found["omega"])
        for k in (0, 100, 199):
            there, h = shape.at(found.t[k]), 1e-4
            turn = (shape.at(found.t[k] + h).theta - shape.at(found.t[k] - h).theta) / (2.0 * h)
            assert found["v_c"][k, leader] == pytest.approx(there.v)
            assert found["omega_c"][k, leader] == pytest.approx(turn, abs=1e-5)
            assert found["angle"][k, leader] == pytest.approx(there.theta - found["theta"][k, leader])

    def test_of_a_follower_is_its_place_which_moves_along_the_auxiliary_orientation(self, beside):
        file = read(beside(self.SEES), ["run.horizon=1", "disturbances=[]"])
        found = simulate.simulate(file)
        dt, one = file.scenario.run.dt, 1
        rate = np.diff(found["theta_r_star"][:, one]) / dt
        assert found["omega_c"][:-1, one] == pytest.approx(rate, abs=1e-6)
        moved = np.stack([np.diff(found["x_r"][:, one]), np.diff(found["y_r"][:, one])]) / dt
        star = found["theta_r_star"][:-1, one]
        along = moved[0] * np.cos(star) + moved[1] * np.sin(star)
        assert found["v_c"][50:-1, one] == pytest.approx(along[50:], abs=0.02)
