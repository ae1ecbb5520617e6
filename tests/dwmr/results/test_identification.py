"""Parameters of a robot from a log: exact without noise, within their intervals with it, and named if undetermined."""

from unittest.mock import Mock

import numpy as np
import pytest

from dwmr import Log, UnexplainedError, read
from tests.bench import identification as study
from tests.dwmr.process import here

#: Columns of a log that identifies.
HEAD = "t,robot,v,omega,v_c,omega_c"


@pytest.fixture(autouse=True)
def short_logs(monkeypatch):
    monkeypatch.setattr(study, "DURATION", 10.0)


def by_key(identified):
    return {one.key: one for one in identified.estimates}


def csv_of(path, log):
    rows = np.column_stack([log.t, log.signals["v"], log.signals["omega"], log.commands])
    lines = [f"{t!r},leader,{','.join(map(repr, rest))}" for t, *rest in rows.tolist()]
    path.write_text("\n".join([HEAD, *lines, ""]), encoding="utf-8")
    return path


def test_without_noise_the_truth_comes_back_from_other_values():
    true = study.truth("robot.mass=100", "robot.friction.coulomb_torque=2.5", "robot.inertia=11")
    estimates = by_key(study.identified(study.log_of(true, 1, noise=(0.0, 0.0)), study.scenario()))
    for key, value in study.true_values(true).items():
        assert estimates[key].value == pytest.approx(value, rel=1e-4), key


def test_intervals_hold_the_truth_of_a_log_with_noise():
    true = study.true_values(study.truth())
    result = study.identified(study.log_of(study.truth(), 3), study.scenario())
    inside = [one.low is not None and one.low <= true[one.key] <= one.high for one in result.estimates]
    assert sum(inside) >= 9  # of 10 intervals of 95 %; the study has 100 logs
    assert result.residuals == pytest.approx(study.NOISE, rel=0.1)
    assert result.residuals[0] < 0.1 * result.before[0]


def test_accelerations_of_an_inner_loop_leave_the_mass_undetermined():
    reading = "robot.inner_loop.torque_reading=acceleration"
    fast = (reading, "robot.actuator.torque_limit=1e5", "robot.inner_loop.k_p_v=3.0", "robot.inner_loop.k_p_omega=4.0")
    fast += ("robot.inner_loop.k_d_v=0.2", "robot.inner_loop.k_d_omega=0.2")
    result = study.identified(study.log_of(study.truth(*fast), 3), study.scenario(*fast))
    mass = by_key(result)["mass"]
    assert (mass.value, mass.low, mass.high) == (pytest.approx(120.0), None, None)
    assert mass.why.startswith("the log does not tell it from")
    assert by_key(result)["actuator.lag"].low is not None


def test_logs_that_identify_nothing_are_refused(tmp_path):
    t = 0.02 * np.arange(200)
    still = {"v": np.zeros(200), "omega": np.zeros(200)}
    steps = np.ones((200, 2)) * np.sign(t - 2.0)[:, None]
    for words, log in (
        ("its commands never change", Log(t, still, t, np.ones((200, 2)))),
        ("its velocities never change", Log(t, still, t, steps)),
        ("no part without gaps is longer than 1 s", Log(t[:40], {k: v[:40] for k, v in still.items()}, t, steps[:40])),
    ):
        done = here("identify", csv_of(tmp_path / "log.csv", log), status=1)
        assert f"log.csv: error[FZ911]: leader: {words}" in done.stderr
        assert "help: log a differential drive under commands that change" in done.stderr
    done = here("identify", tmp_path / "log.csv", "--scenario", "omnidirectional", status=1)
    assert "leader: only a differential drive can be identified" in done.stderr
    (tmp_path / "log.csv").write_text("t,robot,v,omega,v_c\n", encoding="utf-8")
    done = here("identify", tmp_path / "log.csv", "--format", "json", status=1)
    assert "names no column omega_c" in done.stdout


def in_other_units(factor):
    log = study.log_of(study.truth(), 3)
    return Log(log.t, {"v": factor * log.signals["v"], "omega": log.signals["omega"]}, log.command_t, log.commands)


def test_a_log_in_other_units_gets_a_message_and_no_traceback(tmp_path, monkeypatch):
    with pytest.raises(UnexplainedError, match="no mass, friction and drives lead"):
        study.identified(in_other_units(1e9), study.scenario())
    assert study.identified(in_other_units(1e3), study.scenario()).excess > 20.0
    path = csv_of(tmp_path / "log.csv", in_other_units(1e3))
    monkeypatch.setattr("dwmr.results.identification.identify", Mock(side_effect=UnexplainedError("no mass")))
    done = here("identify", path, status=1)
    assert "log.csv: error[FZ911]: leader: no mass" in done.stderr
    assert "help: write v and v_c in m/s" in done.stderr


def test_residuals_above_the_noise_are_warned_of(tmp_path):
    """The robot has another inner loop than the scenario."""
    log = csv_of(tmp_path / "log.csv", study.log_of(study.truth(), 3))
    done = here("identify", log, "--scenario", "paper-with-limits")
    assert "times the noise of the log" in done.stdout
    assert study.identified(study.log_of(study.truth(), 3), study.scenario()).excess < 1.5
    assert study.identified(study.log_of(study.truth(), 3, correlation=0.6), study.scenario()).excess < 3.0


def test_a_file_that_is_read_is_not_replaced(tmp_path):
    log = csv_of(tmp_path / "log.csv", study.log_of(study.truth(), 3))
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "paper-with-limits"\nname = "mine"\n', encoding="utf-8")
    for path in (log, mine):
        before = path.read_bytes()
        done = here("identify", log, "--scenario", mine, "-o", path, status=2)
        assert f"{path.name} is read; write another file." in done.stderr.replace("\n", "")
        assert path.read_bytes() == before


def test_the_command_writes_a_scenario_with_the_values(tmp_path):
    words = [word for one in study.FORCES for word in ("--set", one)]
    log = csv_of(tmp_path / "log.csv", study.log_of(study.truth(), 3))
    out = tmp_path / "mine.toml"
    done = here("identify", log, "--scenario", "paper-with-limits", *words, "-o", out)
    assert "in the log: there is no follower1" in done.stderr
    for key in study.true_values(study.truth()):
        assert key in done.stdout
    robot = read(out).scenario.robots["leader"]
    assert robot.mass == pytest.approx(120.0, rel=0.05)
    assert robot.actuator.angular_acceleration == pytest.approx(1.7, rel=0.02)
    assert read(out).scenario.robots["follower1"].actuator.lag == 0.02
    assert "dead_time = 0.0" in out.read_text(encoding="utf-8")
