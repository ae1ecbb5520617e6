"""Drawn controllers with ranges and claims: no run breaks what is proved, and what is refuted is so by the kernel."""

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl import Kernel, Proved, Refuted
from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.expr import Number
from fuzzyctl.kernels.step_form import StepForm
from tests import sizes
from tests.properties.running import quick
from tests.properties.test_controllers import controllers

#: States that only a limit keeps in their ranges, and some that leave them.
STATES = (
    "state k in [0.1, inf) = 0.1\nnext k = max(0.1, k + 0.2 * {a})",
    "state k in [-1, 2] = 0\nnext k = clamp(k + dt * {a}, -1, 2)",
    "state k in [-5, 5] = 0\nnext k = 0.8 * k + 0.2 * {a}",
    "state k in [-3, 3] = 0\nnext k = k + 0.3 * (clamp({a}, -3, 3) - k)",
    "state k in [-1, 1] = 0\nnext k = where(k > 0.5 and {a} > 0 or k < 0 and {a} < 0, k, k + 0.1 * clamp({a}, -1, 1))",
    "state k in [0, 4] = 0\nnext k = where(k >= 3, 0, k + 1)",
    "state k in [0, 9] = 1\nnext k = sqrt({a} + 2)",
    "state k in [-1, 1] = 0\nnext k = clamp(2 * learned({a}), -1, 1)",
    "state k in [-5, 5] = 0\nnext k = 0.9 * k + learned({a} - k)",
)
#: A system with states of its own.
LEARNED = """system learned
and product
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
output u in [-0.5, 0.5] adaptive rate 3 * e
  terms N=-0.1 Z=0 P=0.1
table u = e
    N Z P
  | N Z P
"""


CLAIMS = (
    "require {n} <= {high}",
    "require {n} >= {low}",
    "require abs({n}) <= {most} within 1e-9",
    "require {n} + k >= {low} or {n} > k",
    "require {n} <= z + {high}",
    "require {n} >= {low} when x * y >= 0",
    "require {n} <= {high} when near and not inside(y)",
    "require near or {n} >= {low}",
)
#: Copies of a step that are attacked side by side.
ROWS = 250


@st.composite
def ranged_controllers(draw):
    """Draw a controller whose inputs have ranges, with a state that has one, and claims near what a short run shows."""
    head, _, body = draw(controllers()).rpartition("controller drawn\n")
    names = [f"v{k}" for k in range(body.count("let v"))]
    for name in ("x", "y"):
        body = body.replace(f"input {name}\n", f"input {name} in [-2, 2]\n")
    body = body.replace("output w =", f"output w in [-{draw(st.integers(1, 8))}, 8] =")
    body = body.replace("param k in [0, 1] = 0.5\n", "")
    body += draw(st.sampled_from(STATES)).format(a=draw(st.sampled_from([*names, "x"]))) + "\n"
    body += draw(st.sampled_from(["", "every 50 ms\n"]))
    text = head + LEARNED + "controller drawn\n" + body
    seen = seen_in(text, [*names, "k", "z"])
    for name in draw(st.lists(st.sampled_from([*names, "k", "z"]), min_size=3, max_size=6)):
        low, high = seen[name]
        margin = draw(st.sampled_from([0.0, 0.01, 0.3, 3.0]))
        form = draw(st.sampled_from(CLAIMS))
        text += form.format(n=name, low=low - margin, high=high + margin, most=max(-low, high) + margin) + "\n"
    return text


def controller_of(text):
    return fuzzyctl.loads(text, block=re.findall(r"^controller (\w+)", text, re.MULTILINE)[-1])


class Attack:
    """Many copies of a step side by side, with inputs at random, at their ends, switching, and against one claim each.

    Args:
        step: A step of two inputs in [-2, 2], on numpy.
        margins: Returns by how much each claim holds, shape (claims, rows), from the values of a step by name.
        rows: Copies.
    """

    def __init__(self, step, margins, rows=ROWS, seed=1):
        self.step, self.margins, self.random = step, margins, np.random.default_rng(seed)
        self.states = np.tile(step.start(), (rows, 1))
        self.kind = np.arange(rows) % 5
        self.target = np.arange(rows) // 5
        self.held = self.draw(1.0)
        self.times = None if step.period is not None else 10.0 ** self.random.uniform(-4, 1, rows)

    def draw(self, ends):
        """Draw inputs, a part of them at the ends of their ranges."""
        shape = (len(self.states), 2)
        at_ends = self.random.random(shape) < ends
        return np.where(at_ends, self.random.choice([-2.0, 2.0], shape), self.random.uniform(-2, 2, shape))

    def inputs(self):
        """Return the next inputs of each copy, by its kind."""
        self.held = np.where(self.random.random((len(self.held), 1)) < 0.05, self.draw(0.8), self.held)
        switched = np.where(self.kind[:, None] == 1, -self.held, self.held)
        self.held = switched
        found = np.where(self.kind[:, None] == 0, self.draw(0.1), switched)
        best = np.full(len(found), np.inf)
        for candidate in (self.draw(1.0), self.draw(0.3), self.draw(0.0)):
            margins = np.atleast_2d(self.margins(self.values(candidate)[0]))
            own = margins[self.target % len(margins), np.arange(len(found))]
            better = (self.kind >= 3) & (own < best)
            found, best = np.where(better[:, None], candidate, found), np.where(better, own, best)
        return found

    def values(self, inputs):
        """Return the values of a step by name, shape (rows,) each, and the next states."""
        times = {} if self.times is None else {"dt": self.times}
        outputs, states = self.step.batch(inputs, self.states, **times)
        names = (*self.step.output_names, *(f"next {n}" for n in self.step.state_names))
        outputs = outputs.reshape(len(states), -1)
        return dict(zip(names, (*outputs.T, *states.T), strict=True)), states

    def run(self, steps):
        """Make steps, and yield the values of each."""
        for _ in range(steps):
            found, states = self.values(self.inputs())
            yield found
            self.states = states


