"""Generated systems: backends agree with each other and with an obvious reference, and stay inside proved bounds."""

import math
import warnings
from fractions import Fraction
from itertools import pairwise, product

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, note

from fuzzyctl import Consequent, FuzzySystem, Input, Is, Membership, Method, Output, Rule, Term, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.expr import Number
from fuzzyctl.testing import check_text
from tests.properties.around import corners_of
from tests.properties.drawn_systems import OVER_RULES, OVER_SETS, PLAIN_RANGES, linear_terms, plain_systems, points
from tests.properties.running import evaluated, quick
from tests.reference.formulas import corners
from tests.reference.interpreter import Reference
from tests.reference.sets import Straight


def tolerance(output):
    lower, upper = output.lower.value, output.upper.value
    return 1e-13 * (upper - lower) + 4e-16 * max(abs(lower), abs(upper), 1.0)


def alike(a, b, tolerances):
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return all((math.isnan(x) and math.isnan(y)) or abs(x - y) <= t for x, y, t in zip(a, b, tolerances, strict=True))


def test_all_defuzzifiers_are_drawn():
    ((known,),) = (d.facts for d in check_text("system s\ndefuzzifier zzz\n")[1] if d.code == "FZ213")
    assert set(known.removeprefix("one of: ").split(", ")) == {*OVER_SETS, *OVER_RULES}


@quick(120)
@given(st.data())
def test_generated_python_and_numpy_agree_with_the_reference(data):
    system = data.draw(plain_systems())
    kernel, arrays = compile_system(system, "python"), compile_system(system, "numpy")
    tolerances = [tolerance(o) for o in system.outputs]
    for point in data.draw(points(system, special=True)):
        found = evaluated(kernel, point)
        assert alike(found, evaluated(arrays, point, batch=True), tolerances)
        if any(math.isnan(x) for x in point):
            assert all(math.isnan(x) for x in found)
            continue
        reference = Reference(system, point)
        expected = reference.values()
        if not reference.tiny:
            note(f"{point} {found} {expected}")
            assert alike(found, expected, tolerances)


@st.composite
def joined_sets(draw):
    """Two to five overlapping sets whose activations are the inputs themselves."""
    lower, upper = draw(st.sampled_from(PLAIN_RANGES))
    sets = draw(st.lists(linear_terms(lower, upper), min_size=2, max_size=5))
    ramp = Membership(kind="triangle", arguments=(Number(0.0), Number(1.0), Number(math.inf)))
    inputs = tuple(
        Input(name=f"x{i}", lower=Number(0.0), upper=Number(1.0), terms=(Term(name="on", membership=ramp),))
        for i in range(len(sets))
    )
    output = Output(
        name="u",
        lower=Number(lower),
        upper=Number(upper),
        terms=tuple(Term(name=f"t{i}", membership=m) for i, m in enumerate(sets)),
        otherwise="nan",
    )
    rules = tuple(
        Rule(antecedent=Is(variable=f"x{i}", term="on"), consequents=(Consequent(output="u", term=f"t{i}"),))
        for i in range(len(sets))
    )
    method = Method(
        implication=draw(st.sampled_from(["min", "product"])), aggregation=draw(st.sampled_from(["max", "sum"]))
    )
    return FuzzySystem(name="s", method=method, inputs=inputs, outputs=(output,), blocks=rules)


@quick(80)
@given(st.data())
def test_exact_centroids_are_exact(data):
    system = data.draw(joined_sets())
    kernel = compile_system(system, "python")
    output = system.outputs[0]
    lower, upper = output.lower.value, output.upper.value
    degrees = st.integers(0, 4).map(lambda i: i / 4) | st.floats(1e-9, 1.0)
    for _ in range(4):
        point = tuple(data.draw(degrees) for _ in system.inputs)
        sets = [corners(t.membership.kind, [a.value for a in t.membership.arguments]) for t in output.terms]
        terms = list(zip(sets, point, strict=True))
        expected = Straight(terms, system.method.implication, system.method.aggregation, lower, upper).centroid()
        found = kernel(*point)
        if expected is None:
            assert math.isnan(found)
        else:
            # 1e-14 of the range, and the last digit that a result near the ends of the range can have.
            assert abs(Fraction(found) - expected) <= 1e-14 * (upper - lower) + math.ulp(max(abs(lower), abs(upper)))


@pytest.mark.usefixtures("kernel_folder")
@quick(6, 2)
@given(st.data())
def test_compiled_kernels_agree_with_generated_python(data):
    system = data.draw(plain_systems())
    kernel, compiled = compile_system(system, "python"), compile_system(system, "numba")
    tolerances = [tolerance(o) for o in system.outputs]
    for point in data.draw(points(system, count=30, special=True)):
        found = evaluated(kernel, point)
        assert alike(found, evaluated(compiled, point), tolerances)
        assert alike(found, evaluated(compiled, point, batch=True), tolerances)


@quick(80)
@given(st.data())
def test_exact_bounds_are_attained_where_they_say(data):
    system = data.draw(plain_systems(averages=True))
    kernel = compile_system(system, "python")
    for k, output in enumerate(system.outputs):
        bound = output_bounds(system)[output.name]
        for end, at in ((bound.lo, bound.lo_at), (bound.hi, bound.hi_at)):
            found = evaluated(kernel, tuple(at.values())) if at else "nowhere"
            if not isinstance(found, str):
                assert found[k] == end
        assume(bound.exact)
        assert bound.lo_at is not None
        assert bound.hi_at is not None


def critical_points(system):
    """Corners of the input terms with their neighbours among the floats, and points between."""
    axes = []
    for variable in system.inputs:
        own, (lower, upper) = corners_of(variable), system.range_of(variable)
        between = [(a + b) / 2 for a, b in pairwise(own)]
        near = [math.nextafter(x, side) for x in own for side in (-math.inf, math.inf)]
        axes.append(sorted({*own, *between, *(x for x in near if lower <= x <= upper)})[::2])
    return list(product(*axes))[:400]


@quick(80)
@given(st.data())
def test_coverage_agrees_with_sampling_at_corners_and_beside_them(data):
    system = data.draw(plain_systems(averages=True, extrapolate=False))
    verdicts = uncovered(system)
    for output in system.outputs:
        verdict = verdicts[output.name]

        def fires(point, output=output):
            return bool(Reference(system, point).parts(output))

        if verdict is None:
            assert all(fires(point) for point in critical_points(system))
        elif isinstance(verdict, Hole):
            assert not fires(tuple(verdict.witness.values()))
            for ends in product(*((s.lower, s.upper) for s in verdict.region.values())):
                inside = [s.middle * 0.5 + e * 0.5 for s, e in zip(verdict.region.values(), ends, strict=True)]
                assert not fires(inside)


@quick(60)
@given(st.data())
def test_arrays_give_what_points_give_and_warn_about_nothing(data):
    system = data.draw(plain_systems(extrapolate=False))
    for output in system.outputs:
        assume(output.otherwise not in ("error", None))
    kernel = compile_system(system, "numpy")
    batch = np.array(data.draw(points(system, count=8, special=True))).reshape(2, 4, -1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = kernel.batch(batch)
    width = len(system.outputs)
    assert found.shape == ((2, 4) if width == 1 else (2, 4, width))
    for index in np.ndindex(2, 4):
        single = evaluated(kernel, batch[index].tolist())
        assert alike(single, np.atleast_1d(found[index]), [tolerance(o) for o in system.outputs])
