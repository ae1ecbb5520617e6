"""`fuzzyctl prove` within its time; transcripts/prove.txt holds what it prints."""

import itertools
import json
import math
import time
from unittest.mock import Mock

import pytest

import fuzzyctl
from fuzzyctl.testing import run_command
from tests.commands import runner
from tests.shipped import LAWS, SYSTEMS

run = runner("prove")
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
LAG = "controller c\ninput x in [-1, 1]\n{}every 10 ms\noutput y = {}\n"


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "s.fz"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_shipped_files_are_proved_one_line_each():
    result = run(*SYSTEMS, *LAWS)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert sum(": proved: " in line for line in lines) == 30
    assert lines[-1] == "30 proved"


def test_ctrl_c_keeps_what_was_reported_and_counts_what_is_left(write, base, monkeypatch):
    path = write(base + "require u <= 2\nrequire u >= -2\nrequire u <= 0.5\n")
    first, *_ = fuzzyctl.prove(fuzzyctl.load(path))
    monkeypatch.setattr("fuzzyctl.analysis.prove.Prover.verdict", Mock(side_effect=[first, KeyboardInterrupt] * 2))
    result = run(path)
    assert result.exit_code == 130
    assert result.stdout == f"{path}:21: proved: u <= 2\n"
    assert result.stderr == "interrupted: 1 proved, 2 left\n"
    assert run(path, "--format", "json").stdout == ""


def test_bounds_are_attained_at_the_points_shown():
    (f,) = json.loads(run("--bounds", "ais_reaction", "--format", "json").stdout)["outputs"]
    system = fuzzyctl.load("ais_reaction")
    assert (f["low"], f["high"]) == (-1.0, 0.18)
    assert system(**f["low_at"]) == f["low_found"] == -1.0
    assert system(**f["high_at"]) == f["high_found"] == 0.18
    assert f["slopes"] == {"sigma": pytest.approx(44, rel=1e-12), "dsigma": pytest.approx(1.36, rel=1e-12)}


def test_time_is_for_all_bounds_together_and_the_lack_of_it_is_said(write):
    path = write(BELLS)
    result = run("--bounds", path, "--timeout", "0.5")
    assert result.stdout.startswith("u: from -1 to 1\n")
    assert result.stdout.endswith("  the time is spent; with more of it the bound may be tighter\n")


