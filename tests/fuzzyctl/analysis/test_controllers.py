"""Claims about controllers: known truths, states by induction, witnesses that are replayed, bounds."""

import math
import re

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import Proved, Refuted, Undecided
from tests.shipped import rules_folder

#: Seconds; what is decided here takes one at the most.
AMPLE = 60.0

SURFACE = """system surface
and product
defuzzifier center_average
input e in [-1, 1]
  terms N Z P
output u in [-1, 1]{otherwise}
  terms N@-1 Z@0 P@1
{rules}
"""
WHOLE = SURFACE.format(otherwise="", rules="table u = e\n    N Z P\n  | N Z P")
GAP = SURFACE.format(otherwise=" else {}", rules="if e is P then u is P")


def controller_of(text):
    return fuzzyctl.loads(text, block=re.findall(r"^controller (\w+)", text, re.MULTILINE)[-1])


def verdicts(text, timeout=AMPLE):
    return fuzzyctl.prove(controller_of(text), timeout=timeout)


HEAD = "controller c\ninput x in [-1, 1]\n"
OUT = "output out = x\n"
#: Lines of a controller with the verdict on the last of its claims: P, R or U.
TRUTHS = {
    # integrators
    "state s in [-2, 2] = 0\nnext s = clamp(s + dt * x, -2, 2)": "P",
    "state s in [-2, 2] = 0\nnext s = s + 0.01 * x": "R",
    "state s in [0.1, inf) = 0.1\nnext s = max(0.1, s + dt * x)": "P",
    "state s in (0, 10] = 1\nnext s = s * 0.5": "R",  # it underflows
    "state s in (0, 10] = 1\nnext s = 0.5 * s + 0.1": "P",
    "state s in [0, inf) = 0\nnext s = s + x * x": "P",
    "state s in [0, 2] = 0\nnext s = where(s >= 1, 0, s + 0.5 + 0.5 * x)": "P",
    "state s in [0, 1] = 0\nnext s = x > 0 and x < 0.5 or s > 0.5": "P",
    "state s in [0, 1] = 0\nnext s = x > 0\nrequire s <= 0.5": "R",
    # anti-windup
    "let i = integral(x, hold = i > 1 and x > 0 or i < -1 and x < 0)\nevery 10 ms\nrequire abs(i) <= 1.011": "P",
    "let i = integral(x, hold = i > 1 and x > 0)\nevery 10 ms\nrequire i <= 1.011": "P",
    "let i = integral(x)\nevery 1 s\nrequire i <= 50": "R",
    "let i = integral(x, hold = u != v)\nlet v = x + i\nlet u = clamp(v, -1, 1)\nevery 1 s\nrequire abs(i) <= 4": "P",
    # operators
    "let y = previous(x, start=0.5)\nrequire abs(y) <= 1": "P",
    "let y = delay(x, 5, start=2)\nrequire y <= 1": "R",
    "let y = delay(x, 5, start=2)\nrequire y <= 2": "P",
    "let y = lowpass(x, 0.3 s)\nrequire abs(y) <= 1 within 1e-9": "P",
    "let y = rate_limit(x, 2)\nrequire abs(y) <= 1": "P",
    "let y = hysteresis(x, -0.2, 0.2)\nrequire y >= 0 and y <= 1": "P",
    "let y = difference(x)\nrequire abs(y) <= 2": "P",
    "let y = derivative(x, filter=20 ms)\nevery 10 ms\nrequire abs(y) <= 201": "P",
    "let y = derivative(x, filter=20 ms)\nevery 10 ms\nrequire abs(y) <= 30": "R",
    "let y = derivative(x)\nrequire y <= 1e6": "R",
    # states without a range
    "state s = 0\nnext s = 0.9 * s + x\nrequire abs(s) <= 10 within 1e-6": "P",
    "state s = 0\nnext s = s + 0.1 * (x - s)\nrequire abs(s) <= 1 within 1e-9": "P",
    "state s = 0\nnext s = s + 1\nrequire s >= 0": "P",
    # outputs and expressions
    "output u in [0, 1] = clamp(3 * x, 0, 1)": "P",
    "output u in [-1, 1] = 1.5 * x": "R",
    "let k = 1 + abs(x)\nlet f = 0.5 * x\nrequire k - 2 * f > 0": "P",
    "require where(x > 0, x, -x) >= 0": "P",
    "require x * x - x + 0.25 >= 0 within 1e-9": "P",
    "require x > 0.5 when x > 0.6": "P",
    "require bounded(2 * x, -2, 2)": "P",
    "require bounded(out, -1, 0.5)": "R",
    "require 1 / x >= 1 when x > 0.1": "P",
    "require sqrt(x) >= 0": "U",
    "let y = dt / (1 + dt)\nrequire y > 0 and y <= 1": "P",
}


