"""Which variable and which term of one system is which of another, also where one was renamed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Term


@dataclass(frozen=True)
class Matches:
    """Pairs of things that stand for each other.

    Args:
        variables: Name in the first system by name in the second.
        terms: Name of a term in the first system by (variable, term) of the second.
    """

    variables: Mapping[str, str]
    terms: Mapping[tuple[str, str], str]

    def variable(self, name: str) -> str:
        """Return what a variable of the second system is called in the first."""
        return self.variables.get(name, name)

    def term(self, variable: str, name: str) -> str:
        """Return what a term of the second system is called in the first."""
        return self.terms.get((variable, name), name)


def matches(a: FuzzySystem, b: FuzzySystem) -> Matches:
    """Pair variables and terms by name; of what is left those that mean the same, as after renaming."""
    variables: dict[str, str] = {}
    terms: dict[tuple[str, str], str] = {}
    for own, other in ((a.inputs, b.inputs), (a.outputs, b.outputs)):
        for first, second in _variable_pairs(own, other):
            variables[second.name] = first.name
            for t, u in _term_pairs(first.terms, second.terms):
                terms[second.name, u.name] = t.name
    return Matches(variables, terms)


def _variable_pairs(
    own: Sequence[LinguisticVariable], other: Sequence[LinguisticVariable]
) -> list[tuple[LinguisticVariable, LinguisticVariable]]:
    by_name = {v.name: v for v in own}
    pairs = [(by_name[v.name], v) for v in other if v.name in by_name]
    named = {v.name for v in other}
    left, right = [v for v in own if v.name not in named], [v for v in other if v.name not in by_name]
    for v in left:
        same = [w for w in right if (w.lower, w.upper) == (v.lower, v.upper) and _shapes(w) == _shapes(v)]
        if len(same) == 1 and sum(_shapes(u) == _shapes(v) for u in left) == 1:
            pairs.append((v, same[0]))
    return pairs


def _shapes(v: LinguisticVariable) -> list[object]:
    return [t.membership for t in v.terms]


def _term_pairs(own: Sequence[Term], other: Sequence[Term]) -> list[tuple[Term, Term]]:
    by_name = {t.name: t for t in own}
    pairs = [(by_name[t.name], t) for t in other if t.name in by_name]
    named = {t.name for t in other}
    left, right = [t for t in own if t.name not in named], [t for t in other if t.name not in by_name]
    for t in left:
        same = [u for u in right if u.membership == t.membership]
        if len(same) == 1 and sum(u.membership == t.membership for u in left) == 1:
            pairs.append((t, same[0]))
    return pairs
