"""`fuzzyctl prove` as a user types it."""

import json

import pytest

from fuzzyctl.analysis.prove import Prover
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

RULES = rules_folder()

run = runner("prove")


@pytest.fixture
def written(tmp_path):
    def write(*claims, extra=""):
        path = tmp_path / "line.fz"
        text = "system line\ninput e in [-1, 1]\n  terms N Z P\noutput u in [-1, 1]\n  terms N Z P\n"
        text += "and product\ndefuzzifier center_average\ntable u = e\n   N Z P\n | N Z P\n" + extra
        path.write_text(text + "".join(f"require {c}\n" for c in claims), encoding="utf-8")
        return path

    return write


def test_shipped_files_are_proved_one_line_each():
    result = run(*sorted(RULES.glob("*.fz")))
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert sum(": proved: " in line for line in lines) == 22
    assert lines[-1] == "22 proved"


def test_a_refuted_claim_shows_its_witness_and_fails(written):
    result = run(written("u <= 0.5", "u <= 1"))
    assert result.exit_code == 1
    assert ":11: refuted: u <= 0.5\n    at e = 1: u = 1\n" in result.stdout
    assert result.stdout.endswith("1 proved, 1 refuted\n")


def test_an_undecided_claim_says_what_would_decide_it_and_exits_with_3(written):
    result = run(written("u <= 0.5 when e <= 0.5"))
    assert result.exit_code == 3
    assert "within" in result.stdout


def test_a_refuted_claim_counts_more_than_an_undecided_one(written):
    assert run(written("u <= 0.5 when e <= 0.5", "u < 0")).exit_code == 1


def test_params_may_be_set(written):
    path = written("u <= c", extra="param c = 1\n")
    assert run(path).exit_code == 0
    result = run(path, "--set", "c=0.25")
    assert result.exit_code == 1
    assert "c = 0.25" in result.stdout


@pytest.mark.parametrize("arguments", [("--set", "d=1"), ("--set", "c=one"), ("--block", "none")])
def test_unknown_names_and_values_that_are_not_numbers_are_wrong_usage(written, arguments):
    assert run(written("u <= c", extra="param c = 1\n"), *arguments).exit_code == 2


def test_json_holds_the_same(written):
    result = run(written("u <= 0.5", "u <= 1", "u <= 0.5 when e <= 0.5", "decreasing(u, e)"), "--format", "json")
    data = json.loads(result.stdout)
    (system,) = data["systems"]
    kinds = [g["verdict"] for g in system["guarantees"]]
    assert kinds == ["refuted", "proved", "undecided", "refuted"]
    assert system["guarantees"][0]["witness"] == {"point": {"e": 1.0}, "other": None, "values": {"u": 1.0}}
    assert system["guarantees"][3]["witness"]["other"] is not None
    assert system["guarantees"][0]["line"] == 11
    assert data["diagnostics"] == []


def test_json_says_infinite_in_words(tmp_path):
    path = tmp_path / "pole.fz"
    path.write_text(
        "system pole\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms A B\noutput y in [0, 9]\n"
        "  K = function(1 / x)\ntable y = x\n   A B\n | K K\nrequire y <= 1e300\n",
        encoding="utf-8",
    )
    (guarantee,) = json.loads(run(path, "--format", "json").stdout)["systems"][0]["guarantees"]
    assert guarantee["witness"] == {"point": {"x": 0.0}, "other": None, "values": {"y": "inf"}}


def test_a_mistake_in_the_file_is_a_diagnostic(written):
    result = run(written("v <= 1"))
    assert result.exit_code == 1
    assert "FZ202" in result.stderr
    data = json.loads(run(written("v <= 1"), "--format", "json").stdout)
    assert data["diagnostics"][0]["code"] == "FZ202"


def test_of_a_file_with_mistakes_nothing_is_counted(tmp_path):
    path = tmp_path / "broken.fz"
    path.write_text("system s\n", encoding="utf-8")
    assert run(path).stdout == ""


def test_ctrl_c_keeps_what_was_reported_and_counts_what_is_left(written, monkeypatch):
    path = written("u <= 1", "u >= -1", "u <= 0.5")
    verdict = Prover.verdict

    def interrupted(prover, guarantee):
        if guarantee.span.line == 12:
            raise KeyboardInterrupt
        return verdict(prover, guarantee)

    monkeypatch.setattr(Prover, "verdict", interrupted)
    result = run(path)
    assert result.exit_code == 130
    assert result.stdout == f"{path}:11: proved: u <= 1\n"
    assert result.stderr == "interrupted: 1 proved, 2 left\n"
    assert run(path, "--format", "json").stdout == ""