@pytest.mark.parametrize("lines", TRUTHS)
def test_known_truths(lines):
    *_, last = verdicts(HEAD + OUT + lines + "\n")
    assert type(last).__name__[0] == TRUTHS[lines], last


ADAPTIVE = (
    SURFACE.format(otherwise="", rules="table u = e\n    N Z P\n  | N Z P")
    .replace("surface", "gain")
    .replace("output u in [-1, 1]", "output u in [-0.5, 0.5] adaptive rate 3 * e")
    .replace("N@-1 Z@0 P@1", "N=-0.1 Z=0 P=0.1")
    .replace("center_average", "weighted_average")
)
HOLDING = GAP.format("hold").replace("surface", "pump")

PI = (
    WHOLE.replace("system surface", "system surface")
    + """controller valve
input error in [-2, 2]
param GU = 0.8
let move   = surface(error)
let wanted = integral(GU * move, hold=wanted > 1 and move > 0 or wanted < 0 and move < 0)
output opening in [0, 1] = clamp(wanted, 0, 1)
every 50 ms
require wanted <= 1 + 0.05 * GU within 1e-9
require wanted >= -0.05 * GU within 1e-9
require wanted <= 1
"""
)


class TestSystems:
    def test_the_integral_of_a_fuzzy_controller_is_bounded_by_its_anti_windup(self):
        assert [type(v) for v in verdicts(PI)] == [Proved, Proved, Proved, Refuted]

    def test_the_switching_gain_is_positive_with_the_law_that_moves_it(self):
        """Goto, Bertol, Martins, Eqs. (15) to (22); the gain is kept at or above its floor."""
        rules = rules_folder()
        systems = "".join((rules / f"{n}.fz").read_text(encoding="utf-8") for n in ("ais_reaction", "boundary_layer"))
        found = verdicts("\n".join(s for s in systems.split("\n") if not s.startswith("require")) + CHANNEL)
        assert {v.claim: type(v) for v in found} == {
            "k_h in [k_h_min, inf)": Proved,
            "gain > 0": Proved,
            "gain >= G_min within 1e-12": Proved,
            "push * sigma >= 0": Proved,
        }

    def test_a_gap_of_a_rule_base_that_gives_nan_is_not_proved_away(self):
        text = (
            GAP.format("nan") + HEAD + "state s in [0, 1] = 0\nnext s = surface(x)\noutput y in [0, 1] = surface(x)\n"
        )
        state, output = verdicts(text)
        assert isinstance(state, Refuted)
        assert math.isnan(state.witness.sides[0][1])
        assert isinstance(output, Undecided)

    def test_formulas_of_a_system_may_have_no_value(self):
        rooted = SURFACE.format(otherwise="", rules="table u = e\n    N Z P\n  | N Z P").replace(
            "terms N@-1 Z@0 P@1", "N = function(sqrt(e))\n  Z = constant(0)\n  P = constant(1)"
        )
        text = rooted.replace("center_average", "weighted_average") + HEAD
        text += "state s in [0, 1] = 0\nnext s = clamp(surface(x), 0, 1)\noutput y = where(s >= 0 or s < 0, 0, 5)\n"
        assert not isinstance(verdicts(text + "require y <= 0\n")[0], Proved)

    def test_states_of_systems_stay_in_their_ranges(self):
        text = ADAPTIVE + HOLDING + HEAD + "let a = gain(x)\nlet b = pump(x)\noutput y = a + b\n"
        assert [type(v) for v in verdicts(text + "require abs(a) <= 0.5\nrequire b >= -1 and b <= 1\n")] == [
            Proved,
            Proved,
        ]

    def test_a_step_that_cannot_be_made_breaks_no_claim(self):
        text = (
            GAP.format("error") + HEAD + "state s in [0, 1] = 0\nnext s = surface(x)\noutput y in [0, 1] = surface(x)\n"
        )
        assert {type(v) for v in verdicts(text)} == {Proved}


