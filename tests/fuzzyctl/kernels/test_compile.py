import copy
import gc
import math
import pickle
import subprocess
import sys
import weakref

import numpy as np
import pytest

import fuzzyctl.kernels.compile as compile_module
from fuzzyctl import loads
from fuzzyctl.diagnostics.diagnostic import (
    ArgumentError,
    BackendUnavailableError,
    DiagnosticError,
    NoRuleFiresError,
    UnknownNameError,
)
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.compile import operations
from fuzzyctl.kernels.plan.build import plan
from tests import sizes

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

    def test_takes_inputs_in_the_order_of_declaration(self, gappy):
        kernel = compile_system(gappy(), "python")
        assert kernel.input_names == ("speed", "turn")
        assert kernel(1.0, -0.5) == (10.0, 2.0)
        assert kernel(0.5, -1.0) == (10.0, 2.0)

    def test_weighs_rules_by_their_weight_in_both_sums(self, gappy):
        _, lamp = compile_system(gappy(), "python")(1.0, 0.0)
        assert lamp == pytest.approx((0.5 * 2 + 0.5 * 0.5 * 1) / (0.5 + 0.25))

    def test_unknown_backends_are_refused_with_the_known_ones(self, ais):
        with pytest.raises(UnknownNameError, match=r"no backend 'nunba'.*did you mean 'numba'"):
            compile_system(ais, "nunba")

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

    @pytest.mark.usefixtures("no_numba")
    def test_numba_is_named_when_it_is_asked_for_and_absent(self, ais):
        with pytest.raises(BackendUnavailableError, match="numba"):
            compile_system(ais, "numba")

    def test_auto_leaves_to_numpy_what_numba_would_take_long_over(self, ais, monkeypatch):
        assert compile_system(curves(50)).backend == "numpy"  # not compiled here, which would take half a minute
        assert compile_system(ais).backend == "numba"
        count = operations(algorithm_of(plan(ais)).point)
        monkeypatch.setattr(compile_module, "MOST_OPERATIONS", count - 1)
        assert compile_system(ais).backend == "numpy"
        monkeypatch.setattr(compile_module, "MOST_OPERATIONS", count)
        assert compile_system(ais).backend == "numba"

    def test_operations_grow_with_what_compilers_read_and_not_with_what_loops_run(self):
        few, many = (operations(algorithm_of(plan(curves(k))).point) for k in (5, 10))
        assert 1.8 * few < many < 2.2 * few
        # Corners of curves are searched, whatever their number.
        searched = [operations(algorithm_of(plan(curves(5, corners=k))).point) for k in (50, 200)]
        assert searched[0] == searched[1] < operations(algorithm_of(plan(curves(5, corners=20))).point)

    @pytest.mark.usefixtures("no_numba")
    def test_auto_survives_a_missing_numba_and_says_so_once(self, ais):
        with pytest.warns(RuntimeWarning, match="numba cannot be used .* slower") as said:
            kernels = [compile_system(ais), compile_system(ais)]
        assert len(said) == 1
        assert kernels[0].backend == "numpy"
        assert kernels[0](0.0, 0.0) == pytest.approx(0.18)

    def test_exact_maxima_refuse_curved_terms_without_a_closed_form(self):
        from fuzzyctl.kernels.plan.build import plan
        from fuzzyctl.model.method import Defuzzifier

        curved = loads(
            """
system curved
defuzzifier centroid(resolution=100)
input x in [0, 1]
  any = triangle(-inf, 0, inf)
output u in [0, 1]
  bump = sigmoid_product(0.2, 20, -20, 0.8)
if x is any then u is bump
"""
        )
        method = curved.method.model_copy(update={"defuzzifier": Defuzzifier(kind="mom")})
        with pytest.raises(DiagnosticError, match=r"'bump'.*has no closed form"):
            plan(curved.model_copy(update={"method": method}))


