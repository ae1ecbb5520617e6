"""Free numbers: a kernel that takes them as arguments computes what the system with these numbers computes."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, note

from fuzzyctl import ArgumentError, ValueOutOfBoundsError
from fuzzyctl import compile as compile_system
from fuzzyctl.formulas import MEMBERSHIP
from tests.properties.drawn_systems import KINDS, points
from tests.properties.running import quick, total


def candidates(system):
    """The names of all numbers of a system that may be free."""
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            own = term.membership
            if own.kind in MEMBERSHIP:
                formula = MEMBERSHIP[own.kind]
                names = formula.parameters
                if formula.variadic:
                    names = [f"{'xy'[k % 2]}{k // 2 + 1}" for k in range(len(own.arguments))]
                for name, value in zip(names, own.arguments, strict=True):
                    if math.isfinite(value.value):
                        yield f"{variable.name}.{term.name}.{name}"
                yield f"{variable.name}.{term.name}.height"
    for output in system.outputs:
        yield f"{output.name}.weights"


@st.composite
def values_of(draw, kernel):
    """Values near those of the system."""
    start = kernel.start()
    moved = [draw(st.sampled_from([0.0, 0.0, 0.01, -0.03, 0.1])) for _ in start]
    return start + np.array(moved) * np.where(start == 0.0, 1.0, np.abs(start))


def allowed(compute):
    """What a function returns, None where it is refused with one of the known reasons."""
    try:
        return compute()
    except ArgumentError as error:
        if not any(reason in str(error) for reason in ("cannot be free", "adaptive integral")):
            raise
        return None


def alike(a, b):
    """Whether results agree to 1e-12 of their size; where a rounding error decides there is no one value."""
    return np.allclose(a, b, rtol=1e-12, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("kind", KINDS)
@quick(120, 10)
@given(data=st.data())
def test_free_numbers_are_those_of_the_system(kind, data):
    system = total(data.draw(KINDS[kind]))
    names = data.draw(st.lists(st.sampled_from(list(candidates(system))), min_size=1, max_size=4, unique=True))
    note(f"free {names}")
    kernel = allowed(lambda: compile_system(system, "python", free=names))
    if kernel is None:
        return
    arrays = compile_system(system, "numpy", free=names)
    rows = np.array(data.draw(points(system)))
    for values in (kernel.start(), data.draw(values_of(kernel))):
        note(f"values {values}")
        try:
            found = kernel.batch(rows, values)
        except ValueOutOfBoundsError:
            assert not np.array_equal(values, kernel.start())
            continue
        changed = system.with_values(dict(zip(kernel.free_names, values, strict=True)))
        expected = compile_system(changed, "python", algorithm="rules").batch(rows)
        assert alike(found, expected), (found, expected)
        assert alike(arrays.batch(rows, values), expected)


def slopes(function, start, steps):
    """Central differences along each axis, NaN where the function is not smooth within a step."""
    found = []
    for k, step in enumerate(steps):
        move = np.zeros(len(steps))
        move[k] = step
        ahead, here, behind = function(start + move), function(start), function(start - move)
        sides = np.stack([(ahead - here) / step, (here - behind) / step])
        smooth = np.abs(sides[0] - sides[1]) <= 1e-5 * (1.0 + np.abs(sides).max(axis=0))
        found.append(np.where(smooth, sides.mean(axis=0), np.nan))
    return np.stack(found, axis=-1)


@pytest.mark.parametrize("kind", KINDS)
@quick(80, 8)
@given(data=st.data())
def test_gradients_are_the_limits_of_differences(kind, data):
    system = total(data.draw(KINDS[kind]))
    names = data.draw(st.lists(st.sampled_from(list(candidates(system))), min_size=1, max_size=3, unique=True))
    note(f"free {names}")
    widths = np.array([i.upper.value - i.lower.value for i in system.inputs])
    # Corners are drawn on a grid, and at a kink branches may have other slopes than the whole.
    rows = np.array(data.draw(points(system))) + 0.00137 * widths
    kernel = allowed(lambda: compile_system(system, "numpy", free=names))
    by_inputs = kernel and allowed(lambda: kernel.gradient(rows, kernel.start()))
    if by_inputs is None:
        return
    plain = compile_system(system, "numpy")
    assert np.allclose(plain.gradient(rows), by_inputs, rtol=1e-9, atol=1e-9, equal_nan=True)
    by_values = kernel.gradient(rows, kernel.start(), by="state")
    for row, own in zip(rows, by_inputs, strict=True):
        differences = slopes(plain.batch, row, 1e-6 * widths)
        assert close(own, differences, widths), (row, own, differences)
    values = kernel.start()
    sizes = 1e-6 * np.maximum(np.abs(values), 1e-3)
    try:
        differences = slopes(lambda v: kernel.batch(rows, v), values, sizes)
    except ValueOutOfBoundsError:
        return  # at a bound
    assert close(by_values, differences, sizes * 1e6), (by_values, differences)


def close(exact, differences, sizes):
    """Whether derivatives are what differences tell, in outputs per size of an argument."""
    known = np.isfinite(differences)
    gap = np.abs(exact - differences) * sizes
    return bool(np.all(gap[known] <= 1e-4 * (1.0 + np.abs(differences * sizes)[known])))