CHANNEL = """
controller channel
input sigma
param p       = 1.2
param k_h_min = 0.1
param k_s     = 0.55
param G_min   = 0.001
param Gamma   = 0.2
param epsilon = 0.001
state k_h in [k_h_min, inf) = k_h_min
let f     = ais_reaction(sigma, derivative(sigma), k_h_min=k_h_min, k_s=k_s)
let beta  = boundary_layer(abs(sigma))
let size  = abs(sigma)
let way   = sign(size - epsilon)
let rate  = where(k_h <= k_h_min, k_h_min, Gamma * where(size > beta, size, size * size / beta) * way)
output gain = k_h - k_s * f
output push = gain * where(size > beta, sign(sigma), sigma / beta) + p * sigma
next k_h = max(k_h_min, k_h + dt * rate)
require gain > 0
require gain >= G_min within 1e-12
require push * sigma >= 0
"""

COUPLED = HEAD + OUT + "state a in [-1, 1] = 0\nstate b in [-1, 1] = 0\nnext a = {}\nnext b = {}\nrequire abs(b) <= 1\n"


class TestInduction:
    def test_states_keep_each_other_in_their_ranges(self):
        assert {type(v) for v in verdicts(COUPLED.format("b * x", "0.5 * a + 0.5 * x"))} == {Proved}

    def test_a_range_that_is_left_proves_nothing_else(self):
        a, b, claim = verdicts(COUPLED.format("a + 0.001 * x", "a"))
        assert isinstance(a, Refuted)
        assert "no run that reaches it was found" in a.note
        assert isinstance(b, Refuted | Undecided)
        assert isinstance(claim, Undecided)
        assert "the range of 'b' is not proved" in claim.reason

    def test_a_range_may_hold_up_to_rounding_only(self):
        (found,) = verdicts(HEAD + OUT + "state s in [-1, 1] = 0\nnext s = s + 0.3 * (x - s)\n")
        assert isinstance(found, Proved)
        assert "up to 1e-9" in found.note

    def test_states_of_controllers_inside_are_kept_as_well(self):
        inner = "controller inner\ninput v\nstate s in [0, {}] = 0\nnext s = clamp(s + v, 0, 1)\noutput y = s\n"
        outer = HEAD + "block a = inner(x)\noutput y in [0, 1] = a.y\nrequire a.y <= 1\n"
        assert {type(v) for v in verdicts(inner.format(2) + outer)} == {Proved}
        assert {type(v) for v in verdicts(inner.format(0.5) + outer)} == {Proved}  # whatever it says of its own range

    def test_long_delays_take_no_long(self):
        assert isinstance(verdicts(HEAD + OUT + "let y = delay(x, 2000)\nrequire abs(y) <= 1\n")[0], Proved)

    def test_long_chains_are_no_recursion(self):
        chain = "".join(f"let a{k} = a{k + 1} + 1\n" for k in range(1500)) + "let a1500 = x\n"
        text = HEAD + OUT + chain + "let y = where(a0 > 1500, a0, 1500)\nrequire y >= 1500\n"
        assert isinstance(verdicts(text)[0], Proved)


def printed(witness):
    """Return the numbers that the text of a witness shows."""
    parts = str(witness).removeprefix("at ").split(": ")[0].split(", ")
    return {name: float(value) for name, value in (part.split(" = ") for part in parts)}


