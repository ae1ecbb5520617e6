"""What `check` says has no effect has none: generated systems of every kind, with and without the rules it names."""

import re
from collections import Counter

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, note

from fuzzyctl import RuleBlock, RuleTable, check
from fuzzyctl import compile as compile_system
from tests.properties.drawn_systems import KINDS
from tests.properties.running import quick, total


def check_effects(system, seed):
    """Rules that are reported can go; a jump that is reported is one."""
    system = total(system)
    reported_here = check(system, guarantees=False)[1]
    for jump in (d for d in reported_here if d.code == "FZ405"):
        output, size = re.match(r"output '(\w+)' jumps by (\S+)", jump.message).groups()
        low, high = system.range_of(system.output(output))
        assert float(size) > 0.999e-3 * (high - low)
    found = [d for d in reported_here if d.code == "FZ403"]
    # A rule is known by its antecedent only: of several with the same one all or none must be reported.
    reported = Counter(d.message.partition("'")[2].rpartition("'")[0] for d in found)
    idle = {text for text in reported if reported[text] == sum(text_of(r) == text for r in system.rules)}
    kept = tuple(r for r in system.rules if text_of(r) not in idle)
    named = {c.output for r in kept for c in r.consequents}
    general = all(m.activation.kind == "general" for m in system.rule_methods)
    if not idle or named != {o.name for o in system.outputs} or not general:
        return
    rng = np.random.default_rng(seed)
    ends = np.array([system.range_of(i) for i in system.inputs])
    points = rng.uniform(ends[:, 0], ends[:, 1], (400, len(ends)))
    before, after = (
        compile_system(s, "numpy", algorithm="rules").batch(points) for s in (system, without(system, idle))
    )
    note(f"{idle}")
    np.testing.assert_allclose(before, after, rtol=1e-9, atol=1e-9)


def without(system, idle):
    """The system without some rules, the others in their rule blocks."""
    blocks = []
    for part in system.blocks:
        if isinstance(part, RuleBlock):
            rules = tuple(r for r in rules_of(part.rules) if text_of(r) not in idle)
            blocks += [part.model_copy(update={"rules": rules})] if rules else []
        else:
            blocks += [r for r in rules_of([part]) if text_of(r) not in idle]
    return system.model_copy(update={"blocks": tuple(blocks)})


def rules_of(parts):
    return [r for part in parts for r in (part.rules() if isinstance(part, RuleTable) else [part])]


def text_of(rule):
    return str(rule)[len("Rule(") :].partition(" then ")[0]


@pytest.mark.parametrize("kind", KINDS)
@quick(60)
@given(st.data())
def test_rules_without_effect_can_go(kind, data):
    check_effects(data.draw(KINDS[kind]), data.draw(st.integers(0, 1000)))
