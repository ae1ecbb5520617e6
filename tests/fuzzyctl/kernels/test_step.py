"""Steps of controllers beside plain loops, and the same numbers from every backend."""

import math
import pickle

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, NoRuleFiresError, UnknownNameError, ValueOutOfBoundsError

BACKENDS = ("python", "numpy", "numba")

SURFACE = """
system surface
input e in [-1, 1]
  terms N Z P
output u in [-1, 1]{otherwise}
  terms N@-1 Z@0 P@1
defuzzifier center_average
{rules}
"""
PROPORTIONAL = SURFACE.format(otherwise="", rules="table u = e\n    N Z P\n  | N Z P")
SILENT = SURFACE.format(otherwise=" else error", rules="if e is P then u is P")


def controller(text, name=fuzzyctl.Controller):
    return fuzzyctl.loads(text, block=name)


def outputs_of(law, inputs, backend="python", **options):
    return fuzzyctl.compile(law, backend).run(inputs, **options)[0]


def previous(x, dt):
    return [3.0, *x[:-1]]


def difference(x, dt):
    return [0.0, *np.diff(x)]


def filtered(x, dt):
    found, d = [], 0.0
    for change in difference(x, dt):
        d = (0.5 * d + change) / (0.5 + dt)
        found.append(d)
    return found


def integral(x, dt):
    return [1.0 + dt * sum(x[:k]) for k in range(len(x))]


def held_integral(x, dt):
    found, total = [], 0.0
    for value in x:
        found.append(total)
        total += dt * value if value <= 0.5 else 0.0
    return found


def lowpass(x, dt):
    found = [x[0]]
    for value in x[1:]:
        found.append(found[-1] + dt / (0.5 + dt) * (value - found[-1]))
    return found


def rate_limit(x, dt):
    found = [x[0]]
    for value in x[1:]:
        found.append(min(max(value, found[-1] - 2 * dt), found[-1] + 2 * dt))
    return found


def hysteresis(x, dt):
    found, on = [], 0.0
    for value in x:
        on = 1.0 if value >= 0.3 else 0.0 if value <= -0.3 else on
        found.append(on)
    return found


def delay(x, dt):
    return [7.0, 7.0, 7.0, *x[:-3]]


OPERATORS = {
    "previous(x, start=3)": previous,
    "difference(x)": difference,
    "derivative(x)": lambda x, dt: [d / dt for d in difference(x, dt)],
    "derivative(x, filter=0.5)": filtered,
    "integral(x, start=1)": integral,
    "integral(x, hold = x > 0.5)": held_integral,
    "lowpass(x, 0.5)": lowpass,
    "rate_limit(x, 2)": rate_limit,
    "hysteresis(x, -0.3, 0.3)": hysteresis,
    "delay(x, 3, start=7)": delay,
    "where(x > 0 and not x > 0.5, 1, x)": lambda x, dt: [1.0 if 0 < v <= 0.5 else v for v in x],
    "clamp(x, -0.25, 0.5)": lambda x, dt: [min(max(v, -0.25), 0.5) for v in x],
    "x * 50 % + 500 ms": lambda x, dt: [v / 2 + 0.5 for v in x],
}


class TestOperators:
    @pytest.mark.parametrize("text", OPERATORS)
    def test_each_is_a_plain_loop(self, text):
        x = np.random.default_rng(4).uniform(-1, 1, 50)
        found = outputs_of(controller(f"controller c\ninput x\noutput y = {text}\n"), x, dt=0.01)
        assert found == pytest.approx(OPERATORS[text](list(x), 0.01), rel=1e-13, abs=1e-15)

    def test_each_use_has_a_state_of_its_own(self):
        both = controller("controller c\ninput a\ninput b\noutput u = previous(a)\noutput v = previous(b)\n")
        assert outputs_of(both, [[1, 2], [3, 4]], dt=1.0).tolist() == [[0, 0], [1, 2]]


