import json

import numpy as np
import pytest

from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

TANK = str(rules_folder() / "loops" / "water_tank.fz")
SMALL = """
controller law
input r
input y
param K in (0, 10] = 1
output u "valve" unit "V" = K * (r - y)
every 0.1 s

plant p
input u
param K = 2
param T = 1
state x in [-5, 5] unit "m" = 0
der x = (K * u - x) / T
output y "level" unit "m" = x

loop {name} "A step"
block law = law(r, p.y)
block p = p(law.u)
let r = steps(0: 1)
measure final "at the end" unit "m" = final(p.y)
measure {measure} = iae(p.y, r)
run 5 s
require final {claim}
"""

run = runner("simulate")


@pytest.fixture
def small(tmp_path):
    """Write a file with one loop and return its path."""

    def write(file="small.fz", name="small", measure="iae", claim="<= 1"):
        path = tmp_path / file
        path.write_text(SMALL.format(name=name, measure=measure, claim=claim), encoding="utf-8")
        return path

    return write


#: Numbers that depend on params, in each kind of block.
SET = """
controller inner
input x
param d = 1
state s = 1 / d
next s = x
output y = s

controller c
input x
param T = 0.1 s
block a = inner(x)
output y = a.y
every T

plant p
input u
param T = 0.2 s
state x = 0
der x = delay(u, T) - x
output y = x

plant q = tf(num=[1], den=[T, 1])
param T = 1

loop l
param end = 1
param wait = 0.1
param sigma = 0
param band = 2 %
block c = c(p.y + noise(sigma))
block p = p(c.y)
block q = q(c.y)
measure m = settling(q.y, 1, band=band)
run end step wait
"""


