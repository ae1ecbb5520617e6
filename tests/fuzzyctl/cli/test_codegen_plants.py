"""Plants in the languages of `codegen`: a compiled plant steps as a loop does."""

import importlib.util
import shutil
import subprocess

import numpy as np
import pytest
from click.testing import CliRunner

import fuzzyctl
from fuzzyctl.cli.main import main

PLANT = """plant p "Pendulum"
param k in (0, 9] = 2
input v
state x = 0.3
state w = -1.7
let pull = k * sin(3 * x)
der x = w - 0.37 * x * x
der w = pull - 0.11 * w + v + 0.1 * sin(t)
output y = x + 0.01 * pull
"""
LOOP = PLANT + "loop l\nblock p = p(0.7)\nrun 1 s step 125 ms\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "p.fz").write_text(LOOP)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(*words):
    result = CliRunner().invoke(main, ["codegen", "p.fz", "--block", "p", "--step", "0.125", *words])
    assert result.exit_code == 0, result.output
    return result.stdout.split()[1::2]


def test_python_is_the_loop(folder):
    written("--target", "python", "--substeps", "3")
    spec = importlib.util.spec_from_file_location("p", folder / "p.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    run = fuzzyctl.simulate(fuzzyctl.load("p.fz", block="l"), backend="python", substeps=3)
    state = module.start()
    for expected in run["p.y"]:
        y, state = module.step(0.7, state)
        assert y == pytest.approx(expected, rel=1e-13)


def test_c_passes_its_self_test_and_says_how_it_is_integrated(folder):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    written("--target", "c", "--free", "k")
    assert "integrated by Runge and Kutta in steps of 0.125 s" in (folder / "p.h").read_text()
    subprocess.run([compiler, "-O1", "-o", "selftest", "p.c", "p_selftest.c", "-lm"], check=True)
    assert "0 failures" in subprocess.run(["./selftest"], check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("target", ["st", "javascript"])
def test_other_languages_are_written(folder, target):
    assert written("--target", target)


def test_the_state_of_the_kernel_is_that_of_the_loop(folder):
    from fuzzyctl.model.discrete_plant import discretised

    plant, loop = fuzzyctl.load("p.fz", block="p"), fuzzyctl.load("p.fz", block="l")
    outputs, _ = fuzzyctl.compile(discretised(plant, 0.125), "numba").run(np.full(9, 0.7))
    np.testing.assert_allclose(outputs, fuzzyctl.simulate(loop)["p.y"], rtol=1e-13)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--block", "p"], "give the sample time of plant 'p'"),
        (["--block", "p", "--step", "0"], "0"),
        (["--block", "p", "--step", "0.1", "--table", "5"], "is a plant, whose steps no table holds"),
    ],
)
def test_options_that_do_not_fit_are_refused(folder, words, message):
    result = CliRunner().invoke(main, ["codegen", "p.fz", "--target", "c", *words])
    assert result.exit_code == 2
    assert message in result.stderr