PID = """
controller pid
input r
input y
param Kp = 2
param Ti = 0.8
param Td = 0.1
let e  = r - y
let u0 = Kp * (e + integral(e, hold = u0 != u) / Ti - Td * derivative(y, filter=20 ms))
output u = clamp(u0, -3, 3)
every 10 ms
"""


def plain_pid(rows):
    total, d, last, found, dt = 0.0, 0.0, None, [], 0.01
    for r, y in rows:
        d = (0.02 * d + (0.0 if last is None else y - last)) / (0.02 + dt)
        u0 = 2 * ((r - y) + total / 0.8 - 0.1 * d)
        u = min(max(u0, -3.0), 3.0)
        total += 0.0 if u0 != u else dt * (r - y)
        last = y
        found.append(u)
    return found


class TestController:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_pid_with_anti_windup_is_the_loop_that_one_writes_by_hand(self, backend):
        rows = np.random.default_rng(7).uniform(-1.5, 1.5, (10_000, 2))
        found = outputs_of(controller(PID), rows, backend)
        assert np.abs(found).max() == 3.0
        assert found == pytest.approx(plain_pid(rows), rel=1e-12, abs=1e-12)

    def test_a_system_is_called_by_position_and_by_name(self):
        text = PROPORTIONAL + "controller c\ninput x\noutput a = surface(x)\noutput b = surface(e = x) * 2\n"
        assert outputs_of(controller(text), [0.3, -0.6], dt=1.0) == pytest.approx(np.array([[0.3, 0.6], [-0.6, -1.2]]))

    def test_several_outputs_of_a_system_have_the_name_of_the_call(self):
        text = PROPORTIONAL + "output w in [0, 1]\n  terms a@0 b@1\nif e is not P then w is a\nif e is P then w is b\n"
        text += "controller c\ninput x\nlet t = surface(x)\noutput a = t.u\noutput b = t.w\n"
        assert outputs_of(controller(text), [1.0, 0.0], dt=1.0).tolist() == [[1.0, 1.0], [0.0, 0.0]]

    def test_blocks_have_states_and_params_of_their_own(self):
        text = (
            "controller inner\ninput x\nparam k = 1\nstate s = 0\nnext s = s + k*x\noutput y = s\n"
            "controller outer\ninput x\nblock a = inner(x)\nblock b = inner(x, k=10)\nblock c = inner(a.y)\n"
            "output u = a.y\noutput v = b.y\noutput w = c.y\n"
        )
        found = outputs_of(controller(text, "outer"), [1.0, 1.0, 1.0], dt=1.0)
        assert found.tolist() == [[0, 0, 0], [1, 10, 0], [2, 20, 1]]

    def test_functions_take_their_arguments_once(self):
        text = "function twice(a) = a + a\ncontroller c\ninput x\noutput y = twice(twice(previous(x, start=1)))\n"
        assert outputs_of(controller(text), [5.0, 0.0], dt=1.0).tolist() == [4.0, 20.0]


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_delays_of_delays_and_states_between_them_are_those_of_python(backend):
    law = controller(
        "controller d\ninput x\nstate s = 1\nnext s = 0.5 * s + delay(y, 7, start=3)\nlet y = delay(x, 6)\n"
        "let z = delay(delay(y, 5), 4)\noutput u = y + 10 * z + previous(z)\noutput v = s\nevery 10 ms\n"
    )
    rows = np.random.default_rng(1).uniform(-1, 1, 60)
    rows[30] = np.nan
    step, expected = fuzzyctl.compile(law, backend), fuzzyctl.compile(law, "python").run(rows)
    for own, other in zip(step.run(rows), expected, strict=True):
        np.testing.assert_array_equal(own, other)
    states = np.tile(expected[1], (3, 1))
    after = step.batch([0.5, np.nan, 1.0], states)[1]
    np.testing.assert_array_equal(after[1:], [expected[1], step(1.0, expected[1])[1]])


