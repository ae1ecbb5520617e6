import math

import numpy as np
import pytest

from fuzzyctl.codegen.files import expected_of as sequence
from tests.fuzzyctl.codegen.conftest import written
from tests.fuzzyctl.codegen.steps.targets import by_kernel, unit_of
from tests.fuzzyctl.codegen.steps.texts import GAPS, TEXTS

STEPS = 200


class TestSequence:
    @pytest.mark.parametrize("precision", ["double", "float"])
    def test_is_what_the_kernel_makes_of_its_inputs(self, precision):
        unit = unit_of(TEXTS["pid"], precision=precision)
        steps = sequence(unit).vectors
        assert len(steps) == STEPS
        rows = np.array([v.inputs for v in steps])
        np.testing.assert_array_equal(np.array([v.outputs for v in steps]), by_kernel(TEXTS["pid"], rows))
        if precision == "float":
            np.testing.assert_array_equal(rows.astype(np.float32), rows)

    def test_holds_what_a_target_may_get_wrong(self, text):
        unit = unit_of(text)
        steps = sequence(unit).vectors
        if unit.equations.inputs:
            assert len(steps) == STEPS
            assert sum(math.isnan(x) for v in steps for x in v.inputs) >= 2
            assert all(math.isnan(y) for v in steps if any(math.isnan(x) for x in v.inputs) for y in v.outputs)
        if unit.equations.period is None:
            assert {v.inputs[-1] for v in steps} >= {0.0, 0.005, 0.01, 0.02}
        if unit.refusals:
            assert {v.refused for v in steps} == {"", *unit.refusals}

    def test_ends_where_rounding_decides_whatever_the_inputs(self):
        steps = sequence(unit_of(TEXTS["clock"])).vectors  # ten times 0.1 are not 1
        assert 5 < len(steps) < STEPS

    def test_takes_other_inputs_where_rounding_decides(self, monkeypatch):
        drawn = iter([0.5, 0.25, *[0.125] * 300])
        monkeypatch.setattr("fuzzyctl.codegen.sequence._drawn", lambda *_: (next(drawn),))
        text = "controller c\ninput x\noutput y = where(x * x >= 0.25, 1, 0)\nevery 1 s\n"
        assert sequence(unit_of(text)).vectors[0].inputs == (0.25,)

    def test_ends_before_numbers_that_no_target_holds(self):
        text = "controller c\ninput x\nstate s = 1\nnext s = 1e30 * s\noutput y = s\nevery 1 s\n"
        assert [v.outputs[0] for v in sequence(unit_of(text)).vectors] == pytest.approx([1, 1e30, 1e60, 1e90])

    def test_a_step_that_is_infinite_from_the_start_is_refused(self):
        text = "controller c\nstate s = inf\nnext s = 1\noutput y = s\nevery 1 s\n"
        assert "no first step is found that is finite" in written(text).errors

    def test_the_state_stays_where_a_system_refuses(self):
        text = GAPS.format(name="gaps", otherwise="error")
        text += "controller c\ninput x in [-2, 2]\nstate n = 0\nnext n = n + 1\noutput y = gaps(x) + n\nevery 1 s\n"
        counted = 0
        for vector in sequence(unit_of(text)).vectors:
            if vector.refused:
                assert math.isnan(vector.outputs[0])
            elif not math.isnan(vector.inputs[0]):
                assert vector.outputs[0] in (counted, counted + 1)
                counted += 1


class TestTolerance:
    def test_is_relative_to_the_largest_output(self):
        steps = sequence(unit_of(TEXTS["pid"]))
        largest = max(abs(v.outputs[0]) for v in steps.vectors if not math.isnan(v.outputs[0]))
        assert steps.tolerance(0, "double") == 1e-12 * largest
        assert steps.tolerance(0, "float") == 1e-4 * largest

    @pytest.mark.parametrize("precision", ["double", "float"])
    def test_of_what_is_0_but_for_rounding_is_relative_to_the_inputs(self, precision):
        text = "controller c\ninput x in [-3, 3]\ninput y in [-1, 2]\noutput z = (x + y) * 0.1 - x * 0.1 - y * 0.1\n"
        steps = sequence(unit_of(text, precision=precision))
        assert len(steps.vectors) == STEPS
        assert steps.tolerance(0, "double") == 3e-12
