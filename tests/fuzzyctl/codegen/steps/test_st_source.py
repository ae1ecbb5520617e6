"""Steps as function blocks; that they compute what the kernel computes is tested in test_agreement.py."""

import re

import pytest

from fuzzyctl.codegen.files import sources
from tests.fuzzyctl.codegen.conftest import written
from tests.fuzzyctl.codegen.steps.targets import by_kernel, by_structured_text, rows_for, unit_of
from tests.fuzzyctl.codegen.steps.texts import GAPS, SURFACE, TEXTS
from tests.fuzzyctl.codegen.structured_text import Block


def block(text, **options):
    return "".join(sources(unit_of(text, "st", **options), "st").values())


class TestBlock:
    def test_declares_inputs_outputs_and_the_state_with_its_start(self):
        found = Block(block(TEXTS["operators"]))
        assert found.inputs == ["x", "y", "time_step"]
        assert found.outputs[:2] == ["a", "a_valid"]
        assert found.variables["previous_1"] == 0.25
        (delay,) = (n for n in found.types if n.startswith("delay") and not n.endswith("oldest"))
        assert found.variables[delay] == [-0.5] * 7

    def test_a_number_that_is_missing_stays_missing_in_the_state(self):
        text = "controller c\ninput x\nstate s = 0\nnext s = s + sqrt(x)\noutput y = s\n"
        text += "output z = delay(sqrt(x), 5)\nevery 1 s\n"
        found = Block(block(text))
        said = [found(x=x)[1::2] for x in (1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)]
        assert [valid for valid, _ in said] == [True, True, *[False] * 6]
        assert [valid for _, valid in said] == [True] * 6 + [False, True]

    @pytest.mark.parametrize(
        "form", ["min(q, y)", "max(q, y)", "clamp(q, -1, y)", "abs(q)", "where(q > 0, 1, y)", "q / q"]
    )
    def test_functions_take_a_number_that_is_missing_as_the_kernel_does(self, form):
        text = f"controller c\ninput x\ninput y\nlet q = 1 / sqrt(x)\noutput z = {form}\n"
        text += "output w = previous(q)\nevery 1 s\n"
        rows = rows_for(unit_of(text), 80)
        found, expected = by_structured_text(unit_of(text, "st"), rows), by_kernel(text, rows)
        assert (expected == expected).any()
        assert found == pytest.approx(expected, rel=1e-12, nan_ok=True)

    @pytest.mark.parametrize("algorithm", ["auto", "active", "rules"])
    def test_systems_take_a_number_that_is_missing_as_the_kernel_does(self, algorithm):
        text = GAPS.format(name="gaps", otherwise="nan") + SURFACE
        text += "controller c\ninput x\ninput y\noutput z = surface(gaps(x), y)\nevery 1 s\n"
        rows = rows_for(unit_of(text), 80)
        found, expected = by_structured_text(unit_of(text, "st", algorithm=algorithm), rows), by_kernel(text, rows)
        assert 10 < (expected != expected).sum() < 70
        assert found == pytest.approx(expected, rel=1e-12, nan_ok=True)

    def test_quotients_by_numbers_need_no_guard(self):
        text = block(TEXTS["pid"])
        assert "<>" not in text
        assert re.search(r":= \(?\(.* / 0\.35\)?;", text)

    def test_a_quotient_by_zero_is_guarded(self):
        found = Block(block("controller c\ninput x\noutput y = 1 / x\noutput z = x / x\nevery 1 s\n"))
        assert found(x=0.0) == [1.7976931348623157e308, True, 0.0, False]

    @pytest.mark.parametrize("name", ["refused", "time_step", "valid", "u_valid", "s_oldest", "u0", "CASE", "Result0"])
    def test_may_have_any_names(self, name):
        text = f"controller {name}\ninput {name}\nstate s = 0\nnext s = {name}\noutput u = s + delay({name}, 4)\n"
        rows = rows_for(unit_of(text), 20)
        assert by_structured_text(unit_of(text, "st"), rows) == pytest.approx(by_kernel(text, rows), nan_ok=True)

    def test_single_precision_is_real(self):
        text = re.sub(r"\(\*.*?\*\)", "", block(TEXTS["timed"], precision="float"))
        assert "LREAL" not in text
        assert "(ABS(y) <= 3.4028235E38)" in text

    def test_a_function_that_the_standard_does_not_have_is_refused(self):
        found = written("controller c\ninput x\noutput y = floor(x)\nevery 1 s\n", "st")
        assert "no standard function" in found.errors
