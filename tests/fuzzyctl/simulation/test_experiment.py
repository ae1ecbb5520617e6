"""Runs of loops beside plain Python, exact solutions and adaptive solvers."""

import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError, Experiment, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.simulation.simulate import solved
from fuzzyctl.testing import check_text

#: Both run one text: in the test line numba runs some loops, and those of tests/properties/test_loops.py.
BACKENDS = ("python", pytest.param("numba", marks=pytest.mark.long))

#: Params that stand before the first block reach systems, controllers inside others, plants and measures.
SHARED = """
param k = 2
param T = 0.01
param q = 2 * k

system gain
defuzzifier weighted_average
input y in [-9, 9]
  terms N P
output u in [-99, 99]
  terms low=(-9*k) high=(9*k)
table u = y
     N    P
  |  low  high

controller part
input y
output u = -gain(y)
every T

controller law
input y
block part = part(y)
output u = part.u - q
every T

plant p
input u
state x = 2
der x = u + q
output y = x

loop l
block law = law(p.y)
block p   = p(law.u)
measure twice   = k + q
measure largest = maximum(abs(law.u))
measure last    = final(p.y)
run 1 s step 10 ms
"""
PI = """
controller pi_law
input r
input y
param Kp = 3
param Ti = 1
let e  = r - y
let u0 = Kp * (e + integral(e, hold = u0 != v) / Ti)
output v in [0, 10] = clamp(u0, 0, 10)
every 10 ms
"""
TANK = """
plant tank
input v
param a = 2
state h in [0, inf) unit "m" = 0.5
der h = (5 * v - a * sqrt(max(h, 0))) / 20
output y = h
"""
FILL = (
    PI
    + TANK
    + """
loop fill
block law  = pi_law(r = reference, y = level)
block tank = tank(v = law.v - leak)
let reference = steps(0: 1.0, 2.5 s: 0.5)
let leak      = pulse(1 s, 1.2 s) * 1.0
let level     = tank.y + noise(sigma = 0.002, seed = 1)
measure iae = iae(tank.y, reference)
run 5 s step 10 ms
"""
)
#: A plant that is driven by a signal of time alone.
DRIVEN = "plant p\n{plant}\nloop l\nblock p = p({signal})\nrun {run}\n"


def driven(plant, signal, run):
    return DRIVEN.format(plant=plant, signal=signal, run=run)


LAG = "input u\nparam T = 0.5\nstate x = 0\nder x = (u - x) / T\noutput y = x"
LAG_PLANT = f"plant p\n{LAG}\n"
PURE = "input u\nstate x = 0\nder x = delay(u, {time})\noutput y = x"

PLANTS = {
    "oscillator": "input u\nstate x = 1\nstate v = 0\nder x = v\nder v = -4*x - 0.3*v + u\noutput y = x",
    "van der Pol": "input u\nstate x = 1\nstate v = 0\nder x = v\nder v = (1 - x^2)*v - x + u\noutput y = x",
    "pendulum": "input u\nstate a = 0.5\nstate w = 0\nder a = w\nder w = -9.81*sin(a) - 0.1*w + u\noutput y = a",
    "tank": "input u\nstate h in [0, inf) = 1\nder h = 0.5 + 0.2*u - 0.4*sqrt(max(h, 0))\noutput y = h",
    "prey": "input u\nstate a = 2\nstate b = 1\nder a = a - a*b\nder b = a*b - b + 0.01*u\noutput y = a",
}


def by_hand(samples):
    """Return level, valve and next of FILL as one would write it."""
    h, total, dt = 0.5, 0.0, 0.01
    noise = 0.002 * np.random.Generator(np.random.PCG64(1)).standard_normal(samples)
    found = []
    for k in range(samples):
        t = k * dt
        e = (1.0 if t < 2.5 else 0.5) - (h + noise[k])
        u0 = 3 * (e + total)
        v = min(max(u0, 0.0), 10.0)
        found.append((h, v))
        total += 0.0 if u0 != v else dt * e

        def rate(h, t=t, v=v):
            leak = 1.0 if 0.995 < t < 1.195 else 0.0
            return (5 * (v - leak) - 2 * math.sqrt(max(h, 0.0))) / 20

        a = rate(h)
        b = rate(h + dt / 2 * a)
        c = rate(h + dt / 2 * b)
        h += dt / 6 * (a + 2 * b + 2 * c + rate(h + dt * c))
    return np.array(found)


def long(value):
    return pytest.param(value, marks=pytest.mark.long)


