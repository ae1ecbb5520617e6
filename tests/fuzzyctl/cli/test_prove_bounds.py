"""`fuzzyctl prove --bounds` as a user types it."""

import itertools
import json
import time

import pytest

from fuzzyctl import load
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

RULES = rules_folder()

run = runner("prove", "--bounds")


def test_bounds_are_attained_at_the_points_shown():
    result = run(RULES / "ais_reaction.fz", "--format", "json")
    assert result.exit_code == 0
    (f,) = json.loads(result.stdout)["outputs"]
    system = load(RULES / "ais_reaction.fz")
    assert (f["low"], f["high"]) == (-1.0, 0.18)
    assert system(**f["low_at"]) == f["low_found"] == -1.0
    assert system(**f["high_at"]) == f["high_found"] == 0.18
    assert f["slopes"] == {"sigma": pytest.approx(44, rel=1e-12), "dsigma": pytest.approx(1.36, rel=1e-12)}


def test_the_tip_is_bounded_to_one_percent_with_its_unit():
    result = run(RULES / "tipper.fz", "--timeout", "0.2")
    assert result.exit_code == 0
    # The tip comes down to 5.13 percent, and its range is 30 percent wide.
    assert 5.13 - 0.01 * 30 <= float(result.stdout.split()[2]) <= 5.132
    assert result.stdout.splitlines()[0].endswith(" %")


def test_a_bound_by_params_follows_them():
    result = run(RULES / "fcafsmc.fz", "--set", "half_width=0.2", "--timeout", "0.5")
    assert result.stdout.startswith("F: from -2 to 2\n")
    assert "nan" not in result.stdout


def test_a_jump_has_no_bound_of_its_slope(tmp_path):
    text = (
        "system s\ninput x in [0, 1]\n  a = rectangle(0, 0.5)\n  b = rectangle(0.5, 1)\n"
        "output y in [0, 1]\n  p = constant(0.25)\n  q = constant(0.75)\ndefuzzifier weighted_average\n"
        "table y = x\n  a b\n| p q\n"
    )
    path = tmp_path / "s.fz"
    path.write_text(text, encoding="utf-8")
    assert (
        run(path).stdout
        == "y: from 0.25 to 0.75\n"
        + "".join(f"  {v} at x = {x}\n" for v, x in ((0.25, 0), (0.75, 1)))
        + "  no bound of the slope is known along x\n"
    )


def test_a_file_with_mistakes_is_refused(tmp_path):
    path = tmp_path / "s.fz"
    path.write_text("system s\n", encoding="utf-8")
    assert run(path).exit_code == 1


class TestControllers:
    TEXT = (
        "system s\ninput e in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  terms N@-1 P@1\nand product\n"
        "defuzzifier center_average\ntable u = e\n   N P\n | N P\n"
        'controller c\ninput x in [-1, 1]\nstate k in [0, inf) unit "m" = 0\nnext k = max(0, k + x)\n'
        'output y unit "V" = 2 * s(x)\n'
    )

    @pytest.fixture
    def path(self, tmp_path):
        path = tmp_path / "c.fz"
        path.write_text(self.TEXT, encoding="utf-8")
        return path

    def test_outputs_and_states_are_printed_with_their_units(self, path):
        result = run(path)
        assert result.exit_code == 0, result.output
        assert result.stdout == "y: from -2 to 2 V\nstate k: from 0 to inf m\n"

    def test_json_holds_the_same(self, path):
        data = json.loads(run(path, "--format", "json").stdout)
        assert data["controller"] == "c"
        assert data["states"] == [{"name": "k", "low": 0.0, "high": "inf", "note": None}]
        assert [o["name"] for o in data["outputs"]] == ["y"]

    def test_why_an_end_is_infinite_is_said_at_once(self, path):
        path.write_text("controller c\ninput x\noutput y = where(x > 0, x, 1)\n", encoding="utf-8")
        assert run(path).stdout == "y: from 0 to inf\n  it grows with x\n"

    def test_inputs_up_to_which_a_bound_is_proved_are_said(self, path):
        path.write_text("controller c\ninput x\ninput z\noutput y = clamp(2 * x - 2 * z, -1, 1)\n", encoding="utf-8")
        assert run(path).stdout.splitlines()[1].startswith("  for x, z up to 1e30 in magnitude")

    def test_a_system_may_be_named(self, path):
        assert run(path, "--block", "s").stdout.startswith("u: from -1 to 1\n")

    def test_one_of_several_controllers_is_named(self, path):
        path.write_text(self.TEXT + "controller d\ninput x in [0, 1]\noutput z = x\n", encoding="utf-8")
        result = run(path)
        assert result.exit_code == 2
        assert "several controllers" in result.stderr
        assert run(path, "--block", "d").stdout == "z: from 0 to 1\n"

    def test_a_name_of_no_block_is_answered_with_all_names(self, path):
        result = run(path, "--block", "nope")
        assert result.exit_code == 2
        assert "the file holds no system or controller 'nope'" in result.stderr
        assert "= systems or controllers: s, c\n" in result.stderr

    def test_zero_has_no_sign(self, path):
        path.write_text("controller c\ninput x in [0, 1]\noutput y = -0 * x\noutput z = -x\n", encoding="utf-8")
        assert run(path).stdout == "y: from 0 to 0\nz: from -1 to 0\n"
        assert '"high": 0.0' in run(path, "--format", "json").stdout


BELLS = """
system bell
and product
implication min
aggregation max
defuzzifier centroid
input e in [-1, 1]
  N = bell(-1, 0.4, 2)
  P = bell(1, 0.4, 2)
output u in [-1, 1]
  N = bell(-0.5, 0.3, 2)
  P = bell(0.5, 0.3, 2)
if e is N then u is N
if e is P then u is P
"""