class TestRefuted:
    def test_the_kernel_breaks_the_claim_at_the_witness(self):
        text = (
            HEAD + "state s in [-3, 3] = 0\nnext s = s + 0.2 * x\noutput y = 2 * s + x\nevery 10 ms\nrequire y <= 5\n"
        )
        controller = controller_of(text)
        step = fuzzyctl.compile(controller, "python")
        state, claim = fuzzyctl.prove(controller, timeout=AMPLE)
        y, after = step(state.witness.point["x"], [state.witness.point["s"]])
        assert not -3 <= after[0] <= 3
        y, after = step(claim.witness.point["x"], [claim.witness.point["s"]])
        assert y > 5
        assert ("y", y) in claim.witness.sides

    @pytest.mark.parametrize(
        "claim",
        ["a <= 0.2", "a >= -0.3", "a + s <= 3", "b < 1", "a * b <= 0.1 when x > 0.3", "s - 10 * a <= 1"],
    )
    def test_a_witness_shows_the_states_of_systems_and_replays_as_printed(self, claim):
        text = ADAPTIVE + HOLDING + HEAD + "let a = gain(x)\nlet b = pump(x)\noutput u = a\noutput v = b\n"
        lines = "state s = 0\nnext s = 0.99 * s + a\nevery 10 ms\n"
        controller = controller_of(text + lines + f"require {claim}\n")
        (found,) = fuzzyctl.prove(controller, timeout=AMPLE)
        assert isinstance(found, Refuted)
        assert any("." in n for n in found.witness.point), found.witness
        left, *_ = claim.split(" when ")
        truth = controller_of(text + lines + f"output truth = where({left}, 1, 0)\n")
        step = fuzzyctl.compile(truth, "python")
        for point in (found.witness.point, printed(found.witness)):
            state = [point.get(n, x) for n, x in zip(step.state_names, step.start(), strict=True)]
            assert step(point.get("x", 0.0), state)[0][2] == 0.0, (point, found)

    def test_a_run_from_the_start_is_said(self):
        state, claim = verdicts(HEAD + OUT + "state s in [-1, 1] = 0\nnext s = s + 0.2 * x\nrequire s <= 0.5\n")
        assert state.note.startswith("reached from the start after ")
        assert claim.note.startswith("reached from the start after ")

    def test_the_number_of_steps_is_that_of_the_run(self):
        (claim,) = verdicts("controller c\noutput n = k\nstate k = 0\nnext k = k + 1\nrequire n < 7\n")
        assert claim.note == "reached from the start after 7 steps"

    def test_the_first_step_is_said(self):
        (claim,) = verdicts("controller c\noutput n = k\nstate k = 3\nnext k = k + 1\nrequire n < 3\n")
        assert claim.note == "at the first step"

    def test_without_states_there_is_nothing_to_reach(self):
        (claim,) = verdicts(HEAD + OUT + "require x < 1\n")
        assert claim.note == ""
        assert list(claim.witness.point) == ["x"]

    def test_a_state_of_an_operator_that_no_run_reaches_refutes_nothing(self):
        claim = verdicts(HEAD + OUT + "let y = hysteresis(x, -0.2, 0.2)\nrequire y * (1 - y) <= 0\n")[0]
        assert isinstance(claim, Undecided)
        assert "no run was found that reaches this state" in claim.reason


class TestNumbers:
    def test_nan_leaves_the_state_in_its_range(self):
        controller = controller_of(
            HEAD + "state s in [0, 1] = 0.5\nnext s = clamp(s + x, 0, 1)\noutput y in [0, 1] = s\n"
        )
        assert {type(v) for v in fuzzyctl.prove(controller)} == {Proved}
        step = fuzzyctl.compile(controller, "python")
        output, state = step(math.nan, step.start(), dt=0.1)
        assert math.isnan(output)
        assert state.tolist() == [0.5]

    def test_a_state_that_becomes_nan_has_left_its_range(self):
        (found,) = verdicts(HEAD + OUT + "state s in [0, 1] = 0\nnext s = sqrt(x)\n")
        assert isinstance(found, Refuted)

    def test_a_state_that_may_be_nan_proves_nothing_of_what_reads_it(self):
        text = (
            HEAD + OUT + "state s = 0\nnext s = sqrt(x)\nlet y = where(s >= 0, 0, where(s < 0, 0, 5))\nrequire y <= 0\n"
        )
        assert not isinstance(verdicts(text)[0], Proved)
        same = text.replace("where(s >= 0, 0, where(s < 0, 0, 5))", "where(s == s, 0, 5)")
        assert not isinstance(verdicts(same)[0], Proved)

    def test_inputs_up_to_which_a_claim_is_proved_are_said(self):
        text = "controller c\ninput x\ninput z\noutput y in [-1, 1] = clamp(2 * x - 2 * z, -1, 1)\n"
        (found,) = verdicts(text)
        assert found.note == "for x, z up to 1e30 in magnitude"
        (found,) = verdicts(text.replace("x\n", "x in [-1e40, 1e40]\n").replace("z\n", "z in [0, 1]\n", 1))
        assert (type(found), found.note) == (Proved, "")

    def test_an_input_without_a_range_may_be_any_number(self):
        assert not isinstance(
            verdicts("controller c\ninput x\noutput y in [0, 1] = where(x > 1e32, 2, 0)\n")[0], Proved
        )

    def test_no_region_is_said(self):
        (found,) = verdicts(HEAD + OUT + "require x > 2 when x > 3\n")
        assert "nothing is claimed" in found.note

    def test_two_expressions_without_tolerance_are_compared_in_exact_arithmetic(self):
        (found,) = verdicts(
            HEAD + OUT + "let a = 0.1 * x + 0.2 * x\nrequire a <= 0.3 * x + 1e-20 * x * x when x >= 0\n"
        )
        assert not isinstance(found, Refuted)


