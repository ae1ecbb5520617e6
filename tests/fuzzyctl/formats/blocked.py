"""Systems whose rules stand in blocks, and what of them a file must keep."""

import dataclasses
from itertools import pairwise

from hypothesis import strategies as st

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.model.rule import RuleBlock


@st.composite
def blocked(draw, systems, norms, activations=None):
    """Draw a system whose rules stand in several blocks with methods of their own.

    Args:
        draw: Draws.
        systems: Draws systems; each of their rules is there twice then.
        norms: Pairs of conjunction and disjunction.
        activations: Draws activation methods, None for none.
    """
    base = draw(systems)
    rules = draw(st.permutations(base.rules * 2))
    cuts = sorted(draw(st.sets(st.integers(1, len(rules) - 1), min_size=1, max_size=2)))
    blocks = []
    for k, (a, b) in enumerate(pairwise([0, *cuts, len(rules)])):
        conjunction, disjunction = draw(st.sampled_from([(None, None), *norms]))
        own = {
            "conjunction": conjunction,
            "disjunction": disjunction,
            "implication": draw(st.sampled_from([None, "min", "product"])),
            "activation": draw(st.none() | activations) if activations is not None else None,
        }
        blocks.append(RuleBlock(name=f"Block_{k + 1}", rules=tuple(rules[a:b]), **own))
    return base.model_copy(update={"blocks": tuple(blocks)})


def keeps_blocks(system, back):
    """Hold a system that was read back to the one that was written: names and places, and all that is computed."""
    assert [b.name for b in back.rule_blocks] == [b.name for b in system.rule_blocks]
    assert [m.block for m in back.rule_methods] == [m.block for m in system.rule_methods]
    assert back.rules == system.rules
    try:
        planned = plan(system)
    except DiagnosticError:  # such as maxima that have no closed form
        return
    assert heeded(plan(back)) == heeded(planned)


def heeded(found):
    """Return a plan without implications that averages and sums over rules do not heed."""
    outputs = tuple(dataclasses.replace(o, implication="min") if o.over_rules else o for o in found.outputs)
    return dataclasses.replace(found, outputs=outputs)