def test_time_is_for_all_bounds_together_and_the_lack_of_it_is_said(tmp_path):
    path = tmp_path / "s.fz"
    path.write_text(BELLS, encoding="utf-8")
    result = run(path, "--timeout", "0.5")
    assert result.stdout.startswith("u: from -1 to 1\n")
    assert result.stdout.endswith("  the time is spent; with more of it the bound may be tighter\n")
    assert (
        "the time is spent"
        in json.loads(run(path, "--timeout", "0.5", "--format", "json").stdout)["outputs"][0]["note"]
    )


@pytest.mark.parametrize("step", [10.0, 0.5, 0.1, 0.02])
def test_json_is_complete_wherever_the_time_ends(step, tmp_path, monkeypatch):
    path = tmp_path / "s.fz"
    path.write_text(BELLS, encoding="utf-8")
    clock = itertools.count(step=step)
    monkeypatch.setattr("fuzzyctl.analysis.work.used", lambda: next(clock))
    result = run(path, "--timeout", "0.5", "--format", "json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout, parse_constant=lambda name: pytest.fail(f"JSON knows no {name}"))
    (bound,) = data["outputs"]
    assert (bound["low"], bound["high"]) == (-1.0, 1.0)
    assert "the time is spent" in bound["note"]


@pytest.mark.parametrize(
    "lines",
    [
        "let d = delay(x, 10000)\n",
        "let d = lowpass(x, 0.3 s)\n"
        + "".join(f"let d{k} = lowpass(d{k - 1 if k else ''}, 0.3 s)\n" for k in range(500)),
    ],
)
def test_controllers_with_many_states_keep_their_time(lines, tmp_path):
    path = tmp_path / "c.fz"
    path.write_text(f"controller c\ninput x in [-1, 1]\n{lines}every 10 ms\noutput y = d\n", encoding="utf-8")
    assert run(path, "--timeout", "60").stdout.startswith("y: from -1 to 1\n")
    before = time.process_time()
    assert run(path, "--timeout", "1").stdout.startswith("y: from -")
    assert time.process_time() - before < 10


def test_a_state_without_ends_is_bounded_without_a_warning_of_numpy(tmp_path):
    path = tmp_path / "c.fz"
    lines = "input e in [-1, 1]\nstate i = 0\nnext i = i + dt * (e + 50 * i)\nevery 20 ms\noutput y = min(1, i)\n"
    path.write_text(f"controller c\n{lines}", encoding="utf-8")
    result = run(path)
    assert result.stdout == "y: from -inf to 1\n  it grows with i\nstate i: from -inf to inf\n"
    assert result.stderr == ""


def test_a_controller_that_calls_a_large_adaptive_system_keeps_its_time(tmp_path):
    names = [f"t{k}" for k in range(80)]
    terms, singletons = " ".join(names), " ".join(f"{n}={k / 100}" for k, n in enumerate(names))
    rows = "".join(f"{n} | {terms}\n" for n in names)
    path = tmp_path / "c.fz"
    path.write_text(
        f"system adaptive\ndefuzzifier weighted_average\ninput x, z in [-1, 1]\n  terms {terms}\n"
        f"output k in [-1, 1] adaptive rate x\n  terms {singletons}\ntable k = x x z\n  {terms}\n{rows}"
        "controller c\ninput e in [-1, 1]\nevery 10 ms\noutput v = adaptive(e, -e)\n",
        encoding="utf-8",
    )
    before = time.process_time()
    result = run(path, "--timeout", "1")
    assert result.stdout.startswith("v: from "), result.output
    assert "the time is spent; with more of it the bound may be tighter" in result.stdout
    assert time.process_time() - before < 10


def test_states_without_a_range_are_named_as_far_as_a_line_holds_them(tmp_path):
    path = tmp_path / "c.fz"
    filters = "".join(f"let d{k} = lowpass({f'd{k - 1}' if k else 'x'}, 0.3 s)\n" for k in range(40))
    path.write_text(f"controller c\ninput x in [-1, 1]\n{filters}every 10 ms\noutput y = d39\n", encoding="utf-8")
    result = run(path, "--timeout", "1e-9")
    assert "  no range of #started, lowpass#1.filtered, " in result.stdout
    assert " and 21 more is proved; the time is spent" in result.stdout


@pytest.mark.parametrize(("comment", "least", "most"), [("", 5.0, 5.0), ("# " * 500_000, 0.5, 1.5)])
def test_reading_a_large_system_is_part_of_the_time(comment, least, most, tmp_path, monkeypatch):
    path = tmp_path / "s.fz"
    path.write_text(BELLS + comment, encoding="utf-8")
    times = []
    monkeypatch.setattr("fuzzyctl.analysis.extremes.extents", lambda _, timeout: times.append(timeout) or ())
    assert run(path).exit_code == 0
    assert least <= times[0] <= most


def test_reading_is_part_of_the_time_of_a_controller(tmp_path, monkeypatch):
    path = tmp_path / "c.fz"
    path.write_text("controller c\ninput x in [-1, 1]\noutput y = x\n", encoding="utf-8")
    clock = iter([10.0, 12.5])
    monkeypatch.setattr("fuzzyctl.analysis.work.used", lambda: next(clock))
    times = []
    monkeypatch.setattr("fuzzyctl.analysis.induction.bounds.controller_bounds", lambda _, t: times.append(t) or {})
    run(path)
    assert times == [1.25]