class TestRun:
    @pytest.mark.parametrize("backend", ["python", "numba"])
    def test_it_is_the_loop_that_one_writes_by_hand(self, loop, backend):
        run = Experiment(loop(FILL), backend).run()
        assert run.t.tolist() == (np.arange(501) * 0.01).tolist()
        assert np.column_stack([run["tank.h"], run["law.v"]]) == pytest.approx(by_hand(501), rel=1e-12, abs=1e-13)

    def test_lets_inputs_states_and_outputs_are_recorded(self, loop):
        run = Experiment(loop(FILL), "python").run()
        assert run.names == (*("reference", "leak", "level", "law.r", "law.y", "law.v", "tank.v", "tank.h", "tank.y"),)
        assert run["law.r"].tolist() == run["reference"].tolist()
        assert list(run) == list(run.names)
        assert len(run) == 501
        with pytest.raises(UnknownNameError, match=r"tank\.z"):
            run["tank.z"]

    def test_the_same_seed_gives_the_same_run_and_another_one_another(self, loop):
        first, again = (Experiment(loop(FILL), "python").run()["level"] for _ in range(2))
        other = Experiment(loop(FILL.replace("seed = 1", "seed = 2")), "python").run()["level"]
        assert first.tolist() == again.tolist()
        assert first.tolist() != other.tolist()

    @pytest.mark.parametrize("name", ["water_tank", pytest.param("pendulum", marks=pytest.mark.long)])
    def test_shipped_loops_run_the_same_on_both_backends_and_meet_their_requirements(self, name):
        loop = fuzzyctl.load(name, block=fuzzyctl.Loop)
        one, other = (Experiment(loop, backend).run() for backend in ("python", "numba"))
        assert one.passed
        assert one.record == pytest.approx(other.record, rel=1e-9, abs=1e-9)

    def test_a_run_in_parts_is_the_run_in_one(self, loop, monkeypatch):
        whole = Experiment(loop(FILL), "numba").run(substeps=2)
        monkeypatch.setattr("fuzzyctl.simulation.experiment.CHUNK", 14)
        seen = []
        parts = Experiment(loop(FILL), "numba").run(substeps=2, progress=lambda done, all_: seen.append((done, all_)))
        assert parts.record.tolist() == whole.record.tolist()
        assert seen[0] == (7, 501)
        assert seen[-1] == (501, 501)

    def test_what_was_done_before_an_interruption_is_kept(self, loop):
        def interrupt(done, _all):
            if done >= 1000:
                raise KeyboardInterrupt

        run = Experiment(loop(FILL.replace("run 5 s", "run 50 s")), "python").run(progress=interrupt)
        assert len(run) == 1000
        assert (run.stopped.code, run.stopped.message) == ("FZ707", "the run was interrupted at t = 10 s")
        assert not run.passed
        assert run.measures["iae"] == pytest.approx(
            Experiment(loop(FILL.replace("run 5 s", "run 9.99 s"))).run().measures["iae"]
        )

    @pytest.mark.parametrize(("samples", "backend"), [(3, "numba"), (400, "python")])
    def test_what_numba_would_take_long_over_is_left_to_python(self, loop, samples, backend):
        text = f"controller c\ninput x\noutput u = delay(x, {samples})\nevery 1 s\nloop l\nblock c = c(t)\nrun 900 s\n"
        experiment = Experiment(loop(text))
        assert experiment.backend == backend
        assert experiment.run()["c.u"][-1] == 900 - samples


class TestIntegration:
    def test_halving_the_step_divides_the_error_by_sixteen(self, loop):
        text = driven("input u\nstate x = 1\nder x = -x * cos(t) + u\noutput y = x", "sine(0.5)", "2 s step 100 ms")
        experiment = Experiment(loop(text), "python")
        exact = solved(experiment, "DOP853", relative=1e-12, absolute=1e-13)["p.x"]
        errors = [np.abs(experiment.run(substeps=n)["p.x"] - exact).max() for n in (1, 2, 4)]
        assert errors[0] / errors[1] == pytest.approx(16, rel=0.2)
        assert errors[1] / errors[2] == pytest.approx(16, rel=0.2)

    @pytest.mark.parametrize("name", [n if n in ("van der Pol", "tank") else long(n) for n in PLANTS])
    def test_dop853_at_tight_tolerances_is_the_referee(self, loop, name):
        text = PI.replace("[0, 10]", "[-10, 10]").replace("clamp(u0, 0, 10)", "clamp(u0, -10, 10)")
        text += f"plant p\n{PLANTS[name]}\nloop l\nblock law = pi_law(r, p.y)\nblock p = p(law.v + d)\n"
        text += "let r = steps(0: 0.5, 2: 0.8)\nlet d = 0.2 * sine(1.5)\nrun 5 s step 10 ms\n"
        experiment = Experiment(loop(text), "numba")
        referee = solved(experiment, "DOP853", relative=1e-10, absolute=1e-12)
        assert experiment.run(substeps=4).record == pytest.approx(referee.record, abs=2e-9, rel=2e-9)

    def test_a_jump_at_a_sample_acts_from_there_on_and_not_before(self, loop):
        text = driven(
            "input u\nstate x = 0\nder x = u\noutput y = x", "steps(0: 0, 0.3 s: 1, 0.7 s: -1)", "1 s step 0.1 s"
        )
        x = Experiment(loop(text), "python").run()["p.x"]
        assert x == pytest.approx([0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.3, 0.2, 0.1], abs=1e-14)

    def test_a_disturbance_of_time_is_integrated_between_samples(self, loop):
        text = driven("input u\nstate x = 0\nder x = u\noutput y = x", "t^3", "1 s step 0.5 s")
        assert Experiment(loop(text), "python").run()["p.x"] == pytest.approx([0, 1 / 64, 1 / 4], rel=1e-14)

    def test_the_output_of_a_controller_is_held(self, loop):
        text = (
            "controller c\ninput x\noutput u = x\nevery 0.5 s\nplant p\ninput u\nstate x = 0\nder x = u\noutput y = x\n"
        )
        text += "loop l\nblock c = c(t)\nblock p = p(c.u)\nrun 2 s\n"
        assert Experiment(loop(text), "python").run()["p.x"] == pytest.approx([0, 0, 0.25, 0.75, 1.5])


#: Two periods whose greatest common divisor is neither.
SLOW = "controller slow\ninput x\nstate n = 0\nnext n = n + 1\noutput u = n + 0 * x\nevery 20 ms\n"
SLOWER = SLOW + SLOW.replace("slow", "slower").replace("20 ms", "30 ms")
SLOWER += "loop l\nblock a = slow(t)\nblock b = slower(t)\nrun 1 s\n"


