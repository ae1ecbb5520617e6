"""`eval`, `why` and `plot-surface` of controllers, at the state of the start or at another."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import fuzzyctl
from fuzzyctl.cli.main import main
from fuzzyctl.explain.block_trace import BlockTrace

TREE = """system first
defuzzifier weighted_average
input a in [0, 1]
  terms low high
input b in [0, 1]
  terms low high
output x in [0, 1]
  terms small=0 large=1
table x = a x b
         low    high
  low  | small  small
  high | small  large

system second
defuzzifier weighted_average
input x in [0, 1]
  terms low high
input c in [0, 1]
  terms low high
output y in [0, 10] else hold
  terms small=0 large=10
table y = x x c
         low    high
  low  | small  large
  high | large  large

controller tree
input a in [0, 1]
input b in [0, 1]
input c
let middle = first(a, b)
output y = second(middle, c)

controller count "Counts"
input a
state n = 2
next n = n + dt * a
output y "Number" unit "m" = n
"""
SUM = """controller sum
input a in [0, 1]
state n = 2
next n = n + a
output y = 2 * n + a
every 10 ms
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "tree.fz"
    path.write_text(TREE)
    return str(path)


def run(*words, stdin=None):
    return CliRunner().invoke(main, list(map(str, words)), input=stdin)


class TestEval:
    def test_a_tree_of_systems_is_evaluated_as_its_systems_are(self, file):
        result = run("eval", file, "--block", "tree", "a=.2", "b=.3", "c=.4")
        first, second = fuzzyctl.load_all(file)
        expected = second(x=first(a=0.2, b=0.3), c=0.4)
        assert result.stdout == f"y = {expected!r}\nnext y.y = {expected!r}\n"

    def test_a_state_is_that_of_the_start_or_as_given(self, file):
        given = ("eval", file, "--block", "count", "a=3", "dt=0.5")
        assert run(*given).stdout == "y = 2.0 m\nnext n = 3.5\n"
        assert run(*given, "--state", "n=7").stdout == "y = 7.0 m\nnext n = 8.5\n"
        data = json.loads(run(*given, "--state", "n=7", "--format", "json").stdout)
        assert (data["controller"], data["outputs"], data["next_state"]) == ("count", {"y": 7.0}, {"n": 8.5})

    @pytest.mark.parametrize("dt", ["0", "-1", "nan", "inf"])
    def test_a_time_of_a_csv_that_is_none_is_placed(self, file, tmp_path, dt):
        rows = tmp_path / "rows.csv"
        rows.write_text(f"a,dt\n1,0.5\n1,{dt}\n")
        result = CliRunner().invoke(main, ["eval", file, "--block", "count", "--points", str(rows)])
        assert result.exit_code == 1
        assert f"{rows}:3: error[FZ505]: 'dt' must be > 0 s and finite, got" in result.stderr

    def test_rows_of_a_csv_follow_each_other(self, file):
        points = "dt,a\n0.5,1\n0.25,2\n1,0\n"
        result = run("eval", file, "--block", "count", "--points", "-", "--state", "n=1", stdin=points)
        assert result.stdout == "dt,a,y\n0.5,1,1.0\n0.25,2,1.5\n1,0,2.0\n"

    @pytest.mark.parametrize(
        ("words", "message"),
        [
            (["--block", "count", "a=1", "dt=1", "--state", "m=1"], "no state 'm'"),
            (["--block", "count", "a=1", "dt=1", "--state", "n=nan"], "state 'n' is not a number: 'nan'"),
            (["--block", "first", "a=1", "b=1", "--state", "m=1"], "the block has no state"),
            (["--block", "count", "dt=1"], "input 'a' has no value"),
            (["--block", "count", "a=1"], "'dt' has no value"),
            (["--block", "counts", "a=1"], "the file holds no system or controller 'counts'"),
            (["--block", "count", "a=1", "dt=0"], "dt must be > 0 s and finite"),
        ],
    )
    def test_mistakes_are_diagnostics(self, file, words, message):
        result = run("eval", file, *words)
        assert result.exit_code in (1, 2)  # 2 for unknown names
        assert message in result.stderr
        assert result.stdout == ""

    def test_without_a_name_those_of_all_kinds_are_listed(self, file):
        result = run("eval", file, "a=1")
        assert result.exit_code == 2
        assert " = systems: first, second\n = controllers: tree, count\n" in result.stderr


class TestWhy:
    def test_each_system_has_its_part(self, file):
        result = run("why", file, "--block", "tree", "a=.2", "b=.3", "c=.4")
        assert result.exit_code == 0, result.output
        for line in (
            "System first",
            "System second",
            "  middle = 0.142857",
            "if x is low and c is low then y is small",
        ):
            assert line in result.stdout

    def test_it_is_the_step_of_the_kernel(self, file):
        tree = fuzzyctl.load(file, block="tree")
        trace = fuzzyctl.why(tree, a=0.2, b=0.3, c=0.4)
        assert isinstance(trace, BlockTrace)
        kernel = fuzzyctl.compile(tree, "python")
        outputs, state = kernel(0.2, 0.3, 0.4, kernel.start())
        assert trace.outputs == {"y": outputs}
        assert list(trace.next_state.values()) == state.tolist()
        assert [call.trace.outputs for call in trace.calls] == [{"x": trace.lets["middle"]}, {"y": outputs}]
        assert "System first" in str(trace)

    def test_a_state_is_given_by_name(self, file):
        data = json.loads(
            run("why", file, "--block", "count", "a=3", "dt=1", "--state", "n=4", "--format", "json").stdout
        )
        assert (data["state"], data["next_state"], data["calls"]) == ({"n": 4.0}, {"n": 7.0}, [])

    def test_a_picture_is_of_the_rules_of_a_system(self, file, tmp_path):
        result = run("why", file, "--block", "tree", "a=.2", "b=.3", "c=.4", "-o", tmp_path / "x.png")
        assert result.exit_code == 2
        assert "-o draws the rules of a system" in result.stderr


