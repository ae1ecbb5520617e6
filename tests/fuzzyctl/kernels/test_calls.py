"""Calls of compiled kernels and of systems: which numbers and names they take, and what they say of others."""

import copy
import gc
import math
import pickle
import subprocess
import sys
import weakref
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
import fuzzyctl.kernels.compile as compile_module
from fuzzyctl import ArgumentError, FuzzyctlError, UnknownNameError, ValueOutOfBoundsError, loads

EACH = pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
SUM = """system sum
and product
defuzzifier weighted_average
input a in [-1, 1]
  terms N P
input b in [-1, 1]
  terms N P
output u in [-1, 1]
  L = singleton(-1)
  H = singleton(1)
  M = singleton(0.25)
table u = a x b
      N P
  N | L M
  P | M H
"""
SYSTEM = loads(SUM)
KERNELS = {backend: fuzzyctl.compile(SYSTEM, backend) for backend in ("python", "numpy", "numba")}


@given(st.floats(), st.floats())
def test_all_floats_give_what_python_gives(a, b):
    assert KERNELS["numba"](a, b) == pytest.approx(KERNELS["python"](a, b), rel=1e-13, nan_ok=True)


@EACH
def test_other_numbers_are_converted(backend):
    kernel = KERNELS[backend]
    for kind in (int, np.float64, np.float32, np.int8, Fraction, bool, np.array):
        assert kernel(kind(1), 0.5) == kernel(0.5, kind(1)) == kernel(1.0, 0.5)
        assert type(kernel(kind(1), 0.5)) is float
    assert kernel(2**70, 0.5) == kernel(1.0, 0.5)
    assert kernel.batch([[Fraction(7, 20), 0.5]])[0] == pytest.approx(kernel(Fraction(7, 20), 0.5))


@EACH
@pytest.mark.parametrize("wrong", ["0.5", None, 1j, b"1", [0.5], np.zeros(1), object()])
def test_what_is_no_real_number_is_refused(backend, wrong):
    for arguments in ((wrong, 0.5), (0.5, wrong)):
        with pytest.raises(ArgumentError, match="real number"):
            KERNELS[backend](*arguments)


@EACH
def test_numbers_beyond_floats_and_texts_are_refused_by_name(backend):
    kernel = KERNELS[backend]
    with pytest.raises(ValueOutOfBoundsError, match="input 'b'"):
        kernel(0.5, 10**400)
    with pytest.raises(ValueOutOfBoundsError, match="points"):
        kernel.batch([[10**400, 0]])
    with pytest.raises(ArgumentError, match="points must be an array of real numbers"):
        kernel.batch([["0.01", "0"]])


@EACH
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_wrong_number_of_arguments_is_refused(backend, count):
    inputs = "".join(f"input x{i} in [0, 1]\n  terms a b\n" for i in range(count))
    rules = "".join(f"if x{i} is a then u is lo\nif x{i} is b then u is hi\n" for i in range(count))
    text = f"system s\ndefuzzifier weighted_average\n{inputs}output u in [0, 1]\n  terms lo=0 hi=1\n{rules}"
    kernel = fuzzyctl.compile(loads(text), backend)
    assert repr(kernel).startswith("Kernel(x0")
    assert kernel(*[0.25] * count) == pytest.approx(0.25)
    assert math.isnan(kernel(*[math.nan] * count))
    for wrong in (count - 1, count + 1):
        with pytest.raises(ArgumentError, match=rf"takes {count} arguments? \(x0.*, got {wrong}$"):
            kernel(*[0.5] * wrong)


def test_an_array_in_the_place_of_all_inputs_has_a_hint():
    with pytest.raises(ArgumentError, match=r"got 1; kernel\.batch takes arrays$"):
        KERNELS["numba"]([0.5, 0.5])


