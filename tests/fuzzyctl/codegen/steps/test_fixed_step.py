"""Fixed-point steps: what is proved of them, what is refused, and the C that keeps it."""

import re
import shutil
import subprocess
from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.fixed.fixed_format import to_format
from fuzzyctl.codegen.fixed.fixed_step import fixed_step
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from tests.fuzzyctl.codegen.conftest import SANITIZED
from tests.fuzzyctl.codegen.steps.targets import STRICT, by_fixed_c, by_kernel, unit_of
from tests.fuzzyctl.codegen.steps.texts import ADAPTIVE, SURFACE

HEAD = "controller c\ninput x in [-2, 2]\ninput y in [-2, 2]\n"
NEEDS_C = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


def step_of(lines, form="Q5.10", period="every 50 ms\n", head=HEAD):
    return fixed_step(unit_of(head + lines + "\n" + period), to_format(form))


def refused(lines, form="Q5.10", **more):
    with pytest.raises(DiagnosticError) as error:
        step_of(lines, form, **more)
    (found,) = error.value.diagnostics
    assert found.code == "FZ410"
    return found


class TestErrors:
    @pytest.mark.parametrize(
        "lines",
        [
            "output u = x - y",
            "output u = previous(x) + delay(y, 200)",
            "output u = 2 * difference(x) + max(abs(y), 0.25)",
            "output u = hysteresis(x - y, -0.3, 0.1)",
            "output u = rate_limit(x, 2.5)",
            "output u = where(x < 0.1 or y > x, x, 0.5)",
            "state k = 0\nnext k = where(k >= 9, 0, k + 1)\noutput u = where(k == 3, x, y)",
            "state s in [-2, 2] = 0.25\nnext s = clamp(s + x, -2, 2)\noutput u = s",
        ],
    )
    def test_what_the_format_holds_whole_is_equal_at_every_step(self, lines):
        found = step_of(lines)
        assert found.errors == (0.0,)
        assert found.slot_errors == (0.0,) * len(found.unit.slots)

    def test_of_a_product_is_half_a_unit(self):
        (error,) = step_of("output u = x * y").errors
        assert Fraction(1, 2048) <= Fraction(error) <= Fraction(1, 2047)

    def test_of_a_lag_is_what_its_roundings_add_up_to(self):
        """By hand: s' = s + a (x - s), off by the sum of its roundings, half a unit of the state each, over a."""
        found = step_of("output u = lowpass(x, 0.95 s)")
        (slot,) = (k for k, s in enumerate(found.unit.slots) if s.name.endswith("filtered"))
        unit_in_last = 2.0 ** -found.formats.slots[slot]
        assert 0.5 * unit_in_last / 0.05 <= found.slot_errors[slot] <= 1.5 * unit_in_last / 0.05

    def test_a_longer_lag_adds_up_more(self):
        errors = [max(step_of(f"output u = lowpass(x, {lag})").slot_errors) for lag in (0.05, 0.5, 5)]
        assert errors == sorted(errors)
        assert errors[2] > 5 * errors[0]

    def test_inputs_without_a_range_have_that_of_the_format(self):
        found = step_of("output u = 0.5 * x", head="controller c\ninput x\n")
        assert found.inputs == ((-(2**15), 2**15 - 1),)

    def test_a_system_that_nothing_reads_is_not_asked_for(self):
        curved = SURFACE.replace(
            "  terms N Z P\noutput", "  N = gaussian(0, 1)\n  Z = gaussian(1, 1)\n  P = ramp(1, 2)\noutput"
        )
        assert step_of("let z = surface(x, y)\noutput u = x", head=curved + HEAD).errors == (0.0,)