class TestPlotSurface:
    def test_of_a_tree_of_systems(self, file, tmp_path):
        result = run("plot-surface", file, "--block", "tree", "--at", "c=0.5", "-o", tmp_path / "tree.png")
        assert result.exit_code == 0, result.output
        assert (tmp_path / "tree.png").exists()
        ax = fuzzyctl.plot.surface(fuzzyctl.load(file, block="tree"), "a", at={"b": 1, "c": 0})
        kernel = fuzzyctl.compile(fuzzyctl.load(file, block="tree"), "python")
        x, y = ax.lines[0].get_data()
        expected = kernel.batch(np.column_stack([x, np.ones_like(x), np.zeros_like(x)]))[0]
        np.testing.assert_allclose(y, expected)

    def test_what_cannot_be_drawn_is_a_diagnostic(self, file, tmp_path):
        for words, message in (
            (["--block", "tree", "-x", "c", "-y", "a"], "input 'c' has no finite range"),
            (["--block", "count"], "its outputs depend on 'dt'"),
        ):
            result = run("plot-surface", file, *words, "-o", tmp_path / "no.png")
            assert result.exit_code == 2
            assert message in result.stderr
            assert not (tmp_path / "no.png").exists()

    def test_a_state_is_that_of_the_start_or_as_given(self, tmp_path):
        controller = fuzzyctl.loads(SUM)
        (first, second) = (fuzzyctl.plot.surface(controller, state=state).lines[0] for state in (None, {"n": 5}))
        np.testing.assert_allclose(first.get_ydata() + 6, second.get_ydata())
        path = tmp_path / "sum.fz"
        path.write_text(SUM)
        result = run("plot", path, "--state", "n=5", "-o", tmp_path / "sum.svg", "--svg-text")
        assert result.exit_code == 0, result.output
        assert "(n = 5)" in (tmp_path / "sum.svg").read_text()
        assert "no state 'm'" in run("plot", path, "--state", "m=5").stderr

    def test_terms_are_those_of_each_system(self, file, tmp_path):
        result = run("plot", file, "--terms", "--block", "tree", "-o", tmp_path / "terms.svg", "--svg-text")
        assert result.exit_code == 0, result.output
        drawn = (tmp_path / "terms.svg").read_text()
        assert ">first<" in drawn
        assert ">second<" in drawn
        tree = fuzzyctl.load(file, block="tree")
        assert [ax.get_xlabel() for ax in fuzzyctl.plot.terms(tree)] == ["a", "b", "x", "x", "c", "y"]
        assert fuzzyctl.plot.terms(tree, "second.c").get_xlabel() == "c"
        result = run("plot", file, "--terms", "--block", "count")
        assert (result.exit_code, "controller 'count' calls no systems" in result.stderr) == (2, True)


class TestCompare:
    @pytest.fixture
    def other(self, tmp_path):
        path = tmp_path / "other.fz"
        path.write_text(TREE.replace("input c\n", "input c in [0, 1]\n").replace("= second(", "= 0.5 * second("))
        return str(path)

    def test_trees_differ_by_their_largest_difference(self, other, tmp_path):
        path = tmp_path / "tree.fz"
        path.write_text(TREE.replace("input c\n", "input c in [0, 1]\n"))
        result = run("compare", path, other, "--block", "tree", "--points", 100)
        assert result.exit_code == 0, result.output
        assert "  y: largest difference 5 at a = " in result.stdout
        assert run("compare", path, other, "--block", "tree", "--within", 1).exit_code == 1

    def test_a_step_is_made_from_the_start_or_as_given(self, tmp_path):
        paths = [tmp_path / "a.fz", tmp_path / "b.fz"]
        paths[0].write_text(SUM)
        paths[1].write_text(SUM.replace("2 * n", "3 * n"))
        for words, value in (([], "2 at"), (["--state", "n=5"], "5 at")):
            result = run("compare", *paths, "--points", 10, *words)
            assert f"y: largest difference {value}" in result.stdout
            assert "next n: no difference" in result.stdout
        assert "no state 'm'" in run("compare", *paths, "--state", "m=5").stderr

    def test_tools_compute_the_systems_of_a_tree(self, other):
        result = run("compare", other, "--as", "matlab,exact", "--block", "tree", "--points", 100)
        assert result.stdout.startswith(f"{other} as matlab  and  {other} as exact: ")

    @pytest.mark.parametrize(("block", "message"), [("tree", "input 'c' has no finite range"), ("count", "'a' has no")])
    def test_what_cannot_be_compared_is_a_diagnostic(self, file, block, message):
        result = run("compare", file, file, "--block", block)
        assert result.exit_code == 2
        assert message in result.stderr
        assert "'--loops' compares runs" in result.stderr


def test_a_controller_without_inputs_has_a_step_and_no_plot(tmp_path):
    path = tmp_path / "z.fz"
    path.write_text("controller z\nstate n = 0\nnext n = n + 1\noutput y = n\nevery 1 s\n")
    result = CliRunner().invoke(main, ["plot", str(path)])
    assert result.exit_code == 2
    assert "controller 'z' has no inputs" in result.stderr
    result = CliRunner().invoke(main, ["why", str(path), "--state", "n=4"])
    assert result.stdout == "y = 4.0\n\nState, and the next one\n  n = 4, then 5\n"
