"""Params of controllers inside a block by name: the block computes the same, and they may be free or set."""

import json

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.testing import run_command
from tests import sizes

TEXT = """param q = 3
controller gain
input x
param k in [0, 10] = 2
param m = 2 * k
output u = k * x + m + q
controller mid
input x
param g = 1
block a = gain(g * x, k = 3 * g)
block b = gain(x)
output u = a.u + b.u
controller top
input x
block one = mid(x, g = 2)
block two = mid(x)
output u = one.u + 10 * two.u
every 0.1 s
"""
LOOP = "plant p\ninput u\nstate x = 0\nder x = u - x\noutput y = x\n"
LOOP += "loop l\nblock c = top(1)\nblock p = p(c.u)\nmeasure f = final(c.u)\nrun 1 s\n"


@pytest.fixture(scope="module")
def top():
    return fuzzyctl.loads(TEXT, block="top")


def expected(x, k=6.0, g=1.0, m=4.0):
    """What `top` gives with `one.a.k`, `two.g` and `two.b.m`."""
    one = (k * 2 * x + 2 * k + 3) + (2 * x + 4 + 3)
    two = (3 * g * g * x + 6 * g + 3) + (2 * x + m + 3)
    return one + 10 * two


@pytest.mark.parametrize("backend", sizes.BACKENDS)
def test_they_are_free_numbers_of_the_controller(backend, top):
    step = fuzzyctl.compile(top, backend, free=["one.a.k", "two.g", "two.b.m"])
    assert step.free_names == ("one.a.k", "two.g", "two.b.m")
    assert step.start().tolist() == [6.0, 1.0, 4.0]
    for changed in ({}, {"one.a.k": 7.0}, {"two.g": 2.0, "two.b.m": 5.0}):
        own = {name.rpartition(".")[2]: value for name, value in changed.items()}
        assert step(0.5, step.start(changed))[0] == pytest.approx(expected(0.5, **own), rel=1e-15)
    np.testing.assert_allclose(step.gradient([0.5], step.start(), by="all")[0], [64.0, 3.0, 90.0, 10.0])


def test_values_lie_in_the_range_that_the_inner_controller_declares(top):
    step = fuzzyctl.compile(top, "python", free=["one.a.k"])
    with pytest.raises(ValueOutOfBoundsError, match=r"'one.a.k' must be in \[0, 10\], got 70"):
        step.start({"one.a.k": 70})


def test_a_param_of_the_file_and_that_of_one_instance_are_two_numbers(top):
    step = fuzzyctl.compile(top, "python", free=["q", "two.a.q"])
    plain = step(0.0, step.start())[0]
    assert step(0.0, step.start({"two.a.q": 4}))[0] - plain == 10.0
    assert step(0.0, step.start({"q": 4}))[0] - plain == 12.0


def test_what_one_instance_gives_does_not_reach_another_one(top):
    step = fuzzyctl.compile(top, "python", free=["two.a.m", "one.a.m", "one.a.k"])
    assert step.start().tolist() == [6.0, 12.0, 6.0]
    assert step(0.5, step.start())[0] == expected(0.5)


@pytest.mark.parametrize("name", ["one.z", "one.a.z", "on.k", "one.a.k.k"])
def test_unknown_names_are_answered_with_the_known_ones(name, top):
    with pytest.raises(UnknownNameError, match=r"no free number.*one\.a\.k"):
        fuzzyctl.compile(top, "python", free=[name])


def test_loops_have_them_below_their_blocks():
    loop = fuzzyctl.loads(TEXT + LOOP, block="l")
    assert {"c.one.a.k", "c.two.g"} <= set(loop.instance_params)
    experiment = fuzzyctl.Experiment(loop, "python", free=["c.one.a.k"])
    assert [experiment.run(v).measures["f"] for v in (None, [7.0])] == pytest.approx([expected(1), expected(1, k=7)])
    with pytest.raises(ValueOutOfBoundsError, match=r"'c.one.a.k' must be in \[0, 10\]"):
        experiment.run([70.0])


def test_commands_set_them(tmp_path):
    text = TEXT.replace("input x\nblock one", "input x in [0, 1]\nblock one")
    (tmp_path / "l.fz").write_text(TEXT + LOOP, encoding="utf-8")
    (tmp_path / "c.fz").write_text(f"{text}require u <= {expected(1):g}\n", encoding="utf-8")

    def run(*words, code=0):
        result = run_command(*words, folder=tmp_path)
        assert result.exit_code == code, result
        return result.output + result.errors

    seven, far, unknown = "one.a.k=7", "one.a.k=70", "one.a.kk=7"
    assert run("simulate", "l.fz", "--set", f"c.{seven}").split()[-1] == f"{expected(1, k=7):g}"
    assert "param 'c.one.a.k' is 70, outside of [0, 10]" in run("simulate", "l.fz", "--set", f"c.{far}", code=1)
    assert "did you mean 'c.one.a.k'?" in run("simulate", "l.fz", "--set", f"c.{unknown}", code=2)
    top = ("c.fz", "--block", "top")
    run("prove", *top)
    assert "refuted: u <=" in run("prove", "c.fz", "--set", seven, code=1)
    assert "outside of [0, 10]" in run("prove", "c.fz", "--set", far, code=1)
    assert "did you mean 'one.a.k'?" in run("prove", "--bounds", *top, "--set", unknown, code=2)
    bounds = ("prove", "--bounds", *top, "--format", "json")
    assert json.loads(run(*bounds)) != json.loads(run(*bounds, "--set", seven))
    run("codegen", *top, "--target", "python", "--set", seven, "-o", "out", "--unproved")
    assert "Param set: one.a.k = 7" in (tmp_path / "out" / "top.py").read_text(encoding="utf-8")