class TestSampleTimes:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_slow_controller_runs_every_other_sample(self, loop, backend):
        text = f"{SLOW}controller fast\ninput x\noutput y = x\nevery 10 ms\n"
        text += "loop l\nblock slow = slow(t)\nblock fast = fast(slow.u)\nrun 50 ms\n"
        run = Experiment(loop(text), backend).run()
        assert run["slow.u"].tolist() == [0, 0, 1, 1, 2, 2]
        assert run["fast.y"].tolist() == [0, 0, 1, 1, 2, 2]

    def test_time_since_the_step_before_is_that_of_the_controller(self, loop):
        text = "controller a\ninput x\noutput d = derivative(x)\nevery 20 ms\ncontroller b\ninput x\noutput d = dt\n"
        text += "loop l\nblock a = a(t)\nblock b = b(t)\nrun 80 ms step 10 ms\n"
        run = Experiment(loop(text), "python").run()
        assert run["a.d"] == pytest.approx([0, 0, *[1] * 7])
        assert set(run["b.d"]) == {0.01}

    def test_a_held_system_keeps_its_state(self, loop):
        rule = "system s\ninput e in [0, 1]\n  L = ramp(0.5, 0)\n  H = ramp(0.5, 1)\noutput u in [0, 1] else hold\n"
        rule += "  terms lo@0 hi@1\ndefuzzifier center_average\nif e is H then u is hi\n"
        text = f"{rule}controller c\ninput x\noutput u = s(x)\nevery 1 s\nloop l\nblock c = c(x)\n"
        text += "let x = steps(0: 0, 2 s: 0.8, 3 s: 0)\nrun 4 s\n"
        for backend in ("python", "numba"):
            assert Experiment(loop(text), backend).run()["c.u"].tolist() == [0.5, 0.5, 1, 1, 1]

    @pytest.mark.parametrize(
        ("window", "taken"),
        [
            ("begin=20 s", "from 20 s on"),
            ("begin=1 s", "from 1 s on"),
            ("begin=1.5 ms, end=8 ms", "from 0.0015 s to 0.008 s"),
        ],
    )
    def test_a_measure_without_samples_is_warned_of_with_the_times_that_exist(self, window, taken):
        text = f"{LAG_PLANT}loop l\nblock p = p(1)\nmeasure m = maximum(p.y, {window})\nrun 1 s step 10 ms\n"
        _, found = check_text(text)
        message = "measure 'm' has no value: it takes two samples or more"
        facts = (f"maximum(...) takes those {taken}", "the run has samples from 0 s to 1 s, one each 0.01 s")
        assert [(d.code, d.severity, d.message, d.facts) for d in found] == [("FZ214", "warning", message, facts)]

    @pytest.mark.parametrize(
        ("text", "code", "words"),
        [
            (
                f"{SLOW}loop l\nblock slow = slow(t)\nrun 1 s step 15 ms\n",
                "FZ702",
                "block 'slow' runs every 0.02 s, which is not a multiple of the step of 0.015 s",
            ),
            (driven(LAG, "1", "1 s"), "FZ702", "has no sample time"),
            (SLOWER, "FZ702", "step 0.01 s"),
            (
                f"{LAG_PLANT}loop l\nblock p = p(t)\n" + "let a{0} = t\n" * 30 + "run 9e6 s step 1 s\n",
                "FZ703",
                "records 297,000,033 numbers",
            ),
            (
                f"{LAG_PLANT}loop l\nblock p = p(t)\n"
                + "measure m{0} = final({0} * p.y)\n" * 30
                + "run 9e6 s step 1 s\n",
                "FZ703",
                "records 297,000,033 numbers, 33 signals",
            ),
            (
                "controller law\ninput e\noutput u = e\nevery 1 us\nloop l\nblock c = law(t)\nrun 1000 s\n",
                "FZ703",
                "the run has 1,000,000,000 samples",
            ),
        ],
    )
    def test_samples_that_do_not_fit_are_mistakes(self, loop, text, code, words):
        count = iter(range(30))
        lines = [line.replace("{0}", f"{next(count)}") if "{0}" in line else line for line in text.splitlines()]
        with pytest.raises(DiagnosticError) as error:
            Experiment(loop("\n".join(lines) + "\n"))
        (found,) = error.value.diagnostics
        assert words in f"{found.message} {found.help}"
        assert found.code == code


def test_a_measure_may_call_a_system(loop):
    text = "system double\ndefuzzifier weighted_average\ninput x in [0, 1]\nall = function(1)\noutput y in [0, 2]\n"
    text += "if x is all then y is linear(x=2)\n"
    text += f"{LAG_PLANT}loop l\nblock p = p(0.5)\nmeasure m = final(double(0.25 * t))\nrun 2 s step 10 ms\n"
    assert Experiment(loop(text), "python").run().measures["m"] == pytest.approx(1)


class TestLackingInputs:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_controller_without_an_input_gives_nan_and_keeps_its_state(self, loop, backend):
        text = "controller c\ninput x\nstate n = 0\nnext n = n + 1\noutput u = n + 0 * x\nevery 1 s\n"
        text += "loop l\nblock c = c(sqrt(0.5 - pulse(2 s, 4 s)))\nrun 6 s\n"
        run = Experiment(loop(text), backend).run()
        assert run["c.u"] == pytest.approx([0, 1, math.nan, math.nan, 2, 3, 4], nan_ok=True)
        assert run["c.n"].tolist() == [0, 1, 2, 2, 2, 3, 4]
        step = fuzzyctl.compile(loop(text).controllers[0], "python")
        assert step.run(run["c.x"])[0] == pytest.approx(run["c.u"], nan_ok=True)

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("first", ["law", "walk"])
    def test_an_output_that_needs_no_input_is_known_before_the_inputs(self, loop, backend, first):
        text = "controller walk\ninput u\nstate n = 0\nnext n = n + u\noutput y = n\nevery 1 s\n"
        text += "controller law\ninput y\noutput u = 0.5 * (8 - y)\nevery 2 s\n"
        blocks = {"law": "block law = law(walk.y)\n", "walk": "block walk = walk(law.u)\n"}
        text += f"loop l\n{blocks.pop(first)}{''.join(blocks.values())}run 4 s\n"
        run = Experiment(loop(text), backend).run()
        assert run["walk.y"].tolist() == [0, 4, 8, 8, 8]
        assert run["law.u"].tolist() == [4, 4, 0, 0, 0]

    def test_an_integral_breaks_a_circle_through_a_plant_without_a_state_between(self, loop):
        text = "controller law\ninput y\noutput u = integral(1 - y)\nevery 10 ms\n"
        text += "plant p = tf(num=[1, 2], den=[1, 1])\nloop l\nblock p = p(law.u)\nblock law = law(p.y)\nrun 9 s\n"
        assert Experiment(loop(text), "python").run()["p.y"][-1] == pytest.approx(1, abs=1e-3)


