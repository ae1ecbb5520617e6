"""Steps as Python modules: they need nothing installed, and leave the state to their caller."""

import math
import subprocess
import sys

import pytest

import fuzzyctl
from fuzzyctl.codegen.files import sources
from tests.fuzzyctl.codegen.steps.targets import controller_of, unit_of
from tests.fuzzyctl.codegen.steps.texts import TEXTS


def module(unit):
    (text,) = sources(unit, "python").values()
    return text


def run(text):
    """Return the names of the generated module."""
    names = {"__name__": "generated"}
    exec(compile(module(unit_of(text, "python")), "generated", "exec"), names)
    return names


class TestModule:
    def test_names_what_the_step_of_the_kernel_names(self, text):
        names, step = run(text), fuzzyctl.compile(controller_of(text), "python")
        assert names["INPUTS"] == list(step.input_names)
        assert names["OUTPUTS"] == list(step.output_names)
        assert names["STATES"] == list(step.state_names)
        assert names.get("PERIOD") == step.period
        own, kept = names["start"](), step.start()
        assert own == kept.tolist()
        point = [0.75] * (len(step.input_names) + (step.period is None))
        for _ in range(40 if "refusing" not in text else 0):
            _, own = names["step"](*point[: len(step.input_names)], own, *point[len(step.input_names) :])
            time = {} if step.period is not None else {"dt": 0.75}
            _, kept = step(*point[: len(step.input_names)], kept, **time)
            assert own == pytest.approx(kept.tolist(), rel=1e-12, abs=1e-12)

    def test_does_not_grow_with_a_delay(self):
        text = TEXTS["waits"].replace("30", "10000")
        assert len(module(unit_of(text, "python"))) < 2000
        assert len(run(text)["start"]()) == 10_003

    def test_leaves_what_it_is_given_as_it_is(self):
        step, state = run(TEXTS["pid"])["step"], [1.0, 1.0, 0.5, 0.25]
        _, after = step(1.0, 0.0, state)
        assert state == [1.0, 1.0, 0.5, 0.25]
        assert after != state
        value, after = step(math.nan, 0.0, state)
        assert math.isnan(value)
        assert after == state
        assert after is not state

    def test_raises_where_no_rule_fires(self):
        names = run(TEXTS["refusing"])
        with pytest.raises(ArithmeticError, match="no rule fires for output 'u'"):
            names["step"](0.0, names["start"]())

    def test_runs_without_any_package(self, tmp_path):
        path = tmp_path / "valve.py"
        text = module(unit_of(TEXTS["pid"], "python")) + "print(step(1, 0, start())[0])\n"
        path.write_text(text, encoding="utf-8")
        # -S and -I: no installed package is in reach.
        done = subprocess.run([sys.executable, "-I", "-S", str(path)], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (0, "0.5\n", "")

    @pytest.mark.parametrize("name", ["start", "step", "PERIOD", "state", "divide", "nan"])
    def test_may_have_any_names(self, name):
        text = f"controller {name}\ninput {name} in [0, 1]\ninput y\noutput u = {name} / y + previous(y)\nevery 1 s\n"
        names = run(text)
        assert names["step"](1.0, 2.0, names["start"]()) == (0.5, [2.0])
        assert next(iter(sources(unit_of(text), "python"))).removesuffix(".py").isidentifier()
