"""Rules, variables and terms of two systems, matched with each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from fuzzyctl.comparison.settings import plain_text
from fuzzyctl.expr import ONE
from fuzzyctl.formats.fz import antecedent_text, rule_text
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule, RuleTable, rules_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Term


@dataclass(frozen=True)
class Said:
    """The consequent of a rule for one output.

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
    """Rules of one antecedent that stand for each other, as wholes or in the consequent of one output.

    Args:
        before: In the first system; None if added.
        after: In the second; None if removed.
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
    """Return an output and the consequents of two rules for it; one of them exists."""
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
    listed: set[int] = set()
    for s, t in pairs:
        before, after = s.rule if s else None, t.rule if t else None
        if s and t:
            changed = (_texts(s, t),) if s.text != t.text else ()
            yield RulePair(before, after, changed, (s.position, t.position))
        elif id(before or after) in met:
            yield RulePair(before, after, (_texts(s, t),))
        elif id(before or after) not in listed:
            listed.add(id(before or after))
            yield RulePair(before, after)


def _said(position: int, rule: FlatRule) -> list[Said]:
    return [Said(position, rule, output, text) for output, text in rule.consequents]


def _said_pairs(first: list[Said], second: list[Said]) -> Iterator[tuple[Said | None, Said | None]]:
    """Yield consequents with their partners: the same in the same block, the same, of the same output."""
    left, right = list(first), list(second)
    likeness: tuple[Callable[[Said], object], ...] = (
        lambda s: (s.output, s.text, s.rule.block),
        lambda s: (s.output, s.text),
        lambda s: s.output,
    )
    partner: dict[int, Said] = {}
    for like in likeness:
        for s in [s for s in left if id(s) not in partner]:
            match = next((t for t in right if like(t) == like(s)), None)
            if match is not None:
                partner[id(s)] = match
                right = [t for t in right if t is not match]
    yield from ((s, partner.get(id(s))) for s in left)
    yield from ((None, t) for t in right)


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
        """Return the name in the first system of a rule block of the second."""
        return self.blocks.get(name, name)

    def variable(self, name: str) -> str:
        """Return the name in the first system of a variable of the second."""
        return self.variables.get(name, name)

    def term(self, variable: str, name: str) -> str:
        """Return the name in the first system of a term of the second."""
        return self.terms.get((variable, name), name)


def matches(a: FuzzySystem, b: FuzzySystem) -> Matches:
    """Pair variables and terms by name, and by name but for case and signs; of the rest those that mean the same."""
    variables: dict[str, str] = {}
    terms: dict[tuple[str, str], str] = {}
    for one, other in ((a.inputs, b.inputs), (a.outputs, b.outputs)):
        for first, second in _variable_pairs(one, other):
            variables[second.name] = first.name
            for t, u in _term_pairs(first.terms, second.terms):
                terms[second.name, u.name] = t.name
    return Matches(variables, terms)


def _by_name(
    one: Sequence[Named], other: Sequence[Named]
) -> tuple[list[tuple[Named, Named]], list[Named], list[Named]]:
    """Return pairs of the same name, or of names that differ in case and signs only, and the rest of both."""
    pairs: list[tuple[Named, Named]] = []
    left, right = list(one), list(other)
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
    """Return the letters and digits of a name in small letters, which formats that rename keep."""
    return "".join(c for c in name.casefold() if c.isalnum())


def _variable_pairs(
    one: Sequence[LinguisticVariable], other: Sequence[LinguisticVariable]
) -> list[tuple[LinguisticVariable, LinguisticVariable]]:
    pairs, left, right = _by_name(one, other)
    for v in left:
        same = [w for w in right if (w.lower, w.upper) == (v.lower, v.upper) and _shapes(w) == _shapes(v)]
        if len(same) == 1 and sum(_shapes(u) == _shapes(v) for u in left) == 1:
            pairs.append((v, same[0]))
    return pairs


def _shapes(v: LinguisticVariable) -> list[object]:
    return [t.membership for t in v.terms]


def _term_pairs(one: Sequence[Term], other: Sequence[Term]) -> list[tuple[Term, Term]]:
    pairs, left, right = _by_name(one, other)
    for t in left:
        same = [u for u in right if u.membership == t.membership]
        if len(same) == 1 and sum(u.membership == t.membership for u in left) == 1:
            pairs.append((t, same[0]))
    return pairs


@dataclass(frozen=True)
class FlatRule:
    """A rule with its names in reports.

    Args:
        key: Its antecedent in a form that does not depend on the order of its parts.
        rule: The rule.
        what: `cell` of a table, or `rule`.
        name: Its antecedent, or row and column of its cell.
        text: The rule as a line.
        consequents: Outputs with their consequents, weight included.
        block: Name of its rule block, empty without one.
    """

    key: str
    rule: Rule
    what: str
    name: str
    text: str
    consequents: tuple[tuple[str, str], ...]
    block: str = ""


def flat_rules(system: FuzzySystem, names: Matches | None = None, *, carried: bool = False) -> list[FlatRule]:
    """Return the rules of a system one by one, in the order written.

    Args:
        system: The system.
        names: How another system calls its variables and terms; keys and consequents then use those names.
        carried: Whether a hedge in a consequent stays for all later ones of its rule, which then say so.
    """
    names = names or Matches({}, {})
    rules = []
    for what, rule, block in _rules(system):
        name = antecedent_text(rule.antecedent, top=True)
        consequents = tuple(_consequents(rule, names, carried))
        key = _key(rule.antecedent, names)
        rules.append(FlatRule(key, rule, what, name, rule_text(rule), consequents, names.block(block)))
    return rules


def with_blocks(a: FuzzySystem, b: FuzzySystem, names: Matches) -> Matches:
    """Add which rule block is which: those of one name, and of the rest those that share most of their rules."""
    first, second = _said_by_block(a, Matches({}, {})), _said_by_block(b, names)
    left = [name for name in first if name not in second]
    blocks: dict[str, str] = {}
    for name in (n for n in second if n not in first):
        shared = {one: (first[one] & second[name]).total() for one in left}
        best = max(left, key=lambda one: shared[one], default=None)
        if best is not None and 2 * shared[best] > max(first[best].total(), second[name].total()):
            blocks[name] = best
            left.remove(best)
    return replace(names, blocks=blocks)


def _said_by_block(system: FuzzySystem, names: Matches) -> dict[str, Counter[object]]:
    """Count the antecedents and consequents of each rule block, in the names of another system."""
    counts: dict[str, Counter[object]] = {block.name: Counter() for block in system.rule_blocks}
    for rule in flat_rules(system, names):
        if rule.block:
            counts[rule.block][rule.key, rule.consequents] += 1
    return counts


def _rules(system: FuzzySystem) -> Iterator[tuple[str, Rule, str]]:
    """Yield rules with their kind and the name of their rule block, empty without one."""
    names = [b.name for b in system.rule_blocks]
    kinds = ["cell" if isinstance(p, RuleTable) else "rule" for p in system.tables_and_rules for _ in rules_of(p)]
    for kind, rule, method in zip(kinds, system.rules, system.rule_methods, strict=True):
        yield kind, rule, names[method.block] if method.block >= 0 else ""


def _key(antecedent: Antecedent, names: Matches) -> str:
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return " ".join([names.variable(variable), "is", *hedges, names.term(variable, term)])
        case Not(operand=operand):
            return f"not ({_key(operand, names)})"
        case And(operands=operands) | Or(operands=operands):
            word = " and " if isinstance(antecedent, And) else " or "
            return f"({word.join(sorted(_key(o, names) for o in operands))})"
    raise TypeError(type(antecedent).__name__)


def _consequents(rule: Rule, names: Matches, carried: bool) -> Iterator[tuple[str, str]]:
    """Yield outputs with the consequents of a rule."""
    before: list[str] = []
    for c in rule.consequents:
        after = f" after {' '.join(before)}" if before else ""
        yield names.variable(c.output), _consequent(c, names) + after + _weight(rule)
        before = [*c.hedges, *before] if carried else []


def _consequent(c: Consequent, names: Matches) -> str:
    term = names.term(c.output, c.term) if isinstance(c.term, str) else _function(c.term)
    return " ".join([*c.hedges, term])


def _function(m: Membership) -> str:
    return f"{m.kind}({', '.join(map(plain_text, m.arguments))})"


def _weight(rule: Rule) -> str:
    return f" weight {plain_text(rule.weight)}" if rule.weight != ONE else ""