class TestRefusals:
    def test_names_the_integrator_and_its_place(self):
        found = refused("state s in [-2, 2] = 0\nnext s = clamp(s + 0.01 * x, -2, 2)\noutput u = s")
        assert found.message == "no bound of the error of state 's' holds over all steps"
        assert found.facts == ("it keeps its error, as an integrator does, and each step may add that of a rounding",)
        assert found.span.line == 4
        assert "--float float" in found.help

    @pytest.mark.parametrize(
        ("lines", "message", "fact"),
        [
            (
                "output u = clamp(integral(x), -1, 1)",
                "no range of the state of 'integral' is proved",
                "least and its lar",
            ),
            ("output u = rate_limit(x, 2)", "no bound of the error of the state of 'rate_limit'", "keeps its error"),
            ("output u = sin(x)", "fixed point has no 'sin'", ""),
            ("output u = x / (y + 3)", "fixed point divides by numbers only", ""),
            ("output u = x^0.5", "fixed point has no powers but", ""),
            (
                "output u = where(lowpass(x, 1) > 0.3, 1, -1)",
                "no useful bound is found for the error of 'u'",
                "'u' jumps",
            ),
            ("output u = hysteresis(lowpass(x, 1), 0, 1)", "the error of the state of 'hysteresis'", "'u' jumps where"),
            ("output u = 30 * x", "Q5.10 reaches from -32 to 31.9990234, and 'u' from -60 to 60", ""),
            ("output u = 1e9 * x - 1e9 * y - 1e9 * x^2", "beyond integers of 32 bits", ""),
            (
                "state a in [-9, 9] = 0\nstate b in [-9, 9] = 0\nnext a = clamp(0.8 * b + x, -9, 9)\n"
                "next b = clamp(1.3 * a, -9, 9)\noutput u = a",
                "no bound of the error of state",
                "states make each other's errors larger step by step",
            ),
        ],
    )
    def test_says_why(self, lines, message, fact):
        found = refused(lines)
        assert message in found.message
        assert fact in "".join(found.facts)
        assert found.span is not None

    def test_what_to_write_in_place_of_an_integral_is_accepted(self):
        found = refused("output u = clamp(x + integral(x), -1, 1)")
        assert found.facts[1] == "it keeps its error, as an integrator does, and each step may add that of a rounding"
        state, update = re.findall(r"'((?:state|next) [^']*)'", found.help)
        assert step_of(f"{state}\n{update}\noutput u = clamp(x + sum, -1, 1)").slot_errors == (0.0,)

    def test_needs_a_period(self):
        assert "needs a sample time" in refused("output u = x", period="").message

    def test_needs_ranges_of_inputs_where_outputs_are_beyond(self):
        assert refused("output u = 2 * x", head="controller c\ninput x\n").help.startswith("give 'x' a range")

    def test_says_which_format_reaches(self):
        lines = "output u = 30 * x"
        found = re.search(r"--fixed (Q\S+)", refused(lines).help)
        assert step_of(lines, found[1]).errors[0] < 1e-3

    def test_a_step_without_a_state_that_no_round_settles_is_refused(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.codegen.fixed.fixed_step._ROUNDS", 0)
        found = refused("output u = x / 3")
        assert found.message == "no integers of 32 bits hold a step in Q5.10 with its roundings"
        assert found.span.line == 1

    def test_an_adaptive_system_is_named_with_its_place(self):
        found = refused("output u = gain(x, y)", head=ADAPTIVE + HEAD)
        assert found.message == "fixed point needs systems that interpolate, and 'gain' does not: it has a state"

    def test_needs_systems_that_interpolate(self):
        curved = SURFACE.replace("and product", "and min")
        found = refused("output u = surface(x, y)", head=curved + HEAD)
        assert found.message.startswith("fixed point needs systems that interpolate, and 'surface' does not: ")


SAMPLE = (
    SURFACE
    + HEAD.replace("controller c", "controller sample")
    + """let d = derivative(x - y, filter=0.3 s)
let w = lowpass(surface(0.7 * (x - y), 0.05 * d), 0.2 s)
output u in [-3, 3] = clamp(w + 0.5 * x, -3, 3)
output v in [-2, 2] = where(x > 0.3, delay(y, 7), previous(x))
every 50 ms
"""
)


@NEEDS_C
class TestSource:
    def test_keeps_the_bound_beside_the_kernel(self, tmp_path):
        step = fixed_step(unit_of(SAMPLE), to_format("Q3.12"))
        rows = np.random.default_rng(1).integers(-9000, 9000, (4000, 2))
        (found,) = by_fixed_c([step], [rows], tmp_path, SANITIZED)
        held = np.clip(rows, *np.transpose(step.inputs))
        off = np.abs(found / 4096.0 - by_kernel(SAMPLE, held / 4096.0)).max(axis=0)
        assert np.all(off <= step.errors)
        # A bound far above what happens would hold as well.
        assert off[0] > 0.5 * step.errors[0]

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            (None, None),
            ("state->started = v", "state->started = 0 * v"),
            ("< 6U)", "< 5U)"),
            ("(shift - 1U)", "(shift - 2U)"),
        ],
    )
    def test_the_self_test_finds_what_is_wrong(self, tmp_path, old, new):
        for name, text in generate(unit_of(SAMPLE), "c", fixed_step(unit_of(SAMPLE), to_format("Q3.12"))).files.items():
            if old is not None and name == "sample.c":
                assert old in text
                text = text.replace(old, new)
            (tmp_path / name).write_text(text, encoding="utf-8")
        program = str(tmp_path / "program")
        subprocess.run(["gcc", *STRICT, *map(str, tmp_path.glob("*.c")), "-o", program], check=True)
        assert subprocess.run([program], capture_output=True, check=False).returncode == (0 if old is None else 1)

    def test_has_no_floating_point(self):
        source = generate(unit_of(SAMPLE), "c", fixed_step(unit_of(SAMPLE), to_format("Q3.12"))).files["sample.c"]
        assert not re.search(r"\b(float|double)\b|\d\.\d|math\.h", source)
