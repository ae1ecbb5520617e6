import csv
import io
import json
import math

import pytest

import fuzzyctl
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.support.shipped import rules_folder
from tests.bench import startup
from tests.commands import runner

AIS = str(rules_folder() / "ais_reaction.fz")
TIPPER = str(rules_folder() / "tipper.fz")

run = runner("eval")


class TestPoint:
    def test_it_prints_every_digit(self):
        result = run(TIPPER, "service=2", "food=1")
        assert result.exit_code == 0
        assert result.output.startswith("tip = 7.0150623200")
        assert result.output.endswith(" %\n")

    def test_negative_values_are_no_options(self):
        assert run(AIS, "sigma=-0.06", "dsigma=-1").output == "f = -1.0\n"

    def test_json_gives_inputs_and_outputs(self):
        data = json.loads(run(AIS, "sigma=0", "dsigma=0", "--format", "json").output)
        assert data["outputs"] == {"f": 0.18}

    def test_a_value_outside_the_range_is_clamped_with_a_warning(self):
        result = run(AIS, "sigma=5", "dsigma=1")
        assert result.exit_code == 0
        assert "sigma = 5 lies outside [-0.06, 0.06]; taken as 0.06" in result.output
        assert "f = -1.0" in result.output

    def test_nan_in_gives_nan_out(self):
        assert run(AIS, "sigma=nan", "dsigma=1").output == "f = nan\n"
        assert json.loads(run(AIS, "sigma=nan", "dsigma=1", "--format", "json").output)["outputs"] == {"f": None}

    def test_all_mistakes_are_named(self):
        result = run(AIS, "sgma=1", "dsigma=a", "x")
        assert result.exit_code == 2
        for part in (
            "no input 'sgma'",
            "did you mean 'sigma'",
            "'dsigma' is not a number: 'a'",
            "'x' is not of the form",
        ):
            assert part in result.output

    def test_a_decimal_comma_is_shown_as_a_point(self):
        result = run(TIPPER, "service=7,5", "food=-1,25")
        assert result.exit_code == 2
        assert "help: write service=7.5" in result.output
        assert "help: write food=-1.25" in result.output

    @pytest.mark.parametrize("value", ["50%", "7,", "7;5", "1.000,5", "1_000", "７", "seven", "", "1 000"])
    def test_no_number_is_made_up_for_a_value_that_is_none(self, value):
        result = run(TIPPER, f"service={value}", "food=8")
        assert result.exit_code == 2
        assert "= help: the form is: service=NUMBER\n" in result.output

    def test_a_comma_may_separate_thousands(self):
        result = run(TIPPER, "service=1,000", "food=8")
        assert "= decimals are written with a point, thousands without a separator: 1000\n" in result.output
        assert "thousands" not in run(TIPPER, "service=0,125", "food=8").output

    def test_a_value_that_overflows_is_no_infinity(self):
        result = run(AIS, "sigma=1e400", "dsigma=inf")
        assert result.exit_code == 2
        assert "input 'sigma' = 1e400 is larger than 1.8e308" in result.output

    def test_a_missing_value_is_named_with_its_range(self):
        result = run(AIS, "sigma=1")
        assert result.exit_code == 2
        assert "input 'dsigma' has no value" in result.output
        assert "[-1, 1] 1/s" in result.output

    @pytest.mark.parametrize("setting", ["k_s=inf", "k_s=nan", "k_s=-0.05"])
    def test_a_param_that_does_not_fit_is_blamed_on_the_command_line(self, setting):
        result = run(AIS, "sigma=0", "dsigma=0", "--set", setting)
        assert result.exit_code == (1 if setting == "k_s=-0.05" else 2)
        assert "error[FZ" in result.output
        assert setting.replace("k_s=", "'k_s' = ") in result.output or f"with --set {setting}" in result.output
        assert "swap the ends" not in result.output

    def test_params_can_be_set(self):
        result = run(AIS, "sigma=0", "dsigma=0", "--set", "k_x=1")
        assert result.exit_code == 2
        assert "no param 'k_x'" in result.output
        assert run(AIS, "sigma=0", "dsigma=0", "--set", "k_s=0.5").exit_code == 0

    def test_an_adaptive_system_is_evaluated_at_its_initial_consequents(self):
        assert run(rules_folder() / "fcafsmc.fz", "sigma=0.1").output == "F = 0.0\n"

    def test_a_file_with_a_hole_is_refused(self, tmp_path, changed):
        path = tmp_path / "a.fz"
        path.write_text(changed(("N |  N  Z", "N |  .  Z")))
        result = run(path, "x=-1", "y=0")
        assert result.exit_code == 1
        assert "FZ401" in result.output

    def test_where_no_rule_fires_else_error_is_said_plainly(self, tmp_path, changed):
        path = tmp_path / "a.fz"
        path.write_text(changed(("N |  N  Z", "N |  .  Z"), ("[-2, 2]", "[-2, 2] else error")))
        result = run(path, "x=-1", "y=0")
        assert (result.exit_code, result.output.count("Traceback")) == (1, 0)
        assert "no rule fires for output 'u' at x = -1, y = 0" in result.output