class TestText:
    def test_measures_and_requirements_are_printed(self, small):
        result = run(small())
        assert result.exit_code == 0, result.output
        assert result.output.split("\n") == [
            "small: A step",
            "  5 s in 51 samples, RK4 with 1 step a sample",
            "  half the step changes p.x by 2.4e-07",
            "",
            "final  at the end  0.66667 m",
            "iae                1.8669",
            "",
            "require final <= 1: met  (final = 0.666667)",
            "",
        ]

    def test_a_requirement_that_is_not_met_fails(self, small):
        result = run(small(claim="> 0.9"))
        assert result.exit_code == 1
        assert "require final > 0.9: not met  (final = 0.666667)" in result.output

    def test_the_tolerance_of_a_requirement_is_printed(self, small):
        result = run(small(claim="== 0.6 within 0.1"))
        assert result.exit_code == 0
        assert "require final == 0.6: met  (final = 0.666667, within 0.1)" in result.output

    def test_the_shipped_loop_runs(self):
        result = run(TANK)
        assert result.exit_code == 0, result.output
        assert "require settling <= 10 s: met" in result.output

    def test_params_are_set(self, small):
        output = run(small(), "--set", "law.K=4", "--set", "T=0.5").output
        assert "final  at the end  0.88889 m" in output
        assert run(small(), "--set", "law.K=4", "--set", "p.T=0.5").output == output

    @pytest.mark.parametrize(
        ("setting", "exit_code", "code", "text"),
        [
            ("K=4", 2, "FZ502", "no param 'K'"),
            ("law.k=4", 2, "FZ502", "did you mean 'law.K'?"),
            ("law.K=40", 1, "FZ302", "param 'law.K' is 40, outside of (0, 10]"),
            ("law.K=40", 1, "FZ302", "give --set another value"),
            ("law.K=high", 2, "FZ503", "param 'law.K' is not a number"),
        ],
    )
    def test_a_setting_that_does_not_fit_is_a_mistake(self, small, setting, exit_code, code, text):
        result = run(small(), "--set", setting)
        assert result.exit_code == exit_code
        assert code in result.output
        assert text in result.output

    @pytest.mark.parametrize(
        ("setting", "message"),
        [
            ("end=0", "the duration is 0 s, not positive"),
            ("end=-1", "the duration is -1 s, not positive"),
            ("wait=0", "the step is 0 s, not positive"),
            ("c.T=0", "the period is 0 s, not positive"),
            ("sigma=-1", "'sigma' of 'noise' is -1: expected 0 or more"),
            ("band=0", "'band' of 'settling' is 0: expected a positive number"),
            ("c.a.d=0", "division by zero"),
            ("p.T=-1", "the dead time is -1 s: expected a finite time of 0 or more"),
            ("q.T=0", "division by zero"),
        ],
    )
    def test_settings_are_checked_as_numbers_of_the_file(self, tmp_path, setting, message):
        path = tmp_path / "l.fz"
        path.write_text(SET, encoding="utf-8")
        assert run(path).exit_code == 0
        result = run(path, "--set", setting, "--format", "json")
        assert result.exit_code == 1
        (found,) = json.loads(result.output)["diagnostics"]
        assert found["message"] == message
        assert found["facts"] == [f"with --set {setting}"]
        assert found["line"] > 0

    def test_a_run_that_is_stopped_says_when_and_why(self, small):
        result = run(small(), "--set", "law.K=10", "--set", "p.K=10", "--set", "p.T=0.1")
        assert result.exit_code == 1
        assert "FZ701" in result.output
        assert "state 'p.x' left its range at t = " in result.output
        assert "require final <= 1: not met" in result.output

    def test_an_output_of_a_plant_without_a_value_stops_the_run(self, small, tmp_path):
        path = small()
        path.write_text(path.read_text("utf-8").replace("= x\n", "= sqrt(0.5 - x)\n"), encoding="utf-8")
        result = run(path, "-o", tmp_path / "out")
        assert result.exit_code == 1
        assert "output 'p.y' is not a number at t = 0.8 s" in result.output
        assert "  = there p.x = 0.595" in result.output
        assert "require final <= 1: not met" in result.output
        assert len((tmp_path / "out" / "data.csv").read_text("utf-8").splitlines()) == 1 + 8

    def test_a_signal_without_a_value_is_a_warning(self, small):
        path = small()
        text = path.read_text("utf-8").replace("iae(p.y, r)", "integral(slip)") + "let slip = p.y / p.y\n"
        path.write_text(text, encoding="utf-8")
        result = run(path)
        assert result.exit_code == 0
        assert "warning[FZ708]: 'slip' is not a number at t = 0 s" in result.output
        assert "signals have no value at 1 of 51 samples" in result.output
        assert "measures without a value: iae" in result.output
        assert "FZ708" not in run(path, "--quiet").output

    def test_signals_that_lose_their_values_apart_are_all_said(self, small):
        path = small()
        text = path.read_text("utf-8").replace("iae(p.y, r)", "integral(slip + log(p.y - 0.1))")
        lets = "let slip = p.y / p.y\nlet twice = 2 * slip\nlet root = sqrt(p.y - 0.1)\nallow FZ216\n"
        path.write_text(text + lets, encoding="utf-8")
        (warning,) = run(path).output.split("warning[")[1:]
        assert warning.startswith("FZ708]: 'slip' is not a number at t = 0 s")
        assert "= nor is 'root' at t = 0 s (line " in warning
        assert "twice" not in warning

    def test_an_inaccurate_integration_is_a_warning(self, small):
        result = run(small(), "--set", "p.T=0.05")
        assert "warning[FZ706]" in result.output
        assert "--substeps 4" in result.output
        assert "FZ706" not in run(small(), "--set", "p.T=0.05", "--substeps", 20).output

    def test_standard_input_is_a_file(self, small):
        path = small()
        piped = run("-", stdin=path.read_text("utf-8"))
        assert (piped.exit_code, piped.output) == (0, run(path).output)

    def test_other_solvers_give_the_same(self, small):
        first = run(small()).output.split("\n")[4:]
        assert run(small(), "--solver", "DOP853").output.split("\n")[4:] == first

    def test_wrong_usage(self, small):
        assert run(small(), "--solver", "euler").exit_code == 2
        assert run(small(), "--substeps", "0").exit_code == 2
        unknown = run(small(), "--block", "smal")
        assert unknown.exit_code == 2
        assert "did you mean 'small'?" in unknown.output
        plant = run(small(), "--block", "p")
        assert plant.exit_code == 2
        assert "'p' is a plant: a loop runs it" in plant.output
        output = run(rules_folder() / "tipper.fz").output
        assert "the file holds no loop\n = it holds: system 'tipper'\n = help: a 'loop' joins controllers" in output


