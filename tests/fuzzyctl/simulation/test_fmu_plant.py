"""Plants that are FMUs: the numbers of the same plant in text, and what goes wrong with native code."""

from pathlib import Path

import numpy as np
import pytest

from fuzzyctl import ArgumentError, DiagnosticError, Experiment, simulate
from fuzzyctl.interop.scipy import rhs
from tests.fuzzyctl.codegen.fmu.fmus import changed, write_fmu

TEXT = """input u "force" unit "N"
param d in [0, 10] = 0.1
state x in [-100, 1.7] = 1
state v = 0
der x = v
der v = u - 4*x - d*v
output y "place" unit "m" = x
output speed = v
"""
LOOP = """
controller law
input y
output u = -2 * y
every 20 ms
loop l
block law = law(p.y)
block p = p(law.u + push)
let push = pulse(1 s, 2 s)
measure m = rms(p.y)
run 3 s step 20 ms
"""


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """The FMUs of the plant by version, made once."""
    pytest.importorskip("fmpy")
    folder = tmp_path_factory.mktemp("fmus")
    return {v: write_fmu(f"plant p\n{TEXT}", folder / f"{v}.fmu", version=v).read_bytes() for v in (2, 3)}


@pytest.fixture
def fmu_loop(loop, tmp_path, fmus):
    def load(text=LOOP, data=None, version=3, params=""):
        (tmp_path / "p.fmu").write_bytes(fmus[version] if data is None else data)
        return loop(f'plant p = fmu("p.fmu")\n{params}{text}')

    return load


def stopped(loop):
    try:
        return Experiment(loop).run().stopped
    except DiagnosticError as error:
        (found,) = error.diagnostics
        return found


@pytest.mark.parametrize("version", [2, 3])
def test_it_is_the_plant_that_text_says(loop, fmu_loop, version):
    text = Experiment(loop(f"plant p\n{TEXT}{LOOP}"), "python").run(substeps=20)
    run = simulate(fmu_loop(version=version))
    for name in run.names:
        assert run[name] == pytest.approx(text[name], rel=1e-12, abs=1e-12)
    assert run.measures == pytest.approx(text.measures)
    assert run.error == {}


def test_its_params_are_those_of_the_block(loop, fmu_loop):
    text = LOOP.replace("law.u + push", "law.u + push, d=3")
    expected = Experiment(loop(f"plant p\n{TEXT}{text}"), "python").run(substeps=20)
    run = simulate(fmu_loop(text, params="param d in [0, 10] = 0.2\n"))
    assert run["p.y"] == pytest.approx(expected["p.y"], rel=1e-12, abs=1e-12)


def test_each_run_begins_anew_and_each_block_is_an_instance(fmu_loop):
    text = LOOP.replace("let push", "block q = p(push)\nlet push")
    experiment = Experiment(fmu_loop(text))
    first, second = experiment.run(), experiment.run()
    assert np.array_equal(first.record, second.record)
    assert not np.allclose(first["p.y"], first["q.y"])


def test_what_was_computed_until_its_error_is_kept(fmu_loop):
    run = Experiment(fmu_loop(LOOP.replace("law.u + push", "20"))).run()
    assert run.stopped.code == "FZ711"
    assert run.stopped.message == "FMU 'p' cannot make a step at t = 0.3 s"
    said = "it says: fmi3DoStep: state 'x' is not a number, or left its range at t = 0.3 s"
    assert said in run.stopped.facts
    assert run.stopped.facts[-1].startswith("it is block 'p', ")
    assert run.stopped.span.text == "p"
    assert len(run) == 16
    assert run["p.y"][-1] < 1.7


def test_an_output_that_is_not_a_number_ends_the_run(fmu_loop, tmp_path):
    """Between 0.1 and 0.5 no rule fires."""
    own = tmp_path / "gaps.fmu"
    gaps = "system p\ndefuzzifier weighted_average\ninput u in [-2, 2]\n  low = triangle(-inf, -2, 0.1)\n"
    gaps += "  high = triangle(0.5, 2, inf)\noutput y in [0, 1] else nan\n  a = constant(0)\n"
    gaps += "if u is low then y is a\nif u is high then y is a\n"
    run = Experiment(fmu_loop("loop l\nblock p = p(t)\nrun 3 s step 20 ms\n", write_fmu(gaps, own).read_bytes())).run()
    assert run.stopped.message == "output 'y' of FMU 'p' is nan at t = 0.12 s"
    assert len(run) == 6


