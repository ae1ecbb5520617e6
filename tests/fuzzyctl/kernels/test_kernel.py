"""Calls of compiled kernels from Python: the same answers, whatever is handed over."""

from __future__ import annotations

import gc
import math
import sys
import weakref
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import ArgumentError, FuzzyctlError, ValueOutOfBoundsError

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
SYSTEM = fuzzyctl.loads(SUM)
KERNEL = fuzzyctl.compile(SYSTEM, "numba")
PLAIN = fuzzyctl.compile(SYSTEM, "python")


@given(st.floats(), st.floats())
def test_all_floats_give_what_python_gives(a: float, b: float) -> None:
    assert KERNEL(a, b) == pytest.approx(PLAIN(a, b), rel=1e-13, nan_ok=True)


@pytest.mark.parametrize("kind", [int, np.float64, np.float32, np.int8, Fraction, bool, np.array])
def test_other_numbers_are_converted(kind: Any) -> None:
    assert KERNEL(kind(1), 0.5) == KERNEL(0.5, kind(1)) == KERNEL(1.0, 0.5)


@pytest.mark.parametrize("wrong", ["0.5", None, 1j, b"1", [0.5], np.zeros(1), object()])
def test_what_is_no_number_is_refused(wrong: Any) -> None:
    for arguments in ((wrong, 0.5), (0.5, wrong)):
        with pytest.raises(ArgumentError, match="real number"):
            KERNEL(*arguments)


@pytest.mark.parametrize("arguments", [(), (0.5,), (0.5, 0.5, 0.5)])
def test_a_wrong_number_of_arguments_is_refused(arguments: tuple[float, ...]) -> None:
    with pytest.raises(ArgumentError, match=f"takes 2 arguments .*got {len(arguments)}"):
        KERNEL(*arguments)


def test_an_array_in_the_place_of_all_inputs_has_a_hint() -> None:
    with pytest.raises(ArgumentError, match=r"got 1; kernel\.batch takes arrays$"):
        KERNEL([0.5, 0.5])
    with pytest.raises(ArgumentError, match=r"got 1$"):
        KERNEL(0.5)


def test_integers_beyond_64_bits_are_converted() -> None:
    assert KERNEL(2**70, 0.5) == KERNEL(0.5, 2**70) == KERNEL(1.0, 0.5)


def test_huge_integers_are_named() -> None:
    with pytest.raises(ValueOutOfBoundsError, match="input 'b'"):
        KERNEL(0.5, 10**400)


def test_the_function_is_compiled_at_the_first_call() -> None:
    kernel = fuzzyctl.compile(fuzzyctl.loads(SUM.replace("0.25", "0.125")), "numba")
    assert "jit" not in vars(kernel)
    assert kernel(-1.0, 1.0) == kernel.jit(-1.0, 1.0) == 0.125


def test_nan_gives_nan() -> None:
    assert math.isnan(KERNEL(math.nan, 0.5))
    assert math.isnan(KERNEL(0.5, math.nan))


def test_no_reference_is_lost_or_kept() -> None:
    value = 0.123
    gc.collect()
    before = sys.getrefcount(value), sys.getrefcount(None), sys.getrefcount(float)
    for _ in range(1000):
        KERNEL(value, value)
        KERNEL(value, 1)
        with pytest.raises(FuzzyctlError):
            KERNEL(value, None)
    gc.collect()
    after = sys.getrefcount(value), sys.getrefcount(None), sys.getrefcount(float)
    assert all(b - a < 100 for a, b in zip(before, after, strict=True))


def test_a_call_outlives_its_kernel_and_a_kernel_goes_when_it_is_not_needed() -> None:
    system = fuzzyctl.loads(SUM)
    kernel = fuzzyctl.compile(system, "numba")
    call, gone = kernel.__call__, weakref.ref(kernel)
    del kernel, system
    gc.collect()
    assert call(0.5, 0.25) == KERNEL(0.5, 0.25)
    assert call(1, 0.25) == KERNEL(1.0, 0.25)
    del call
    gc.collect()
    assert gone() is None


def test_what_one_caller_compiles_changes_nothing_for_others() -> None:
    system, other = fuzzyctl.loads(SUM), fuzzyctl.loads(SUM.replace("0.25", "0.75"))
    before = system(a=0.1, b=0.3), fuzzyctl.compile(other, "numba").batch([[0.1, 0.3]])
    kernel = fuzzyctl.compile(system, "numba")
    kernel(0.1, 0.3)
    kernel.batch([[0.1, 0.3]])
    assert (system(a=0.1, b=0.3), fuzzyctl.compile(other, "numba").batch([[0.1, 0.3]])) == before
    assert type(kernel) is type(PLAIN) is fuzzyctl.Kernel
    assert system(a=0.1, b=0.3) == PLAIN(0.1, 0.3)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