class TestDeadTime:
    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("time", ["0.3 s", "0.237 s", "37 ms", "0 s", "5 s"])
    def test_a_delayed_step_is_integrated_exactly(self, loop, backend, time):
        run = Experiment(loop(driven(PURE.format(time=time), "steps(0: 2)", "1 s step 0.1 s")), backend).run()
        seconds = float(time.split()[0]) * (1e-3 if "ms" in time else 1)
        assert run["p.x"] == pytest.approx(2 * np.maximum(run.t - seconds, 0), abs=1e-13)

    def test_a_delayed_sine_is_accurate(self, loop):
        text = driven(PURE.format(time="0.137 s"), "t * sine(0.2)", "4 s step 20 ms")
        run = Experiment(loop(text), "numba").run()
        w, t = 0.4 * math.pi, np.maximum(run.t - 0.137, 0)
        exact = np.sin(w * t) / w**2 - t * np.cos(w * t) / w
        assert run["p.x"] == pytest.approx(exact, abs=2e-6)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_state_is_delayed_in_its_own_equation_with_order_four(self, loop, backend):
        """x' = -x(t - 1) with x = 1 before: a polynomial on each second (method of steps), beyond 4 s of order > 4."""
        text = driven("input u\nstate x = 1\nder x = -delay(x, 1 s, start=1)\noutput y = x", "0", "12 s step 50 ms")
        experiment = Experiment(loop(text), backend)
        runs = [experiment.run(substeps=n) for n in (1, 2, 4)]
        t = runs[0].t
        exact = sum((-1) ** k * np.maximum(t - k + 1, 0) ** k / math.factorial(k) for k in range(1, 14)) + 1
        early, late = ([np.abs(r["p.x"] - exact)[part].max() for r in runs] for part in (t <= 3, t > 3))
        assert max(early) < 1e-13
        assert late[0] < 2e-8
        assert np.log2(np.array(late[:2]) / late[1:]).min() > 3.9

    @pytest.mark.parametrize(
        ("plant", "signal"),
        [
            ("state x = 1\nder x = -2 * delay(x, 0.537 s, start=0.3) + u\noutput y = x", "sine(0.7)"),
            (
                "state x = 1\nstate z = 0\nder x = delay(z, 0.237 s) - 2 * delay(x, 0.537 s)\n"
                "der z = delay(u * x, 0.337 s) - z^2\noutput y = x",
                "steps(0: 1, 2 s: -1)",
            ),
            (
                "state x = 1\nlet a = delay(x + u, 0.33 s)\nlet b = delay(a^2, 0.21 s)\nder x = a - sin(b) - x\n"
                "output y = x",
                "steps(0: 1, 1 s: 2, 3 s: -1)",
            ),
        ],
        ids=["beside samples", "of two states", "of one another"],
    )
    def test_dead_times_of_states_beside_samples_keep_the_order(self, loop, plant, signal):
        experiment = Experiment(loop(driven(f"input u\n{plant}", signal, "6 s step 0.5 s")), "numba")
        exact = experiment.run(substeps=640)["p.x"]
        errors = [np.abs(experiment.run(substeps=n)["p.x"] - exact).max() for n in (40, 160)]
        assert errors[0] < 1e-5
        assert math.log(errors[0] / errors[1], 4) > 3.7

    def test_the_disturbance_of_a_distillation_column_is_met_by_default(self, loop):
        """The feed of Wood and Berry's column acts after 8.1 minutes, beside the samples of one minute."""
        text = "plant top = tf(num=[3.8], den=[14.9, 1], delay=8.1 min)\nloop l\nblock top = top(feed)\n"
        text = text.replace("den=[14.9, 1]", "den=[14.9 * 60, 1]")
        text += "let feed = steps(5 min: 0.34)\nrun 60 min step 1 min\n"
        run = Experiment(loop(text), "python").run()
        exact = 0.34 * 3.8 * (1 - np.exp(-np.maximum(run.t / 60 - 13.1, 0) / 14.9))
        assert run["top.y"] == pytest.approx(exact, abs=1e-6)

    def test_a_plant_without_states_has_dead_time(self, loop):
        run = Experiment(loop(driven("input u\noutput y = delay(u, 0.25 s, start=-1)", "t", "1 s step 0.1 s"))).run()
        assert run["p.y"] == pytest.approx([-1, -1, -1, *(np.arange(3, 11) / 10 - 0.25)])

    def test_dead_times_of_too_many_steps_or_numbers_are_named_by_check(self):
        plant = "plant {0}\ninput u\nstate x = 0\nder x = delay(u, {1} s)\noutput y = x\n"
        text = plant.format("a", "1e-7") + plant.format("b", "1e7")
        _, found = check_text(f"{text}loop l\nblock a = a(1)\nblock b = b(1)\nrun 10 s step 1 ms\n")
        assert [(d.code, d.span.line, d.message) for d in found] == [
            ("FZ703", 4, "a dead time of 1e-07 s takes 10,000 steps of integration a sample, 100,010,000 in all"),
            ("FZ703", 9, "a dead time of 1e+07 s keeps 4e+10 numbers at steps of 0.001 s"),
        ]

    def test_a_dead_time_below_a_sample_takes_more_steps_of_integration(self, loop):
        assert Experiment(loop(driven(PURE.format(time="30 ms"), "1", "1 s step 0.1 s")), "python").run().substeps == 4

    def test_a_transfer_function_with_dead_time_is_the_one_without_later(self, loop):
        text = "plant a = tf(num=[2], den=[0.3, 1], delay=0.4 s)\nplant b = tf(num=[2], den=[0.3, 1])\n"
        text += "loop l\nblock a = a(1)\nblock b = b(1)\nrun 2 s step 0.1 s\n"
        run = Experiment(loop(text), "python").run()
        assert run["a.y"][4:] == pytest.approx(run["b.y"][:-4], rel=1e-12, abs=1e-14)
        assert run["b.y"] == pytest.approx(2 * (1 - np.exp(-run.t / 0.3)), abs=2e-4)

    @pytest.mark.parametrize("value", ["a", None, math.nan, 10**400, 1j])
    def test_values_of_params_are_finite_numbers(self, loop, value):
        with pytest.raises(ValueOutOfBoundsError, match="param 'K' must be a finite number"):
            fuzzyctl.simulate(loop(driven(LAG, "K", "1 s step 0.1 s") + "param K = 1\n"), K=value)

    def test_adaptive_solvers_refuse_substeps_and_dead_time(self, loop):
        with pytest.raises(ArgumentError, match="solver RK45 chooses its own"):
            fuzzyctl.simulate(loop(driven(LAG, "1", "1 s step 0.1 s")), solver="RK45", substeps=2)
        with pytest.raises(ArgumentError, match="dead time takes the solver RK4"):
            fuzzyctl.simulate(loop(driven(PURE.format(time="30 ms"), "1", "1 s step 0.1 s")), solver="LSODA")