def seen_in(text, names):
    """Return the least and the largest value of some names in a short run."""
    text += "".join(f"output seen_{n} = {n}\n" for n in names)
    step = fuzzyctl.compile(controller_of(text), "numpy")
    values = list(Attack(step, lambda found: found["w"], rows=10, seed=3).run(40))
    seen = {n: np.array([v[f"seen_{n}"] for v in values]) for n in names}
    return {n: (float(np.nanmin(s)), float(np.nanmax(s))) for n, s in seen.items()}


def margin_of(truth, values, room=0.0):
    """Return by how much a claim holds for values by name, with some room at ends that belong to it, shape (rows,)."""
    if hasattr(truth, "parts"):
        joined = {"Every": np.minimum, "Some": np.maximum}[type(truth).__name__]
        return joined.reduce([margin_of(p, values, room) for p in truth.parts])
    left, right = (e.value if isinstance(e, Number) else values[e.name] for e in (truth.left, truth.right))
    return left - right + (float(truth.tolerance) if truth.strict else max(float(truth.tolerance), room))


def room_of(truth):
    """Return what rounding may take from a range, by its largest number: 1e-9 of it."""
    if hasattr(truth, "parts"):
        return max(map(room_of, truth.parts), default=0.0)
    return 1e-9 * max((abs(e.value) for e in (truth.left, truth.right) if isinstance(e, Number)), default=0.0)


def margin_in_region(claim, values, room=0.0):
    """Return by how much a claim holds for values by name, infinite outside of its region, shape (rows,)."""
    found = margin_of(claim.truth, values, room)
    return (
        found
        if getattr(claim.region, "parts", None) == ()
        else np.where(margin_of(claim.region, values) >= 0, found, np.inf)
    )


def require_sound(text, steps):
    """Check that runs break no claim that is proved, and that what is refuted is broken by the kernel."""
    controller = controller_of(text)
    prover = ControllerProver(controller, timeout=1.0)
    # Runs would find many false claims before a proof is tried, and it is the proofs that are looked at here.
    prover.__dict__["_reached"] = {}
    claims = prover.claims
    verdicts = [prover.verdict(c) for c in claims.own]
    proved = [c for c, v in zip(claims.own, verdicts, strict=True) if isinstance(v, Proved)]
    notes = [v.note for v in verdicts if isinstance(v, Proved)]
    rooms = [room_of(c.claim.truth) if "1e-9" in note else 0.0 for c, note in zip(proved, notes, strict=True)]

    def margins(values):
        found = [margin_in_region(c.claim, values, room) for c, room in zip(proved, rooms, strict=True)]
        return np.stack([np.broadcast_to(margin, values["w"].shape) for margin in found or [0.0]])

    attack = Attack(Kernel(StepForm(claims.equations), "numpy"), margins)
    for values in attack.run(steps):
        for claim, margin in zip(proved, margins(values), strict=False):
            fine = margin >= (-1e-9 * (1 + np.abs(values["z"])) if is_exact(verdicts, claim) else 0.0)
            assert (fine | (np.isnan(margin) & (not claim.state))).all(), (claim.claim.text, text)
    for claim, verdict in zip(claims.own, verdicts, strict=True):
        if isinstance(verdict, Refuted):
            assert is_broken(claims, claim, verdict), (claim.claim.text, text)
    return {type(v).__name__ for v in verdicts}


def is_exact(verdicts, claim):
    """Whether a claim is proved in exact arithmetic only."""
    return any(v.claim == claim.claim.text and "exact" in v.note for v in verdicts if isinstance(v, Proved))


def is_broken(claims, claim, verdict):
    """Whether the step at a witness breaks a claim."""
    step = Kernel(StepForm(claims.equations), "python")
    point = verdict.witness.point
    state = [point.get(n, x) for n, x in zip(step.state_names, step.start(), strict=True)]
    outputs, after = step(*(point.get(n, 0.0) for n in step.input_names), state, **dt_of(step, point))
    values = dict(zip(step.output_names, np.atleast_1d(outputs), strict=True))
    values |= {f"next {n}": x for n, x in zip(step.state_names, after, strict=True)}
    margin = margin_of(claim.claim.truth, values)
    return margin <= 0 or np.isnan(margin)


def dt_of(step, point):
    return {} if step.period is not None else {"dt": point.get("dt", 1.0)}


@given(ranged_controllers())
@quick(300, 3)
def test_no_run_breaks_what_is_proved(text):
    require_sound(text, 400 if sizes.LONG else 60)
