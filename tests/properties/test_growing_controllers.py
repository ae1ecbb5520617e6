"""Drawn controllers whose states may grow: no run breaks what is proved; claims about bounded states are decided."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import Kernel, Proved, Undecided
from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.kernels.step_form import StepForm
from tests import sizes
from tests.properties.running import quick
from tests.properties.test_controller_proofs import controller_of, margin_in_region

GROWING = (
    "state {n} = 0\nnext {n} = 2 * {n} + {a}",
    "state {n} = 1\nnext {n} = 1.3 * {n}",
    "state {n} = 0\nnext {n} = -3 * {n} + {a}",
    "state {n} = 0\nnext {n} = {n} + 0.02 * ({a} + 50 * {n})",
    "state {n} = 1\nnext {n} = {n} * {n} + abs({a})",
    "state {n} = 0\nnext {n} = {n} + 1e22 * {a}",
    "state {n} = 0\nnext {n} = 2 * {n} - 3 * {a}",
    "let {n} = integral({a} + 40 * previous({n}, start=0))",
    "let {n} = delay(3 * previous({n}, start=1) + {a}, 3)",
    "let {n} = lowpass(8 * previous({n}, start=0) + {a}, 0.01)",
    "let {n} = rate_limit(1e300 * {a}, 1e290)",
    "let {n} = 1e200 * {a} * {a} * 1e150",
    "let {n} = derivative(1e299 * {a})",
)
BOUNDED = (
    "state {n} = 0\nnext {n} = 0.9 * {n} + {a}",
    "state {n} in [-2, 2] = 0\nnext {n} = clamp({n} + {a}, -2, 2)",
    "state {n} = 0\nnext {n} = {n} + 0.1 * (clamp({a}, -9, 9) - {n})",
    "let {n} = lowpass({a}, 0.3)",
    "let {n} = hysteresis({a}, -0.2, 0.2)",
    "let {n} = integral({a}, hold = {n} > 1 and {a} > 0 or {n} < -1 and {a} < 0)",
    "let {n} = integral({a})",
    "let {n} = delay({a}, 4)",
    "let {n} = clamp({a}, -1, 1)",
)
CLAIMS = (
    "output o{k} in [0, 1] = where({n} > {size}, 2, 0)",
    "output o{k} in [-1, 1] = clamp({n}, -1, 1)",
    "output o{k} in [0, 1] = hysteresis({n}, -{size}, {size})",
    "output o{k} in [0, 1] = where(abs({n}) - abs({n}) == 0, 0, 2)",
    "require {n} <= {size}",
    "require abs({n}) <= {size}",
    "require where({n} * 0 == 0, 1, 0) >= 1",
    "require {n} <= {size} when x > 0",
    "require clamp({n}, 0, {size}) <= {size}",
)


@st.composite
def claimed(draw, forms, inputs=("in [-1, 1]", "")):
    """Draw the text of a controller with states of some forms and claims about them."""
    lines = [f"input {n} {draw(st.sampled_from(inputs))}" for n in "xy"]
    names = []
    for k in range(draw(st.integers(1, 3))):
        a = draw(st.sampled_from(["x", "y", *names]))
        lines.append(draw(st.sampled_from(forms)).format(n=f"g{k}", a=a))
        names.append(f"g{k}")
    lines += [*draw(st.sampled_from([["every 20 ms"], []])), f"output last = {names[-1]}"]
    for k in range(draw(st.integers(1, 3))):
        size = f"1e{draw(st.integers(25, 300))}"
        lines.append(draw(st.sampled_from(CLAIMS)).format(n=draw(st.sampled_from(names)), k=k, size=size))
    return "controller c\n" + "\n".join(lines) + "\n"


def proofs_of(text):
    """Return the claims about outputs of a controller with their verdicts, and the prover."""
    prover = ControllerProver(controller_of(text), timeout=0.3)
    return [(c, prover.verdict(c)) for c in prover.claims.own if not c.state], prover


def runs(prover, steps, is_limited):
    """Yield the inputs of runs: all at their lower ends, at their upper ends, at random, switching between ends."""
    random = np.random.default_rng(1)
    most = 1e30 if is_limited else np.finfo(float).max
    ends = np.array([(low, high) if abs(high) < 1e30 else (-most, most) for low, high in prover.inputs.values()])
    for kind in range(4):
        drawn = random.uniform(0, 1, (steps, len(ends)))
        if kind == 3:
            drawn = drawn.round()
        rows = ends[:, 0] * (1 - drawn) + ends[:, 1] * drawn if kind > 1 else np.tile(ends[:, kind], (steps, 1))
        if kind == 2:
            rows = np.clip(rows, -1e3, 1e3)
        yield rows


def require_kept(text, steps):
    found, prover = proofs_of(text)
    proved = [(c, v) for c, v in found if isinstance(v, Proved)]
    step = Kernel(StepForm(prover.claims.equations), "python")
    for claim, verdict in proved:
        for rows in runs(prover, steps, is_limited="1e30 in magnitude" in verdict.note):
            with np.errstate(all="ignore"):
                outputs, _ = step.run(rows, **({} if step.period is not None else {"dt": 0.05}))
            values = dict(zip(step.output_names, outputs.reshape(len(rows), -1).T, strict=True))
            with np.errstate(all="ignore"):
                margin = np.broadcast_to(margin_in_region(claim.claim, values), len(rows))
            assert (margin >= 0.0).all(), (verdict, text, int(np.argmin(margin >= 0.0)))


@given(claimed(GROWING))
@quick(700, 12)
def test_no_run_breaks_what_is_proved_of_a_state_that_grows(text):
    require_kept(text, 10_000 if sizes.LONG else 600)


@given(claimed((*GROWING, *BOUNDED)))
@quick(300, 8)
def test_no_run_breaks_what_is_proved_of_mixed_states(text):
    require_kept(text, 10_000 if sizes.LONG else 600)


SEEN = []


@given(claimed(BOUNDED, inputs=("in [-1, 1]",)))
@quick(200, 10)
def draw_bounded(text):
    SEEN.extend(not isinstance(v, Undecided) for _, v in proofs_of(text)[0])
    require_kept(text, 600)


def test_most_claims_about_states_that_do_not_grow_are_decided():
    SEEN.clear()
    draw_bounded()
    assert np.mean(SEEN) >= 0.6, np.mean(SEEN)


@pytest.mark.parametrize(
    "lines",
    [
        "next i = i + dt * (e + 50 * i)\nevery 20 ms\noutput alarm in [0, 1] = where(i > 1e32, 2, 0)",
        "next i = 2 * i + e\nevery 20 ms\noutput y = i\nrequire i <= 1e31",
        "next i = 2 * i + e\nevery 20 ms\noutput y in [0, 1] = where(i - i == 0, 0, 2)",
        *(
            f"next i = 2 * i + e\nevery 20 ms\noutput y in [0, 1] = where({condition}, 0, 2)"
            for condition in (
                "(i - i) * (i - i) >= 0",
                "exp(i - i) >= 0",
                "sign(i - i) >= -1",
                "i - i <= exp(abs(i) + 1000)",
            )
        ),
    ],
)
def test_what_grows_beyond_1e30_proves_nothing(lines):
    found, _ = proofs_of(f"controller c\ninput e in [-1, 1]\nstate i = 0\n{lines}\n")
    assert not any(isinstance(v, Proved) for _, v in found), found