class TestSignals:
    def signal(self, loop, text, run="2 s step 0.5 s"):
        return Experiment(loop(driven(LAG, text, run)), "python").run()["p.u"]

    def test_each_is_what_its_form_says(self, loop):
        assert self.signal(loop, "steps(0.5 s: 1, 1.5 s: 3)").tolist() == [0, 1, 1, 3, 3]
        assert self.signal(loop, "pulse(0.5 s, 1.5 s)").tolist() == [0, 1, 1, 0, 0]
        assert self.signal(loop, "ramp(0.5 s, 1.5 s, low=1, high=3)").tolist() == [1, 1, 2, 3, 3]
        assert self.signal(loop, "sine(0.5, amplitude=2, phase=pi)") == pytest.approx([0, -2, 0, 2, 0], abs=1e-14)

    @pytest.mark.parametrize("step", [0.15, 0.35, 0.011, 0.013])
    def test_edges_at_samples_are_met_whatever_the_rounding(self, loop, step):
        typed = {k: f"{k * step:.15g}" for k in range(1, 200)}
        late = [k for k, text in typed.items() if k * step < float(text)][:3]
        assert late
        for k in (7, *late):
            found = self.signal(loop, f"steps({typed[k]}: 1)", f"{typed[199]} step {step}")
            assert found.tolist() == [0] * k + [1] * (len(found) - k)

    def test_noise_is_normal(self, loop):
        noise = self.signal(loop, "noise(sigma=2, seed=5)", "100 s step 10 ms")
        assert np.std(noise) == pytest.approx(2, rel=0.05)
        assert np.mean(noise) == pytest.approx(0, abs=0.1)

    def noises(self, loop, lets, **settings):
        text = f"{LAG_PLANT}loop l\nblock p = p(0)\n{lets}run 100 s step 10 ms\n"
        return Experiment(loop(text), "python").run(**settings)

    @pytest.mark.parametrize("seed", [None, 7])
    @pytest.mark.parametrize("count", [2, 20])
    def test_each_noise_draws_its_own_numbers(self, loop, count, seed):
        """The correlation of independent streams is normal with deviation 1 / sqrt(n): 5 of them for each pair."""
        run = self.noises(loop, "".join(f"let a{k} = noise(0.1)\n" for k in range(count)), seed=seed)
        columns = np.array([run[f"a{k}"] for k in range(count)])
        correlation = np.corrcoef(columns) - np.eye(count)
        assert np.abs(correlation).max() < 5 / math.sqrt(len(run))
        assert np.std(columns, axis=1) == pytest.approx(0.1, rel=0.05)

    def test_noises_of_one_line_and_of_inputs_draw_their_own_numbers(self, loop):
        text = "plant two\ninput u\ninput w\noutput y = u + w\nloop l\nblock p = two(noise(1), w=noise(1) - noise(1))\n"
        run = Experiment(loop(f"{text}run 100 s step 10 ms\n"), "python").run()
        assert np.std(run["p.w"]) == pytest.approx(math.sqrt(2), rel=0.05)
        assert np.std(run["p.y"]) == pytest.approx(math.sqrt(3), rel=0.05)

    def test_noises_depend_on_their_names_and_not_on_the_order_of_lines(self, loop):
        lines = ["let a = noise(0.1)\n", "let b = noise(0.1)\n"]
        one, other = self.noises(loop, "".join(lines)), self.noises(loop, "".join(lines[::-1]))
        assert one["a"].tolist() == other["a"].tolist()

    @pytest.mark.parametrize("others", ["", "let b = noise(0.1, seed=1)\n", "let b = noise(0.1, seed=0)\n"])
    def test_the_only_noise_without_a_seed_has_the_seed_0_if_no_other_has(self, loop, others):
        run = self.noises(loop, f"let a = noise(0.1)\n{others}")
        drawn = 0.1 * np.random.Generator(np.random.PCG64(0)).standard_normal(len(run))
        assert (run["a"].tolist() == drawn.tolist()) == ("seed=0" not in others)
        assert "b" not in run.names or abs(np.corrcoef(run["a"], run["b"])[0, 1]) < 5 / math.sqrt(len(run))

    def test_noises_of_one_seed_are_warned_of(self):
        lets = "let a = noise(0.1, seed=3)\nlet b = noise(0.2, 3)\nallow FZ216\n"
        _, found = check_text(f"{LAG_PLANT}loop l\nblock p = p(0)\n{lets}run 1 s step 10 ms\n")
        message = "two noises have the seed 3: they are the same numbers"
        assert [(d.code, d.severity, d.message, d.span.line) for d in found] == [("FZ214", "warning", message, 10)]

    def test_a_table_is_on_straight_lines_between_its_rows(self, loop, tmp_path):
        (tmp_path / "load.csv").write_text("t,a,b\n0.5,1,5\n1.0,2,6\n2.0,4,7\n", encoding="utf-8")
        assert self.signal(loop, 'csv("load.csv", column="a")') == pytest.approx([1, 1, 2, 3, 4])
        text = driven("input u\nstate x = 0\nder x = u\noutput y = x", 'csv("load.csv", column="a")', "2 s step 0.5 s")
        assert Experiment(loop(text), "numba").run()["p.x"] == pytest.approx([0, 0.5, 1.25, 2.5, 4.25])

    @pytest.mark.parametrize(
        ("rows", "message"),
        [
            ("t,a\n0,1\n0,2\n", "times in column 't' of 'load.csv' do not ascend at line 3"),
            ("t,a\n0,1\n1,high\n", "'high' is not a finite number, in line 3 of 'load.csv'"),
            ("t,a\n0,1\n1\n", "'' is not a finite number, in line 3 of 'load.csv'"),
            ("t,a\n", "'load.csv' has no rows below its header"),
        ],
    )
    def test_a_table_that_cannot_be_used_is_a_mistake(self, loop, tmp_path, rows, message):
        (tmp_path / "load.csv").write_text(rows, encoding="utf-8")
        with pytest.raises(DiagnosticError) as error:
            self.signal(loop, 'csv("load.csv", column="a")')
        (found,) = error.value.diagnostics
        assert (found.code, found.message) == ("FZ705", message)
        assert found.span is not None


