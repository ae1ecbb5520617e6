"""Predictive control: its plans against an integrator and other commands, its faults, and its extra."""

import json
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import minimize

from dwmr import read
from tests.dwmr.process import here
from tests.dwmr.scenarios import diagnostics, run, shared
from tests.explanation import script, text

needs_casadi = pytest.mark.skipif(find_spec("casadi") is None, reason="CasADi is not installed: pip install casadi")
needs_do_mpc = pytest.mark.skipif(find_spec("do_mpc") is None, reason="do-mpc is not installed: pip install do-mpc")
SHORT = ("run.horizon=3",)
EVERY, STEPS = 20, 5
WEIGHTS = (1.0, 0.1, 0.1, 0.03)


def rolled_out(commands, start, period, fine=20):
    """Return the cost of commands, with short steps of Runge and Kutta.

    Args:
        commands: v and omega of each step, flat.
        start: Errors along and across, velocity of the place seen from the robot, and d.
    """
    x_e, y_e, drift_x, drift_y, d = start
    q_y, q_theta, r_v, r_omega = WEIGHTS
    speed, total, h = np.hypot(drift_x, drift_y), 0.0, period / fine

    def seen(turn):
        return drift_x * np.cos(turn) + drift_y * np.sin(turn), drift_y * np.cos(turn) - drift_x * np.sin(turn)

    def rates(error, v, omega):
        along, across = seen(error[2])
        return np.array([along - v + omega * error[1], across - omega * (d + error[0]), omega])

    error = np.array([x_e, y_e, 0.0])
    for v, omega in np.reshape(commands, (-1, 2)):
        along, across = seen(error[2])
        total += q_theta * (speed - along) + r_v * (v - along) ** 2 + r_omega * (omega - across / d) ** 2
        for _ in range(fine):
            a = rates(error, v, omega)
            b = rates(error + 0.5 * h * a, v, omega)
            c = rates(error + 0.5 * h * b, v, omega)
            error = error + h / 6.0 * (a + 2.0 * b + 2.0 * c + rates(error + h * c, v, omega))
        total += error[0] ** 2 + q_y * error[1] ** 2
    return total


@needs_casadi
class TestPlan:
    @pytest.mark.parametrize("number", [1, 4, 20])
    def test_costs_as_little_as_the_commands_that_another_optimiser_finds(self, number):
        limits = (1.1, 0.9)
        drives = (f"robot.actuator.v_limit={limits[0]}", f"robot.actuator.omega_limit={limits[1]}")
        one = run("paper-with-limits", "mpc", *SHORT, f"robot.controllers.mpc.steps={STEPS}", *drives)
        period, dt = number * EVERY, one.step
        turn, v_r = one["theta_r"][period, 0] - one["theta"][period, 0], one["v_r"][period, 0]
        start = (one["x_e"][period, 0], one["y_e"][period, 0], v_r * np.cos(turn), v_r * np.sin(turn), 0.1)
        best = minimize(
            rolled_out, np.tile([0.5, 0.0], STEPS), (start, EVERY * dt), "SLSQP",
            bounds=[(-most, most) for most in limits] * STEPS, options={"ftol": 1e-12, "maxiter": 500},
        )  # fmt: skip
        assert one["cost"][period + 1, 0] == pytest.approx(best.fun, rel=1e-4)
        commands = [one["v_c"][period + 1, 0], one["omega_c"][period + 1, 0]]
        assert commands == pytest.approx(best.x[:2].tolist(), abs=2e-3)

    def test_acts_from_the_next_period_to_the_next_plan(self):
        one = run("paper-with-limits", "mpc", *SHORT, "robot.controllers.mpc.every=4")
        changes = np.flatnonzero(np.abs(np.diff(one["omega_c"][:, 0])) > 0.0) + 1
        assert set(changes % 4) == {1}
        assert one["omega_c"][0, 0] == 0.0

    def test_does_not_depend_on_how_many_periods_are_computed_at_a_time(self, monkeypatch):
        _, whole = shared("paper-with-limits", "mpc", *SHORT)
        monkeypatch.setattr("dwmr.simulation.simulate.PERIODS_AT_A_TIME", 7)
        parts = run("paper-with-limits", "mpc", *SHORT)
        assert np.array_equal(whole.values, parts.values)
        assert np.array_equal(whole.law_values, parts.law_values)