class TestNaNAndInfinity:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_nan_in_any_input_makes_every_output_nan(self, gappy, backend):
        kernel = compile_system(gappy("else error"), backend)
        for point in ((math.nan, 0.0), (0.0, math.nan), (4.0, math.nan)):
            assert all(math.isnan(v) for v in kernel(*point))
            assert np.isnan(kernel.batch(np.array(point))).all()

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_infinity_and_far_values_are_clamped_to_the_range(self, ais, backend):
        kernel = compile_system(ais, backend)
        assert kernel(math.inf, -math.inf) == kernel(0.06, -1.0) == kernel(5.0, -1e300)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_extrapolated_inputs_go_through_the_formulas(self, backend):
        text = """
system s
defuzzifier weighted_average
input x in [0, 1] {}
  a = triangle(-inf, 0, 2)
  b = triangle(0, 2, inf)
output u in [0, 10]
  lo = singleton(0)
  hi = singleton(10)
if x is a then u is lo
if x is b then u is hi
"""
        free = loads(text.format("")).inputs[0].model_copy(update={"extrapolate": True})
        system = loads(text.format(""))
        assert compile_system(system, backend)(2.0) == 5.0
        assert compile_system(system.model_copy(update={"inputs": (free,)}), backend)(2.0) == 10.0


class TestOtherwise:
    HOLE = (4.0, -1.0)

    @pytest.mark.parametrize("backend", sizes.BACKENDS)
    @pytest.mark.parametrize(
        ("clause", "value"), [("else nan", math.nan), ("else midpoint", 50.0), ("else 7", 7.0), ("else 200", 200.0)]
    )
    def test_holds_where_no_rule_fires(self, gappy, backend, clause, value):
        kernel = compile_system(gappy(clause), backend)
        np.testing.assert_equal(kernel(*self.HOLE), (value, 1.5))
        np.testing.assert_equal(kernel.batch(np.array(self.HOLE)), [value, 1.5])

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_error_names_output_and_point(self, gappy, backend):
        kernel = compile_system(gappy("else error"), backend)
        with pytest.raises(NoRuleFiresError, match="output 'brake' at speed = 4, turn = -1"):
            kernel(*self.HOLE)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_error_in_a_batch_names_the_first_point(self, gappy, backend):
        kernel = compile_system(gappy("else error", "else error"), backend)
        with pytest.raises(NoRuleFiresError, match=r"output 'brake' at speed = 4, turn = 0\.5"):
            kernel.batch([[1.0, -0.5], [4.0, 0.5], [4.5, -1.0]])
        with pytest.raises(NoRuleFiresError, match="output 'lamp' at speed = 9, turn = -1"):
            kernel.batch([[9.0, -1.0]])

    def test_compiled_functions_raise_an_arithmetic_error(self, gappy):
        with pytest.raises(ArithmeticError, match="no rule fires for output 'brake'"):
            compile_system(gappy("else error"), "numba").jit(*self.HOLE)


class TestArguments:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_wrong_number_names_the_inputs(self, ais, backend):
        with pytest.raises(ArgumentError, match=r"2 arguments \(sigma, dsigma\), got 1"):
            compile_system(ais, backend)(0.1)

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("wrong", ["0.1", None, [0.1], np.zeros(3), 1j])
    def test_what_is_no_real_number_is_refused(self, ais, backend, wrong):
        with pytest.raises(ArgumentError, match="real number"):
            compile_system(ais, backend)(wrong, 0.0)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_other_numbers_count_as_floats(self, ais, backend):
        kernel = compile_system(ais, backend)
        exact = kernel(float(np.float32(0.01)), 1.0)
        assert kernel(np.float32(0.01), 1) == kernel(np.float32(0.01), np.int64(1)) == exact
        assert type(kernel(np.float64(0.01), True)) is float


class TestBatch:
    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("shape", [(), (5,), (3, 4), (0,), (2, 0)])
    def test_keeps_the_shape_of_the_points(self, ais, gappy, backend, shape):
        points = np.full((*shape, 2), 0.01)
        assert compile_system(ais, backend).batch(points).shape == shape
        assert compile_system(gappy(), backend).batch(points).shape == (*shape, 2)

    @pytest.mark.parametrize("backend", ["numpy", "numba"])
    def test_agrees_with_single_points_over_several_blocks(self, gappy, backend):
        rng = np.random.default_rng(1)
        points = rng.uniform((-1, -2), (12, 2), (20_000, 2))
        found = compile_system(gappy(), backend).batch(points)
        kernel = compile_system(gappy(), "python")
        for i in (*range(50), 8191, 8192, 16384, 19_999):
            np.testing.assert_allclose(found[i], kernel(*points[i]), rtol=1e-14)

    def test_takes_arrays_in_any_layout(self, ais):
        points = np.random.default_rng(2).uniform(-1, 1, (2, 50)).T
        for backend in BACKENDS:
            kernel = compile_system(ais, backend)
            np.testing.assert_array_equal(kernel.batch(points[::2]), kernel.batch(points.copy()[::2]))
            np.testing.assert_array_equal(kernel.batch(points.tolist()), kernel.batch(points))

    def test_refuses_other_shapes_and_words(self, ais):
        kernel = compile_system(ais, "numpy")
        with pytest.raises(ArgumentError, match=r"shape \(..., 2\) for sigma, dsigma, got \(3,\)"):
            kernel.batch(np.zeros(3))
        with pytest.raises(ArgumentError, match="array of real numbers"):
            kernel.batch([["a", "b"]])
        with pytest.raises(ArgumentError, match="no state"):
            kernel.batch(np.zeros(2), np.zeros(7))