@pytest.mark.parametrize(
    ("change", "message", "fact"),
    [
        (lambda n, c: c if "binaries" not in n else None, "the FMU has no binary for this machine", "for: no machine"),
        (lambda n, c: c if "binaries" not in n else b"\x7fELF nothing", "FMU 'p' cannot begin at t = 0 s", "p.so"),
        (
            lambda n, c: c.replace(b'guid="{', b'guid="{0'),
            "FMU 'p' cannot begin at t = 0 s",
            "it says: fmi2Instantiate: expected the token",
        ),
        (
            lambda n, c: c.replace(b'"y" valueReference="2"', b'"y" valueReference="99"'),
            "FMU 'p' cannot give its outputs at t = 0 s",
            "it says: fmi2GetReal: no variable has the reference 99",
        ),
    ],
)
def test_an_fmu_that_cannot_be_run_here(fmu_loop, fmus, tmp_path, change, message, fact):
    here = Path.cwd()
    (tmp_path / "own.fmu").write_bytes(fmus[2])
    found = stopped(fmu_loop(data=changed(tmp_path / "own.fmu", change).read_bytes()))
    assert Path.cwd() == here
    assert (found.code, found.message) == ("FZ711", message)
    assert any(fact in f for f in found.facts), found.facts
    assert found.help


def test_an_fmu_may_end_the_simulation(fmu_loop, fmus, tmp_path):
    def ending(name, content):
        old = b"    *lastSuccessfulTime"
        return content.replace(old, b"    *terminateSimulation = own->now.time > 0.25;\n" + old)

    (tmp_path / "own.fmu").write_bytes(fmus[3])
    run = Experiment(fmu_loop(data=changed(tmp_path / "own.fmu", ending, compile_again=True).read_bytes())).run()
    assert run.stopped.facts[0] == "it asks to end the simulation"
    assert run.stopped.message == "FMU 'p' cannot make a step at t = 0.24 s"
    assert len(run) == 13


def test_without_fmpy_it_says_what_to_install(fmu_loop, monkeypatch, tmp_path):
    (tmp_path / "fmpy.py").write_text("raise ImportError")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("fuzzyctl.simulation.fmu_process._idle", [])
    found = stopped(fmu_loop())
    assert found.message == "FMUs are run by FMPy, which is not installed"
    assert found.help == "pip install 'fuzzyctl[interop]'"


def test_machine_code_adaptive_solvers_and_free_params_are_refused(fmu_loop):
    loop = fmu_loop(params="param d = 0.2\n")
    with pytest.raises(ArgumentError, match="plant 'p' is an FMU, and called by generated Python"):
        Experiment(loop, "numba")
    with pytest.raises(ArgumentError, match="a loop with an FMU takes the solver RK4"):
        simulate(loop, solver="RK45")
    with pytest.raises(ArgumentError, match=r"'p.d' is a param of an FMU"):
        Experiment(loop, free=["p.d"])


def test_a_controller_as_an_fmu_drives_a_plant_one_sample_later(loop, tmp_path):
    law = "controller own\ninput y\noutput u = -2 * y\nevery 20 ms\n"
    write_fmu(law, tmp_path / "own.fmu", version=2)
    text = LOOP.replace("block law = law(p.y)", "block law = own(p.y)").replace("controller law", "controller unused")
    run = simulate(loop(f'plant own = fmu("own.fmu")\nplant p\n{TEXT}{text}'))
    assert run["law.u"][1:] == pytest.approx(-2 * run["p.y"][:-1])


def test_an_fmu_is_no_function_of_its_states(fmu_loop):
    with pytest.raises(ArgumentError, match="plant 'p' is an FMU, whose states only it knows"):
        rhs(fmu_loop().plants[0], 0.0)
