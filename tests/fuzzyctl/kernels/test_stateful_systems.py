"""Systems with states inside controllers: the numbers of their own kernels, driven step by step."""

import math

import numpy as np
import pytest

import fuzzyctl

BACKENDS = ("python", "numpy", "numba")

ADAPTIVE = """
system gain
defuzzifier weighted_average
param gamma = 40
input sigma in [-0.4, 0.4]
  terms N Z P
input e in [-1, 1]
output F in [-0.5, 0.5] adaptive rate gamma * sigma + e
  terms N=-0.1 Z=0 P=0.1
table F = sigma
     N Z P
   | N Z P
"""
HOLDING = """
system pump
defuzzifier weighted_average
input level in [0, 10]
  low  = triangle(-inf, 1, 4)
  high = triangle(6, 9, inf)
output on in [0, 1] else hold(0)
  terms no=0 yes=1
output speed in [0, 5] else hold
  terms slow=1 fast=4
if level is low then on is yes, speed is fast
if level is high then on is no, speed is slow
"""


def controller(text):
    """Load a controller, and its first system, from a text."""
    return fuzzyctl.loads(text, block=fuzzyctl.Controller), fuzzyctl.loads(text, block=fuzzyctl.FuzzySystem)


def adapted(system, points, dt):
    """Return the outputs of an adaptive system whose consequents are integrated by hand, and the last of these."""
    kernel = fuzzyctl.compile(system, "python")
    output = system.outputs[0]
    low, high = system.number(output.lower), system.number(output.upper)
    state, found = list(kernel.start()), []
    for point in points:
        found.append(kernel(*point, state))
        rates = [0.0] * len(state)
        kernel.jit_rates(*point, state, rates)
        if not math.isnan(rates[0]):
            state = [min(max(c + dt * r, low), high) for c, r in zip(state, rates, strict=True)]
    return found, state


class TestAdaptive:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_consequents_move_as_those_of_the_kernel(self, backend):
        text = ADAPTIVE + "controller c\ninput s\ninput e\nlet law = gain(s, e)\noutput u = 2 * law\nevery 5 ms\n"
        law, system = controller(text)
        step = fuzzyctl.compile(law, backend)
        assert step.state_names == ("law.F[1]", "law.F[2]", "law.F[3]")
        assert step.start().tolist() == [-0.1, 0.0, 0.1]
        points = np.random.default_rng(5).uniform([-0.9, -0.7], [1.1, 1.3], (2000, 2))
        found, state = step.run(points)
        expected, last = adapted(system, points.tolist(), 0.005)
        np.testing.assert_allclose(found, 2 * np.array(expected), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(state, last, rtol=1e-12, atol=1e-12)
        assert max(abs(state)) == 0.5  # some consequent has reached the end of its range

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_copies_side_by_side_have_states_of_their_own(self, backend):
        text = ADAPTIVE + "controller c\ninput s\ninput e\noutput u = gain(s, e)\n"
        law, system = controller(text)
        step = fuzzyctl.compile(law, backend)
        points = np.random.default_rng(6).uniform(-0.4, 0.4, (40, 3, 2))
        states, outputs = np.tile(step.start(), (3, 1)), []
        for row in points:
            output, states = step.batch(row, states, dt=0.01)
            outputs.append(output)
        for k in range(3):
            expected, last = adapted(system, points[:, k].tolist(), 0.01)
            np.testing.assert_allclose(np.array(outputs)[:, k], expected, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(states[k], last, rtol=1e-12, atol=1e-12)

    def test_each_call_is_an_instance_and_equal_calls_are_one(self):
        text = ADAPTIVE + (
            "controller c\ninput s\ninput e\nstate first = 0\nnext first = s\n"
            "let a = gain(s, e)\nlet b = gain(e, s, gamma=1)\noutput u = a + b + gain(s, e)\nevery 10 ms\n"
        )
        law, system = controller(text)
        step = fuzzyctl.compile(law, "python")
        assert step.state_names == ("first", *(f"{x}.F[{k}]" for x in "ab" for k in (1, 2, 3)))
        points = np.random.default_rng(2).uniform(-0.4, 0.4, (50, 2))
        one, _ = adapted(system, points.tolist(), 0.01)
        other, _ = adapted(system.with_params(gamma=1.0), points[:, ::-1].tolist(), 0.01)
        np.testing.assert_allclose(step.run(points)[0], 2 * np.array(one) + np.array(other), rtol=1e-12, atol=1e-12)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_an_argument_without_a_value_leaves_the_consequents(self, backend):
        text = ADAPTIVE + "controller c\ninput s\ninput e\noutput u = gain(s / e, e)\nevery 10 ms\n"
        step = fuzzyctl.compile(controller(text)[0], backend)
        _, state = step.run([[0.1, 0.5]])
        output, after = step(0.0, 0.0, state)
        assert math.isnan(output)
        assert after.tolist() == state.tolist()


class TestHolding:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_an_output_holds_as_that_of_the_kernel(self, backend):
        text = HOLDING + (
            "controller c\ninput level\nlet p = pump(level)\noutput on = p.on\noutput speed = p.speed\nevery 1 s\n"
        )
        law, system = controller(text)
        step = fuzzyctl.compile(law, backend)
        assert step.state_names == ("p.on", "p.speed")
        assert step.start().tolist() == [0.0, 2.5]
        levels = np.random.default_rng(1).uniform(0, 10, 300)
        expected = fuzzyctl.compile(system, "python").run(levels)[0]
        found, state = step.run(levels)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
        assert state.tolist() == found[-1].tolist()

    def test_a_value_that_is_held_is_no_algebraic_loop(self):
        text = HOLDING + "controller c\ninput x\nlet p = pump(x + previous(on))\noutput on = p.on\nevery 1 s\n"
        assert fuzzyctl.compile(controller(text)[0], "python").run([1.0, 4.5])[0].tolist() == [1.0, 1.0]

    def test_without_a_period_it_needs_no_time(self):
        law, _ = controller(HOLDING + "controller c\ninput x\nlet p = pump(x)\noutput on = p.on\n")
        assert fuzzyctl.compile(law, "python").run([0.5, 5.0, 9.0, 5.0])[0].tolist() == [1.0, 1.0, 0.0, 0.0]
