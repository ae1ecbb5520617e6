"""A run without numpy has the bits of `simulate`, and says what it does not run."""

import math
import re

import pytest

import fuzzyctl
from fuzzyctl.simulation.plain_run import PlainRunError, plain_run

TANK = """plant tank
input q
state h in [{low}, 20] = {start}
der h = {flow} - 0.1 * h
output y = {output}

loop fill
block tank = tank(reference - level)
let reference = steps(0: 0, 1 s: 2)
let level = tank.y{noise}
run 4 s step 20 ms
measure error = iae(tank.y, reference)
"""


def written(tmp_path, start=1, low=-20, output="h", flow="q", noise=""):
    text = TANK.format(start=start, low=low, output=output, flow=flow, noise=noise)
    (tmp_path / "a.fz").write_text(text, encoding="utf-8")
    return fuzzyctl.load(tmp_path / "a.fz", block=fuzzyctl.Loop)


def bits(values):
    return [float(v).hex() for v in values]


def same(loop):
    run, plain = fuzzyctl.Experiment(loop, "python").run(), plain_run(loop)
    assert bits(plain.t) == bits(run.t)
    assert {n: bits(v) for n, v in plain.signals.items()} == {n: bits(run[n]) for n in run.positions}
    assert bool(plain.stopped) == (run.stopped is not None)
    assert plain.substeps == run.substeps
    assert plain.requirements == run.requirements
    for name, value in plain.measures.items():
        assert value == pytest.approx(run.measures[name], rel=1e-12, nan_ok=True)
    for expr in run.judgement.signals:
        assert bits(plain.signal(expr)) == bits(run.signal(expr))
    return plain


def test_a_run_has_the_bits_of_simulate(tmp_path):
    assert not same(fuzzyctl.load("pendulum", block=fuzzyctl.Loop)).stopped
    assert not same(written(tmp_path)).stopped


def test_dead_times_shorter_than_a_sample_are_kept(tmp_path):
    assert same(written(tmp_path, flow="delay(q, 15 ms)")).substeps == 4


def test_a_run_that_ends_early_says_why(tmp_path):
    left = same(written(tmp_path, start=0.5, low=0.4))
    assert re.fullmatch(r"state 'tank.h' left its range at t = [0-9.]+ s", left.stopped)
    lost = same(written(tmp_path, output="1 / (h - 1)"))
    assert (lost.stopped, lost.t) == ("'tank.y' has no finite value at t = 0 s", [])


def test_noise_is_drawn_by_another_generator(tmp_path):
    found = plain_run(written(tmp_path, noise=" + noise(sigma=0.1, seed=1)"))
    noise = [a - b for a, b in zip(found.signals["level"], found.signals["tank.y"], strict=True)]
    assert found.has_noise
    assert 0.08 < math.sqrt(sum(v * v for v in noise) / len(noise)) < 0.12


def test_each_noise_draws_its_own_numbers(tmp_path):
    found = plain_run(written(tmp_path, noise=" + noise(0.1) - noise(0.1)"))
    noise = [a - b for a, b in zip(found.signals["level"], found.signals["tank.y"], strict=True)]
    assert 0.11 < math.sqrt(sum(v * v for v in noise) / len(noise)) < 0.17


def test_a_table_over_time_has_the_bits_of_simulate(tmp_path):
    (tmp_path / "b.csv").write_text("t,v\n0,1\n1.3,-2\n3,5\n", encoding="utf-8")
    same(written(tmp_path, noise=' + csv("b.csv", column="v")'))


def test_what_is_not_run_is_named(tmp_path):
    names = 'inputs = ("q",)\nstates = {"h": 0.0}\noutputs = ("y",)\n'
    (tmp_path / "b.py").write_text(names, encoding="utf-8")
    text = TANK.format(start=1, low=-20, output="h", flow="q", noise="")
    body = text[text.index("plant tank") : text.index("loop fill")]
    (tmp_path / "a.fz").write_text(text.replace(body, 'plant tank = python("b.py")\n\n'), encoding="utf-8")
    with pytest.raises(PlainRunError, match="is in Python"):
        plain_run(fuzzyctl.load(tmp_path / "a.fz", block=fuzzyctl.Loop))


def test_a_run_that_takes_too_long_is_refused(tmp_path):
    with pytest.raises(PlainRunError, match="operations, more than 1e\\+02"):
        plain_run(written(tmp_path), 100)
