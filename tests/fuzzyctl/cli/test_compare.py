"""Shares of differences that `fuzzyctl compare` explains; transcripts/compare.txt holds what it prints."""

import json

import pytest

from tests.commands import runner

run = runner("compare")


@pytest.fixture
def files(tmp_path, base, changed):
    first, second = tmp_path / "first.fz", tmp_path / "second.fz"
    first.write_text(base, encoding="utf-8")
    second.write_text(changed(("  Z |  N  P", "  Z |  Z  P"), after="and product\n"), encoding="utf-8")
    return first, second


def test_the_causes_together_explain_the_difference(files):
    data = json.loads(run(*files, "--points", "200", "--format", "json").stdout)
    (output,) = data["pairs"][0]["outputs"]
    assert output["largest"] > 0.1
    assert sum(c["explains"] for c in output["causes"]) == pytest.approx(1.0, abs=1e-6)


def test_a_difference_that_no_single_setting_explains_is_reported(files, monkeypatch):
    monkeypatch.setattr("fuzzyctl.comparison.explanation.parts", lambda *_: iter(()))
    assert "the rest: several of what differs at once  explains 100 %" in run(*files).stdout


def test_a_point_with_one_value_has_its_own_causes(tmp_path, changed):
    first, second = tmp_path / "first.fz", tmp_path / "second.fz"
    hole = ("  Z |  N  P", "  Z |  .  .")
    first.write_text(changed(hole, ("[-2, 2]", "[-2, 2] else nan")), encoding="utf-8")
    second.write_text(changed(hole, ("[-2, 2]", "[-2, 2] else 0.5"), after="and product\n"), encoding="utf-8")
    (output,) = json.loads(run(first, second, "--points", "200", "--format", "json").stdout)["pairs"][0]["outputs"]
    assert (output["gap"]["first"], [c["name"] for c in output["gap"]["causes"]]) == (None, ["else"])
    assert output["largest"] > 0
