"""What notebooks complete behind `system(`: the names of its inputs."""

import inspect

import pytest

import fuzzyctl

TEXT = """system s
input {name} in [0, 1]
  terms low high
output u in [0, 1] else hold(0.5)
  terms a=0 b=1
defuzzifier weighted_average
if {name} is low then u is a
if {name} is high then u is b
"""


def parameters(called):
    return [(p.name, p.kind.name) for p in inspect.signature(called).parameters.values()]


@pytest.fixture(scope="module")
def tipper():
    return fuzzyctl.load("tipper")


def test_a_system_takes_its_inputs_by_name(tipper):
    assert parameters(tipper) == [("service", "KEYWORD_ONLY"), ("food", "KEYWORD_ONLY")]
    inspect.signature(tipper).bind(service=1, food=2)


def test_kernels_take_them_by_position_too(tipper):
    assert str(inspect.signature(fuzzyctl.compile(tipper, "python"))) == "(service, food)"
    free = fuzzyctl.compile(tipper, "python", free=["tip.cheap.peak"])
    assert str(inspect.signature(free)) == "(service, food, state)"
    held = fuzzyctl.compile(fuzzyctl.loads(TEXT.format(name="x")), "python")
    assert str(inspect.signature(held)) == "(x, state)"


@pytest.mark.parametrize(("every", "expected"), [("", "(x, state, *, dt)"), ("every 1 s\n", "(x, state)")])
def test_a_step_without_period_takes_the_time_by_name(tmp_path, every, expected):
    (tmp_path / "c.fz").write_text(f"controller c\ninput x\noutput y = integral(x)\n{every}", encoding="utf-8")
    step = fuzzyctl.compile(fuzzyctl.load(tmp_path / "c.fz", block=fuzzyctl.Controller), "python")
    assert str(inspect.signature(step)) == expected


@pytest.mark.parametrize("name", ["lambda", "state"])
def test_names_that_python_cannot_write_leave_that_of_the_call(name):
    kernel = fuzzyctl.compile(fuzzyctl.loads(TEXT.format(name=name)), "python")
    assert [n for n, _ in parameters(kernel)] == ["arguments", "named"]


@pytest.mark.parametrize("kind", [fuzzyctl.FuzzySystem, fuzzyctl.Kernel])
def test_a_class_has_the_signature_of_its_constructor(kind):
    assert "span" in dict(parameters(kind)) or {"backend"} <= set(dict(parameters(kind)))