class TestStep:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_all_ways_give_the_same_numbers(self, backend):
        step = fuzzyctl.compile(controller(PID), backend)
        rows = np.random.default_rng(3).uniform(-1, 1, (30, 2))
        outputs, last = step.run(rows)
        for turned in (np.asfortranarray(rows), np.hstack([rows, rows])[:, : rows.shape[1]], rows[::-1].copy()[::-1]):
            np.testing.assert_array_equal(step.run(turned)[0], outputs)
        state, copies = step.start(), np.tile(step.start(), (4, 1))
        for row, output in zip(rows, outputs, strict=True):
            one, state = step(*row, state)
            many, copies = step.batch(np.tile(row, (4, 1)), copies)
            assert one == output
            assert many.tolist() == [output] * 4
        assert state.tolist() == last.tolist()

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_nan_gives_nan_and_leaves_the_state(self, backend):
        step = fuzzyctl.compile(controller(PID), backend)
        _, state = step.run([[1.0, 0.5], [1.0, 0.4]])
        output, after = step(math.nan, 0.3, state)
        assert math.isnan(output)
        assert after.tolist() == state.tolist()
        assert math.isnan(step.run([[1.0, math.nan]], state)[0][0])

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_overflow_of_a_state_gives_infinity_without_a_warning(self, backend):
        lines = (
            "controller c\nstate s = 1\nstate z = 0\nnext s = s * 1e200\nnext z = z\noutput y = s - s / z\nevery 1 s\n"
        )
        step = fuzzyctl.compile(controller(lines), backend)
        state = step.start()
        found = []
        for _ in range(4):
            output, state = step(state)
            found.append(output)
        assert found[:2] == [-math.inf, -math.inf]
        assert math.isnan(found[3])
        assert state.tolist() == [math.inf, 0.0]

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_rule_base_with_a_gap_is_an_error_of_the_step(self, backend):
        step = fuzzyctl.compile(controller(SILENT + "controller c\ninput x\noutput y = surface(x)\n"), backend)
        assert step(0.5, step.start(), dt=1.0)[0] == 1.0
        for call in (
            lambda: step(-0.5, step.start(), dt=1.0),
            lambda: step.run([0.5, -0.5], dt=1.0),
            lambda: step.batch([0.5, -0.5], np.empty((2, 0)), dt=1.0),
        ):
            with pytest.raises(NoRuleFiresError, match=r"x = -0\.5"):
                call()

    def test_the_time_is_an_argument_or_a_period(self):
        free = fuzzyctl.compile(controller("controller c\ninput x\noutput y = dt\n"), "python")
        fixed = fuzzyctl.compile(controller(PID), "python")
        assert free(0.0, free.start(), dt=0.25)[0] == 0.25
        assert free.run([0.0, 0.0], dt=[0.25, 0.5])[0].tolist() == [0.25, 0.5]
        assert (free.period, fixed.period) == (None, 0.01)
        with pytest.raises(ArgumentError, match="'dt' is missing"):
            free(0.0, free.start())
        with pytest.raises(ArgumentError, match=r"period of 0\.01 s"):
            fixed(0.0, 0.0, fixed.start(), dt=0.1)
        for dt in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(ValueOutOfBoundsError, match="dt"):
                free(0.0, free.start(), dt=dt)
            with pytest.raises(ValueOutOfBoundsError, match="dt"):
                free.run([0.0, 0.0], dt=[0.1, dt])

    @pytest.mark.parametrize("backend", ["python", "numba"])
    def test_times_broadcast_with_points_and_states(self, backend):
        text = "controller c\ninput x\noutput y = s + dt * x\nstate s = 1\nnext s = s + dt\n"
        step, times = fuzzyctl.compile(controller(text), backend), [0.25, 0.5, 1.0]
        outputs, states = step.batch([2.0], [[1.0], [2.0], [3.0]], dt=times)
        assert outputs.tolist() == [1.5, 3.0, 5.0]
        assert states.tolist() == [[1.25], [2.5], [4.0]]
        assert step.batch([[2.0]], dt=times)[0].tolist() == [1.5, 2.0, 3.0]
        assert step.batch([[2.0], [4.0]], dt=np.ones((3, 1)))[0].tolist() == [[3.0, 5.0]] * 3
        for run in (step.batch, step.run):
            with pytest.raises(ArgumentError, match="'dt'"):
                run([[2.0], [4.0]], dt=times)
        for dt in ([times], np.ones((3, 1))):
            with pytest.raises(ArgumentError, match=r"'dt' must be one number or have the shape \(1,\)"):
                step.run([[2.0]], dt=dt)

    def test_the_callers_arrays_stay_as_they_are(self):
        step = fuzzyctl.compile(controller(PID), "numba")
        state = step.start()
        state.flags.writeable = False
        step(0.3, 0.2, state)
        step.run([[0.3, 0.2]] * 5, state)
        assert state.tolist() == step.start().tolist()

    def test_arguments_may_be_given_by_their_names(self):
        step = fuzzyctl.compile(controller(PID), "python")
        e, y = step.input_names
        by_position = step(0.3, 0.2, step.start())
        by_name = step(0.3, **{y: 0.2, "state": step.start()})
        assert by_name[0] == by_position[0]
        assert by_name[1].tolist() == by_position[1].tolist()
        with pytest.raises(UnknownNameError, match="no input 'q'"):
            step(0.3, 0.2, step.start(), q=1)
        with pytest.raises(ArgumentError, match="a value is missing for: state"):
            step(**{e: 0.3, y: 0.2})

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_step_that_was_used_can_be_sent_to_another_process(self, backend):
        step = fuzzyctl.compile(controller(PID), backend, free=["Kp"])
        used = step(0.3, 0.2, step.start(Kp=2))
        step.run([[0.3, 0.2]] * 5)
        step.gradient([0.3, 0.2], step.start())
        copy = pickle.loads(pickle.dumps(step))
        again = copy(0.3, 0.2, copy.start(Kp=2))
        assert (again[0], again[1].tolist()) == (used[0], used[1].tolist())