class TestPoints:
    def test_outputs_are_appended_and_other_columns_kept(self):
        result = run(TIPPER, "--points", "-", stdin="food,service,who\n1,2,ann\n5,4,bob\n")
        rows = list(csv.reader(io.StringIO(result.output)))
        assert rows[0] == ["food", "service", "who", "tip"]
        assert rows[2][:3] == ["5", "4", "bob"]
        assert float(rows[2][3]) == pytest.approx(14.4530101086, rel=1e-11)

    def test_a_file_gives_what_single_points_give(self, tmp_path):
        points = [(s / 100, d / 10) for s in range(-7, 8) for d in range(-11, 12)]
        path = tmp_path / "in.csv"
        path.write_text("sigma,dsigma\n" + "".join(f"{s},{d}\n" for s, d in points))
        rows = list(csv.DictReader(io.StringIO(run(AIS, "--points", path).stdout)))
        from fuzzyctl.loading.load import load

        system = load(AIS)
        assert len(rows) == len(points)
        for (s, d), row in zip(points, rows, strict=True):
            assert float(row["f"]) == pytest.approx(system(sigma=s, dsigma=d), abs=1e-12)

    def test_json_is_a_list(self):
        data = json.loads(run(TIPPER, "--points", "-", "--format", "json", stdin="food,service\n1,2\nnan,2\n").output)
        assert data[0]["inputs"] == {"food": 1.0, "service": 2.0}
        assert data[1]["outputs"] == {"tip": None}

    def test_a_header_alone_gives_a_header(self):
        assert run(TIPPER, "--points", "-", stdin="food,service\n").output == "food,service,tip\n"
        assert json.loads(run(TIPPER, "--points", "-", "--format", "json", stdin="food,service\n").output) == []

    def test_clamped_values_are_counted(self):
        result = run(AIS, "--points", "-", stdin="sigma,dsigma\n0.5,0\n0.01,0\n-inf,3\n")
        assert result.exit_code == 0
        assert "2 of 3 values of 'sigma' lie outside [-0.06, 0.06]" in result.stderr
        assert "1 of 3 values of 'dsigma' lie outside [-1, 1]" in result.stderr
        assert result.stdout.count("\n") == 4

    def test_a_malformed_first_block_prints_no_header(self):
        assert run(TIPPER, "--points", "-", stdin="food,service\n1,x\n").stdout == ""

    @pytest.mark.parametrize(
        ("stdin", "part"),
        [
            ("food;service\n1;2\n", "not separated by commas"),
            ("food,service\n1,1e400\n", "'1e400' in column 'service' is not a number"),
            ("", "no header line"),
            ("food\n1\n", "no column 'service'"),
            ("food,servce\n1,2\n", "is 'servce' meant?"),
            ("food,food,service\n1,2,3\n", "2 columns 'food'"),
            ("food,service,tip\n1,2,3\n", "already has a column 'tip'"),
            ("food,service\n1,2\n\n1,x\n", "<stdin>:4: error[FZ505]: 'x' in column 'service' is not a number"),
            ("food,service\n1\n", "the row has 1 cell for 2 columns"),
        ],
    )
    def test_malformed_points_are_named(self, stdin, part):
        result = run(TIPPER, "--points", "-", stdin=stdin)
        assert result.exit_code == 1
        assert part in result.output
        assert "Traceback" not in result.output

    @pytest.mark.parametrize(("text", "line"), [("1,x\n\n\n1,2\n", 2), ('1,2\n"a\nb",2\n', 4), ("\n\n1,2\n\n,2\n", 6)])
    def test_the_line_of_a_bad_row_is_that_of_the_file(self, text, line):
        result = run(TIPPER, "--points", "-", stdin="food,service\n" + text)
        assert f"<stdin>:{line}: error[FZ505]" in result.output

    def test_standard_input_may_begin_with_a_byte_order_mark(self):
        assert run(TIPPER, "--points", "-", stdin=b"\xef\xbb\xbffood,service\n1,2\n").exit_code == 0

    def test_standard_input_must_be_utf8(self):
        result = run(TIPPER, "--points", "-", stdin=b"food,service\n1,\xff\n")
        assert (result.exit_code, "FZ002" in result.output) == (1, True)

    @pytest.mark.parametrize("form", ["text", "json"])
    def test_a_bad_row_far_down_leaves_nothing_half_written(self, form):
        text = "food,service\n" + "1,2\n" * 9000 + "1,x\n"
        assert run(TIPPER, "--points", "-", "--format", form, stdin=text).stdout.strip()[:1] in ("", "{")

    def test_an_endless_cell_is_refused(self):
        result = run(TIPPER, "--points", "-", stdin="food,service\n1," + "2" * 200_000 + "\n")
        assert (result.exit_code, "FZ505" in result.output) == (1, True)

    def test_a_missing_points_file_is_named(self, tmp_path):
        result = run(TIPPER, "--points", tmp_path / "no.csv")
        assert result.exit_code == 1
        assert "FZ001" in result.output

    def test_points_and_values_together_are_wrong_usage(self):
        assert run(TIPPER, "service=1", "--points", "-").exit_code == 2

    def test_many_rows_stream(self):
        text = "sigma,dsigma\n" + "0.01,0.1\n" * 20_000
        lines = run(AIS, "--points", "-", stdin=text).output.split("\n")
        assert len(lines) == 20_002
        assert len(set(lines[1:-1])) == 1
        assert not math.isnan(float(lines[1].rsplit(",", 1)[1]))


def test_a_name_of_another_tool_is_typed_as_the_identifier_that_it_becomes(tmp_path):
    system = fuzzyctl.loads(
        "system odd\ndefuzzifier weighted_average\ninput b in [0, 1]\n  all = trapezoid(-1, 0, 1, 2)\n"
        "output y in [0, 3] else 0\n  m = constant(1.5)\nif b is all then y is m\n"
    )
    text, _ = FORMATS["fml"].write(system)
    path = tmp_path / "odd.fml"
    path.write_text(text.replace('"b"', '"b=c"').replace(">b<", ">b=c<"), encoding="utf-8")
    result = run(path, "b_c=0.25")
    assert result.exit_code == 0, result.output
    assert result.stdout == "y = 1.5\n"


def test_one_evaluation_goes_through_few_files_and_calls():
    found = startup.walk(["eval", startup.TIPPER, "service=7", "food=8"])
    assert len({file for file, _ in found}) <= startup.MOST_FILES
    assert found.total() <= startup.MOST_CALLS
