"""Runs of the loop: their records, their ends, and that they depend on nothing else."""

import subprocess
import sys

import numpy as np
import pytest

from dwmr import measure, read
from dwmr.control.formation import follower_auxiliary_rate
from dwmr.core.jit import COMPILED
from dwmr.simulation import simulate
from tests.dwmr.process import LONG
from tests.dwmr.scenarios import DIVERGES, PAPER, diagnostics, edited_rules, run


class TestRun:
    def test_records_every_period_and_begins_with_auxiliary_orientations(self, run_paper):
        _, trajectory = run_paper("smc", "run.horizon=1")
        assert len(trajectory.t) == 201
        assert trajectory.t[-1] == pytest.approx(1.0)
        assert trajectory["x"].shape == (201, 3)
        assert trajectory["x"][0].tolist() == [-1.0, -3.5, -3.0]
        assert trajectory["theta_r_star"][0] == pytest.approx([np.arctan2(1, 2), 0.0, 0.0])

    def test_does_not_depend_on_how_often_it_reports(self, monkeypatch, run_paper):
        _, whole = run_paper("aifqsmc", "run.horizon=1")
        monkeypatch.setattr(simulate, "PERIODS_AT_A_TIME", 37)
        pieces = run("paper", "aifqsmc", "run.horizon=1")
        assert np.array_equal(whole.values, pieces.values)
        assert np.array_equal(whole.law_values, pieces.law_values)

    @pytest.mark.parametrize(("every", "horizon"), [(4, 1.0), (7, 1.0), (500, 0.5)])
    def test_a_thinned_record_has_every_nth_sample_and_the_last(self, run_paper, every, horizon):
        _, whole = run_paper("aifqsmc", f"run.horizon={horizon}")
        samples = sorted({*range(0, len(whole.t), every), len(whole.t) - 1})
        thin = run("paper", "aifqsmc", f"run.horizon={horizon}", f"run.record_every={every}")
        assert thin.t.tolist() == whole.t[samples].tolist()
        assert np.array_equal(thin.values, whole.values[samples])
        assert np.array_equal(thin.law_values, whole.law_values[samples])

    def test_a_thinned_record_ends_with_the_sample_at_which_the_run_stops(self):
        whole, thin = (run("paper", "smc", "run.horizon=5", *DIVERGES, f"run.record_every={every}") for every in (1, 7))
        assert thin.stop == whole.stop
        assert len(whole.t) % 7 != 1
        assert thin.t[-2:].tolist() == [whole.t[len(whole.t) // 7 * 7], whole.t[-1]]
        assert np.array_equal(thin.values[-1], whole.values[-1], equal_nan=True)

    def test_a_record_that_would_be_too_large_is_thinned(self, monkeypatch):
        monkeypatch.setattr("dwmr.simulation.periods.LARGEST_RECORD", 201 * 8 * 3 * (20 + 14) // 5)
        thin = run("paper", "aifqsmc", "run.horizon=1")
        assert (thin.every, len(thin.t)) == (6, 35)
        measures = measure(thin, read(PAPER).scenario)
        assert (measures["steps"], measures["record_every"]) == (200, 6)
        assert len(run("paper", "aifqsmc", "run.horizon=1", "run.record_every=1").t) == 201

    def test_does_not_depend_on_the_order_of_the_robots(self, tmp_path, run_paper):
        head, leader, rest = PAPER.read_text(encoding="utf-8").partition("[robots.leader]")
        first, follower, tail = rest.partition("[robots.follower1]")
        middle, obstacles, end = tail.partition("# ---- obstacles")
        text = head + follower + middle + leader + first + obstacles + end
        (tmp_path / "swapped.toml").write_text(text, encoding="utf-8")
        trajectory = run(tmp_path / "swapped.toml", "smc", "run.horizon=5")
        assert trajectory.robots == ("follower1", "follower2", "leader")
        assert np.array_equal(trajectory["x"][:, [2, 0, 1]], run_paper("smc", "run.horizon=5")[1]["x"])

    @pytest.mark.parametrize("law", ["smc", "aifqsmc", "fcafsmc"])
    def test_stops_where_a_number_is_not_finite_and_keeps_the_samples_before(self, run_paper, law):
        _, trajectory = run_paper(law, "run.horizon=20", *DIVERGES)
        stop = trajectory.stop
        assert stop.robot == "leader"
        assert "is not finite: the run diverged" in stop.reason
        assert trajectory.t[-1] == stop.t
        assert 1.0 < stop.t < 1.1
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
        trajectory = run("paper", "smc", "run.horizon=5", *only, value)
        stop = trajectory.stop
        assert stop.robot == "leader"
        assert reason in stop.reason
        assert stop.reason.endswith(": the run diverged")
        assert stop.t < 1.05
        assert np.isfinite(trajectory.values).all()

    def test_a_start_far_from_the_reference_is_no_divergence(self):
        assert run("paper", "aifqsmc", "run.horizon=5", "robots.leader.x_0=1e6").stop is None

    def test_keeps_the_record_when_interrupted(self, monkeypatch):
        reports, computed = [], simulate._computed

        def interrupted(periods, report, *others):
            def heard(done):
                reports.append(done)
                if done > 0:  # 0 is reported when all is compiled
                    raise KeyboardInterrupt

            return computed(periods, heard, *others)

        monkeypatch.setattr(simulate, "_computed", interrupted)
        trajectory = run("paper", "smc", "run.horizon=60")
        assert trajectory.stop.reason == "interrupted"
        assert len(trajectory.t) == simulate.PERIODS_AT_A_TIME
        assert reports == [0, simulate.PERIODS_AT_A_TIME]

    @pytest.mark.parametrize("noise", [(), ("robot.noise.x=0.01", "robot.noise.omega=0.04")])
    def test_runs_as_plain_python_to_the_same_numbers(self, run_paper, noise):
        code = (
            "import sys; sys.modules['numba'] = None\nimport dwmr\n"
            "file = dwmr.read('paper', ['run.horizon=0.25', *sys.argv[1:]])\n"
            "for law in ('aifqsmc', 'fcafsmc', 'smc'):\n"
            "    print(repr(dwmr.simulate(file, law).values.tolist()))\n"
        )
        words = [sys.executable, "-c", code, *noise]
        done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=LONG)
        for law, line in zip(("aifqsmc", "fcafsmc", "smc"), done.stdout.splitlines(), strict=True):
            plain = np.array(eval(line, {"__builtins__": {}}))
            assert plain == pytest.approx(run_paper(law, "run.horizon=0.25", *noise)[1].values, abs=1e-9)


@pytest.mark.skipif(not COMPILED, reason="needs numba")
def test_the_loop_is_not_compiled_again_for_other_rules_robots_and_paths(tmp_path, run_paper):
    usual = run_paper("aifqsmc", "run.horizon=1")[1]
    before = len(simulate.loop.run_periods.nopython_signatures)
    edited_rules(tmp_path, "ais_reaction.fz", ("ZO |  ZO  PS  PM  PS  ZO", "ZO |  ZO  PS  NS  PS  ZO"))
    changed = run("paper", "aifqsmc", "run.horizon=1", folders=(tmp_path,))
    assert not np.array_equal(changed.values, usual.values)
    for name in ("own-references", "five-robots"):
        run(name, "aifqsmc", "run.horizon=1")
    assert len(simulate.loop.run_periods.nopython_signatures) == before


@pytest.mark.parametrize("limit", ["omega_limit", "v_limit"])
def test_limits_hold_the_velocities_that_the_inner_loop_follows(run_paper, limit):
    name = limit.removesuffix("_limit")
    _, trajectory = run_paper("smc", "run.horizon=8", f"robot.actuator.{limit}=0.05")
    # at the start the drives turn too far before they settle
    assert np.abs(trajectory[f"{name}_c"][-800:]).max() > 0.2
    assert np.abs(trajectory[name][-800:]).max() < 0.12


def fastest_change(trajectory, name):
    """Return the largest mean acceleration over 0.2 s; for a moment the inner loop overshoots its set point."""
    return np.abs(trajectory[name][40:] - trajectory[name][:-40]).max() / 0.2


@pytest.mark.parametrize(
    ("name", "signals"),
    [("paper", ("v", "omega")), ("ackermann", ("v",)), ("omnidirectional", ("v", "v_y", "omega"))],
)
def test_drives_with_limits_of_acceleration_change_their_velocities_no_faster(name, signals):
    limits = ("robot.actuator.acceleration=0.2", "robot.actuator.angular_acceleration=0.25")
    usual, limited = (run(name, "", "run.horizon=5", *more) for more in ((), limits))
    for signal in signals:
        most = 0.25 if signal == "omega" else 0.2
        assert fastest_change(usual, signal) > 1.5 * most
        assert 0.9 * most < fastest_change(limited, signal) < 1.1 * most


def test_avoidance_uses_the_radius_of_the_robot_that_avoids(run_paper):
    _, usual = run_paper("smc", "run.horizon=52")
    _, wide = run_paper("smc", "run.horizon=52", "robots.follower1.radius=3.0")
    assert (usual["obstacle"] >= 0).any()
    assert np.array_equal(usual.values, wide.values)
    _, wider = run_paper("smc", "run.horizon=52", "robots.leader.radius=1.0")
    assert (wider["obstacle"] >= 0).sum() > (usual["obstacle"] >= 0).sum()


@pytest.mark.parametrize(("known", "share"), [("ground", 1.0), ("wheels", 0.0)])
def test_the_leaders_velocity_turns_the_auxiliary_orientation_of_a_follower(run_paper, known, share):
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


def test_only_the_named_robots_feel_a_disturbance(run_paper):
    _, trajectory = run_paper("smc", "run.horizon=6", 'disturbances.0.robots=["follower2"]')
    assert not trajectory["d_v"][:, :2].any()
    assert trajectory["d_v"][:, 2].any()


class TestPeriod:
    @pytest.mark.parametrize(
        ("name", "override", "message"),
        [
            ("paper", "run.dt=0.01", "-1.161 has the magnitude 1.161 > 1"),
            ("paper-with-limits", "run.dt=0.0125", "0.3337 ± 0.997i has the magnitude 1.052 > 1"),
        ],
    )  # fmt: skip
    def test_a_period_at_which_the_velocity_loop_grows_is_refused(self, name, override, message):
        (one,) = diagnostics(run, name, "aifqsmc", "run.horizon=1", override)
        start = f"{override.replace('=', ' = ')} s: the velocity loop of robots.leader in v is unstable, "
        assert one.message == f"{start}its eigenvalue {message}"
        assert one.help.startswith("shorten run.dt")

    def test_at_the_edge_the_eigenvalue_agrees_with_the_run(self):
        # 0.99997 at 10 ms, 1.03 at 10.1 ms
        quiet = run("undisturbed", "aifqsmc", "run.horizon=8", "run.substeps=16", "run.dt=0.01")
        assert np.abs(np.diff(quiet["v"][-100:, 0])).max() < 0.01
        (one,) = diagnostics(run, "undisturbed", "aifqsmc", "run.horizon=1", "run.substeps=16", "run.dt=0.0101")
        assert "has the magnitude 1.03" in one.message


def known_errors(trajectory, shift):
    """Return x_e of follower1 with the leader's state of some periods before, shape (samples - shift,) [m]."""
    scenario = read(PAPER).scenario
    place, behind = scenario.robots["follower1"].formation, scenario.robots["leader"].d
    x_i, y_i, theta_i = (trajectory[name][: len(trajectory.t) - shift, 0] for name in ("x", "y", "theta"))
    x, y, theta = (trajectory[name][shift:, 1] for name in ("x", "y", "theta"))
    x_e = x_i - behind * np.cos(theta_i) + place.separation * np.cos(theta_i + place.bearing) - x
    y_e = y_i - behind * np.sin(theta_i) + place.separation * np.sin(theta_i + place.bearing) - y
    return np.cos(theta) * x_e + np.sin(theta) * y_e


class TestCommunication:
    def test_a_follower_knows_the_state_of_its_leader_a_delay_before(self, run_paper):
        late = run("paper", "smc", "run.horizon=3", "communication.delay=0.1")
        # σ*_v = -λ_1² x_e
        assert late["sigma_v"][20:, 1] == pytest.approx(-0.25 * known_errors(late, 20), abs=1e-12)
        assert late["sigma_v"][:20, 0].tolist() == run_paper("smc", "run.horizon=3")[1]["sigma_v"][:20, 0].tolist()
        assert late["x_e"][:, 1] == pytest.approx(known_errors(late, 0), abs=1e-12)

    def test_a_lost_message_leaves_the_state_before(self):
        lossy, again, other = (run("paper", "smc", "run.horizon=5", "communication.loss=0.6", s) for s in (
            "run.seed=0", "run.seed=0", "run.seed=1"
        ))  # fmt: skip
        assert np.array_equal(lossy.values, again.values)
        assert not np.array_equal(lossy.values, other.values)
        known = -4.0 * lossy["sigma_v"][:, 1]
        arrived = np.abs(known - known_errors(lossy, 0))[1:] < 1e-12
        assert arrived.mean() == pytest.approx(0.4, abs=0.05)

    @pytest.mark.parametrize(
        ("override", "message"),
        [
            ("communication.loss=1.0", "communication.loss must be < 1"),
            ("communication.delay=-0.1", "communication.delay must be >= 0"),
            ("communication.dealy=0.1", "unknown key communication.dealy"),
        ],
    )
    def test_impossible_values_are_refused(self, override, message):
        (one,) = diagnostics(read, "paper", [override])
        assert one.message.startswith(message)

    def test_other_vehicles_are_refused(self):
        (one,) = diagnostics(read, "omnidirectional", ["communication.delay=0.1"])
        assert one.message.startswith("communication is for robots with two driven wheels")
