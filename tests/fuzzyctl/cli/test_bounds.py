"""`fuzzyctl bounds` as a user types it."""

import json

import pytest

from fuzzyctl import load
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

RULES = rules_folder()

run = runner("bounds")


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
    result = run(RULES / "tipper.fz", "--timeout", "1")
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
