"""Matching of rules of two systems: by antecedent, and among equal antecedents by consequent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from fuzzyctl.comparison.rules import FlatRule


@dataclass(frozen=True)
class Said:
    """What a rule says of one output.

    Args:
        position: The rule's position in its system.
        rule: The rule.
        output: The output.
        text: The consequent, weight included.
    """

    position: int
    rule: FlatRule
    output: str
    text: str


@dataclass(frozen=True)
class RulePair:
    """Rules of one antecedent that stand for each other, as wholes or in what they say of one output.

    Args:
        before: In the first system; None for what was added.
        after: In the second; None for what was removed.
        changed: For each output with different consequents the texts of both, None for nothing; empty for a rule
            that was added or removed as a whole.
        places: Positions of both, for telling whether their order is the same; None for one without a partner.
    """

    before: FlatRule | None
    after: FlatRule | None
    changed: tuple[tuple[str, str | None, str | None], ...] = ()
    places: tuple[int, int] | None = None


@dataclass
class _Group:
    """Rules of one antecedent that have no partner yet, by their positions."""

    first: dict[int, FlatRule] = field(default_factory=dict)
    second: dict[int, FlatRule] = field(default_factory=dict)


def rule_pairs(first: Sequence[FlatRule], second: Sequence[FlatRule], *, wholes: bool) -> Iterator[RulePair]:
    """Pair the rules of two systems.

    Args:
        first: The rules of the first system, in the order written.
        second: Those of the second, with keys, outputs and terms as the first calls them.
        wholes: Whether rules count as wholes. Else a rule with two consequents means the same as two rules with one.
    """
    groups: dict[str, _Group] = {}
    for k, rule in enumerate(first):
        groups.setdefault(rule.key, _Group()).first[k] = rule
    for k, rule in enumerate(second):
        groups.setdefault(rule.key, _Group()).second[k] = rule
    for group in groups.values():
        yield from _same(group)
        yield from _changed_wholes(group) if wholes else _changed_parts(group)


def _same(group: _Group) -> Iterator[RulePair]:
    """Yield rules that say the same, those of the same rule block first, and take them out of the group."""
    for block in (True, False):
        for i, a in list(group.first.items()):
            fitting = (j for j, b in group.second.items() if _says(a) == _says(b) and (a.block == b.block or not block))
            j = next(fitting, None)
            if j is not None:
                yield RulePair(group.first.pop(i), group.second.pop(j), places=(i, j))


def _says(rule: FlatRule) -> list[tuple[str, str]]:
    return sorted(rule.consequents)


def _changed_wholes(group: _Group) -> Iterator[RulePair]:
    """Yield rules with the one that has most in common, at least an output."""
    for i, a in group.first.items():
        best, negative = max(((_common(a, b), -j) for j, b in group.second.items()), default=((0, 0), 0))
        if best[1] == 0:
            yield RulePair(a, None)
            continue
        j = -negative
        b = group.second.pop(j)
        pairs = _said_pairs(_said(i, a), _said(j, b))
        changed = tuple(_texts(s, t) for s, t in pairs if s is None or t is None or s.text != t.text)
        yield RulePair(a, b, changed, (i, j))
    yield from (RulePair(None, b) for b in group.second.values())


def _texts(s: Said | None, t: Said | None) -> tuple[str, str | None, str | None]:
    """Return an output and what two rules say of it, at least one of them something."""
    one = s or t
    assert one is not None
    return one.output, s.text if s else None, t.text if t else None


def _common(a: FlatRule, b: FlatRule) -> tuple[int, int]:
    """Return how many consequents two rules have in common, and how many outputs."""
    outputs = {output for output, _ in a.consequents} & {output for output, _ in b.consequents}
    return len(set(a.consequents) & set(b.consequents)), len(outputs)


def _changed_parts(group: _Group) -> Iterator[RulePair]:
    """Yield pairs of consequents, output by output; a rule without any matched consequent stays whole."""
    first = [s for i, rule in group.first.items() for s in _said(i, rule)]
    second = [t for j, rule in group.second.items() for t in _said(j, rule)]
    pairs = list(_said_pairs(first, second))
    met = {id(one.rule) for s, t in pairs if s and t for one in (s, t)}
    shown: set[int] = set()
    for s, t in pairs:
        before, after = s.rule if s else None, t.rule if t else None
        if s and t:
            changed = (_texts(s, t),) if s.text != t.text else ()
            yield RulePair(before, after, changed, (s.position, t.position))
        elif id(before or after) in met:
            yield RulePair(before, after, (_texts(s, t),))
        elif id(before or after) not in shown:
            shown.add(id(before or after))
            yield RulePair(before, after)


def _said(position: int, rule: FlatRule) -> list[Said]:
    return [Said(position, rule, output, text) for output, text in rule.consequents]


def _said_pairs(first: list[Said], second: list[Said]) -> Iterator[tuple[Said | None, Said | None]]:
    """Yield what is said on both sides with its partner: the same in the same block, the same, of the same output."""
    left, right = list(first), list(second)
    likeness: tuple[Callable[[Said], object], ...] = (
        lambda s: (s.output, s.text, s.rule.block),
        lambda s: (s.output, s.text),
        lambda s: s.output,
    )
    partner: dict[int, Said] = {}
    for like in likeness:
        for s in [s for s in left if id(s) not in partner]:
            found = next((t for t in right if like(t) == like(s)), None)
            if found is not None:
                partner[id(s)] = found
                right = [t for t in right if t is not found]
    yield from ((s, partner.get(id(s))) for s in left)
    yield from ((None, t) for t in right)
