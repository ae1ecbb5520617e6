"""Order of rules in two systems: which activation methods depend on it, and for which rules."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from fuzzyctl.comparison.rule_pairs import RulePair
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem

#: Positions of one rule in two systems.
Places = tuple[int, int]


def order_changed(a: FuzzySystem, b: FuzzySystem, pairs: Sequence[RulePair]) -> bool:
    """Return whether rules stand in another order where that changes what they do.

    Adaptive outputs have one state a rule, in the order written. Activation methods that choose rules go through those
    of their block. Where an antecedent reads how far the rules before it have activated an output, it matters which of
    the rules that set this output stand before.
    """
    places = sorted({pair.places for pair in pairs if pair.places})
    if any(o.adaptive is not None for s in (a, b) for o in s.outputs):
        return _inverted(places)
    return any(map(_inverted, _by_block(a, b, places))) or _reads_others(a, b, places)


def _inverted(places: Sequence[Places]) -> bool:
    return any(later < earlier for (_, earlier), (_, later) in itertools.pairwise(places))


def _by_block(a: FuzzySystem, b: FuzzySystem, places: Sequence[Places]) -> list[list[Places]]:
    """Return the places of rules that are chosen by their order, for each block of the first system."""
    found: dict[int, list[Places]] = {}
    for i, j in places:
        methods = a.rule_methods[i], b.rule_methods[j]
        if any(m.activation.compares and m.activation.kind != "proportional" for m in methods):
            found.setdefault(methods[0].block, []).append((i, j))
    return list(found.values())


def _reads_others(a: FuzzySystem, b: FuzzySystem, places: Sequence[Places]) -> bool:
    """Whether a rule reads an output whose rules stand before it in one system and behind it in the other."""
    if all(s.method.semantics.chained != "degree" for s in (a, b)):
        return False
    setting: dict[str, list[Places]] = {o.name: [] for o in a.outputs}
    for i, j in places:
        for output in {c.output for c in a.rules[i].consequents}:
            setting[output].append((i, j))
    for i, j in places:
        for output in {p.variable for p in literals(a.rules[i].antecedent)} & setting.keys():
            if any((p < i) != (q < j) for p, q in setting[output] if (p, q) != (i, j)):
                return True
    return False
