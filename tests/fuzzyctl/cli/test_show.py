"""`fuzzyctl show` on any width and as data; transcripts/show.txt holds what it prints."""

import dataclasses
import json

import pytest

import fuzzyctl
from tests.commands import runner
from tests.shipped import SYSTEMS


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_nothing_is_wider_than_the_terminal(columns, monkeypatch):
    monkeypatch.chdir(SYSTEMS[0].parent)
    run = runner("show", COLUMNS=str(columns))
    for path in SYSTEMS:
        result = run(path.name)
        assert result.exit_code == 0
        assert "\nRules: " in result.output
        assert max(map(len, result.output.splitlines())) <= columns
        assert "\x1b" not in result.output


def test_no_setting_of_a_method_is_left_out_of_the_data():
    data = json.loads(runner("show")("tipper", "--format", "json").stdout)
    fields = {field.name for field in dataclasses.fields(fuzzyctl.load("tipper").method)}
    assert len(data["method"]) == len(fields - {"span", "spans"})


def test_data_of_a_table_and_of_ends_at_infinity():
    run = runner("show")
    data = json.loads(run("fcafsmc", "--format", "json").stdout)
    (foot,) = {t["parameters"][2] for t in data["inputs"][0]["terms"] if t["name"] == "NB"}
    assert data["inputs"][0]["terms"][0]["parameters"] == ["-inf", -0.4, foot]
    assert repr(foot).startswith("-0.26666666666666")
    assert data["outputs"][0]["bounds"] == {"low": -2.0, "high": 2.0, "attained": True}
    (table,) = json.loads(run("ais_reaction", "--format", "json").stdout)["rules"]
    assert (len(table["cells"]), len(table["cells"][0])) == (5, 5)