class TestOneClassForAllBlocks:
    STATELESS = "controller twice\ninput x\ninput y\noutput u = 2 * x + y\nevery 1 s\n"
    ADAPTIVE = (
        "system gain\ndefuzzifier weighted_average\ninput s in [-1, 1]\n  low = triangle(-inf, -1, 1)\n"
        "  high = triangle(-1, 1, inf)\noutput F in [-9, 9] adaptive rate s\n  terms C=0 D=2\n"
        "if s is low then F is C\nif s is high then F is D\n"
    )

    def test_a_controller_without_state_is_called_with_its_inputs_alone(self, backend, tmp_path):
        path = tmp_path / "twice.fz"
        path.write_text(self.STATELESS)
        kernel = fuzzyctl.compile(fuzzyctl.load(path, block=fuzzyctl.Controller), backend)
        assert kernel(1.0, 0.5) == kernel(y=0.5, x=1.0) == 2.5
        outputs, state = kernel(1.0, 0.5, [])
        assert (outputs, state.shape) == (2.5, (0,))
        assert [x.tolist() for x in kernel.batch([[1.0, 0.5]])] == [[2.5], [[]]]

    def test_derivatives_by_consequents_are_normalised_strengths(self, backend):
        kernel = fuzzyctl.compile(fuzzyctl.loads(self.ADAPTIVE), backend)
        assert kernel.state_names == ("F[1]", "F[2]")
        assert kernel.gradient([[0.5], [-1.0]], by="state") == pytest.approx(np.array([[0.25, 0.75], [1.0, 0.0]]))
        assert kernel.gradient([[0.5]], [1.0, 3.0], by="all") == pytest.approx(np.array([[1.0, 0.25, 0.75]]))

    def test_states_broadcast_with_points(self, backend):
        kernel = fuzzyctl.compile(fuzzyctl.loads(self.ADAPTIVE), backend)
        states = np.array([[[0.0, 2.0]], [[4.0, 4.0]]])
        assert kernel.batch([-1.0, 1.0], states).tolist() == [[0.0, 2.0], [4.0, 4.0]]

    def test_no_free_number_is_a_plain_kernel(self, backend):
        kernel = fuzzyctl.compile(fuzzyctl.loads(self.ADAPTIVE), backend, free=[])
        assert kernel(1.0, kernel.start()) == 2.0


HELD = """system held
defuzzifier weighted_average
input x in [0, 10]
  low = triangle(0, 1, 3)
output u in [-5, 5] else hold(-1)
  a = singleton(-4)
output v in [-5, 5] else hold(2)
  a = singleton(3)
if x is low then u is a
if x is low then v is a
"""
MOVES = (
    "controller c\ninput x\nstate a = 1\nstate b = 2\noutput u = a\noutput v = b\nnext a = a\nnext b = b\nevery 1 s\n"
)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
@pytest.mark.parametrize("text", [HELD, MOVES])
def test_states_with_names_are_taken_by_name(text: str, backend: str) -> None:
    pd = pytest.importorskip("pandas")
    kernel: Any = fuzzyctl.compile(fuzzyctl.loads(text, block=fuzzyctl.Block), backend)
    first, second = kernel.state_names
    other = {second: 7.0, first: 5.0}
    expected = kernel(9.0, [5.0, 7.0])
    for state in (other, pd.Series(other)):
        assert str(kernel(9.0, state)) == str(expected)
        assert str(kernel.batch([9.0], state)) == str(kernel.batch([9.0], [5.0, 7.0]))
        assert str(kernel.run([9.0], state)) == str(kernel.run([9.0], [5.0, 7.0]))
    with pytest.raises(ArgumentError, match="no state 'z'"):
        kernel(9.0, pd.Series({first: 1.0, "z": 2.0}))
    with pytest.raises(ValueOutOfBoundsError, match="range of floats"):
        kernel(9.0, [10**400, 0])


@pytest.mark.parametrize("text", [HELD, MOVES])
def test_rows_of_points_and_states_have_the_same_labels(text: str) -> None:
    pd = pytest.importorskip("pandas")
    kernel: Any = fuzzyctl.compile(fuzzyctl.loads(text, block=fuzzyctl.Block), "python")
    points = pd.DataFrame({"x": [9.0, 9.5]}, index=["p", "q"])
    states = pd.DataFrame([[5.0, 7.0], [6.0, 8.0]], columns=list(kernel.state_names), index=["q", "p"])
    for ask in (kernel.batch, kernel.gradient):
        with pytest.raises(ArgumentError, match="different row labels"):
            ask(points, states)
        ask(points, states.iloc[0])
    np.testing.assert_array_equal(
        kernel.batch(points, states.loc[points.index]), kernel.batch([9.0, 9.5], [[6, 8], [5, 7]])
    )


def test_free_numbers_of_each_point_come_in_a_frame() -> None:
    pd = pytest.importorskip("pandas")
    kernel = fuzzyctl.compile(SYSTEM, "python", free=["u.M.value", "u.weights"])
    values = pd.DataFrame([kernel.start(), kernel.start({"u.M.value": 0.5})], columns=list(kernel.free_names))
    points = [[0.2, 0.9], [0.2, 0.9]]
    expected = kernel.batch(points, values.to_numpy())
    np.testing.assert_array_equal(kernel.batch(points, values[values.columns[::-1]]), expected)
    assert expected[0] != expected[1]


def test_wrong_times_and_kinds_of_derivatives_are_named() -> None:
    step: Any = fuzzyctl.compile(fuzzyctl.loads("controller c\ninput x\noutput u = integral(x)\n", block="c"), "python")
    with pytest.raises(ValueOutOfBoundsError, match="input 'dt' must be within the range of floats"):
        step(1.0, [0.0], dt=10**400)
    with pytest.raises(ArgumentError, match="input 'dt' must be a real number"):
        step(1.0, [0.0], dt="1")
    with pytest.raises(ArgumentError, match="'by' must be one of inputs, state, all"):
        step.gradient(1.0, dt=1.0, by=["inputs"])