class TestStops:
    def stopped(self, loop, plant, signal, run="2 s step 0.1 s", backend="python"):
        text = driven(plant, signal, run) + "measure area = integral(p.y)\nmeasure late = mean(p.y, begin=1.5 s)\n"
        return Experiment(loop(f"{text}require area <= 1\n"), backend).run()

    @pytest.mark.parametrize("backend", ["python", "numba"])
    def test_a_state_that_leaves_its_range_stops_the_run(self, loop, backend):
        plant = 'input u\nstate x in [0, 1) unit "m" = 0\nder x = u\noutput y = x'
        run = self.stopped(loop, plant, "1", backend=backend)
        assert len(run) == 10
        assert run["p.x"] == pytest.approx(np.arange(10) / 10)
        assert run.measures == pytest.approx({"area": 0.405, "late": math.nan}, nan_ok=True)
        assert not any(r.holds for r in run.requirements)
        found = run.stopped
        assert (found.code, found.span.text) == ("FZ701", "x")
        assert found.message.startswith("state 'p.x' left its range at t = 1 s: 1 m is outside of [0, 1)")
        assert found.facts == ("one sample before it was 0.9 m",)

    def test_a_state_beyond_its_range_by_a_rounding_is_shown_with_all_digits(self, loop):
        message = self.stopped(loop, "input u\nstate x in [0, 1] = 0.3\nder x = u\noutput y = x", "1").stopped.message
        shown = float(message.rpartition(": ")[2].split()[0])
        assert 1.0 < shown < 1.0 + 1e-12

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize(
        ("derivative", "what"), [("exp(40 * x)", "infinite"), ("sqrt(0.5 - x)", "not a number")], ids=str
    )
    def test_a_state_without_a_finite_value_stops_the_run(self, loop, backend, derivative, what):
        run = self.stopped(loop, f"input u\nstate x = 0\nder x = {derivative} + u\noutput y = x", "1", backend=backend)
        assert run.stopped.code == "FZ701"
        assert f"state 'p.x' is {what} at t = " in run.stopped.message or "not a number" in run.stopped.message
        assert np.isfinite(run.record).all()
        assert 0 < len(run) < 21

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_an_output_without_a_value_stops_the_run(self, loop, backend):
        rule = "system s\ninput e in [0, 1]\n  H = ramp(0.5, 1)\noutput u in [0, 1] else error\n  terms lo@0 hi@1\n"
        text = f"{rule}defuzzifier center_average\nif e is H then u is hi\n"
        text += "controller c\ninput x\noutput u = s(x)\nevery 1 s\nloop l\nblock c = c(x)\n"
        text += "let x = steps(0: 0.9, 2 s: 0.1)\nrun 4 s\n"
        run = Experiment(loop(text), backend).run()
        assert len(run) == 2
        assert run.stopped.message == "no rule fires for output 'u' at t = 2 s"

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize(("output", "what"), [("sqrt(0.5 - t)", "not a number"), ("1 / (0.5 - t)", "infinite")])
    def test_an_output_of_a_plant_without_a_value_stops_the_run(self, loop, backend, output, what):
        text = driven("input u\nstate x = 0\nder x = u\noutput z = x\noutput y = " + output, "1", "2 s step 0.25 s")
        run = Experiment(loop(text), backend).run()
        last = 0.5 if what == "infinite" else 0.75
        assert run.stopped is not None
        assert run.stopped.message == f"output 'p.y' is {what} at t = {last:g} s"
        assert run.stopped.facts == (f"there p.u = 1, p.x = {last:g}",)
        assert run.stopped.span.text == "y"
        assert run.t[-1] == last - 0.25
        solver = solved(Experiment(loop(text), "python"), "DOP853")
        assert solver.stopped.message.split(" at ")[0] == run.stopped.message.split(" at ")[0]

    def test_a_state_without_a_value_names_where_that_came_from(self, loop):
        law = "controller law\ninput y\noutput u = sqrt(0.6 - y)\nevery 0.25 s\n"
        text = "plant p\ninput u\nstate x = 0\nder x = 1 + 0 * u\noutput y = x\nloop l\nblock law = law(p.y)\n"
        run = Experiment(loop(f"{law}{text}block p = p(law.u)\nrun 2 s\n"), "python").run()
        assert run.stopped.message == "'law.u' is not a number at t = 0.75 s"
        assert run.stopped.span.text == "law"
        assert run.stopped.facts == ("one sample later state 'p.x' is not a number",)

    def test_an_input_of_a_block_that_is_infinite_is_named(self, loop):
        law = "controller law\ninput e\noutput u = 2 * e\nevery 0.25 s\n"
        text = "plant p\ninput u\nstate x = 0\nder x = u - x\noutput y = x\nloop l\n"
        run = Experiment(
            loop(f"{law}{text}block law = law(1 / (t - 0.5))\nblock p = p(law.u)\nrun 2 s\n"), "python"
        ).run()
        assert run.stopped.message == "'law.e' is infinite at t = 0.5 s"
        assert run.stopped.span.line == run.loop.instances[0].span.line

    def test_an_adaptive_solver_stops_as_well(self, loop):
        plant = "input u\nstate x in [0, 1) = 0\nder x = u\noutput y = x"
        run = fuzzyctl.simulate(loop(driven(plant, "1", "2 s step 0.1 s")), solver="RK45")
        assert len(run) in (10, 11)
        assert "left its range" in run.stopped.message

    @pytest.mark.parametrize("solver", ["LSODA", "RK45"])
    def test_an_adaptive_solver_gives_up_where_a_state_goes_to_infinity(self, loop, solver):
        cubic = "input u\nstate x = 1\nder x = x * x * x\noutput y = x"  # infinite at t = 0.5 s
        run = fuzzyctl.simulate(loop(driven(cubic, "0", "1 s step 10 ms")), solver=solver)
        assert 49 <= len(run) <= 52
        assert run.stopped.code == "FZ701"
        assert run.stopped.message.startswith(f"solver {solver} gave up at t = 0.5")
        assert run.stopped.facts[0] == f"the sample before was at t = {run.t[-1]:.6g} s"
        assert run.stopped.facts[1].startswith("its last step was ")

    @pytest.mark.parametrize("solver", ["BDF"])
    def test_an_adaptive_solver_estimates_its_error(self, loop, solver):
        run = fuzzyctl.simulate(loop(driven(LAG, "sine(0.2)", "5 s step 0.1 s")), solver=solver)
        assert 0 < run.error["p.x"] < 1e-5


