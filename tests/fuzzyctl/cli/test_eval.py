"""`fuzzyctl eval` of many points and few calls; transcripts/eval.txt holds what it prints."""

import csv
import io
import math

import pytest

import fuzzyctl
from tests.bench import startup
from tests.commands import runner

run = runner("eval")


def test_a_table_gives_what_single_points_give(tmp_path):
    points = [(s / 100, d / 10) for s in range(-7, 8) for d in range(-11, 12)]
    path = tmp_path / "in.csv"
    path.write_text("sigma,dsigma\n" + "".join(f"{s},{d}\n" for s, d in points))
    rows = list(csv.DictReader(io.StringIO(run("ais_reaction", "--points", path).stdout)))
    system = fuzzyctl.load("ais_reaction")
    assert len(rows) == len(points)
    for (s, d), row in zip(points, rows, strict=True):
        assert float(row["f"]) == pytest.approx(system(sigma=s, dsigma=d), abs=1e-12)


@pytest.mark.parametrize(
    ("stdin", "code", "part"),
    [
        (b"\xef\xbb\xbffood,service\n1,2\n", 0, "tip"),
        (b"food,service\n1,\xff\n", 1, "FZ002"),
        ("food,service\n1," + "2" * 200_000 + "\n", 1, "FZ505"),
    ],
    ids=["mark", "no UTF-8", "endless"],
)
def test_standard_input_is_text(stdin, code, part):
    result = run("tipper", "--points", "-", stdin=stdin)
    assert (result.exit_code, part in result.output) == (code, True)


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_bad_row_far_down_leaves_nothing_half_written(form):
    text = "food,service\n" + "1,2\n" * 9000 + "1,x\n"
    assert run("tipper", "--points", "-", "--format", form, stdin=text).stdout.strip()[:1] in ("", "{")


def test_many_rows_stream():
    text = "sigma,dsigma\n" + "0.01,0.1\n" * 20_000
    lines = run("ais_reaction", "--points", "-", stdin=text).output.split("\n")
    assert len(lines) == 20_002
    assert len(set(lines[1:-1])) == 1
    assert not math.isnan(float(lines[1].rsplit(",", 1)[1]))


def test_a_name_of_another_tool_is_typed_as_the_identifier_that_it_becomes(tmp_path):
    path = tmp_path / "odd.fll"
    path.write_text(
        "Engine: odd\nInputVariable: b=c\n  range: 0 1\n  term: all Trapezoid -1 0 1 2\nOutputVariable: y\n"
        "  range: 0 3\n  default: 0\n  defuzzifier: WeightedAverage TakagiSugeno\n  term: m Constant 1.5\n"
        "RuleBlock:\n  activation: General\n  rule: if b=c is all then y is m\n",
        encoding="utf-8",
    )
    result = run(path, "b_c=0.25")
    assert (result.exit_code, result.stdout) == (0, "y = 1.5\n"), result.output


def test_one_evaluation_goes_through_few_files_and_calls():
    found = startup.walk(["eval", startup.TIPPER, "service=7", "food=8"])
    assert len({file for file, _ in found}) <= startup.MOST_FILES
    assert found.total() <= startup.MOST_CALLS


POINT = ["service=7", "food=8"]


@pytest.mark.parametrize(
    ("command", "proved"),
    [
        *(
            (["eval", *POINT], 0),
            (["why", *POINT], 0),
            (["prove"], 1),
            (["show"], 0),
            (["codegen", "--target", "st"], 1),
        ),
        (["check"], 1),
        (["prove", "--bounds", "--timeout", "0.01"], 0),  # the search takes a minute while its calls are counted
    ],
    ids=lambda c: c[0] if isinstance(c, list) else "",
)
def test_a_file_is_parsed_planned_and_proved_once(command, proved, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = startup.walk([command[0], startup.TIPPER, *command[1:]])
    assert found["fuzzyctl/lang/parser.py", "parse"] == 1
    assert found["fuzzyctl/kernels/plan/build.py", "_plan"] == 1
    assert found["fuzzyctl/analysis/prove.py", "Prover.verdict"] == proved
