"""Free numbers of controllers: the caller of generated code gives them, and steps are those of a file that has them."""

import numpy as np
import pytest

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.st_source import function_block
from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from tests.fuzzyctl.codegen.conftest import SANITIZED
from tests.fuzzyctl.codegen.steps.targets import (
    by_c,
    by_javascript,
    by_kernel,
    by_python,
    by_structured_text,
    rows_for,
    unit_of,
)
from tests.fuzzyctl.codegen.steps.texts import TEXTS

FREE = ["GE", "surface.e.Z.peak"]
PID = TEXTS["pid"]
#: The same controller with other numbers in the file.
OTHER = PID.replace("= 0.7", "= 1.3").replace(
    "input e in [-2, 2]\n  terms N Z P", "input e in [-2, 2]\n  terms N@-2 Z@0.25 P@2"
)


@pytest.mark.parametrize(("other", "numbers"), [(PID, {}), (OTHER, {"GE": 1.3, "surface_e_Z_peak": 0.25})])
def test_all_targets_take_them(gcc, node, tmp_path, other, numbers):
    rows = rows_for(unit_of(PID), 400)
    expected = by_kernel(other, rows)
    in_block = {n.lower().replace("ge", "ge_fz"): v for n, v in numbers.items()}  # GE is a word of the language
    found = [
        by_python(unit_of(PID, "python", free=FREE), rows, **numbers),
        by_structured_text(unit_of(PID, "st", free=FREE), rows, **in_block),
        by_c([unit_of(PID, free=FREE)], [rows], tmp_path, SANITIZED, **numbers)[0],
        by_javascript([unit_of(PID, "javascript", free=FREE)], [rows], tmp_path, **numbers)[0],
    ]
    for own in found:
        np.testing.assert_allclose(own, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("precision", ["double", "float"])
def test_the_self_test_takes_those_of_the_file(compiled, precision):
    built = compiled(unit_of(PID, free=FREE, precision=precision), SANITIZED)
    assert built.code == 0, built.output


def test_they_are_in_a_struct_of_their_own(gcc):
    unit = unit_of(PID, free=FREE)
    header = c_source.header(unit)
    assert "double pid_step(pid_state *state, const pid_params *params, double r, double y);" in header
    assert "void pid_params_init(pid_params *params);" in header
    assert "    double GE; // (0, 10]" in header
    assert "// Free: GE, 0.7 in the rule file" in header
    assert "// Param GE" not in header
    assert [m for m, _ in CLayout(unit).members] == [m for m, _ in CLayout(unit_of(PID)).members]


def test_they_are_inputs_of_the_function_block_with_the_numbers_of_the_file():
    text = function_block(unit_of(PID, "st", free=FREE))
    assert "  GE_fz : LREAL := 0.7;" in text[: text.index("VAR_OUTPUT")]


def test_a_start_that_depends_on_one_is_refused():
    text = "controller c\ninput x\nparam k = 1\nstate s = 2 * k\nnext s = k * x\noutput y = s\nevery 1 s\n"
    with pytest.raises(CodegenError, match="the start of a state depends on a free number, one of k"):
        unit_of(text, free=["k"])


def test_a_number_of_samples_is_none():
    text = "controller c\ninput x\nparam n = 5\noutput y = delay(x, n)\nevery 1 s\n"
    with pytest.raises(ArgumentError, match="'n' cannot be free"):
        unit_of(text, free=["n"])


def test_a_name_that_the_controller_does_not_have_is_refused():
    with pytest.raises(UnknownNameError, match="GU"):
        unit_of(PID, free=["GU"])


def test_inputs_and_numbers_may_have_the_same_names(gcc, compiled):
    text = (
        "controller c\ninput params\nparam double = 2\nparam state = 3\noutput y = params * double + state\nevery 1 s\n"
    )
    built = compiled(unit_of(text, free=["double", "state"]), SANITIZED)
    assert built.code == 0, built.output
