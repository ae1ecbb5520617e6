"""Validated steps hold the exact solutions, from every start and at every time, and worst disturbances."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fuzzyctl.analysis.reach.flow import Flow, NoTubeError
from fuzzyctl.analysis.reach.forms import DomainError, ends
from fuzzyctl.analysis.reach.series import Nodes
from fuzzyctl.analysis.reach.slopes import Slopes
from tests.fuzzyctl.analysis.reach.exact import arb, at, expression, holds

MILLI = Fraction(1, 1000)


def flow(*derivatives, disturbances=(), constants=()):
    """Return the flow of states x0, x1, ...; disturbances w0, w1, ... have given half widths."""
    states = [f"x{k}" for k in range(len(derivatives))]
    acting = [f"w{k}" for k in range(len(disturbances))]
    nodes = Nodes(["t", *states, *constants, *acting], [], [expression(d) for d in derivatives])
    influence = Slopes(nodes, [*states, *acting]) if disturbances else None
    return Flow(nodes, len(states), influence, list(disturbances))


def width(form):
    """Return the width of the first box."""
    low, high = ends(form)
    return high[0] - low[0]


def over_at(form, symbols, share):
    """Return the symbols of a form over a step at a share of it."""
    return [*symbols, *[0] * (form.shape[-1] - 3 - len(symbols)), 2 * Fraction(share) - 1]


#: Derivative, exact solution after a time from a start at a time.
KNOWN = {
    "decay": ("-2 * x0", lambda x, t, _: x * (-2 * t).exp()),
    "square": ("x0 ** 2", lambda x, t, _: x / (1 - x * t)),
    "root": ("1 / (2 * x0)", lambda x, t, _: (x * x + t).sqrt()),
    "time": ("cos(t) + t ** 3", lambda x, t, s: x + (s + t).sin() - s.sin() + ((s + t) ** 4 - s**4) / 4),
    "growth": ("x0 * t", lambda x, t, s: x * (((s + t) ** 2 - s**2) / 2).exp()),
    "thirds": ("1 / 3 + 0.1", lambda x, t, _: x + t * (arb(Fraction(1, 3)) + arb(Fraction(0.1)))),
    "seventh": ("-3 * x0 ** 7", lambda x, t, _: x / (1 + 18 * t * x**6) ** (arb(1) / 6)),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("start", [[[0.7, 0.0, 0.05], [0.9, 0.02, 0.0]], [[0.8, 0.0, 0.0], [0.8, 1e-9, 1e-9]]])
@pytest.mark.parametrize("begin", [0.0, 1.7])
def test_steps_hold_exact_solutions(name, start, begin):
    derivative, exact = KNOWN[name]
    x, step = np.array(start), 0.015625
    (end,), (over,) = flow(derivative).advance(begin, step, [x], [])
    (tube,), _ = flow(derivative).tube(begin, step, [x], [])
    for box, e, own in itertools.product((0, 1), (-1, 1, Fraction(1, 3)), (-1, 1)):
        place = arb(at(x, [e], own, box))
        assert holds(end, [e], exact(place, arb(Fraction(step)), arb(Fraction(begin))), box)
        for share in (Fraction(0), MILLI, Fraction(1, 2), Fraction(7, 8), Fraction(1)):
            value = exact(place, arb(Fraction(step) * share), arb(Fraction(begin)))
            assert holds(over, over_at(over, [e], share), value, box)
            assert holds(tube, [], value, box)
    assert width(end) <= 1.5 * width(x) + 1e-5  # and not everything


def test_many_steps_turn_an_oscillator():
    """The set turns with the solution: its symbols stay those of the start."""
    turning, x = flow("x1", "-x0"), [np.array([[1.0, 0.0, 0.1, 0.0]]), np.array([[0.0, 0.0, 0.0, 0.1]])]
    step = 0.125
    for k in range(50):
        x, _ = turning.advance(k * step, step, x, [])
        angle = arb(Fraction(step) * (k + 1))
        for e in itertools.product((-1, 1), repeat=2):
            p, v = arb(1 + Fraction(0.1) * e[0]), arb(Fraction(0.1) * e[1])
            assert holds(x[0], e, p * angle.cos() + v * angle.sin())
            assert holds(x[1], e, v * angle.cos() - p * angle.sin())
    assert ends(x[0])[1][0] - ends(x[0])[0][0] < 0.3


#: Derivatives that jump or bend within a step, and the end of a solution from 0 after 0.25 s.
BENT = {
    "stops at a wall": (["where(x0 >= 0.1, 0, 1)"], [0.1]),
    "turns at a relay of another state": (["where(x1 >= 0.125, 2, 1)", "1"], [0.375, 0.25]),
    "integral of |x| below 0": (["-1", "abs(x0)"], [-0.25, 0.03125]),
    "integral of |x| above 0": (["1", "abs(x0)"], [0.25, 0.03125]),
    "integral of max(x, 0.125)": (["1", "max(x0, 0.125)"], [0.25, 0.0390625]),
    "integral of min(-x, 0)": (["-1", "min(-x0, 0)"], [-0.25, 0.0]),
    "floor": (["1", "floor(8 * x0)"], [0.25, 0.125]),
    "sign": (["1", "sign(x0 - 0.125)"], [0.25, 0.0]),
    "jump of time": (["where(t >= 0.125, 8, 0)"], [1.0]),
    "jump of time at the end": (["where(t >= 0.25, 8, 0)"], [0.0]),
    "jump of time at the begin": (["where(t > 0, 8, 0)"], [2.0]),
    "bend of time": (["max(t - 0.125, 0)"], [0.0078125]),
    "last entry": (["last_entry(t, -1, 0, 0.125, 8)"], [1.0]),
    "last entry at the end": (["last_entry(t, -1, 0, 0.25, 8)"], [0.0]),
}


@pytest.mark.parametrize("name", BENT)
@pytest.mark.parametrize("parts", [1, 2, 7])
def test_jumps_and_bends_are_held(name, parts):
    derivatives, exact = BENT[name]
    bent, x = flow(*derivatives), [np.array([[0.0, 0.0]]) for _ in derivatives]
    step = 0.25 / parts
    for k in range(parts):
        x, _ = bent.advance(k * step, step, x, [])
    for form, value in zip(x, exact, strict=True):
        low, high = ends(form)
        slack = 0.0 if parts < 7 else 1e-15  # sevenths of a step round
        assert low[0] - slack <= value <= high[0] + slack


def test_a_signal_that_jumps_at_a_sample_has_one_value_over_each_step():
    (end,), _ = flow("where(t >= 0.3, 8, 0)").advance(3 * 0.1, 0.1, [np.array([[0.0, 0.0]])], [])
    assert ends(end)[1][0] < 0.8 + 1e-6
    (end,), _ = flow("where(t >= 0.3, 8, 0)").advance(2 * 0.1, 0.1, [np.array([[0.0, 0.0]])], [])
    assert ends(end)[1][0] < 1e-6


def test_growth_without_limit_is_refused():
    with pytest.raises(NoTubeError):
        flow("x0 ** 2").advance(0.0, 1.0, [np.array([[1.0, 0.0]])], [])  # infinite after 1 s
    with pytest.raises(NoTubeError):
        flow("exp(exp(x0))").advance(0.0, 1.0, [np.array([[7.0, 0.0]])], [])
    with pytest.raises(DomainError):
        flow("sqrt(x0)").advance(0.0, 0.1, [np.array([[0.0, 0.0]])], [])  # from 0 it may begin to move at any time


#: Derivatives with disturbances, half the widths, and a worst one as a function of time and states.
WORST = {
    "integrator": (["w0"], [0.5], lambda _t, _x: [0.5]),
    "unstable": (["3 * x0 + w0"], [0.5], lambda _t, _x: [0.5]),
    "bilinear": (["-x0 + x0 * w0"], [0.5], lambda _t, _x: [0.5]),
    "oscillator": (["x1", "-4 * x0 + w0"], [0.25], lambda t, _x: [0.25 * np.sign(math.cos(2 * (0.25 - t)))]),
    "two": (["x1 * x1 + w0", "sin(x0) + w1"], [0.1, 0.2], lambda _t, _x: [0.1, 0.2]),
    "through a chain": (["x1", "x2", "w0"], [1.0], lambda _t, _x: [1.0]),
    "with a bend": (["abs(x0 - 1) + w0"], [0.5], lambda _t, _x: [0.5]),
}


@pytest.mark.parametrize("name", WORST)
@pytest.mark.parametrize("sign", [-1, 1])
def test_worst_disturbances_are_held(name, sign):
    derivatives, widths, worst = WORST[name]
    disturbed, starts = flow(*derivatives, disturbances=widths), [0.875, 0.5, -0.25][: len(derivatives)]
    x = [np.array([[s, 0.0]]) for s in starts]
    names = [f"x{k}" for k in range(len(starts))]
    codes = [compile(d, "d", "eval") for d in derivatives]

    def rates(t, state):
        values = dict(zip(names, state, strict=True)) | {f"w{k}": sign * w for k, w in enumerate(worst(t, state))}
        return [eval(c, {"sin": math.sin, "abs": abs}, values) for c in codes]

    for k in range(8):
        x, _ = disturbed.advance(k / 32, 1 / 32, x, [0.0] * len(widths))
        solution = solve_ivp(rates, (0, (k + 1) / 32), starts, method="DOP853", rtol=1e-12, atol=1e-14)
        for form, value in zip(x, solution.y[:, -1], strict=True):
            low, high = ends(form)
            assert low[0] - 1e-10 <= value <= high[0] + 1e-10
    assert all(ends(form)[1][0] - ends(form)[0][0] < 3 * sum(widths) for form in x)


def test_a_jump_beside_a_disturbance_is_refused():
    with pytest.raises(DomainError, match="choice"):
        flow("where(x0 > 0, 1, 2) + w0", disturbances=[0.1]).advance(0.0, 0.1, [np.array([[-0.05, 0.0]])], [0.0])


def test_solutions_agree_with_a_precise_solver():
    """A pendulum on a cart, over one hundred steps and two boxes."""
    derivatives = [
        "x1",
        "(9.81 * sin(x0) - cos(x0) * (u + 0.05 * x1 ** 2 * sin(x0)) / 1.1) / (2 / 3 - cos(x0) ** 2 / 22)",
    ]
    falling = flow(*derivatives, constants=["u"])
    x = [np.array([[0.1, 0.0, 0.01, 0.0], [-2.0, 0.0, 0.01, 0.0]]), np.array([[0.0, 0.0, 0.0, 0.1]] * 2)]

    def rates(_, y):
        s, c = math.sin(y[0]), math.cos(y[0])
        return [y[1], (9.81 * s - c * (3.0 + 0.05 * y[1] ** 2 * s) / 1.1) / (2 / 3 - c**2 / 22)]

    places = [(box, e) for box in (0, 1) for e in itertools.product((-1, 1), repeat=2)]
    times = np.arange(1, 31) / 50
    runs = {
        (box, e): solve_ivp(rates, (0, times[-1]), [float(at(v, e, 0, box)) for v in x], method="DOP853", rtol=1e-12,
                            atol=1e-13, t_eval=times).y
        for box, e in places
    }  # fmt: skip
    for k in range(len(times)):
        x, _ = falling.advance(k / 50, 1 / 50, x, [3.0])
        for (box, e), run in runs.items():
            for form, value in zip(x, run[:, k], strict=True):
                middle = at(form, e, 0, box)
                assert abs(Fraction(value) - middle) <= Fraction(float(form[box, 1])) + Fraction(1, 10**9)