class TestSeveral:
    def test_loops_of_other_files_stand_side_by_side(self, small):
        result = run(small(), "--against", small("other.fz", name="other", measure="cost"))
        assert result.exit_code == 0, result.output
        table = [line.rstrip() for line in result.output.split("\n")[7:11]]
        assert table == [
            "measure            small      other",
            "final  at the end  0.66667 m  0.66667 m",
            "iae                1.8669",
            "cost                          1.8669",
        ]
        assert "small: require final <= 1: met" in result.output

    def test_measures_that_only_one_has_are_named(self, small):
        result = run(small(), "--against", small("other.fz", name="other", measure="cost"))
        assert "only small measures: iae" in result.output
        assert "only other measures: cost" in result.output

    def test_loops_of_the_same_name_are_called_after_their_files(self, small):
        output = run(small(), "--against", small("other.fz")).output
        assert "measure            small.small  other.small" in output

    def test_all_loops_of_a_file_are_run_or_the_one_named(self, small):
        path = small()
        more = path.read_text("utf-8").partition("loop small")[2]
        path.write_text(f"{path.read_text('utf-8')}\nloop second{more}", encoding="utf-8")
        assert "measure            small      second" in run(path).output
        assert run(path, "--block", "second").output.startswith("second: A step\n")

    @pytest.mark.parametrize("mistake", [("p.y)", "p.z)"), ("law(r, p.y)", "law(r, p.y,,")])
    def test_a_mistake_in_one_loop_leaves_the_others_alone(self, small, mistake):
        path = small()
        more = path.read_text("utf-8").partition("loop small")[2].replace(*mistake)
        path.write_text(f"{path.read_text('utf-8')}\nloop second{more}", encoding="utf-8")
        assert run(path, "--block", "small").exit_code == 0
        for names in ((), ("--block", "second"), ("--block", "third")):
            result = run(path, *names)
            assert result.exit_code == 1
            assert "error[FZ" in result.output

    def test_a_setting_counts_for_the_loops_that_have_the_param(self, small):
        other = small("other.fz", name="other")
        other.write_text(
            other.read_text("utf-8").replace("param T = 1", "param T2 = 1").replace("/ T", "/ T2"), "utf-8"
        )
        result = run(small(), "--against", other, "--set", "T2=0.8", "--set", "T=0.5", "--substeps", 20)
        assert result.exit_code == 0, result.output


class TestFiles:
    def test_summary_data_and_picture_are_written(self, small, tmp_path):
        result = run(small(), "-o", tmp_path / "new" / "out")
        out = tmp_path / "new" / "out"
        assert sorted(p.name for p in out.iterdir()) == ["data.csv", "loop.png", "summary.json"]
        summary = json.loads((out / "summary.json").read_text("utf-8"))
        assert summary["measures"]["final"] == pytest.approx(2 / 3, rel=1e-4)
        table = np.genfromtxt(out / "data.csv", delimiter=",", names=True, deletechars="")
        assert table.dtype.names == ("t", "r", "law.r", "law.y", "law.u", "p.u", "p.x", "p.y")
        assert table["p.y"][-1] == summary["measures"]["final"]
        assert (out / "loop.png").read_bytes().startswith(b"\x89PNG")
        assert "wrote " in result.output

    @pytest.mark.parametrize("form", ["npz", "parquet"])
    def test_data_has_other_formats(self, small, tmp_path, form):
        out = tmp_path / "out"
        run(small(), "-o", out, "--data", form, "--picture", "svg")
        if form == "npz":
            found = np.load(out / "data.npz")["p.y"]
        else:
            from pyarrow import parquet

            found = parquet.read_table(out / "data.parquet").column("p.y").to_numpy()
        assert len(found) == 51
        assert (out / "loop.svg").read_text("utf-8").startswith("<?xml")

    def test_several_runs_have_folders_of_their_own_and_one_picture(self, small, tmp_path):
        out = tmp_path / "out"
        run(small(), "--against", small("other.fz", name="other"), "-o", out)
        assert sorted(p.relative_to(out).as_posix() for p in out.rglob("*.*")) == [
            *("loop.png", "other/data.csv", "other/summary.json", "small/data.csv", "small/summary.json"),
        ]

    def test_the_same_run_gives_the_same_bytes(self, small, tmp_path):
        for name in ("a", "b"):
            run(small(), "-o", tmp_path / name, "--picture", "svg")
        for path in (tmp_path / "a").iterdir():
            assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()

    def test_the_data_up_to_a_stop_is_kept(self, small, tmp_path):
        run(small(), "--set", "p.K=10", "--set", "p.T=0.1", "--set", "law.K=10", "-o", tmp_path / "out")
        rows = (tmp_path / "out" / "data.csv").read_text("utf-8").splitlines()
        summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
        assert len(rows) - 1 == summary["samples"] < 51
        assert summary["stopped"]["code"] == "FZ701"

    def test_a_file_in_the_place_of_the_folder_is_a_mistake(self, small, tmp_path):
        (tmp_path / "out").write_text("")
        result = run(small(), "-o", tmp_path / "out")
        assert result.exit_code == 1
        assert "FZ909" in result.output
        assert "samples" not in result.output, "it is refused before the run"

    def test_a_file_in_the_place_of_the_folder_of_one_of_several_runs_is_a_mistake(self, small, tmp_path):
        out = tmp_path / "out"
        out.mkdir()
        (out / "small").write_text("")
        result = run(small(), "--against", small("other.fz", name="other"), "-o", out)
        assert result.exit_code == 1
        assert "small cannot be written: it is a file" in result.output
        assert [p.name for p in out.iterdir()] == ["small"]

    def test_files_of_an_earlier_run_do_not_stay_beside_new_ones(self, small, tmp_path):
        run(small(), "-o", tmp_path / "out", "--data", "npz", "--picture", "svg")
        (tmp_path / "out" / "notes.txt").write_text("mine")
        run(small(), "-o", tmp_path / "out")
        names = sorted(p.name for p in (tmp_path / "out").iterdir())
        assert names == ["data.csv", "loop.png", "notes.txt", "summary.json"]


