"""Losses of a system in FCL that reading the text back does not show: what no FCL tool has words for."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.formats.fcl.dialect import DialectName
from fuzzyctl.formats.fcl.written_shapes import says_otherwise, unknown_functions
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.rule import Not, literals, parts_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input


def without_words(system: FuzzySystem, dialect: DialectName) -> Iterator[Loss]:
    """Yield what of terms and rules is written in another way, or that only fuzzyctl reads."""
    whole = f"system '{system.name}'"
    if system.title:
        yield Loss(whole, "the title", "it is a comment", exact=True)
    for hedge in system.hedges:
        yield Loss(whole, f"hedge '{hedge.name}'", "FCL has no hedges of one's own; it is left out")
    for variable in (*system.inputs, *system.outputs):
        where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
        for term in variable.terms:
            if says_otherwise(term.membership, system.values, dialect):
                why = f"the {term.membership.kind} is written as points"
                yield Loss(where, f"term '{term.name}'", why, exact=True)
            for name in unknown_functions(term.membership):
                yield Loss(f"{where}, term '{term.name}'", f"function '{name}'", "no FCL tool has it")
    yield from _of_rules(system, dialect)


def _of_rules(system: FuzzySystem, dialect: DialectName) -> Iterator[Loss]:
    own = {h.name for h in system.hedges}
    no_tool = {"slightly"} if dialect == "fuzzylite" else set()
    for number, rule in enumerate(system.rules, 1):
        hedges = {h for i in literals(rule.antecedent) for h in i.hedges}
        hedges |= {h for c in rule.consequents for h in c.hedges}
        for hedge in sorted(hedges & (own | no_tool) | (hedges - set(HEDGES))):
            why = "it is left out" if hedge not in HEDGES else "only fuzzyctl reads it"
            yield Loss(f"rule {number}", f"hedge '{hedge}'", f"no FCL tool has it; {why}")
        if dialect == "fuzzylite" and any(isinstance(part, Not) for part in parts_of(rule.antecedent)):
            yield Loss(f"rule {number}", "not", "fuzzylite does not read NOT before a condition", exact=True)