@EACH
def test_shapes_and_states_that_do_not_fit_are_refused(backend):
    with pytest.raises(ArgumentError, match=r"shape \(..., 2\) for a, b, got \(3,\)"):
        KERNELS[backend].batch(np.zeros(3))
    for state in (np.zeros(7), [[1.0]]):
        with pytest.raises(ArgumentError, match=r"no state: .*, so it takes none"):
            KERNELS[backend].batch(np.zeros(2), state)
    with pytest.raises(ArgumentError, match="a system has no time, so that 'dt' is not given"):
        KERNELS[backend].batch(np.zeros(2), dt=0.1)
    with pytest.raises(ArgumentError, match=r"shape \(n, 2\) for a, b, got \(2,\)"):
        KERNELS[backend].run(np.zeros(2))


@EACH
def test_arrays_of_texts_are_refused_with_the_types_of_all_arguments(backend):
    with pytest.raises(ArgumentError, match="real number; got a: ndarray, b: float; "):
        KERNELS[backend](np.array("x"), 0.5)


def test_what_can_be_compiled_is_said():
    for wrong in (None, "tipper"):
        with pytest.raises(ArgumentError, match="FuzzySystem"):
            fuzzyctl.compile(wrong)
    with pytest.raises(ArgumentError, match="backend"):
        fuzzyctl.compile(SYSTEM, None)
    with pytest.raises(UnknownNameError, match=r"no backend 'nunba'.*did you mean 'numba'"):
        fuzzyctl.compile(SYSTEM, "nunba")
    with pytest.raises(UnknownNameError, match=r"no algorithm 'rule'.*'rules'"):
        fuzzyctl.compile(SYSTEM, algorithm="rule")


def test_no_reference_is_lost_or_kept():
    value, kernel = 0.123, KERNELS["numba"]
    gc.collect()
    before = sys.getrefcount(value), sys.getrefcount(None), sys.getrefcount(float)
    for _ in range(1000):
        kernel(value, value)
        kernel(value, 1)
        with pytest.raises(FuzzyctlError):
            kernel(value, None)
    gc.collect()
    after = sys.getrefcount(value), sys.getrefcount(None), sys.getrefcount(float)
    assert all(b - a < 100 for a, b in zip(before, after, strict=True))


def test_a_call_outlives_its_kernel_and_a_kernel_goes_when_it_is_not_needed():
    kernel = fuzzyctl.compile(loads(SUM), "numba")
    call, gone = kernel.__call__, weakref.ref(kernel)
    del kernel
    gc.collect()
    assert call(0.5, 0.25) == KERNELS["numba"](0.5, 0.25)
    del call
    gc.collect()
    assert gone() is None


def test_the_function_is_compiled_at_the_first_call():
    kernel = fuzzyctl.compile(loads(SUM.replace("0.25", "0.125")), "numba")
    assert "jit" not in vars(kernel)
    assert kernel(-1.0, 1.0) == kernel.jit(-1.0, 1.0) == 0.125


REFUSING = """system s
defuzzifier weighted_average
input µ in [0, 10]
  low  = triangle(-inf, 1, 4)
input load in [0, 1]
  some = triangle(0, 0.5, inf)
output u in [-5, 20] else error
  a = constant(3)
if µ is low and load is some then u is a
"""
ADAPTING = """system s
and product
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 1, 4)
  high = triangle(1, 4, inf)
output u in [-5, 20] adaptive rate x
  a = constant(3)
  b = constant(4)
if x is low then u is a
if x is high then u is b
"""


@EACH
class TestNames:
    """Inputs by name, which Python binds for functions and not for kernels."""

    def test_are_positions_in_any_of_their_forms(self, backend):
        kernel = KERNELS[backend]
        assert kernel(b=0.5, a=0.25) == kernel(0.25, b=0.5) == kernel(0.25, 0.5)
        kernel = fuzzyctl.compile(loads(REFUSING), backend)
        assert kernel(**{"μ": 2.0}, load=0.5) == kernel(2.0, 0.5) == 3.0  # noqa: PIE804 - the other letter
        kernel = fuzzyctl.compile(loads(ADAPTING), backend)
        assert kernel(x=2.0, state=[1.0, 9.0]) == kernel(2.0, state=[1.0, 9.0]) == kernel(2.0, [1.0, 9.0])

    @pytest.mark.parametrize("text", [REFUSING, ADAPTING])
    def test_that_are_unknown_are_reported_with_the_nearest(self, backend, text):
        kernel = fuzzyctl.compile(loads(text), backend)
        with pytest.raises(UnknownNameError, match="no input 'loda'; there are: .*" + ("x, state|µ, load.*'load'")):
            kernel(loda=1.0)

    def test_must_be_all_and_once(self, backend):
        kernel = KERNELS[backend]
        with pytest.raises(ArgumentError, match="missing for: a"):
            kernel(b=0.5)
        with pytest.raises(ArgumentError, match="'a' is given by position and by name"):
            kernel(0.25, a=0.25, b=0.5)


