"""Calls of other systems in lets: their numbers, their texts and their mistakes."""

import runpy

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError
from fuzzyctl.testing import run_command
from tests import sizes

WHOLE = """
param top = 2
system urgency
defuzzifier center_average
input e in [-1, 1]
  terms N Z P
output k in [0, 1]
  terms low high
output m in [0, top]
  terms low high
table k, m = e
     N          Z         P
  |  high/low   low/high  high/high

system inner
input a in [-1, 1]
input b in [-1, 1]
let k = urgency.k(2 * a) - urgency.m(b)
output y in [-2, 2] = k * a

system outer
defuzzifier center_average
input e in [-1, 1]
let z in [-1, 1] = inner.y(e, urgency.k(e)) / 2
  terms N P
output u in [-5, 5]
  terms N P
if z is N then u is function(z + e)
if z is P then u is P
require u <= 5
"""


def urgency(e):
    n, z, p = (np.interp(np.clip(e, -1, 1), [-1, 0, 1], row) for row in np.eye(3))
    return n + p, 2 * (z + p)


def inner(a, b):
    return (urgency(2 * a)[0] - urgency(b)[1]) * a


def outer(e):
    e = np.clip(e, -1, 1)
    z = inner(e, urgency(e)[0]) / 2
    n = (1 - np.clip(z, -1, 1)) / 2
    return n * (z + e) + (1 - n) * 5


class TestNumbers:
    @pytest.mark.parametrize("backend", sizes.BACKENDS)
    def test_a_call_is_the_system_at_its_arguments(self, backend):
        kernel = fuzzyctl.compile(fuzzyctl.loads(WHOLE, block="outer"), backend)
        e = np.linspace(-1.2, 1.2, 101)
        np.testing.assert_allclose(kernel.batch(e[:, None]), outer(e), rtol=1e-12, atol=1e-12)
        assert kernel(0.3) == pytest.approx(float(outer(0.3)), rel=1e-12)

    def test_shared_params_are_set_in_both(self):
        system = fuzzyctl.loads(WHOLE, block="inner")
        assert system(a=1.0, b=1.0) == pytest.approx(-1.0)
        assert system.with_params(top=3)(a=1.0, b=1.0) == pytest.approx(-2.0)

    def test_bounds_and_guarantees(self):
        bound = fuzzyctl.output_bounds(fuzzyctl.loads(WHOLE, block="inner"))["y"]
        assert (bound.lo, bound.hi) == (-2.0, 2.0)
        verdicts = fuzzyctl.prove(fuzzyctl.loads(WHOLE, block="outer"))
        assert [type(v).__name__ for v in verdicts] == ["Proved"]

    def test_the_text_holds_all_systems_once(self):
        system = fuzzyctl.loads(WHOLE, block="outer")
        text = fuzzyctl.dumps(system)
        assert fuzzyctl.loads(text, block="outer") == system
        assert text.count("system urgency") == text.count("system inner") == 1

    def test_a_controller_calls_a_system_that_calls_others(self, tmp_path):
        path = tmp_path / "c.fz"
        path.write_text(WHOLE + "controller c\ninput e\noutput u = outer(e)\nevery 1 s\n")
        step = fuzzyctl.compile(fuzzyctl.load(path, block=fuzzyctl.Controller), "python")
        e = np.linspace(-1, 1, 11)
        np.testing.assert_allclose(step.run(e)[0], outer(e), rtol=1e-12, atol=1e-12)

    def test_generated_code_holds_what_is_called(self, tmp_path):
        path = tmp_path / "c.fz"
        path.write_text(WHOLE)
        arguments = ("codegen", path, "--block", "outer", "--target", "python", "-o", tmp_path)
        assert run_command(*arguments).exit_code == 0
        names = runpy.run_path(str(tmp_path / "outer.py"))
        assert names["outer"](0.3) == pytest.approx(float(outer(0.3)), rel=1e-12)

    def test_a_system_of_a_used_file_can_be_called(self, tmp_path):
        head, _, tail = WHOLE.partition("system inner")
        (tmp_path / "urgency.fz").write_text(head)
        path = tmp_path / "c.fz"
        path.write_text('use "urgency.fz"\nsystem inner' + tail)
        assert fuzzyctl.load(path, block="outer")(e=0.3) == pytest.approx(float(outer(0.3)), rel=1e-12)


CALLED = (
    "system w\ndefuzzifier center_average\ninput e in [-1, 1]\n  terms N P\noutput k in [0, 1]\n  terms N P\n"
    "table k = e\n    N P\n  | N P\n"
)
HEAD = "system o\ninput e in [-1, 1]\n"
TAIL = "output y in [0, 1] = z\n"


def chained(count, calls=1):
    """Systems that call the next one, some times."""
    body = "input e in [-1, 1]\noutput y in [-9, 9] = "
    links = (f"system s{k}\nlet z = {' + '.join([f's{k + 1}.y(e)'] * calls)}\n{body}z\n" for k in range(count - 1))
    return "".join(links) + f"system s{count - 1}\n{body}e\n"


class TestLimits:
    @pytest.mark.parametrize(
        "text", [chained(21), chained(7, calls=2)]
    )  # 20 + 19 + ... + 1, and 2 + 6 + 14 + ... + 126
    def test_calls_are_counted_directly_and_through_others(self, text):
        with pytest.raises(DiagnosticError) as caught:
            fuzzyctl.loads(text, block="s0")
        (found,) = caught.value.diagnostics
        assert (found.code, found.message) == ("FZ112", "the systems of the file call more than 200 others")

    def test_as_many_as_allowed_may_be_called(self):
        assert fuzzyctl.loads(chained(20), block="s0")(e=0.3) == 0.3
        assert fuzzyctl.loads(chained(6, calls=2), block="s0")(e=0.2) == pytest.approx(6.4)

    def test_rules_of_called_systems_are_counted(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.loading.examination.MAX_CALLED_RULES", 4)
        text = CALLED + HEAD + "let z = w.k(e) + w.k(0) - w.k(1)\n" + TAIL
        with pytest.raises(DiagnosticError, match="the systems that others call have more than 4 rules"):
            fuzzyctl.loads(text, block="o")
        assert fuzzyctl.loads(text.replace(" - w.k(1)", ""), block="o")

    def test_calls_of_used_systems_are_counted_as_often_as_they_are_made(self, tmp_path):
        (tmp_path / "used.fz").write_text(chained(5, calls=3))  # 3 + 12 + 39 + 120
        path = tmp_path / "c.fz"
        path.write_text(
            'use "used.fz"\nsystem o\ninput e in [-1, 1]\nlet z = s0.y(e) + s0.y(1)\noutput y in [0, 1] = z\n'
        )
        with pytest.raises(DiagnosticError, match="call more than 200 others"):
            fuzzyctl.load(path)
