"""Drawn controllers in loops: they make the steps that they make alone, on both backends, beside an adaptive solver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.simulation.simulate import solved
from tests.properties.running import quick
from tests.properties.test_controllers import controllers

PLANTS = (
    "state a = 0.2\nder a = u - a\noutput y = a",
    "state a = 0\nstate b = 0.1\nder a = b\nder b = u - 4*a - b\noutput y = a",
    "state a = 0\nder a = u - sin(3*a) - 0.5*cos(t)\noutput y = tanh(a)".replace("tanh(a)", "a / (1 + abs(a))"),
    "state a = 0.1\nder a = rule(a, u) - a\noutput y = a",
)
DELAYED = "state a = 0\nder a = delay(u, 120 ms) - delay(a, 70 ms, start=0.1)\noutput y = a"
SIGNALS = ("steps(0: 0.5, 0.6: -1)", "ramp(0.2, 1)", "sine(1.5)", "noise(0.3, seed=2)", "0.5 * pulse(0.3, 0.9) - t")


@st.composite
def loops(draw, plants=(*PLANTS, DELAYED)):
    """Draw the text of a loop with a drawn controller, which runs at each sample or at each second one."""
    every = draw(st.sampled_from(["50 ms", "100 ms"]))
    plant, signal = draw(st.sampled_from(plants)), draw(st.sampled_from(SIGNALS))
    lines = [
        "block law = drawn(x = r + 0.1 * p.y, y = p.y)",
        "block p = p(clamp(law.z, -3, 3) + d)",
        f"let r = {signal}",
    ]
    lines += [f"let d = {draw(st.sampled_from(SIGNALS))}", "run 1.5 s step 50 ms", "measure m = rms(p.y - r)"]
    text = draw(controllers()).replace("\ncontroller drawn\n", f"\nplant p\ninput u\n{plant}\n\ncontroller drawn\n")
    return f"{text}every {every}\nloop l\n" + "\n".join(draw(st.permutations(lines))) + "\n"


def loaded(text):
    return fuzzyctl.loads(text, block="l")


def require_the_steps_of_the_controller_alone(loop, run):
    step = fuzzyctl.compile(loop.controllers[0], "python")
    n = round(step.period / 0.05)
    rows = np.column_stack([run[f"law.{name}"] for name in step.input_names])[::n]
    outputs = step.run(rows)[0]
    found = np.column_stack([run[f"law.{name}"] for name in step.output_names])
    assert found[::n] == pytest.approx(outputs, rel=1e-9, abs=1e-9, nan_ok=True)
    held = np.repeat(found[::n], n, axis=0)[: len(found)]
    assert found == pytest.approx(held, nan_ok=True)


@quick(60)
@given(loops())
def test_a_controller_in_a_loop_makes_the_steps_that_it_makes_alone(text):
    loop = loaded(text)
    run = fuzzyctl.Experiment(loop, "python").run(substeps=2)
    require_the_steps_of_the_controller_alone(loop, run)


@pytest.mark.long
@quick(12)
@given(loops())
def test_both_backends_run_the_same(text):
    loop = loaded(text)
    one, other = (fuzzyctl.Experiment(loop, backend).run() for backend in ("python", "numba"))
    assert len(one) == len(other)
    scale = max(1.0, float(np.nanmax(np.abs(one.record))))
    assert one.record[:10] == pytest.approx(other.record[:10], rel=1e-9, abs=1e-9 * scale, nan_ok=True)


@quick(20)
@given(loops(PLANTS))
def test_an_adaptive_solver_is_the_referee(text):
    experiment = fuzzyctl.Experiment(loaded(text), "python")
    run, referee = experiment.run(substeps=8), solved(experiment, "DOP853", relative=1e-10, absolute=1e-12)
    scale = max(1.0, float(np.nanmax(np.abs(referee["p.a"]))))
    # At an edge of the surface RK4 is of a lower order.
    tolerance = scale * (3e-5 if "rule(a, u)" in text else 1e-7)
    # A relay may switch a sample earlier in one of them: what follows is another run.
    apart = np.flatnonzero(~(np.abs(run["law.z"] - referee["law.z"]) <= 0.1 * tolerance))
    same = slice(apart[0] + 1 if len(apart) else None)
    assert run["p.a"][same] == pytest.approx(referee["p.a"][same], rel=0, abs=tolerance)
