"""Plants in Python: the numbers of the same plant in text, and what their code may do wrong."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError, Experiment

CODE = """
inputs = ("u",)
states = {"x": 1.0, "v": 0.0}
outputs = ("y", "speed")


def derivative(t, x, u):
    position, speed = x
    return speed, u[0] - 4 * position - 0.1 * speed


def output(t, x):
    return x
"""
TEXT = "input u\nstate x = 1\nstate v = 0\nder x = v\nder v = u - 4*x - 0.1*v\noutput y = x\noutput speed = v\n"
LOOP = """
controller law
input y
input d
output u = -2 * y - d
every 20 ms
loop l
block law = law(p.y, derived)
block p = p(law.u + push)
let derived = 0.5 * p.speed
let push = pulse(1 s, 2 s)
measure m = rms(p.y)
run 5 s step 20 ms
"""


@pytest.fixture
def python_loop(loop, tmp_path):
    def load(code=CODE):
        (tmp_path / "p.py").write_text(code, encoding="utf-8")
        return loop(f'plant p = python("p.py")\n{LOOP}')

    return load


def test_it_is_the_plant_that_text_says(loop, python_loop):
    text = Experiment(loop(f"plant p\n{TEXT}{LOOP}"), "python").run()
    run = fuzzyctl.simulate(python_loop())
    assert run.record == pytest.approx(np.column_stack([text[n] for n in run.names]), rel=1e-13)
    assert run.measures == pytest.approx(text.measures)
    assert run.error["p.x"] < 1e-6


@pytest.mark.parametrize(
    ("old", "new", "message", "fact"),
    [
        ("return x\n", "return x[0]\n", "'output' of plant 'p' returned 1.0 at t = 0 s", "expected 2 numbers"),
        ("return speed, u", "return u", "'derivative' of plant 'p' returned -", "p.py:7: expected 2 numbers"),
        ("return speed, u", "return u", "'derivative' of plant 'p' returned -", "such as (0.0, 0.0)"),
        ("return speed, u", "return 1e999, u", "'derivative' of plant 'p' returned (inf, -", "not so: x"),
        ("return x\n", "return 1 / 0\n", "'output' of plant 'p' raised ZeroDivisionError", "there x = 1, v = 0"),
        ("(t, x, u)", "(x, u)", "'derivative' of plant 'p' cannot be called with t, x, u", "p.py:7: too many"),
        ("return x\n", "return ['a', None]\n", "'output' of plant 'p' returned ['a', None]", "expected 2 numbers"),
        ("return x\n", "return 1 / 0\n", "'output' of plant 'p' raised ZeroDivisionError at t = 0 s", "p.py:13: "),
        ("return x\n", "return {1.0, 2.0}\n", "'output' of plant 'p' returned {1.0, 2.0}", "expected 2 numbers"),
        ("return x\n", "return '12'\n", "'output' of plant 'p' returned '12'", "expected 2 numbers"),
        ("return x\n", "return 10**400, 0\n", "'output' of plant 'p' returned (1000", "expected 2 numbers"),
        ("return x\n", "return (1 / 0 for v in x)\n", "'output' of plant 'p' raised ZeroDivisionError", "p.py:13: "),
        ("return x\n", "raise SystemExit(0)\n", "'output' of plant 'p' raised SystemExit at t = 0 s", "p.py:13: "),
        ("inputs =", "raise SystemExit(0)\ninputs =", "the file of plant 'p' raised SystemExit", "p.py:2: "),
        ("def output", "def outputs_", "the file has no function 'output'", "it is block 'p'"),
        (
            "inputs =",
            "import nothing_of_that_name\ninputs =",
            "the file of plant 'p' raised ModuleNotFoundError",
            "no files beside it",
        ),
    ],
)
def test_what_its_code_does_wrong_is_a_mistake_with_its_place(python_loop, old, new, message, fact):
    loop = python_loop(CODE.replace(old, new))
    try:
        found = Experiment(loop).run().stopped
    except DiagnosticError as error:
        (found,) = error.diagnostics
    assert found.code == "FZ704"
    assert found.message.startswith(message)
    assert any(fact in f for f in (*found.facts, found.help))
    assert found.span.text == "p"


def test_the_data_before_a_mistake_is_kept(python_loop):
    run = Experiment(python_loop(CODE.replace("position, speed = x", "position, speed = x; assert t < 1"))).run()
    assert len(run) == 50
    assert "raised AssertionError at t = 1 s" in run.stopped.message


def test_numbers_that_are_not_finite_stop_the_run(python_loop):
    run = Experiment(python_loop(CODE.replace("return speed, u", "return 1e305, u"))).run()
    assert run.stopped.message == "state 'p.x' is infinite at t = 0.02 s"
    assert run.stopped.span.text == "p"


def test_nan_is_reported_with_the_function_that_returns_it(python_loop):
    run = Experiment(python_loop(CODE.replace("return speed, u", "return float('nan') if t > 1 else 0.0, u"))).run()
    assert run.stopped.code == "FZ704"
    assert "'derivative' of plant 'p' returned (nan," in run.stopped.message
    assert run.t[-1] == pytest.approx(0.98)


def test_machine_code_and_adaptive_solvers_are_refused(python_loop):
    with pytest.raises(ArgumentError, match="backend 'python'"):
        Experiment(python_loop(), "numba")
    with pytest.raises(ArgumentError, match="a plant in Python takes the solver RK4"):
        fuzzyctl.simulate(python_loop(), solver="RK45")


def test_a_check_does_not_execute_it(python_loop, tmp_path):
    python_loop(CODE + f"\nopen({str(tmp_path / 'executed')!r}, 'w').close()\n")
    assert not (tmp_path / "executed").exists()