class TestFree:
    def test_free_params_are_arguments_of_a_run(self, loop):
        fill = loop(FILL)
        experiment = Experiment(fill, "numba", free=["law.Kp", "tank.a"])
        assert experiment.run().record == pytest.approx(Experiment(fill, "python").run().record, rel=1e-12, abs=1e-12)
        plain = fuzzyctl.simulate(fill, backend="python", Kp=5, a=1)
        assert experiment.run([5, 1]).record == pytest.approx(plain.record, rel=1e-12, abs=1e-12)
        assert experiment.run([5, 1]).measures == pytest.approx(plain.measures)

    def test_params_that_depend_on_a_free_one_follow_it(self, loop):
        text = "controller c\ninput x\nparam a = 1\nparam b = 2 * a\noutput u = b * x\nevery 1 s\n"
        text += "loop l\nparam g = 3\nblock c = c(1, a = g + 1)\nmeasure m = final(c.u) + g\nrun 2 s\n"
        experiment = Experiment(loop(text), "python", free=["g"])
        assert experiment.run()["c.u"].tolist() == [8] * 3
        assert experiment.run([4.0])["c.u"].tolist() == [10] * 3
        assert experiment.run([4.0]).measures == {"m": 14}

    @pytest.mark.parametrize("change", ["set", "free"])
    def test_a_param_before_the_first_block_is_one_number(self, loop, change):
        own = loop(SHARED)
        changed = fuzzyctl.simulate(own, k=3) if change == "set" else Experiment(own, "python", free=["k"]).run([3])
        expected = fuzzyctl.simulate(loop(SHARED.replace("param k = 2", "param k = 3"))).measures
        assert changed.measures == pytest.approx(expected, rel=1e-12)
        assert changed.measures["last"] != pytest.approx(fuzzyctl.simulate(own).measures["last"], rel=1e-3)

    def test_a_period_before_the_first_block_is_set_and_cannot_be_free(self, loop):
        own = loop(SHARED)
        expected = fuzzyctl.simulate(loop(SHARED.replace("param T = 0.01", "param T = 0.02"))).measures
        assert fuzzyctl.simulate(own, T=0.02).measures == expected != fuzzyctl.simulate(own).measures
        with pytest.raises(ArgumentError, match="T"):
            Experiment(own, "python", free=["T"])

    def test_what_must_be_a_constant_cannot_be_free(self, loop):
        text = driven("input u\nparam a = 1\nstate x = a\nder x = -a * x\noutput y = x", "0", "1 s step 0.1 s")
        with pytest.raises(ArgumentError, match=r"'a' cannot be free: a constant depends on it at .*loop\.fz:4:11"):
            Experiment(loop(text), "python", free=["p.a"])

    @pytest.mark.parametrize(
        "body", ["state x = 2 * k\nnext x = x\noutput u = x", "output u = previous(e, start=half)"]
    )
    @pytest.mark.parametrize("name", ["law.k", "k"])
    def test_starts_of_controllers_cannot_be_free(self, loop, name, body):
        head = "param k = 1\n" if name == "k" else ""
        own = "" if head else "param k = 1\n"
        text = f"{head}controller c\ninput e\n{own}param half = k / 2\n{body}\nevery 0.1 s\n"
        text += "loop l\nblock law = c(1)\nmeasure m = final(law.u)\nrun 1 s\n"
        with pytest.raises(ArgumentError, match="cannot be free: a constant depends on it"):
            Experiment(loop(text), "python", free=[name])

    def test_functions_of_a_block_have_its_free_params(self, loop):
        text = "controller c\ninput e\nparam k = 1\nfunction f(x) = k * x\noutput u = f(e)\nevery 0.1 s\n"
        own = loop(text + "loop l\nblock law = c(3)\nmeasure m = final(law.u)\nrun 1 s\n")
        assert Experiment(own, "python", free=["law.k"]).run([2]).measures == {"m": 6.0}

    @pytest.mark.parametrize(
        ("values", "message"),
        [
            ([5.0, 1.0], "'p.k' must be in (0, 4], got 5.0"),
            ([0.0, 1.0], "'p.k' must be in (0, 4], got 0.0"),
            ([3.0, 0.5], "'p.k' must be in (0, 2], got 3.0"),
            ([math.nan, 1.0], "'p.k' must be a finite number, got nan"),
            ([1.0, math.inf], "'p.top' must be a finite number, got inf"),
        ],
    )
    def test_values_stay_in_the_ranges_of_their_params(self, loop, values, message):
        plant = "input u\nparam top = 2\nparam k in (0, 4 * top] = 1\nstate x = 0\nder x = k * u\noutput y = x"
        experiment = Experiment(loop(driven(plant, "1, top=1", "2 s step 1 s")), "python", free=["p.k", "p.top"])
        assert experiment.run([4.0, 1.0])["p.y"][-1] == pytest.approx(8.0)
        with pytest.raises(ValueOutOfBoundsError) as caught:
            experiment.run(values)
        assert message in str(caught.value)
        assert experiment.run([4.0, 1.0])["p.y"][-1] == pytest.approx(8.0)

    def test_names_and_numbers_of_values_are_checked(self, loop):
        with pytest.raises(UnknownNameError, match=r"law\.Kq"):
            Experiment(loop(FILL), "python", free=["law.Kq"])
        with pytest.raises(ArgumentError, match=r"expected 1 values \(law.Kp\), got the shape \(2,\)"):
            Experiment(loop(FILL), "python", free=["law.Kp"]).run([1, 2])
        with pytest.raises(ArgumentError, match=r"'law\.Kp' cannot be free: it is given twice"):
            Experiment(loop(FILL), "python", free=["law.Kp", "law.Kp"])
        with pytest.raises(ArgumentError, match="expected a Loop, got Plant"):
            fuzzyctl.simulate(loop(FILL).plants[0])
        for substeps in (0, -1, 1.5, "1"):
            with pytest.raises(ArgumentError, match="'substeps' must be a positive integer, got "):
                fuzzyctl.simulate(loop(FILL), substeps=substeps)
        with pytest.raises(ArgumentError, match="expected a Loop, got Plant"):
            Experiment(loop(FILL).plants[0])
        with pytest.raises(UnknownNameError, match="backend 'cuda'"):
            Experiment(loop(FILL), "cuda")


