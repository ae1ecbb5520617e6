"""One class of kernels for systems and controllers: states, free numbers and times by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, ValueOutOfBoundsError
from tests.fuzzyctl.kernels.test_calls import SUM


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
class TestOneClassForAllBlocks:
    STATELESS = "controller twice\ninput x\ninput y\noutput u = 2 * x + y\nevery 1 s\n"
    ADAPTIVE = (
        "system gain\ndefuzzifier weighted_average\ninput s in [-1, 1]\n  low = triangle(-inf, -1, 1)\n"
        "  high = triangle(-1, 1, inf)\noutput F in [-9, 9] adaptive rate s\n  terms C=0 D=2\n"
        "if s is low then F is C\nif s is high then F is D\n"
    )

    def test_a_controller_without_state_is_called_with_its_inputs_alone(self, backend):
        kernel = fuzzyctl.compile(fuzzyctl.loads(self.STATELESS, block="twice"), backend)
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
    kernel = fuzzyctl.compile(fuzzyctl.loads(SUM), "python", free=["u.M.value", "u.weights"])
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
