"""One controller makes the same 3,000 steps on every target, from the text on."""

import numpy as np
import pytest

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


def rows(name, count):
    """Return inputs; where a system would refuse, they lie in its terms."""
    found = rows_for(unit_of(TEXTS[name]), count)
    return np.where(np.abs(found) < 0.6, 1.0, found) if name == "refusing" else found


def require_equal(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", TEXTS)
def test_the_module_and_the_function_block_make_the_steps_of_the_kernel(name):
    text, points = TEXTS[name], rows(name, 600)
    expected = by_kernel(text, points)
    assert np.isfinite(expected).any()
    require_equal(by_python(unit_of(text, "python"), points), expected)
    require_equal(by_structured_text(unit_of(text, "st"), points), expected)


def test_c_makes_the_steps_of_the_kernel(gcc, tmp_path):
    names = [n for n in TEXTS if n != "refusing"]  # whose status the driver does not take
    units = [unit_of(TEXTS[n]) for n in names]
    points = [rows(n, 600) for n in names]
    for name, own, found in zip(names, points, by_c(units, points, tmp_path, SANITIZED), strict=True):
        require_equal(found, by_kernel(TEXTS[name], own))


def test_javascript_makes_the_steps_of_the_kernel(node, tmp_path):
    units = [unit_of(text, "javascript") for text in TEXTS.values()]
    points = [rows(n, 600) for n in TEXTS]
    for text, own, found in zip(TEXTS.values(), points, by_javascript(units, points, tmp_path), strict=True):
        require_equal(found, by_kernel(text, own))


def test_all_targets_and_backends_make_the_same_3_000_steps(gcc, node, tmp_path):
    text = TEXTS["pid"]
    points = rows("pid", 3_000)
    expected = by_kernel(text, points, "numba")
    assert 1.0 < np.nanmax(np.abs(expected)) <= 3.0
    require_equal(by_kernel(text, points, "python"), expected)
    require_equal(by_kernel(text, points, "numpy"), expected)
    require_equal(by_python(unit_of(text, "python"), points), expected)
    require_equal(by_structured_text(unit_of(text, "st"), points), expected)
    for flags in (["-O0"], ["-O3"]):
        require_equal(by_c([unit_of(text)], [points], tmp_path, flags)[0], expected)
    require_equal(by_javascript([unit_of(text, "javascript")], [points], tmp_path)[0], expected)


@pytest.mark.parametrize("dt", [0.0, -0.1, np.nan])
def test_no_step_is_made_without_a_time_on_any_target(dt, gcc, node, tmp_path):
    text = TEXTS["timed"]
    points = rows("timed", 60)[1:20]
    still = np.insert(points, 9, [*points[9, :-1], dt], axis=0)
    expected = np.insert(by_kernel(text, points), 9, np.nan, axis=0)
    require_equal(by_python(unit_of(text, "python"), still), expected)
    require_equal(by_structured_text(unit_of(text, "st"), still), expected)
    require_equal(by_c([unit_of(text)], [still], tmp_path)[0], expected)
    require_equal(by_javascript([unit_of(text, "javascript")], [still], tmp_path)[0], expected)


def test_structured_text_makes_no_step_for_infinite_inputs():
    text, points = TEXTS["pid"], rows("pid", 30)[15:]
    with_infinity = np.insert(points, 5, [np.inf, 0.0], axis=0)
    expected = np.insert(by_kernel(text, points), 5, np.nan, axis=0)
    require_equal(by_structured_text(unit_of(text, "st"), with_infinity), expected)