def test_an_output_of_states_alone_breaks_an_algebraic_loop(loop):
    text = """
controller first
input e
state s = 0
next s = s + 0.1 * (e - s)
output u = s
output direct = s + e
every 0.1 s
loop l
block a = first(1 - b.u)
block b = first(a.u)
measure m = final(a.u)
run 20 s
"""
    found = Experiment(loop(text), "python").run()
    assert found.measures["m"] == pytest.approx(0.5, abs=1e-6)
    with pytest.raises(DiagnosticError, match="FZ220"):
        Experiment(loop(text.replace("first(a.u)", "first(a.direct)").replace("- b.u", "- b.direct")), "python")


@pytest.mark.parametrize("name", ["a.T", "half", "length", "scale"])
def test_what_sample_times_depend_on_cannot_be_free(loop, name):
    text = """
param scale = 1
param half = 0.05 * scale
param length = 2
controller law
input r
param T = 0.1
param both = 2 * T
output u = r
every both
loop l
block a = law(1, T=half)
measure m = final(a.u)
run length
"""
    text = text.replace("param length = 2\n", "").replace("loop l\n", "loop l\nparam length = 2\n")
    known = Experiment(loop(text), "python")
    assert known.step == pytest.approx(0.1)
    with pytest.raises(ArgumentError, match=f"'{name}' cannot be free"):
        Experiment(loop(text), "python", free=[name])


def test_recorded_calls_are_what_the_systems_are_given(loop):
    found = loop(SHARED)
    run, plain = (Experiment(found, "python", record_calls=r).run() for r in (True, False))
    assert set(run.names) - set(plain.names) == {"law.gain.y"}
    assert run["law.gain.y"] == pytest.approx(run["p.y"], abs=1e-15)
    assert run["p.y"].tolist() == plain["p.y"].tolist()
    twice = loop(SHARED.replace("gain(y)", "gain(y) + gain(2 * y)"))
    run = Experiment(twice, "python", record_calls=True).run()
    assert set(run.names) - set(plain.names) == {"law.gain.y", "law.gain.2.y"}
    assert run["law.gain.2.y"] == pytest.approx(2 * run["law.gain.y"], abs=1e-15)
    tank = fuzzyctl.load("water_tank", block=fuzzyctl.Loop)
    run = fuzzyctl.simulate(tank, record_calls=True)
    surface = fuzzyctl.compile(tank.controllers[0].systems[0])
    moved = [surface(e, c) for e, c in zip(run["law.surface.error"], run["law.surface.change"], strict=True)]
    valve = run["law.valve"][::5]  # a step of the controller is five of the run
    expected = np.clip(valve[:-1] + 0.05 * 8 * np.array(moved[5::5]), 0, 10)
    assert valve[1:] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("backend", BACKENDS)
def test_signals_take_as_many_steps_as_a_drive_cycle_has(tmp_path, backend):
    times = [0.25 + 0.01 * k for k in range(1500)]
    pairs = ", ".join(f"{t!r}: {k % 7}" for k, t in enumerate(times))
    text = f"plant lag\ninput u\nstate x = 0\nder x = u - x\noutput y = x\nloop l\nlet r = steps({pairs})\n"
    (tmp_path / "a.fz").write_text(text + "block lag = lag(r)\nrun 16 s step 50 ms\n", encoding="utf-8")
    run = Experiment(fuzzyctl.load(tmp_path / "a.fz", block=fuzzyctl.Loop), backend).run()
    last = np.searchsorted(times, run.t + 1e-9, side="right") - 1
    assert run["r"].tolist() == np.where(last < 0, 0, last % 7).tolist()


def coupled(tanks):
    """Return the loop of a row of tanks, each with a branch."""
    plant = "plant tank\ninput q\nstate h in [0, inf) = 0.1\nlet out = where(h > 0, sqrt(h), 0)\n"
    plant += "der h = q - out\noutput y = out\n"
    blocks = "".join(f"block t{k} = tank({f't{k - 1}.y' if k else '0.2'})\n" for k in range(tanks))
    return fuzzyctl.loads(f"{plant}loop row\n{blocks}run 1 s step 100 ms\n", block=fuzzyctl.Loop)


def test_many_branches_are_not_compiled():
    assert Experiment(coupled(10)).backend == "numba"
    many = Experiment(coupled(80))
    assert many.backend == "python"
    assert many.run().stopped is None


def test_more_branches_than_numba_can_take_are_refused(monkeypatch):
    def compiled(*_):
        raise RecursionError

    monkeypatch.setattr("fuzzyctl.simulation.experiment.compiled", compiled)
    with pytest.raises(ArgumentError, match="loop 'row' has too many branches for numba: take backend 'python'"):
        Experiment(coupled(2), "numba").run()
