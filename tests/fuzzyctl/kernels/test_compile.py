import math
import sys

import numpy as np
import pytest

import fuzzyctl.kernels.compile as compile_module
from fuzzyctl import BackendUnavailableError, NoRuleFiresError, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan

BACKENDS = ("python", "numpy", "numba")


def curves(terms, corners=50):
    """A system of two inputs whose terms are measured curves of many corners each."""
    places = [2.0 * k / (corners - 1) for k in range(corners)]
    lines = ["system s", "and min", "defuzzifier weighted_average"]
    for name in "xy":
        lines.append(f"input {name} in [0, {terms}]")
        for t in range(terms):
            numbers = ", ".join(f"{t + p}, {round(math.sin(1.5 * p) ** 2, 6)}" for p in places)
            lines.append(f"  t{t} = piecewise({numbers})")
    lines += ["output u in [0, 1] else nan", "  a = constant(0)", "  b = constant(1)"]
    lines += [f"if x is t{t} and y is t{t} then u is {'ab'[t % 2]}" for t in range(terms)]
    return loads("\n".join(lines))


class TestCompile:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_computes_the_table_of_the_paper_at_its_peaks(self, ais, backend):
        kernel = compile_system(ais, backend)
        assert kernel(-0.03, -0.5) == -1.0
        assert kernel(0.0, 0.0) == pytest.approx(0.18)
        assert kernel(-0.03, 0.5) == pytest.approx(-0.33)
        assert kernel(0.015, 0.5) == pytest.approx(-0.66)

    @pytest.fixture
    def no_numba(self, monkeypatch):
        """Leave numba out; what was found out of it before is forgotten, and again afterwards."""
        monkeypatch.setitem(sys.modules, "numba", None)
        for name in ("source", "machine_code", "integrals", "intrinsics", "disk_cache"):
            monkeypatch.delitem(sys.modules, f"fuzzyctl.kernels.backends.numba.{name}", raising=False)
            monkeypatch.delattr(f"fuzzyctl.kernels.backends.numba.{name}", raising=False)
        for found in (compile_module.numba_is_missing, compile_module._say_once):
            found.cache_clear()
        yield
        for found in (compile_module.numba_is_missing, compile_module._say_once):
            found.cache_clear()

    def test_auto_leaves_to_numpy_what_numba_would_take_long_over(self, ais, monkeypatch):
        assert compile_system(curves(50)).backend == "numpy"  # not compiled here, which would take half a minute
        assert compile_system(ais).backend == "numba"
        count = compile_module.operations(algorithm_of(plan(ais)).point)
        monkeypatch.setattr(compile_module, "MOST_OPERATIONS", count - 1)
        assert compile_system(ais).backend == "numpy"
        monkeypatch.setattr(compile_module, "MOST_OPERATIONS", count)
        assert compile_system(ais).backend == "numba"

    def test_operations_grow_with_what_compilers_read_and_not_with_what_loops_run(self):
        few, many = (compile_module.operations(algorithm_of(plan(curves(k))).point) for k in (5, 10))
        assert 1.8 * few < many < 2.2 * few
        # Corners of curves are searched, whatever their number.
        searched = [compile_module.operations(algorithm_of(plan(curves(5, corners=k))).point) for k in (50, 200)]
        assert searched[0] == searched[1] < compile_module.operations(algorithm_of(plan(curves(5, corners=20))).point)

    @pytest.mark.usefixtures("no_numba")
    def test_auto_survives_a_missing_numba_and_says_so_once(self, ais):
        with pytest.warns(RuntimeWarning, match="numba cannot be used .* slower") as said:
            kernels = [compile_system(ais), compile_system(ais)]
        assert len(said) == 1
        with pytest.raises(BackendUnavailableError, match="numba"):
            compile_system(ais, "numba")
        assert kernels[0].backend == "numpy"
        assert kernels[0](0.0, 0.0) == pytest.approx(0.18)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("otherwise", ["else error", ""])
class TestPromises:
    """Of an output whose `else` is an error, and of one without: NaN of numbers is reported, NaN of NaN is not."""

    def test_nan_in_any_input_makes_every_output_nan(self, gappy, backend, otherwise):
        kernel = compile_system(gappy(otherwise, otherwise), backend)
        for point in ((math.nan, 0.0), (0.0, math.nan), (4.0, math.nan)):
            assert all(math.isnan(v) for v in kernel(*point))
            assert np.isnan(kernel.batch(np.array(point))).all()

    def test_the_output_and_the_first_point_are_named(self, gappy, backend, otherwise):
        kernel = compile_system(gappy(otherwise, otherwise), backend)
        with pytest.raises(NoRuleFiresError, match="output 'brake' at speed = 4, turn = -1"):
            kernel(4.0, -1.0)
        with pytest.raises(NoRuleFiresError, match=r"output 'brake' at speed = 4, turn = 0\.5"):
            kernel.batch([[1.0, -0.5], [math.nan, 0.0], [4.0, 0.5], [4.5, -1.0]])
        with pytest.raises(NoRuleFiresError, match="output 'lamp' at speed = 9, turn = -1"):
            kernel.batch([[9.0, -1.0]])
        if otherwise and backend == "numba":
            with pytest.raises(ArithmeticError, match="no rule fires for output 'brake'"):
                kernel.jit(4.0, -1.0)


@pytest.mark.parametrize("backend", BACKENDS)
def test_infinity_and_far_values_are_clamped_to_the_range(ais, backend):
    kernel = compile_system(ais, backend)
    assert kernel(math.inf, -math.inf) == kernel(0.06, -1.0) == kernel(5.0, -1e300)
