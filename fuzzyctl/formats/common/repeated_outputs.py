"""Rules that set one output several times (fuzzylite allows it), split for formats that do not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.model.rule import Consequent, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem


def without_repeated_outputs(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose rules set each output once, of the same numbers.

    Raises:
        DiagnosticError: With the places of rules that cannot be written as several, since their activation method
            counts or compares rules.
    """
    doubled = [(rule, m) for rule, m in zip(system.rules, system.rule_methods, strict=True) if _repeats(rule)]
    if not doubled:
        return system
    counted = system.method.semantics.total == "all_rules"
    refused = [_refusal(system, rule) for rule, method in doubled if counted or method.activation.compares]
    if refused:
        raise DiagnosticError(refused)
    carried = system.method.semantics.consequent_hedges == "carried"
    blocks: list[Rule | RuleTable | RuleBlock] = []
    for block in system.blocks:
        if isinstance(block, RuleBlock):
            parts = tuple(own for part in block.rules for own in _split(part, carried))
            blocks.append(block.model_copy(update={"rules": parts}))
        else:
            blocks += _split(block, carried)
    return system.model_copy(update={"blocks": tuple(blocks)})


def _repeats(rule: Rule) -> bool:
    return len({c.output for c in rule.consequents}) < len(rule.consequents)


def _refusal(system: FuzzySystem, rule: Rule) -> Diagnostic:
    message = (
        "a rule that sets an output twice can be written as two rules only where rules are not compared or counted"
    )
    place = next((c.span for c in rule.consequents if c.span is not None), rule.span)
    file = "" if place is not None else system.path
    return Diagnostic("FZ608", message, place, help="convert it to .fll, or let the rules set it once", file=file)


def _split(part: Rule | RuleTable, carried: bool) -> Iterator[Rule | RuleTable]:
    """Yield a part as it is, or a rule as several: each takes the first consequents that are left of each output."""
    if isinstance(part, RuleTable) or not _repeats(part):
        yield part
        return
    left = _with_hedges(part.consequents) if carried else list(part.consequents)
    while left:
        outputs = list(dict.fromkeys(c.output for c in left))
        taken = [next(c for c in left if c.output == output) for output in outputs]
        if carried:
            # A hedge would be carried on within the rule once more.
            taken = taken[:1]
        left = [c for c in left if all(c is not t for t in taken)]
        yield part.model_copy(update={"consequents": tuple(taken)})


def _with_hedges(consequents: Sequence[Consequent]) -> list[Consequent]:
    """Return consequents with the hedges that those before them carry on: the nearest to a term acts first."""
    found, before = [], tuple[str, ...]()
    for c in consequents:
        before = (*c.hedges, *before)
        found.append(c.model_copy(update={"hedges": before}))
    return found
