"""Free numbers of controllers: the caller of generated code gives them, and steps are those of a file that has them."""

import numpy as np
import pytest

from tests.fuzzyctl.codegen.conftest import SANITIZED, written
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


def free(text, *names, target="c"):
    return written(text, target, *(word for name in names for word in ("--free", name)))


def test_they_are_in_a_struct_of_their_own_and_inputs_of_the_function_block():
    header = free(PID, *FREE).files["pid.h"]
    for line in (
        "double pid_step(pid_state *state, const pid_params *params, double r, double y);",
        "void pid_params_init(pid_params *params);",
        "    double GE; // (0, 10]",
        "// Free: GE, 0.7 in the rule file",
    ):
        assert line in header
    assert "// Param GE" not in header
    text = free(PID, *FREE, target="st").files["pid.st"]
    assert "  GE_fz : LREAL := 0.7;" in text[: text.index("VAR_OUTPUT")]


@pytest.mark.parametrize(
    ("lines", "name", "words"),
    [
        ("param k = 1\nstate s = 2 * k\nnext s = k * x\noutput y = s", "k", "the start of a state depends on a free n"),
        ("param n = 5\noutput y = delay(x, n)", "n", "'n' cannot be free"),
        ("param k = 1\noutput y = k * x", "GU", "GU"),
    ],
)
def test_a_number_that_cannot_be_free_is_refused(lines, name, words):
    found = free(f"controller c\ninput x\n{lines}\nevery 1 s\n", name)
    assert found.code != 0
    assert words in " ".join(found.errors.split())


def test_inputs_and_numbers_may_have_the_same_names(gcc, compiled):
    text = (
        "controller c\ninput params\nparam double = 2\nparam state = 3\noutput y = params * double + state\nevery 1 s\n"
    )
    built = compiled(unit_of(text, free=["double", "state"]), SANITIZED)
    assert built.code == 0, built.output
