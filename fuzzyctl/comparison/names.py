"""Matching of variables and terms of two systems, renamed ones included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Term

Named = TypeVar("Named", LinguisticVariable, Term)


@dataclass(frozen=True)
class Matches:
    """Pairs of things that stand for each other.

    Args:
        variables: Name in the first system by name in the second.
        terms: Name of a term in the first system by (variable, term) of the second.
        blocks: Name of a rule block in the first system by name in the second.
    """

    variables: Mapping[str, str]
    terms: Mapping[tuple[str, str], str]
    blocks: Mapping[str, str] = field(default_factory=dict)

    def block(self, name: str) -> str:
        """Return what a rule block of the second system is called in the first."""
        return self.blocks.get(name, name)

    def variable(self, name: str) -> str:
        """Return what a variable of the second system is called in the first."""
        return self.variables.get(name, name)

    def term(self, variable: str, name: str) -> str:
        """Return what a term of the second system is called in the first."""
        return self.terms.get((variable, name), name)


def matches(a: FuzzySystem, b: FuzzySystem) -> Matches:
    """Pair variables and terms by name, and by name but for case and signs; of the rest those that mean the same."""
    variables: dict[str, str] = {}
    terms: dict[tuple[str, str], str] = {}
    for own, other in ((a.inputs, b.inputs), (a.outputs, b.outputs)):
        for first, second in _variable_pairs(own, other):
            variables[second.name] = first.name
            for t, u in _term_pairs(first.terms, second.terms):
                terms[second.name, u.name] = t.name
    return Matches(variables, terms)


def _by_name(
    own: Sequence[Named], other: Sequence[Named]
) -> tuple[list[tuple[Named, Named]], list[Named], list[Named]]:
    """Return pairs of the same name, or of names that differ in case and signs only, and what is left of both."""
    pairs: list[tuple[Named, Named]] = []
    left, right = list(own), list(other)
    for key in (lambda n: n, letters):
        names = [[key(x.name) for x in side] for side in (left, right)]
        for x, name in zip(list(left), names[0], strict=True):
            if name and names[0].count(name) == names[1].count(name) == 1:
                y = next(y for y, n in zip(list(right), names[1], strict=True) if n == name and y in right)
                pairs.append((x, y))
        left = [x for x in left if all(x is not p for p, _ in pairs)]
        right = [y for y in right if all(y is not p for _, p in pairs)]
    return pairs, left, right


def letters(name: str) -> str:
    """Return the letters and digits of a name in small letters: what is left of it when a format renames it."""
    return "".join(c for c in name.casefold() if c.isalnum())


def _variable_pairs(
    own: Sequence[LinguisticVariable], other: Sequence[LinguisticVariable]
) -> list[tuple[LinguisticVariable, LinguisticVariable]]:
    pairs, left, right = _by_name(own, other)
    for v in left:
        same = [w for w in right if (w.lower, w.upper) == (v.lower, v.upper) and _shapes(w) == _shapes(v)]
        if len(same) == 1 and sum(_shapes(u) == _shapes(v) for u in left) == 1:
            pairs.append((v, same[0]))
    return pairs


def _shapes(v: LinguisticVariable) -> list[object]:
    return [t.membership for t in v.terms]


def _term_pairs(own: Sequence[Term], other: Sequence[Term]) -> list[tuple[Term, Term]]:
    pairs, left, right = _by_name(own, other)
    for t in left:
        same = [u for u in right if u.membership == t.membership]
        if len(same) == 1 and sum(u.membership == t.membership for u in left) == 1:
            pairs.append((t, same[0]))
    return pairs
