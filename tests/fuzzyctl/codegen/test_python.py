"""The generated module runs without fuzzyctl, and computes the same numbers."""

import math
import subprocess
import sys

import pytest

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import expected_of
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.python_source import module, module_name
from fuzzyctl.codegen.vectors import STEP
from tests.frozen.systems import SYSTEMS


def run(unit):
    """Return the names of the generated module."""
    names = {"__name__": "generated"}
    exec(compile(module(unit), "generated", "exec"), names)
    return names


class TestNumbers:
    def test_are_those_of_the_kernel(self, unit_of, some_kind):
        unit = unit_of(some_kind)
        names = run(unit)
        function = names[module_name(unit)]
        state = names["init"]() if "init" in names else None
        for vector in expected_of(unit).vectors:
            arguments = [*vector.inputs, *([] if state is None else [state])]
            if vector.refused:
                with pytest.raises(ArithmeticError, match=vector.refused):
                    function(*arguments)
                continue
            result = function(*arguments)
            found = result if isinstance(result, tuple) else (result,)
            for k, (a, b) in enumerate(zip(found, vector.outputs, strict=True)):
                assert (math.isnan(a) and math.isnan(b)) or abs(a - b) <= unit.tolerance(k)
            if "rates" in names:
                adapt(state, names["rates"](*arguments), unit.plan)

    @pytest.mark.parametrize(
        "value", ["floor(9 * x) - ceil(-x)", "round(9 * x) + lt(x, 0)", "mod(-x, y) + fmod(x, -y)"]
    )
    def test_of_roundings_and_remainders_are_too(self, value):
        text = (
            "system steps\ndefuzzifier weighted_average\ninput x in [-1, 1] extrapolate\n"
            "  any = trapezoid(-inf, 0, 1, inf)\ninput y in [0, 1]\noutput u in [-20, 20] else 0\n"
            f"if x is any then u is function({value})\n"
        )
        function = run(prepare(loads(text), text))["steps"]
        kernel = compile_system(loads(text), backend="numpy")
        for point in ((0.5, 0.3), (-0.5, 0.0), (1e17, 1.0), (math.inf, 0.5), (-math.inf, 0.5), (-0.0, 1.0)):
            assert function(*point) == pytest.approx(kernel(*point), nan_ok=True, rel=1e-15), point


def test_an_adaptive_integral_is_refused():
    text = SYSTEMS["centroid_curved"]
    with pytest.raises(CodegenError, match="adaptive integral, which only JavaScript of all"):
        module(prepare(loads(text), text))


def adapt(state, rates, plan):
    for k, (o, _) in enumerate(plan.states):
        value = state[k] + STEP * rates[k]
        if value == value:
            state[k] = min(max(value, plan.outputs[o].lower), plan.outputs[o].upper)


class TestModule:
    def call(self, unit, tmp_path, *arguments):
        path = tmp_path / f"{module_name(unit)}.py"
        path.write_text(module(unit), encoding="utf-8")
        # -S and -I: no installed package is in reach.
        command = [sys.executable, "-I", "-S", str(path), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)

    def test_evaluates_its_arguments_without_any_package(self, unit_of, tmp_path):
        done = self.call(unit_of("ais_reaction"), tmp_path, "0", "0")
        assert (done.returncode, done.stdout, done.stderr) == (0, "f = 0.18\n", "")

    @pytest.mark.parametrize(("arguments", "code"), [(["0"], 2), (["0", "zero"], 2), (["5", "0.9"], 1)])
    def test_answers_mistakes_without_a_traceback(self, unit_of, tmp_path, arguments, code):
        done = self.call(unit_of("refusing"), tmp_path, *arguments)
        assert done.returncode == code
        assert done.stderr
        assert "Traceback" not in done.stderr

    def test_prints_every_output(self, unit_of, tmp_path):
        done = self.call(unit_of("chained"), tmp_path, "1", "-1")
        assert [line.split(" = ")[0] for line in done.stdout.splitlines()] == ["u", "v"]