@needs_casadi
class TestLaw:
    def test_keeps_its_commands_within_the_limits_of_the_drives(self):
        limits = ("robot.actuator.v_limit=1.1", "robot.actuator.omega_limit=0.9")
        one = run("paper-with-limits", "mpc", *SHORT, *limits)
        for name, limit in (("v_c", 1.1), ("omega_c", 0.9)):
            assert np.abs(one[name]).max() == limit

    def test_brings_the_robots_to_their_places(self):
        _, one = shared("undisturbed", "mpc", "run.horizon=30")
        assert np.hypot(one["x_e"], one["y_e"])[-1].max() < 0.01

    def test_a_table_of_a_robot_has_its_weights_and_a_wrong_one_is_refused(self):
        (one,) = diagnostics(run, "paper", "mpc", "robots.leader.controllers.mpc.r_v=0")
        assert one.message == "robots.leader.controllers.mpc.r_v must be > 0 s², got 0"
        (one,) = diagnostics(run, "paper", "mpc", "robot.controllers.mpc.r_w=1")
        assert one.message == "unknown key robot.controllers.mpc.r_w"
        assert one.facts == ("robot.controllers.mpc has the keys q_y, q_theta, r_v, r_omega, steps, every",)
        (one,) = diagnostics(run, "paper", "mpc", "robot.controllers.mpc.steps=2.5")
        assert one.message.startswith("robot.controllers.mpc.steps must be a whole number")

    def test_bench_tunes_its_weights_and_not_its_horizon(self):
        options = ("--controller", "kanayama,mpc", "--budget", "2", "--training", "1", "--runs", "1")
        done = here("bench", "undisturbed", *options, "--set", "run.horizon=1", "--format", "json")
        gains = json.loads(done.stdout)["tuned"]["undisturbed"]["mpc"]["gains"]
        assert list(gains) == ["q_y", "q_theta", "r_v", "r_omega"]


class _Failing:
    """A solver that fails at its third plan."""

    def __init__(self, status):
        self.status, self.calls = status, 0

    def __call__(self, **arguments):
        import casadi

        self.calls += 1
        if self.status is None and self.calls == 3:
            raise RuntimeError("of CasADi")
        return {"x": casadi.DM(arguments["x0"]), "f": casadi.DM(1.0)}

    def stats(self):
        return {"success": self.calls != 3, "unified_return_status": self.status, "iter_count": 5}


@needs_casadi
@pytest.mark.parametrize(
    ("status", "words"),
    [
        ("SOLVER_RET_LIMITED", "reached its limit of iterations"),
        ("SOLVER_RET_INFEASIBLE", "found no feasible commands"),
        ("SOLVER_RET_UNKNOWN", "failed"),
        (None, "failed"),
    ],
)
def test_a_solver_that_fails_stops_the_run_at_its_time(monkeypatch, status, words):
    monkeypatch.setattr("dwmr.control.laws.mpc.solver", lambda steps: _Failing(status))
    stop = run("own-references", "mpc", "robot.controllers.mpc.every=10", *SHORT).stop
    robots = list(read("own-references").scenario.robots)
    assert (stop.robot, stop.reason) == (robots[0], f"the solver of the predictive control {words}")
    assert stop.t == pytest.approx(0.1)


def test_the_solver_comes_when_a_run_needs_it_and_not_before(tmp_path):
    code = "import sys; from dwmr.control.laws import mpc; import dwmr.cli.main; assert 'casadi' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_without_its_extra_one_message_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    (one,) = diagnostics(run, "paper", "mpc")
    assert one.message == "the control law mpc needs the package casadi, which cannot be imported"
    assert "pip install 'fuzzyctl[mpc]'" in one.help
    done = here("bench", "undisturbed", "--controller", "smc,mpc", status=1)
    assert done.stderr.count("error[") == 1


@needs_casadi
@needs_do_mpc
@pytest.mark.filterwarnings("ignore")  # of features of do-mpc that are not installed
class TestBesideDoMpc:
    def test_the_same_problem_has_the_same_solution(self):
        found = script("laws/with_do_mpc.py").differences("run.horizon=2")
        ours, theirs = found["mpc"], found["with_do_mpc"]
        for name, one in theirs.items():
            assert ours[name] == pytest.approx(one, rel=0.1 if name == "cost" else 0.02), name

    @pytest.mark.long
    def test_the_table_of_the_page_is_what_the_script_gives(self):
        beside = script("laws/with_do_mpc.py")
        assert "".join(beside.table(beside.differences())) in text("laws.md")