def test_a_file_without_guarantees_says_so(written):
    result = run(written())
    assert result.exit_code == 0
    assert "line: no guarantees" in result.stdout


def test_one_of_several_systems_may_be_named(written, tmp_path):
    both = tmp_path / "both.fz"
    one = written("u <= 1").read_text(encoding="utf-8")
    both.write_text(one + one.replace("system line", "system other").replace("u <= 1", "u <= 0"), encoding="utf-8")
    assert run(both).exit_code == 1
    assert run(both, "--block", "line").exit_code == 0
    assert run(both, "--block", "none").exit_code == 2


def test_a_negative_time_is_wrong_usage(written):
    assert run(written("u <= 1"), "--timeout", "-1").exit_code == 2


def test_a_time_that_is_no_number_is_wrong_usage(written):
    result = run(written("u <= 1"), "--timeout", "nan")
    assert (result.exit_code, "nan is not in the range" in result.output) == (2, True)


CONTROLLER = """
controller valve
function half(a) = a / 2
input x in [-1, 1]
param top in (0, 10] = 1
state s in [0, 2] = 0
next s = clamp(s + x, 0, top)
output y in [0, 5] = half(s)
"""


@pytest.fixture
def controller(written):
    def write(*claims, system=False):
        path = written() if system else written().with_name("valve.fz")
        text = path.read_text(encoding="utf-8") if system else ""
        path.write_text(text + CONTROLLER.lstrip() + "".join(f"require {c}\n" for c in claims), encoding="utf-8")
        return path

    return write


class TestControllers:
    def test_ranges_and_claims_are_proved_in_the_order_written(self, controller):
        result = run(controller("y <= 0.5"))
        assert result.exit_code == 0, result.output
        assert [line.partition(".fz")[2] for line in result.stdout.splitlines()[:-1]] == [
            ":5: proved: s in [0, 2]",
            ":7: proved: y in [0, 5]",
            ":8: proved: y <= 0.5",
        ]
        assert result.stdout.endswith("\n3 proved\n")

    def test_a_refuted_claim_shows_the_state_and_whether_it_is_reached(self, controller):
        result = run(controller("y <= 0.25"))
        assert result.exit_code == 1
        assert "refuted: y <= 0.25\n    at s = " in result.stdout
        assert "\n    reached from the start after " in result.stdout

    def test_an_undecided_claim_exits_with_3(self, controller):
        assert run(controller("sqrt(x) >= 0")).exit_code == 3

    def test_params_may_be_set_within_their_ranges(self, controller):
        path = controller("y <= 0.5")
        assert run(path, "--set", "top=0.5").exit_code == 0
        assert run(path, "--set", "top=1.5").exit_code == 1
        result = run(path, "--set", "top=20")
        assert result.exit_code == 1
        assert "param 'top' is 20, outside of (0, 10]" in result.stderr
        assert "with --set top=20" in result.stderr
        assert "no param 'to'" in run(path, "--set", "to=1").stderr

    def test_systems_beside_a_controller_are_proved_too(self, controller):
        path = controller("y <= 0.5", system=True)
        assert "line: no guarantees" in run(path, "--set", "top=0.5").stdout
        assert run(path, "--block", "line").stdout.endswith("0 proved\n")
        assert run(path, "--block", "valve").stdout.endswith("3 proved\n")
        assert run(path, "--block", "vale").exit_code == 2

    def test_mistakes_are_reported_and_nothing_is_proved(self, controller):
        result = run(controller("z <= 0.5"))
        assert result.exit_code == 1
        assert "no name 'z'" in result.stderr
        assert "proved:" not in result.stdout

    def test_json_holds_the_same(self, controller):
        data = json.loads(run(controller("y <= 0.25", "sqrt(x) >= 0"), "--format", "json").stdout)
        (found,) = data["controllers"]
        assert data["systems"] == []
        assert found["controller"] == "valve"
        assert [g["verdict"] for g in found["guarantees"]] == ["proved", "proved", "refuted", "undecided"]
        assert found["guarantees"][2]["witness"]["point"].keys() == {"s"}
        assert found["guarantees"][2]["note"].startswith("reached from the start after ")