class TestSystems:
    def test_numbers_give_a_float_and_arrays_broadcast(self, ais):
        assert ais(dsigma=0, sigma=np.float32(0.0)) == pytest.approx(0.18)
        assert type(ais(dsigma=0, sigma=0)) is float
        found = ais(sigma=np.linspace(-0.06, 0.06, 5)[:, None], dsigma=[-0.5, 0.0, 0.5])
        assert found.shape == (5, 3)
        assert found[1, 2] == ais(sigma=-0.03, dsigma=0.5)

    def test_several_outputs_come_by_name(self, gappy):
        assert gappy()(speed=1, turn=-0.5) == {"brake": 10.0, "lamp": 2.0}
        found = gappy()(speed=[1, 8], turn=-0.5)
        assert list(found) == ["brake", "lamp"]
        np.testing.assert_array_equal(found["brake"], [10, 90])

    def test_adaptive_outputs_have_their_initial_consequents(self, adaptive):
        assert adaptive(sigma=0.1) == 0.0
        np.testing.assert_array_equal(adaptive(sigma=[0.1, 0.2]), [0.0, 0.0])

    @pytest.mark.parametrize(
        ("values", "error", "message"),
        [
            ({"sgma": 0, "dsigma": 0}, UnknownNameError, r"no input 'sgma'.*did you mean 'sigma'"),
            ({"sigma": 0}, ArgumentError, "missing for: dsigma"),
            ({"sigma": [1, 2, 3], "dsigma": [1, 2]}, ArgumentError, "broadcast"),
            ({"sigma": np.ma.masked_array([1.0], [True]), "dsigma": 0}, ArgumentError, "'sigma' has masked entries"),
            *(
                ({"sigma": wrong, "dsigma": 0}, ArgumentError, "input 'sigma' must be an array of real numbers")
                for wrong in ("much", None, 1j, np.array([1 + 1j]))
            ),
        ],
    )
    def test_other_arguments_are_refused_by_name(self, ais, values, error, message):
        with pytest.raises(error, match=message):
            ais(**values)
        with pytest.raises(ArgumentError, match=r"by name: system\(sigma=\.\.\., dsigma=\.\.\.\)"):
            ais(7, dsigma=8)

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

    def test_that_were_called_can_be_copied_pickled_and_compared(self, gappy):
        system, fresh = gappy(), gappy()
        expected = system(speed=1, turn=0)
        for copied in (copy.deepcopy(system), pickle.loads(pickle.dumps(system)), system.model_copy()):
            assert copied == system == fresh
            assert copied(speed=1, turn=0) == expected

    def test_one_caller_changes_nothing_for_others(self):
        system = loads(SUM)
        before = system(a=0.1, b=0.3)
        kernel = fuzzyctl.compile(system, "numba")
        kernel(0.1, 0.3)
        kernel.batch([[0.1, 0.3]])
        assert system(a=0.1, b=0.3) == before == KERNELS["python"](0.1, 0.3)
        assert type(kernel) is type(KERNELS["python"]) is fuzzyctl.Kernel


def test_numbers_go_without_numpy_and_compiling_imports_nothing_heavy():
    code = """
import sys
from fuzzyctl import compile, load
system = load("ais_reaction")
assert compile(system, "python")(0.01, -0.2) == system(sigma=0.01, dsigma=-0.2)
print([m for m in ("numpy", "scipy", "numba", "matplotlib", "pandas") if m in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
