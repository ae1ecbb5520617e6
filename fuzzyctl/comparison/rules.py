"""Flat rules of a system, in a form in which those of two systems can be matched."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from fuzzyctl.comparison.names import Matches
from fuzzyctl.comparison.settings import plain_text
from fuzzyctl.expr import ONE
from fuzzyctl.formats.fz import antecedent_text, rule_text
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule, RuleTable, rules_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership


@dataclass(frozen=True)
class FlatRule:
    """A rule with what it is called in reports.

    Args:
        key: Its antecedent in a form that does not depend on the order of its parts.
        rule: The rule.
        what: `cell` of a table, or `rule`.
        name: Its antecedent, or row and column of its cell.
        text: The rule as a line.
        consequents: Outputs with what it says of them, weight included.
        block: Name of its rule block, nothing for a rule of none.
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
    found = []
    for what, rule, block in _rules(system):
        name = antecedent_text(rule.antecedent, top=True)
        consequents = tuple(_consequents(rule, names, carried))
        key = _key(rule.antecedent, names)
        found.append(FlatRule(key, rule, what, name, rule_text(rule), consequents, names.block(block)))
    return found


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
    """Return what the rules of each rule block say, in the names of another system."""
    found: dict[str, Counter[object]] = {block.name: Counter() for block in system.rule_blocks}
    for rule in flat_rules(system, names):
        if rule.block:
            found[rule.block][rule.key, rule.consequents] += 1
    return found


def _rules(system: FuzzySystem) -> Iterator[tuple[str, Rule, str]]:
    """Yield rules with what they are and the name of their rule block, nothing for those of none."""
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
    """Yield outputs with what a rule says of them."""
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