class TestBounds:
    def test_outputs_and_states_are_bounded(self):
        text = HEAD + "state s in [0, inf) = 0\nnext s = clamp(s + x, 0, 3)\noutput y = 2 * s - x\n"
        found = fuzzyctl.output_bounds(controller_of(text))
        assert list(found) == ["y", "s"]
        assert (found["s"].lo, found["s"].hi) == (0.0, 3.0)
        assert (found["y"].lo, found["y"].hi) == pytest.approx((-1.0, 7.0), abs=0.05)
        assert found["y"].lo <= -1.0
        assert found["y"].hi >= 7.0

    def test_what_has_no_end_is_infinite(self):
        found = fuzzyctl.output_bounds(
            controller_of("controller c\ninput x\nstate s = 0\nnext s = 2 * s + 1\noutput y = x\n")
        )
        assert (found["y"].lo, found["y"].hi) == (-math.inf, math.inf)
        assert (found["s"].lo, found["s"].hi) == (0.0, math.inf)

    @pytest.mark.parametrize(
        ("value", "ends"),
        [
            ("sqrt(abs(x))", (0.0, math.inf)),
            ("log(1 + abs(x))", (0.0, math.inf)),
            ("0.2 * x", (-math.inf, math.inf)),
            ("1 / (1 + abs(x))", (0.0, 1.0)),
            ("-3 / (1 + abs(x))", (-3.0, 0.0)),
            ("min(abs(x), 3) + 2", (2.0, 5.0)),
        ],
    )
    def test_no_end_depends_on_how_far_numbers_without_an_end_are_taken(self, value, ends):
        found = fuzzyctl.output_bounds(controller_of(f"controller c\ninput x\noutput y = {value}\n"))["y"]
        assert (found.lo, found.hi) == pytest.approx(ends, rel=1e-9)
        assert (found.lo == 0.0) == (ends[0] == 0.0)

    def test_bounds_of_a_fuzzy_controller_hold_in_a_run(self):
        controller = controller_of(PI)
        bound = fuzzyctl.output_bounds(controller)["opening"]
        outputs, _ = fuzzyctl.compile(controller, "python").run(np.random.default_rng(1).uniform(-2, 2, 500))
        assert bound.lo <= outputs.min()
        assert outputs.max() <= bound.hi


def test_progress_is_reported():
    seen = []
    text = HEAD + OUT + "require x * x - x + 0.25 >= 0 within 1e-6\n"
    fuzzyctl.prove(controller_of(text), progress=lambda claim, settled, open_: seen.append(claim))
    assert set(seen) == {"x * x - x + 0.25 >= 0 within 1e-6"}


def test_a_witness_beside_a_round_number_is_printed_in_full():
    text = "controller c\nstate n in [0, 10] = 0\nnext n = where(n >= 10, 0, n + 1)\noutput y = n\nevery 1 s\n"
    (verdict,) = (v for v in verdicts(text) if isinstance(v, Refuted))
    assert 9 < verdict.witness.point["n"] < 10
    assert f"n = {verdict.witness.point['n']!r}: " in str(verdict.witness)
