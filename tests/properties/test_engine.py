"""Generated systems that use everything: backends agree with each other, a plain reference and the proofs."""

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given, note

from fuzzyctl import FuzzySystem, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered
from tests.own_fields import names_of
from tests.properties.drawn_systems import KINDS, points, systems
from tests.properties.running import evaluated, quick
from tests.reference.interpreter import Reference


def alike(a, b, system, tolerance=1e-12):
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    scales = [max(abs(o.lower.value), abs(o.upper.value), 30.0) for o in system.outputs]
    return all(
        (math.isnan(x) and math.isnan(y)) or abs(x - y) <= tolerance * max(s, abs(x))
        for x, y, s in zip(a, b, scales, strict=True)
    )


def at_jump(system, point, exact):
    """Whether rounding decides what a system gives: which samples are largest, or from where on half is reached."""
    if exact is None:
        return False
    found = [Reference(system, point, seed=seed, given=exact).values() for seed in (None, *range(6))]
    return any(not alike(found[0], other, system, 1e-9) for other in found[1:])


def exact_values(system, found):
    """The values of outputs that are exact, which a kernel tells the reference; None if it refused to."""
    exact = {
        o.name: k
        for k, o in enumerate(system.outputs)
        if not o.defuzzifier.over_rules and o.defuzzifier.resolution is None
    }
    if exact and isinstance(found, str):
        return None
    return {name: found[k] for name, k in exact.items()}


# --- properties ------------------------------------------------------------------------------------------------------


@quick(150)
@given(st.data())
def test_generated_python_and_numpy_agree_with_the_reference(data):
    system = data.draw(systems(held=True))
    kernel, arrays = compile_system(system, "python"), compile_system(system, "numpy")
    for point in data.draw(points(system)):
        found = evaluated(kernel, point)
        batch = evaluated(arrays, point, batch=True)
        exact = exact_values(system, found)
        note(f"{point} {found} {batch}")
        assert alike(found, batch, system) or at_jump(system, point, exact)
        if exact is None:
            continue
        reference = Reference(system, point, given=exact)
        expected = reference.values()
        note(f"{expected}")
        if not reference.tiny:
            assert alike(found, expected, system) or at_jump(system, point, exact)


@pytest.mark.usefixtures("kernel_folder")
@quick(6, 1)
@given(st.data())
def test_compiled_kernels_agree_with_generated_python(data):
    system = data.draw(systems(held=True))
    kernel, compiled = compile_system(system, "python"), compile_system(system, "numba")
    for point in data.draw(points(system, count=30)):
        found = evaluated(kernel, point)
        for again in (evaluated(compiled, point), evaluated(compiled, point, batch=True)):
            assert alike(found, again, system) or at_jump(system, point, exact_values(system, found))


@pytest.mark.parametrize("kind", KINDS)
@quick(120)
@given(st.data())
def test_every_sample_lies_within_the_proved_bounds(kind, data):
    system = data.draw(KINDS[kind])
    bounds, kernel = output_bounds(system), compile_system(system, "python")
    for point in data.draw(points(system, count=16, special=kind == "plain")):
        found = evaluated(kernel, point)
        if not isinstance(found, str):
            for output, value in zip(system.outputs, found, strict=True):
                assert math.isnan(value) or bounds[output.name].lo <= value <= bounds[output.name].hi


@quick(120)
@given(st.data())
def test_coverage_is_never_wrong(data):
    system = data.draw(systems())
    # Where nothing fires all outputs are NaN, and NaN goes on to those that read them.
    quiet = tuple(o.model_copy(update={"otherwise": "nan"}) for o in system.outputs)
    system = FuzzySystem(**{k: getattr(system, k) for k in names_of(type(system))} | {"outputs": quiet})
    verdicts, kernel = uncovered(system), compile_system(system, "python")
    for k, output in enumerate(system.outputs):
        verdict = verdicts[output.name]
        if verdict is None:
            for point in data.draw(points(system, count=12)):
                assert not math.isnan(evaluated(kernel, point)[k])
        elif isinstance(verdict, Hole):
            assert math.isnan(evaluated(kernel, tuple(verdict.witness.values()))[k])
