"""Plants of one line: their equations have the transfer function that is written."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import Experiment, loads
from fuzzyctl.expr import Call, evaluate
from tests.properties.running import quick

#: Where transfer functions are compared.
POINTS = (0.1, 1j, 0.3 + 2j, -0.2 + 30j)

NUMBERS = st.floats(0.01, 100).map(lambda x: round(x, 3))
SIGNED = st.one_of(NUMBERS, NUMBERS.map(lambda x: -x))


def plant_of(text):
    return loads(text, block="p")


def matrices(plant):
    """Return A, B, C and D of a linear plant; inputs are not delayed."""
    states, inputs = [s.name for s in plant.states], [i.name for i in plant.inputs]

    def values(at):
        names = dict.fromkeys([*states, *inputs], 0.0) | plant.param_values.values | at
        for d in plant.definitions:
            is_delay = isinstance(d.value, Call) and d.value.function == "delay"
            names[d.name] = evaluate(d.value.arguments[0] if is_delay else d.value, names)
        return [evaluate(d.value, names) for d in (*plant.derivatives, *plant.results)]

    both = np.array([values({name: 1.0}) for name in [*states, *inputs]]).T
    n = len(states)
    return both[:n, :n], both[:n, n:], both[n:, :n], both[n:, n:]


def response(plant, s):
    a, b, c, d = matrices(plant)
    return c @ np.linalg.solve(s * np.eye(len(a)) - a, b) + d if len(a) else d


def written(numbers):
    return f"[{', '.join(map(str, numbers))}]"


@given(st.lists(SIGNED, min_size=1, max_size=5), st.lists(SIGNED, min_size=1, max_size=5))
@quick(80)
def test_a_transfer_function_is_that_of_its_equations(num, den):
    num, den = sorted((num, den), key=len)
    plant = plant_of(f"plant p = tf(num={written(num)}, den={written(den)}, delay=0.1 s)\n")
    assert len(plant.states) == len(den) - 1
    for s in POINTS:
        expected = np.polyval(num, s) / np.polyval(den, s)
        np.testing.assert_allclose(response(plant, s), [[expected]], rtol=1e-9)


@given(
    st.lists(st.one_of(SIGNED, st.tuples(SIGNED, SIGNED)), max_size=3),
    st.lists(st.one_of(SIGNED, st.tuples(SIGNED, SIGNED)), min_size=3, max_size=5),
)
@quick(80)
def test_zeros_and_poles_are_those_of_the_cascade(zeros, poles):
    def roots(parts):
        return [r for p in parts for r in ([complex(*p), complex(*p).conjugate()] if isinstance(p, tuple) else [p])]

    if len(roots(zeros)) > len(roots(poles)):
        zeros, poles = poles, zeros
    texts = [written([f"pair{p}" if isinstance(p, tuple) else p for p in parts]) for parts in (zeros, poles)]
    plant = plant_of(f"plant p = zpk(zeros={texts[0]}, poles={texts[1]}, gain=2.5)\n")
    assert len(plant.states) == len(roots(poles))
    for s in POINTS:
        expected = 2.5 * np.prod([s - z for z in roots(zeros)]) / np.prod([s - p for p in roots(poles)])
        np.testing.assert_allclose(response(plant, s), [[expected]], rtol=1e-8)


def test_matrices_are_those_that_are_written():
    text = (
        "param k = 2\nplant p = ss(A=[[0, 1], [-k, -3]], B=[[1, 0], [0.5, 2]], C=[[1, 0], [0, 4]], D=[[0, 0], [0, 7]])"
    )
    a, b, c, d = matrices(plant_of(text))
    np.testing.assert_array_equal(a, [[0, 1], [-2, -3]])
    np.testing.assert_array_equal(b, [[1, 0], [0.5, 2]])
    np.testing.assert_array_equal(c, [[1, 0], [0, 4]])
    np.testing.assert_array_equal(d, [[0, 0], [0, 7]])
    assert [s.name for s in plant_of(text).inputs] == ["u1", "u2"]


@pytest.mark.parametrize("text", ["B=[0, 1], C=[1, 0], D=[3]", "B=[[0], [1]], C=[[1, 0]], D=[[3]]"])
def test_flat_lists_are_columns_and_rows(text):
    text = f"plant p = ss(A=[[0, 1], [-2, -3]], {text})\n"
    _, b, c, d = matrices(plant_of(text))
    assert (b.tolist(), c.tolist(), d.tolist()) == ([[0.0], [1.0]], [[1.0, 0.0]], [[3.0]])


def test_states_are_of_moderate_size_whatever_the_time_scale():
    for scale in (1e-6, 1.0, 1e6):
        plant = plant_of(f"plant p = tf(num=[1], den=[{scale**3}, {3 * scale**2}, {3 * scale}, 1])\n")
        a, b, _, _ = matrices(plant)
        ratios = np.abs(np.column_stack([a, b]))[:, :] * scale
        assert ratios.max() < 20
        steady = np.linalg.solve(a, -b)
        assert np.abs(steady).max() < 1e3


def test_params_change_the_plant():
    plant = plant_of("param T = 2\nplant p = tf(num=[1], den=[T, 1])\n")
    assert [p.name for p in plant.params] == ["T"]
    np.testing.assert_allclose(response(plant, 1j), [[1 / (2j + 1)]])


def test_a_gain_has_no_state():
    plant = plant_of("plant p = tf(num=[3], den=[2])\n")
    assert (plant.states, response(plant, 1j).tolist()) == ((), [[1.5]])


def test_coefficients_have_no_limit_of_their_own():
    order = 200
    rng = np.random.default_rng(order)
    num, den = (rng.uniform(1, 2, n).round(3).tolist() for n in (order, order + 1))
    text = f"plant p = tf(num={written(num)}, den={written(den)})\n"
    plant = plant_of(text)
    expected = np.polyval(num, 0.9j) / np.polyval(den, 0.9j)
    np.testing.assert_allclose(response(plant, 0.9j), [[expected]], rtol=1e-9)
    loop = loads(text + "loop l\nblock b = p(1)\nrun 20 ms step 10 ms\n", block="l")
    run = Experiment(loop, "python").run()
    assert run["b.y"][-1] == pytest.approx(0.02 * num[0] / den[0], rel=0.05)
