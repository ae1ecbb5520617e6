"""Commands on files that hold controllers, plants and loops."""

import json
from itertools import product

import pytest
from click.testing import CliRunner

import fuzzyctl
from fuzzyctl.cli.main import main
from tests.commands import runner

CONTROLLER = """controller law "A law"
input x in [0, 1]
param k in [0, 5] = 2
state s = 0
let b = a + integral(x)
let a = k * x
next s = b
output y = b + s
every 10 ms
"""
PLANT = 'plant lag "A lag" = tf(num=[1], den=[1, 1], delay=0.1 s)\n'
LOOP = (
    PLANT + "loop step\nblock p = lag(r)\nlet r = steps(0: 1)\n"
    'measure m "M" unit "s" = settling(p.y, r)\nrun 5 s step 10 ms\n'
)
FILES = {"controller": CONTROLLER, "plant": PLANT, "loop": LOOP}
SYSTEM = """system rule
defuzzifier center_average
input e in [-1, 1]
  terms N P
output u in [-1, 1]
  terms N P
table u = e
  N P
| N P

"""

#: Commands that need a system.
ON_SYSTEMS = ("show --plan",)
#: Commands that take controllers as well.
OTHERS = ("eval", "eval x=1", "why x=1", "plot-surface", "plot --terms -o p.png", "compare plant.fz")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / f"{name}.fz").write_text(text, encoding="utf-8")
    (tmp_path / "both.fz").write_text(SYSTEM + CONTROLLER, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(command, file, *rest):
    name, *options = command.split()
    return runner(name)(file, *options, *rest)


class TestWithoutSystem:
    @pytest.mark.parametrize(("kind", "command"), [*product(FILES, ON_SYSTEMS), *product(("plant", "loop"), OTHERS)])
    def test_the_message_names_what_the_file_holds_and_what_to_do(self, kind, command, folder):
        done = run(command, f"{kind}.fz")
        assert done.exit_code == 2
        assert "the file holds no system" in done.output
        assert f"it holds: {'plant' if kind == 'loop' else kind} '" in done.output
        assert "'fuzzyctl show' prints controllers, plants and loops" in done.output

    def test_code_of_a_plant_needs_a_step_and_no_dead_time(self, folder):
        for kind in ("plant", "loop"):
            done = run("codegen --target c", f"{kind}.fz")
            assert done.exit_code == 2
            assert "give the sample time of plant 'lag'" in done.output
        done = run("codegen --target c --step 0.1", "plant.fz")
        assert done.exit_code == 1
        assert "plant 'lag' has dead time" in done.output

    @pytest.mark.parametrize("kind", FILES)
    def test_check_counts_what_each_block_consists_of(self, kind, folder):
        sizes = {"controller": "law: 1 output", "plant": "lag: 1 state", "loop": "step: 1 block"}
        done = run("check", f"{kind}.fz")
        assert (done.exit_code, done.output.splitlines()[-1]) == (0, f"{kind}.fz: {sizes[kind]}, no errors")

    @pytest.mark.parametrize("kind", FILES)
    def test_a_laid_out_file_is_formatted(self, kind, folder):
        assert run("fmt --check", f"{kind}.fz").exit_code == 0


class TestShow:
    def test_equations_are_in_the_order_of_their_computation(self, folder):
        page = run("show", "controller.fz").output
        assert page.startswith("controller law: A law\nfile: controller.fz\nperiod: 0.01 s\n")
        assert page.index("  a = k * x\n") < page.index("  b = a + integral(x)\n") < page.index("  y = b + s\n")
        assert "  s = 0\n  and 1 number of operators, systems and blocks\n" in page

    def test_a_plant_of_one_line_is_shown_by_its_equations(self, folder):
        page = run("show", "plant.fz").output
        assert "Equations in order\n  delayed_u = delay(u, 0.1 s)\n  y = x1\n" in page
        assert "Derivatives\n  d/dt x1 = delayed_u - x1\n" in page

    def test_a_loop_is_shown_with_its_measures(self, folder):
        page = run("show", "loop.fz", "--block", "step").output
        assert "duration: 5 s\n" in page
        assert "Measures\n  m = settling(p.y, r) [s]\n" in page

    def test_params_are_set_within_their_ranges(self, folder):
        assert "  k = 3\n" in run("show", "controller.fz", "--set", "k=3").output
        done = run("show", "controller.fz", "--set", "k=6")
        assert done.exit_code == 1
        assert "param 'k' is 6, outside of [0, 5]" in done.output
        assert "no param 'j'" in run("show", "controller.fz", "--set", "j=6").output

    def test_params_of_controllers_inside_are_reported_once_by_their_names_in_the_file(self, folder):
        inner = CONTROLLER.replace("controller law", "controller rule").replace(
            "k in [0, 5] = 2", "k in [0, 5] = 2\n" + "param twice in [0, 8] = 2 * k"
        )
        text = inner
        for name, inside in (("law", "rule"), ("outer", "law")):
            text += f"controller {name}\ninput x\nblock a = {inside}(x)\noutput y = a.y\nevery 10 ms\n"
        (folder / "inside.fz").write_text(text, encoding="utf-8")
        for value, expected in (
            ("6", "param 'a.a.k' is 6, outside of [0, 5]"),
            ("4.5", "param 'a.twice' of 'law' is 9"),
        ):
            done = run("show", "inside.fz", "--block", "outer", "--set", f"a.a.k={value}")
            assert done.output.count("error") == 1
            assert expected in done.output

    def test_data_of_several_blocks_are_apart_from_those_of_systems(self, folder):
        data = json.loads(run("show --format json", "both.fz").output)
        assert [s["system"] for s in data["systems"]] == ["rule"]
        assert [(b["kind"], b["name"], b["period"]) for b in data["blocks"]] == [("controller", "law", 0.01)]
        assert json.loads(run("show --format json", "plant.fz").output)["kind"] == "plant"


class TestDiff:
    def test_statements_are_compared(self, folder):
        (folder / "other.fz").write_text(LOOP.replace("run 5 s", "run 6 s") + PLANT.replace("lag", "slow"))
        assert run("compare", "--changes", "loop.fz", "other.fz").output.splitlines() == [
            "loop step",
            "~ run: run 5 s step 10 ms → run 6 s step 10 ms",
            "plant slow",
            "+ plant slow: in the second file only",
        ]

    def test_equal_files_have_no_changes(self, folder):
        done = run("compare", "--changes", "loop.fz", "loop.fz")
        assert (done.exit_code, done.output) == (0, "nothing was changed\n")


def test_a_conversion_names_the_blocks_that_it_leaves_out(folder):
    done = run("convert", "both.fz", "both.fll")
    assert "controller 'law': left out: only systems are converted" in done.output


@pytest.mark.parametrize(
    ("block", "reason"),
    [("lag", "plants make no claims"), ("step", "runs decide the requirements of loops: fuzzyctl simulate")],
)
def test_prove_says_why_nothing_is_proved(block, reason, folder):
    done = run("prove", "loop.fz", "--block", block)
    assert (done.exit_code, done.output) == (0, f"loop.fz: {block}: no guarantees; {reason}\n0 proved\n")


@pytest.mark.parametrize("command", ["eval", "plot", "compare loop.fz", "prove --bounds"])
def test_a_block_of_another_kind_is_answered_with_what_works(command, folder):
    (folder / "all.fz").write_text(SYSTEM + LOOP, encoding="utf-8")
    done = run(command, "all.fz", "--block", "lag")
    assert done.exit_code == 2
    assert "'lag' is a plant\n" in done.output
    assert "'simulate' runs a loop with it" in done.output


@pytest.mark.parametrize("command", ["eval", "prove", "show"])
def test_the_option_of_earlier_versions_is_answered_with_that_of_today(command, folder):
    words = [command, "both.fz", "--system", "rule"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert "No such option '--system'" in done.stderr
    assert "Did you mean '--block'?" in done.stderr


def test_numbers_of_a_called_system_are_refused_with_its_name(folder):
    text = (folder / "both.fz").read_text(encoding="utf-8").replace("let a = k * x", "let a = k * rule(x)")
    law = fuzzyctl.loads(text, block="law")
    with pytest.raises(fuzzyctl.UnknownNameError, match=r"no free number 'rule\.q'"):
        law.with_values({"rule.q": 1})
    with pytest.raises(fuzzyctl.ArgumentError, match="system 'rule': free number"):
        law.with_values({"rule.e.N.peak": None})
    with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="system 'rule': free number"):
        law.with_values({"rule.e.N.peak": float("nan")})


def test_params_are_set_by_one_method_for_every_block(folder):
    law = fuzzyctl.load("controller.fz", block="law")
    assert law.with_params(k=3).values == {"k": 3.0}
    with pytest.raises(fuzzyctl.DiagnosticError, match="outside of"):
        law.with_params(k=6)


@pytest.mark.parametrize("time", [["dt=1"], []])
def test_dt_is_taken_by_controllers_without_period_only(time, folder):
    done = run("eval x=1", "controller.fz", *time)
    assert done.exit_code == (2 if time else 0)
    assert "no input 'dt'" in done.output or not time
