"""The generated module runs without fuzzyctl, and computes the same numbers."""

import math
import subprocess
import sys

import pytest

import fuzzyctl
from fuzzyctl.codegen.files import sources
from tests.frozen.systems import SYSTEMS
from tests.fuzzyctl.codegen.conftest import expected_of, unit_of, written


def run(unit):
    """Return the names of the generated module."""
    names = {"__name__": "generated"}
    exec(compile(*sources(unit, "python").values(), "generated", "exec"), names)
    return names


def function_of(unit):
    return run(unit)[next(iter(sources(unit, "python")))[:-3]]


class TestNumbers:
    def test_are_those_of_the_kernel(self, some_kind):
        unit = unit_of(some_kind)
        names = run(unit)
        function = names[next(iter(sources(unit, "python")))[:-3]]
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
        function = function_of(unit_of(text))
        kernel = fuzzyctl.compile(fuzzyctl.loads(text), backend="numpy")
        for point in ((0.5, 0.3), (-0.5, 0.0), (1e17, 1.0), (math.inf, 0.5), (-math.inf, 0.5), (-0.0, 1.0)):
            assert function(*point) == pytest.approx(kernel(*point), nan_ok=True, rel=1e-15), point


def test_an_adaptive_integral_is_refused():
    found = written(SYSTEMS["centroid_curved"], "python").errors
    assert "the exact centroid of these sets is an adaptive integral, which only JavaScript" in " ".join(found.split())


def adapt(state, rates, plan):
    for k, (o, _) in enumerate(plan.states):
        value = state[k] + 0.01 * rates[k]
        if value == value:
            state[k] = min(max(value, plan.outputs[o].lower), plan.outputs[o].upper)


class TestModule:
    @pytest.mark.parametrize(
        ("name", "arguments", "code", "output"),
        [
            ("ais_reaction", ["0", "0"], 0, "f = 0.18\n"),
            ("chained", ["1", "-1"], 0, "u = -3.988529927254727\nv = nan\n"),
            ("refusing", ["0"], 2, ""),
            ("refusing", ["0", "zero"], 2, ""),
            ("refusing", ["5", "0.9"], 1, ""),
        ],
    )
    def test_evaluates_its_arguments_without_any_package(self, tmp_path, name, arguments, code, output):
        (path,) = (tmp_path / file for file in written(name, "python").files)
        path.write_text(written(name, "python").files[path.name], encoding="utf-8")
        # -S and -I: no installed package is in reach.
        command = [sys.executable, "-I", "-S", str(path), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (code, output)
        assert bool(done.stderr) == bool(code)
        assert "Traceback" not in done.stderr