@pytest.mark.parametrize("backend", BACKENDS)
class TestPromisesOfSystems:
    """A system without `else` promises that some rule fires, in a controller as alone."""

    TEXT = (
        "system gap\ndefuzzifier weighted_average\ninput x in [0, 4]\n  low = triangle(-inf, 0, 1)\n"
        "  high = triangle(3, 4, inf)\noutput y in [0, 1] {}\n  terms no=0 yes=1\nif x is low then y is no\n"
        "if x is high then y is yes\n"
        "controller c\ninput x in [0, 4]\nstate s = 0\nnext s = s + 1\noutput u = gap(x + 2 * s) + 1\nevery 1 s\n"
    )

    def compiled(self, otherwise, backend):
        return fuzzyctl.compile(controller(self.TEXT.format(otherwise)), backend)

    def test_a_broken_one_is_an_error_in_each_form_of_a_call(self, backend):
        step = self.compiled("", backend)
        for call in (
            lambda: step(2.0, [0.0]),
            lambda: step.batch([0.0, 2.0], [[0.0], [0.0]]),
            lambda: step.run([0.0, math.nan, 0.0]),  # at the third step the system is called with 2
        ):
            with pytest.raises(NoRuleFiresError, match="no rule fires for output 'y'"):
                call()
        assert step(0.0, [0.0])[0] == 1.0
        assert np.isnan(step.run([0.0, math.nan])[0]).tolist() == [False, True]

    def test_a_nan_that_the_file_declares_is_a_value(self, backend):
        step = self.compiled("else nan", backend)
        assert math.isnan(step(2.0, [0.0])[0])
        assert np.isnan(step.run([0.0, 0.0])[0]).tolist() == [False, True]
        assert pickle.loads(pickle.dumps(step)).run([0.0])[0].tolist() == [1.0]
