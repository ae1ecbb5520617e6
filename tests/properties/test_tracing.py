"""Systems of all kinds, drawn at random: an evaluation taken apart is the kernel's."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import DiagnosticError, NoRuleFiresError, as_profile, why
from fuzzyctl import compile as compile_system
from fuzzyctl.model.profiles import PROFILES
from tests.properties.drawn_systems import plain_systems, points, systems
from tests.properties.running import evaluated, quick

ODD = st.sampled_from([math.nan, math.inf, -math.inf])


def compare(system, kernel, point):
    expected = evaluated(kernel, point)
    try:
        found = why(system, **dict(zip((i.name for i in system.inputs), point, strict=True)))
    except NoRuleFiresError:
        assert expected == "error"
        return
    if expected == "error":  # where the file promises that some rule fires, and none does, there is no value
        assert any(o.otherwise is None and math.isnan(found.outputs[o.name]) for o in system.outputs)
        return
    assert list(found.outputs.values()) == pytest.approx(expected, rel=1e-12, abs=1e-12, nan_ok=True)
    for output in system.outputs:
        parts = [c for r in found.rules for c in r.contributions if c.output == output.name]
        # A rule may act and be felt as nothing, where a hedge makes 0 of its activation.
        assert sum(c.share for c in parts) == pytest.approx(1.0 if any(c.effective_activation for c in parts) else 0.0)
        pulls = [c.influence for c in parts if c.influence is not None]
        # What the output differs from the mean by, and rounding. Functions of inputs without a value pull nowhere.
        largest = max((abs(c.value) for c in parts if c.influence is not None), default=0.0)
        assert abs(sum(pulls)) <= 2e-9 * largest


@quick(60)
@given(data=st.data(), system=systems() | systems(held=True) | plain_systems(), profile=st.sampled_from(list(PROFILES)))
def test_outputs_are_those_of_the_kernel_and_pulls_add_up_to_nothing(data, system, profile):
    try:
        system = as_profile(system, profile)
        kernel = compile_system(system, "python")
    except DiagnosticError:  # what the tool does not evaluate, or a defuzzifier does not under its numerics
        return
    (ordinary,) = data.draw(points(system, count=1))
    place = data.draw(st.integers(0, len(ordinary) - 1))
    compare(system, kernel, ordinary)
    compare(system, kernel, (*ordinary[:place], data.draw(ODD), *ordinary[place + 1 :]))
