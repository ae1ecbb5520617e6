"""Rules one by one, in a form in which those of two systems can be matched."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

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
        rule: The rule.
        what: `cell` of a table, or `rule`.
        name: Its antecedent, or row and column of its cell.
        text: The rule as a line.
        consequents: What it says of each output, weight included.
        block: Name of its rule block, nothing for a rule of none.
    """

    rule: Rule
    what: str
    name: str
    text: str
    consequents: dict[str, str]
    block: str = ""


def flat_rules(system: FuzzySystem, names: Matches | None = None) -> dict[str, FlatRule]:
    """Return the rules of a system by a key that does not depend on the order of the parts of an antecedent.

    Args:
        system: The system.
        names: How another system calls its variables and terms; keys and consequents then use those names.

    Returns:
        In the order written; of several rules with one antecedent each has a key of its own.
    """
    names = names or Matches({}, {})
    found: dict[str, FlatRule] = {}
    seen: dict[str, int] = {}
    for what, rule, block in _rules(system):
        key = _key(rule.antecedent, names)
        seen[key] = seen.get(key, 0) + 1
        name = antecedent_text(rule.antecedent, top=True)
        consequents = {names.variable(c.output): _consequent(c, names) + _weight(rule) for c in rule.consequents}
        # A second rule with the same antecedent is another rule.
        found[f"{key} #{seen[key]}"] = FlatRule(rule, what, name, rule_text(rule), consequents, block)
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


def _consequent(c: Consequent, names: Matches) -> str:
    term = names.term(c.output, c.term) if isinstance(c.term, str) else _function(c.term)
    return " ".join([*c.hedges, term])


def _function(m: Membership) -> str:
    return f"{m.kind}({', '.join(map(plain_text, m.arguments))})"


def _weight(rule: Rule) -> str:
    return f" weight {plain_text(rule.weight)}" if rule.weight != ONE else ""
