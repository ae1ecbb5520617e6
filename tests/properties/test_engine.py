"""Generated systems that use everything: backends agree with each other, a plain reference and the proofs."""

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given, note

from fuzzyctl import FuzzySystem, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.expr import Number
from fuzzyctl.model.method import Defuzzifier, Method
from fuzzyctl.model.rule import Consequent, Is, Rule, RuleBlock
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests.own_fields import names_of
from tests.properties.drawn_systems import KINDS, RANGES, STRAIGHT, memberships, points, systems
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


@quick(24)
@given(st.data())
def test_exact_centroids_are_limits_of_sampled_ones(data):
    lower, upper = data.draw(st.sampled_from(RANGES))
    sets = [data.draw(memberships(lower, upper, STRAIGHT)) for _ in range(3)]
    ramp = Membership(kind="ramp", arguments=(Number(0.0), Number(1.0)))
    inputs = tuple(
        Input(name=n, lower=Number(0.0), upper=Number(1.0), terms=(Term(name="on", membership=ramp),)) for n in "xyz"
    )
    rules = tuple(
        Rule(antecedent=Is(variable=n, term="on"), consequents=(Consequent(output="u", term=n),)) for n in "xyz"
    )
    if data.draw(st.booleans()):
        kinds = st.sampled_from([None, "min", "product", "bounded_difference"])
        rules = tuple(RuleBlock(name=f"b{k}", rules=(r,), implication=data.draw(kinds)) for k, r in enumerate(rules))
    method = Method(
        implication=data.draw(st.sampled_from(["min", "product"])),
        aggregation=data.draw(st.sampled_from(["max", "sum"])),
    )

    def system(resolution):
        output = Output(
            name="u",
            lower=Number(lower),
            upper=Number(upper),
            terms=tuple(Term(name=n, membership=m) for n, m in zip("xyz", sets, strict=True)),
            otherwise="nan",
            defuzzifier=Defuzzifier(resolution=resolution),
        )
        return FuzzySystem(name="s", method=method, inputs=inputs, outputs=(output,), blocks=rules)

    exact, sampled = (compile_system(system(r), "python") for r in (None, 4000))
    for _ in range(2):
        point = tuple(data.draw(st.floats(0.05, 1.0)) for _ in "xyz")
        assert exact(*point) == pytest.approx(sampled(*point), abs=2e-3 * (upper - lower), nan_ok=True)