class TestJson:
    def test_runs_and_diagnostics_are_data(self, small):
        data = json.loads(run(small(claim="> 0.9"), "--format", "json").output)
        (only,) = data["runs"]
        assert (only["label"], only["requirements"]) == ("small", [{"claim": "final > 0.9", "holds": False}])
        assert data["diagnostics"] == []

    def test_a_stop_is_among_the_diagnostics(self, small):
        result = run(small(), "--set", "p.K=10", "--set", "p.T=0.1", "--set", "law.K=10", "--format", "json")
        assert [d["code"] for d in json.loads(result.output)["diagnostics"]] == ["FZ701"]


class TestCompare:
    compare = staticmethod(runner("compare"))

    def test_measures_of_two_files_are_compared(self, small):
        other = small("other.fz", measure="cost")
        other.write_text(other.read_text("utf-8").replace("param K = 2", "param K = 3"), encoding="utf-8")
        result = self.compare(small("first.fz"), other, "--loops")
        assert result.exit_code == 0, result.output
        lines = result.output.split("\n")
        assert lines[0].endswith("other.fz: small")
        assert lines[1:] == [
            "  measure  first    second  difference",
            "  final    0.66667  0.75    0.083333",
            "  iae      1.8669   none    none",
            "  cost     none     1.4095  none",
            "",
        ]

    def test_a_difference_beyond_the_tolerance_fails(self, small):
        one, other = small("first.fz"), small("other.fz", name="renamed")
        assert self.compare(one, other, "--loops", "--within", "0").exit_code == 0
        other.write_text(other.read_text("utf-8").replace("param K = 2", "param K = 3"), encoding="utf-8")
        assert self.compare(one, other, "--loops", "--within", "0.01").exit_code == 1
        data = json.loads(self.compare(one, other, "--loops", "--format", "json").output)
        assert data["pairs"][0]["measures"]["final"]["difference"] == pytest.approx(0.75 - 2 / 3, rel=1e-3)

    def test_settings_count_for_both(self, small):
        result = self.compare(small("first.fz"), small("other.fz"), "--loops", "--set", "law.K=4")
        assert "  final    0.88889  0.88889  0\n" in result.output

    def test_it_takes_two_files(self, small):
        assert self.compare(small(), "--loops").exit_code == 2
        assert self.compare(small(), small(), "--loops", "--block", "small").exit_code == 0
        for option in (("--as", "exact"), ("--points", "5")):
            assert self.compare(small(), small(), "--loops", *option).exit_code == 2


KEPT = "give what is kept a finite start, or keep arguments of sqrt and log in their domain"


@pytest.mark.parametrize(
    ("law", "time", "expected"),
    [
        ("output u = previous(y, start=inf)", "0", "give it a finite start"),
        ("state h = inf\nnext h = y\noutput u = h", "0", "give it a finite start"),
        ("output u = delay(y, 3, start=inf)", "0", "give it a finite start"),
        ("output u = min(0, 1 - previous(delay(y, 3, start=inf), start=1))", "0.1", KEPT),
    ],
)
def test_a_stop_by_a_state_that_starts_infinite_says_so(tmp_path, law, time, expected):
    path = tmp_path / "l.fz"
    plant = "plant p\ninput u\nstate x = 0\nder x = u - x\noutput y = x\n"
    loop = "loop l\nblock c = c(p.y)\nblock p = p(c.u)\nrun 1 s\n"
    path.write_text(f"controller c\ninput y\n{law}\nevery 0.1 s\n{plant}{loop}", encoding="utf-8")
    (found,) = json.loads(run(path, "--format", "json").output)["diagnostics"]
    assert found["message"] == f"'c.u' is infinite at t = {time} s"
    assert found["help"].startswith(expected)
    assert run(path).output.count("what is kept here starts infinite") == 1
