"""Params of controllers inside a block by name: the block computes the same, and they may be free or set."""

import json
from pathlib import Path

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.instance_params import with_instance_params
from tests import sizes
from tests.commands import runner

run = runner("simulate")

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


def blocks(text=TEXT):
    return look_through(SourceText("c.fz", text))


def expected(x, k=6.0, g=1.0, m=4.0):
    """What `top` gives with `one.a.k`, `two.g` and `two.b.m`."""
    one = (k * 2 * x + 2 * k + 3) + (2 * x + 4 + 3)
    two = (3 * g * g * x + 6 * g + 3) + (2 * x + m + 3)
    return one + 10 * two


@pytest.mark.parametrize("backend", sizes.BACKENDS)
def test_they_are_free_numbers_of_the_controller(backend):
    step = fuzzyctl.compile(blocks().controllers[-1], backend, free=["one.a.k", "two.g", "two.b.m"])
    assert step.free_names == ("one.a.k", "two.g", "two.b.m")
    assert step.start().tolist() == [6.0, 1.0, 4.0]
    for changed in ({}, {"one.a.k": 7.0}, {"two.g": 2.0, "two.b.m": 5.0}):
        own = {name.rpartition(".")[2]: value for name, value in changed.items()}
        assert step(0.5, step.start(changed))[0] == pytest.approx(expected(0.5, **own), rel=1e-15)
    np.testing.assert_allclose(step.gradient([0.5], step.start(), by="all")[0], [64.0, 3.0, 90.0, 10.0])


def test_values_lie_in_the_range_that_the_inner_controller_declares():
    step = fuzzyctl.compile(blocks().controllers[-1], "python", free=["one.a.k"])
    with pytest.raises(ValueOutOfBoundsError, match=r"'one.a.k' must be in \[0, 10\], got 70"):
        step.start({"one.a.k": 70})


def test_a_param_of_the_file_and_that_of_one_instance_are_two_numbers():
    step = fuzzyctl.compile(blocks().controllers[-1], "python", free=["q", "two.a.q"])
    plain = step(0.0, step.start())[0]
    assert step(0.0, step.start({"two.a.q": 4}))[0] - plain == 10.0
    assert step(0.0, step.start({"q": 4}))[0] - plain == 12.0


def test_what_one_instance_gives_does_not_reach_another_one():
    step = fuzzyctl.compile(blocks().controllers[-1], "python", free=["two.a.m", "one.a.m", "one.a.k"])
    assert step.start().tolist() == [6.0, 12.0, 6.0]
    assert step(0.5, step.start())[0] == expected(0.5)


@pytest.mark.parametrize("name", ["one.z", "one.a.z", "on.k", "one.a.k.k"])
def test_unknown_names_are_answered_with_the_known_ones(name):
    with pytest.raises(UnknownNameError, match=r"no free number.*one\.a\.k"):
        fuzzyctl.compile(blocks().controllers[-1], "python", free=[name])


def test_loops_have_them_below_their_blocks(tmp_path):
    (loop,) = blocks(TEXT + LOOP).loops
    assert {"c.one.a.k", "c.two.g"} <= set(loop.instance_params)
    experiment = fuzzyctl.Experiment(loop, "python", free=["c.one.a.k"])
    assert [experiment.run(v).measures["f"] for v in (None, [7.0])] == pytest.approx([expected(1), expected(1, k=7)])
    with pytest.raises(ValueOutOfBoundsError, match=r"'c.one.a.k' must be in \[0, 10\]"):
        experiment.run([70.0])
    assert with_instance_params(loop, ["c.one", "p.x", "q", "c.q"]) is loop


def test_simulate_sets_them(tmp_path):
    path = tmp_path / "l.fz"
    path.write_text(TEXT + LOOP, encoding="utf-8")
    result = run(str(path), "--set", "c.one.a.k=7")
    assert (result.exit_code, result.output.split()[-1]) == (0, f"{expected(1, k=7):g}")
    result = run(str(path), "--set", "c.one.a.k=70")
    assert result.exit_code == 1
    assert "param 'c.one.a.k' is 70, outside of [0, 10]" in result.output
    result = run(str(path), "--set", "c.one.a.kk=7")
    assert result.exit_code == 2
    assert "did you mean 'c.one.a.k'?" in result.output


def test_proofs_bounds_and_generated_code_set_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = TEXT.replace("input x\nblock one", "input x in [0, 1]\nblock one")
    Path("c.fz").write_text(f"{text}require u <= {expected(1):g}\n", encoding="utf-8")
    assert runner("prove")("c.fz", "--block", "top").exit_code == 0
    result = runner("prove")("c.fz", "--set", "one.a.k=7")
    assert (result.exit_code, "refuted: u <=" in result.output) == (1, True)
    plain, changed = (
        json.loads(runner("prove", "--bounds")("c.fz", "--block", "top", "--format", "json", *given).output)
        for given in ((), ("--set", "one.a.k=7"))
    )
    assert plain != changed
    result = runner("codegen")(
        "c.fz", "--block", "top", "--target", "python", "--set", "one.a.k=7", "-o", "out", "--unproved"
    )
    assert result.exit_code == 0, result.output
    assert "Param set: one.a.k = 7" in Path("out/top.py").read_text(encoding="utf-8")
    result = runner("prove")("c.fz", "--set", "one.a.k=70")
    assert (result.exit_code, "outside of [0, 10]" in result.output) == (1, True)
    result = runner("prove", "--bounds")("c.fz", "--block", "top", "--set", "one.a.kk=7")
    assert (result.exit_code, "did you mean 'one.a.k'?" in result.output) == (2, True)
