"""Derivatives of steps: closed forms, central differences, all backends, shapes, refusals."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, ValueOutOfBoundsError
from tests import sizes
from tests.fuzzyctl.codegen.steps.texts import ADAPTIVE, SURFACE

PI = "controller q\ninput e\nparam K = 2\nparam T = 0.5\nstate s = 0\nnext s = s + dt * e / T\noutput u = K * (e + s)\n"
FUZZY = (
    SURFACE + ADAPTIVE + "controller q\ninput x in [-2, 2]\ninput y in [-2, 2]\nparam g = 0.7\n"
    "let d = derivative(x - y, filter=0.3 s)\nlet m = surface(g * (x - y), 0.1 * d)\n"
    "output u = lowpass(m, 0.2) + gain(x, y)\noutput v = clamp(x * y, -1, 1) + delay(y, 3)\nevery 50 ms\n"
)


def step_of(text, backend="python", **options):
    return fuzzyctl.compile(fuzzyctl.loads(text, block="q"), backend, **options)


def differences(step, inputs, state, **time):
    """Return central differences of outputs and next states, shape (outputs + states, inputs + states)."""
    point, columns = np.concatenate([inputs, state]), []
    for k in range(len(point)):
        ends = []
        for side in (1.0, -1.0):
            moved = point.copy()
            moved[k] += side * 1e-6
            outputs, after = step(*moved[: len(inputs)], moved[len(inputs) :], **time)
            ends.append(np.concatenate([np.atleast_1d(outputs), after]))
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.stack(columns, axis=-1)


def test_is_that_of_the_equations_of_a_pi_controller():
    step = step_of(PI, free=["K", "T"])
    assert step.state_names == ("s", "K", "T")
    outputs, states = step.gradient([0.3], [0.4, 2.0, 0.5], dt=0.1, by="all")
    np.testing.assert_allclose(outputs, [2.0, 2.0, 0.7, 0.0], atol=1e-15)
    np.testing.assert_allclose(states, [[0.2, 1, 0, -0.12], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-15)


@pytest.mark.parametrize("backend", sizes.BACKENDS)
@pytest.mark.parametrize("free", [[], ["g", "surface.u.P.peak"]])
def test_agrees_with_differences(backend, free):
    step = step_of(FUZZY, backend, free=free) if free else step_of(FUZZY, backend)
    rng = np.random.default_rng(5)
    inputs = rng.uniform(-0.9, 0.9, (2, 3, 2))
    states = np.broadcast_to(step.start(), (2, 3, len(step.state_names))).copy()
    for _ in range(3):
        _, states = step.batch(inputs + rng.uniform(-0.05, 0.05, inputs.shape), states)
    outputs, after = step.gradient(inputs, states, by="all")
    assert outputs.shape == (2, 3, 2, 2 + len(step.state_names))
    assert after.shape == (2, 3, len(step.state_names), 2 + len(step.state_names))
    found = np.concatenate([outputs, after], axis=-2)
    for place in np.ndindex(2, 3):
        expected = differences(step, inputs[place], states[place])
        np.testing.assert_allclose(found[place], expected, rtol=1e-6, atol=1e-7)


def test_of_many_steps_are_products():
    """The derivative of the last output by a param, carried along by the chain rule, beside a difference."""
    step, rows = step_of(FUZZY, free=["g"]), np.random.default_rng(2).uniform(-0.9, 0.9, (30, 2))

    def last(g):
        return step.run(rows, step.start(g=g))[0][-1, 0]

    state, by_g = step.start(), np.eye(len(step.state_names))[-1]
    for row in rows:
        outputs, after = step.gradient(row, state, by="all")
        slope, by_g = outputs[0, 2:] @ by_g, after[:, 2:] @ by_g
        _, state = step(*row, state)
    assert slope == pytest.approx((last(0.7 + 1e-6) - last(0.7 - 1e-6)) / 2e-6, rel=1e-5)


@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_where_no_step_is_made_outputs_have_none_and_states_stay(backend):
    step = step_of(PI, backend)
    outputs, after = step.gradient([np.nan], [0.4], dt=0.1, by="all")
    assert np.isnan(outputs).all()
    np.testing.assert_array_equal(after, [[0.0, 1.0]])


def test_refuses_what_it_cannot_take():
    step = step_of(PI)
    with pytest.raises(ArgumentError, match="shape"):
        step.gradient([0.3], [0.4, 1.0], dt=0.1)
    with pytest.raises(ArgumentError, match="'dt' is missing"):
        step.gradient([0.3], [0.4])
    with pytest.raises(ValueOutOfBoundsError):
        step.gradient([0.3], [0.4], dt=0.0)


@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_where_all_triangles_have_their_peak_it_is_that_of_the_surface(backend):
    """At the set point each degree has a kink, and the surface has none."""
    step = step_of(SURFACE + "controller q\ninput e\ninput d\noutput u = surface(2 * e, d)\nevery 1 s\n", backend)
    np.testing.assert_allclose(step.gradient([0.0, 0.0], [])[0], [1.0, 0.5], rtol=1e-15)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_of_operators_with_a_switch_are_the_slopes_ahead(backend):
    """Inside of a hysteresis and a rate limit, at their ends and outside, and of a short delay; no jump lies ahead."""
    lines = "let h = hysteresis(x, -1, 1)\nlet r = rate_limit(x, 2)\nlet d = delay(2 * x, 1)\n"
    step = step_of(f"controller q\ninput x\n{lines}output u = h\noutput v = r\noutput w = d\nevery 1 s\n", backend)
    before = np.array([step(x, step.start())[1] for x in (0.0, 0.25, 1.0)])
    points = np.array([-3.0, -2.0, -0.9, 0.0, 0.25, 1.0, 2.0, 2.25, 3.0, 5.0])
    inputs, states = np.repeat(points, 3), np.tile(before, (len(points), 1))

    def results(inputs, states):
        return np.concatenate(step.batch(inputs, states), axis=-1)

    at = results(inputs, states)
    ahead = [results(inputs + 1e-7, states) - at]
    ahead += [results(inputs, states + 1e-7 * column) - at for column in np.eye(states.shape[1])]
    found = np.concatenate(step.gradient(inputs, states, by="all"), axis=-2)
    started = step.state_names.index("#started") + 1  # which is 0 or 1
    expected = np.delete(np.stack(ahead, axis=-1) / 1e-7, started, axis=-1)
    np.testing.assert_allclose(np.delete(found, started, axis=-1), expected, atol=1e-6)


@pytest.mark.parametrize("backend", ["python", "numpy"])
@pytest.mark.parametrize(
    ("at", "push", "slopes"),
    [
        (0.5, 1.0, [0.0, 0.0]),  # pushed outwards, the consequent stays at its bound
        (-0.5, -1.0, [0.0, 0.0]),
        (0.5, -1.0, [0.4, 1.0]),
        (-0.5, 1.0, [0.4, 1.0]),
        (0.5, 0.0, [0.0, 0.0]),  # ahead lies beyond the upper bound
        (-0.5, 0.0, [0.4, 1.0]),
    ],
)
def test_of_a_consequent_at_its_bound_is_the_slope_ahead(backend, at, push, slopes):
    text = (
        "system gain\ndefuzzifier weighted_average\ninput s in [-2, 2]\n  all = rectangle(-2, 2)\ninput e in [-2, 2]\n"
        "output F in [-0.5, 0.5] adaptive rate 4 * e\n  terms C=0\nif s is all then F is C\n"
        "controller q\ninput s\ninput e\noutput u = gain(s, e)\nevery 100 ms\n"
    )
    _, after = step_of(text, backend).gradient([0.0, push], [at], by="all")
    assert after[0].tolist() == [0.0, *slopes]