class TestCallByName:
    def test_numbers_give_a_float(self, ais):
        assert ais(dsigma=0, sigma=np.float32(0.0)) == pytest.approx(0.18)
        assert type(ais(dsigma=0, sigma=0)) is float

    def test_arrays_broadcast(self, ais):
        found = ais(sigma=np.linspace(-0.06, 0.06, 5)[:, None], dsigma=[-0.5, 0.0, 0.5])
        assert found.shape == (5, 3)
        assert found[1, 2] == ais(sigma=-0.03, dsigma=0.5)

    def test_several_outputs_come_by_name(self, gappy):
        system = gappy()
        assert system(speed=1, turn=-0.5) == {"brake": 10.0, "lamp": 2.0}
        found = system(speed=[1, 8], turn=-0.5)
        assert list(found) == ["brake", "lamp"]
        np.testing.assert_array_equal(found["brake"], [10, 90])

    def test_unknown_and_missing_names_are_refused(self, ais):
        with pytest.raises(UnknownNameError, match=r"no input 'sgma'.*did you mean 'sigma'"):
            ais(sgma=0, dsigma=0)
        with pytest.raises(ArgumentError, match="missing for: dsigma"):
            ais(sigma=0)

    def test_what_does_not_broadcast_or_is_no_number_is_refused(self, ais):
        with pytest.raises(ArgumentError, match="broadcast"):
            ais(sigma=[1, 2, 3], dsigma=[1, 2])
        with pytest.raises(ArgumentError, match="input 'sigma' must be an array of real numbers"):
            ais(sigma="much", dsigma=0)

    def test_adaptive_outputs_have_their_initial_consequents(self, adaptive):
        assert adaptive(sigma=0.1) == 0.0
        np.testing.assert_array_equal(adaptive(sigma=[0.1, 0.2]), [0.0, 0.0])

    def test_kernels_are_compiled_once_and_forgotten_with_their_system(self, gappy, monkeypatch):
        compiled, kernels = compile_module.compile, []
        monkeypatch.setattr(compile_module, "compile", lambda *a: kernels.append(weakref.ref(k := compiled(*a))) or k)
        system = gappy()
        for x in (1, 2, [1.0, 2.0], [3.0]):
            system(speed=x, turn=0)
        assert [kernel().backend for kernel in kernels] == ["python", "numpy"]
        del system
        gc.collect()
        assert [kernel() for kernel in kernels] == [None, None]

    def test_systems_that_were_called_can_be_copied_pickled_and_compared(self, gappy):
        system, fresh = gappy(), gappy()
        expected = system(speed=1, turn=0)
        for copied in (copy.deepcopy(system), pickle.loads(pickle.dumps(system)), system.model_copy()):
            assert copied == system == fresh
            assert copied(speed=1, turn=0) == expected
        assert "_by_name" not in vars(system.model_copy())


def test_numbers_go_without_numpy_and_compiling_imports_nothing_heavy():
    code = """
import sys
from fuzzyctl import load
from fuzzyctl.kernels.compile import compile
system = load(sys.argv[1])
assert compile(system, "python")(0.01, -0.2) == system(sigma=0.01, dsigma=-0.2)
print([m for m in ("numpy", "scipy", "numba", "matplotlib") if m in sys.modules])
"""
    from pathlib import Path

    path = Path(__file__).parents[3] / "rules" / "ais_reaction.fz"
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