@pytest.mark.parametrize("step", [10.0, 0.5, 0.1, 0.02])
def test_json_is_complete_wherever_the_time_ends(step, write, monkeypatch):
    path = write(BELLS)
    clock = itertools.count(step=step)
    monkeypatch.setattr("fuzzyctl.analysis.work.clock.used", lambda: next(clock))
    result = run("--bounds", path, "--timeout", "0.5", "--format", "json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout, parse_constant=lambda name: pytest.fail(f"JSON knows no {name}"))
    (bound,) = data["outputs"]
    assert (bound["low"], bound["high"]) == (-1.0, 1.0)
    assert "the time is spent" in bound["note"]


@pytest.mark.parametrize(
    "lines",
    [
        "let d = delay(x, 10000)\n",
        pytest.param(
            "let d = lowpass(x, 0.3 s)\n"
            + "".join(f"let d{k} = lowpass(d{k - 1 if k else ''}, 0.3 s)\n" for k in range(500)),
            marks=pytest.mark.long,
        ),
    ],
)
def test_controllers_with_many_states_keep_their_time(lines, write):
    path = write(LAG.format(lines, "d"))
    assert run("--bounds", path, "--timeout", "60").stdout.startswith("y: from -1 to 1\n")
    before = time.process_time()
    assert run("--bounds", path, "--timeout", "1").stdout.startswith("y: from -")
    assert time.process_time() - before < 10


def test_a_controller_that_calls_a_large_adaptive_system_keeps_its_time(write):
    names = [f"t{k}" for k in range(40)]
    terms, singletons = " ".join(names), " ".join(f"{n}={k / 100}" for k, n in enumerate(names))
    rows = "".join(f"{n} | {terms}\n" for n in names)
    path = write(
        f"system adaptive\ndefuzzifier weighted_average\ninput x, z in [-1, 1]\n  terms {terms}\n"
        f"output k in [-1, 1] adaptive rate x\n  terms {singletons}\ntable k = x x z\n  {terms}\n{rows}"
        "controller c\ninput e in [-1, 1]\nevery 10 ms\noutput v = adaptive(e, -e)\n"
    )
    before = time.process_time()
    result = run("--bounds", path, "--timeout", "1")
    assert result.stdout.startswith("v: from "), result.output
    assert "the time is spent; with more of it the bound may be tighter" in result.stdout
    assert time.process_time() - before < 10


def test_states_without_a_range_are_named_as_far_as_a_line_holds_them(write):
    filters = "".join(f"let d{k} = lowpass({f'd{k - 1}' if k else 'x'}, 0.3 s)\n" for k in range(40))
    result = run("--bounds", write(LAG.format(filters, "d39")), "--timeout", "1e-9")
    assert "  no range of #started, lowpass#1.filtered, " in result.stdout
    assert " and 21 more is proved; the time is spent" in result.stdout


@pytest.mark.parametrize(
    ("text", "least", "most"), [(BELLS, 4.0, 4.0), (BELLS + "# " * 500_000, 0.5, 1.5)], ids=["small", "large"]
)
def test_reading_a_large_system_is_part_of_the_time(text, least, most, write, monkeypatch):
    times = []
    monkeypatch.setattr("fuzzyctl.analysis.extremes.extents", lambda _, timeout: times.append(timeout) or ())
    assert run("--bounds", write(text)).exit_code == 0
    assert least <= times[0] <= most


def test_reading_is_part_of_the_time_of_a_controller(write, monkeypatch):
    clock, times = iter([10.0, 12.5]), []
    monkeypatch.setattr("fuzzyctl.analysis.work.clock.used", lambda: next(clock))
    monkeypatch.setattr("fuzzyctl.analysis.induction.bounds.controller_bounds", lambda _, t: times.append(t) or {})
    run("--bounds", write(LAG.format("", "x")))
    assert times == [0.5]


FAMILY = """
plant tank
state h = 1
der h = -h
output level "level" unit "m" = h
loop l "A tank runs empty"
block tank = tank()
for tank.h in [0.5, 1.5]
run 2 s step 100 ms
require always tank.level <= 1.6
"""


@pytest.mark.parametrize("name", ["tube.csv", "tube.svg"])
def test_the_tube_of_a_loop_is_written_as_a_table_and_as_a_picture(name, write, tmp_path):
    target = tmp_path / name
    result = run(write(FAMILY), "--tube", target)
    assert result.exit_code == 0, result.output
    assert f"wrote {target}" in result.stdout
    text = target.read_text("utf-8")
    if name == "tube.csv":
        head, first, *_, last = text.splitlines()
        assert head == "begin,end,least tank.level,greatest tank.level"
        begin, _, least, greatest = map(float, first.split(","))
        assert begin == 0.0
        assert 0.4 < least < 0.5
        assert 1.5 < greatest < 1.6
        assert float(last.split(",")[3]) == pytest.approx(1.5 * math.exp(-2.0), abs=0.03)
    else:
        assert "<svg" in text


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (FAMILY, ("--tube", "tube.txt"), "the name must end in .png, .svg, .pdf, .csv"),
        (FAMILY, ("--tube", "tube.csv", "--bounds"), "--tube is not for --bounds"),
        (BELLS, ("--tube", "tube.csv"), "no loop has a claim 'require always' that is enclosed"),
        (FAMILY + FAMILY[FAMILY.index("loop l") :].replace("loop l", "loop m"), ("--tube", "tube.csv"), "2 loops"),
    ],
    ids=["suffix", "bounds", "no-loop", "two-loops"],
)  # fmt: skip
def test_where_there_is_not_one_tube_none_is_written(text, options, message, write, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(write(text), *options)
    assert result.exit_code in (1, 2)
    assert message in result.stderr
    assert not list(tmp_path.glob("tube.*"))


def test_params_of_blocks_that_are_set_are_those_of_the_loop(write):
    """And the member that breaks a claim is replayed with them."""
    simulate = runner("simulate")
    text = "plant p\nparam A = 1\nstate x = 0.5\nder x = -A * x\noutput y = x\n"
    text += "loop l\nblock p = p()\n{}run 1 s step 100 ms\n"
    for family, replay in (("", ""), ("for p.x in [0.4, 0.5]\n", " --set p.x=0.4")):
        path = write(text.format(family) + "require always p.y >= 0.1 until 0.5 s\n")
        assert run(path).exit_code == 0
        for name in ("A", "p.A"):
            done = run(path, "--set", f"{name}=10")
            assert done.exit_code == 1
            options = f"--set {name}=10{replay}"
            assert f"fuzzyctl simulate {options} shows it" in done.output
            assert simulate(path, *options.split()).exit_code == 1
    done = run(path, "--set", "B=10")
    assert (done.exit_code, "no param 'B'" in done.stderr) == (2, True)


def test_a_param_that_a_loop_does_not_take_is_named(write):
    """That of a controller inside a controller; the loop keeps its value, as `simulate` says by an error."""
    text = "controller inner\ninput y\nparam k = 1\noutput w = k * y\n"
    text += "controller law\ninput y\nblock i = inner(y)\noutput u = -i.w\nevery 100 ms\n"
    text += "plant p\ninput u\nstate x = 1\nder x = u\noutput y = x\nloop l\nblock law = law(p.y)\n"
    path = write(text + "block p = p(law.u)\nrun 1 s\nrequire always abs(law.u) <= 1.5\n")
    done = run(path, "--set", "k=5")
    assert done.exit_code == 0
    assert "note: --set k=5 sets nothing in loop 'l', but in another block" in done.stderr
    done = run(path, "--set", "law.i.k=5")
    assert (done.exit_code, done.stderr) == (1, "")


def test_noise_without_a_bound_is_a_mistake_of_usage_and_an_empty_family_one_of_the_loop(tmp_path):
    text = "plant p\nstate x = 1\nder x = -x\noutput y = x\nloop l\nparam m = 3\nblock p = p()\nfor p.x in [0, m]\n"
    path = tmp_path / "l.fz"
    path.write_text(text + "run 1 s step 100 ms\nrequire always p.y <= 5\n", encoding="utf-8")
    result = run_command("prove", path, "--noise", "inf")
    assert (result.exit_code, "'--noise': inf is not in the range" in result.errors) == (2, True)
    result = run_command("prove", path, "--set", "m=-1")
    assert (result.exit_code, "error[FZ304]: the range of 'p.x' is empty" in result.errors) == (1, True)
