"""Losses of a system in FML."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.formats.common.clamped_inputs import holding_matters
from fuzzyctl.formats.common.numerics import other_numerics
from fuzzyctl.formats.fml.names import CONJUNCTION_WORDS, DISJUNCTION_WORDS
from fuzzyctl.formats.fml.written_rules import WrittenRules
from fuzzyctl.formats.losses import Loss
from fuzzyctl.model.method import OVER_RULES, TSUKAMOTO
from fuzzyctl.model.rule import And, Or, RuleTable, is_joined_by
from fuzzyctl.model.semantics import Semantics
from fuzzyctl.model.system import FuzzySystem


def losses_of(system: FuzzySystem, rules: WrittenRules) -> Iterator[Loss]:
    """Yield the losses of a system in FML, apart from those of terms, which are reported where terms are written."""
    yield from rules.losses
    yield from _of_system(system)
    yield from _of_method(system, rules)
    for variable in (*system.inputs, *system.outputs):
        if variable.label:
            yield Loss(f"variable '{variable.name}'", "label", "FML has no words for it", exact=True)
    for variable in system.inputs:
        if variable.extrapolate:
            exact = not holding_matters(system, variable)
            yield Loss(f"input '{variable.name}'", "values outside the range", "they are held at its ends", exact=exact)
    for output in system.outputs:
        where = f"output '{output.name}'"
        if output.adaptive is not None:
            yield Loss(where, "adaptive consequents", "in FML consequents stay as they are")
        if output.clamped:
            yield Loss(where, "clamp", "FML has no words for it")
        for implication in system.implications_of(output) if rules.kind(output) == "mamdani" else ():
            if implication not in CONJUNCTION_WORDS.values():
                yield Loss(where, f"implication '{implication}'", "MIN is written")
        if rules.kind(output) == "tsk" and _defuzzifier(system, output.name) == "weighted_sum":
            yield Loss(where, "weighted sum", "FML divides by the sum of the activations")
        if rules.unnamed(output.name):
            yield Loss(where, "consequents without a name", "they are terms with names of their own", exact=True)


def impossible(system: FuzzySystem) -> Iterator[str]:
    """Yield why no file can hold a system, not even with losses."""
    for variable in system.inputs:
        if not variable.terms:
            yield f"input '{variable.name}' has no terms, and every fuzzyVariable has some"
    for output in system.outputs:
        kind = _defuzzifier(system, output.name)
        if kind in TSUKAMOTO and kind != "tsukamoto":
            yield f"output '{output.name}': there is no defuzzifier '{kind}'"
    for number, rule in enumerate(system.rules, 1):
        for c in rule.consequents:
            if c.hedges and _defuzzifier(system, c.output) in OVER_RULES:
                yield f"rule {number}: a consequent of an average, '{c.output}', has no modifiers"


def _defuzzifier(system: FuzzySystem, output: str) -> str:
    return (system.output(output).defuzzifier or system.method.defuzzifier).kind


def _of_system(system: FuzzySystem) -> Iterator[Loss]:
    where = f"system '{system.name}'"
    for what, said in (("title", system.title), ("source", system.citation), ("guarantees", system.guarantees)):
        if said:
            yield Loss(where, what, "FML has no words for it", exact=True)
    for param in system.params:
        yield Loss(where, f"param '{param.name}'", "numbers stand for what it is used in", exact=True)
    if any(isinstance(b, RuleTable) for b in system.tables_and_rules):
        yield Loss(where, "tables", "they are written as single rules", exact=True)
    for kind in dict.fromkeys(m.activation.kind for m in system.rule_methods if m.activation.kind != "general"):
        yield Loss(where, f"activation '{kind}'", "in FML all rules act")


def _of_method(system: FuzzySystem, rules: WrittenRules) -> Iterator[Loss]:
    where = f"system '{system.name}'"
    method = system.method
    for rule, own in zip(system.rules, system.rule_methods, strict=True):
        if own.conjunction not in CONJUNCTION_WORDS.values() and is_joined_by(And, rule.antecedent):
            yield Loss(where, f"and '{own.conjunction}'", "MIN is written")
        if own.disjunction not in DISJUNCTION_WORDS.values() and is_joined_by(Or, rule.antecedent):
            yield Loss(where, f"or '{own.disjunction}'", "MAX is written")
    # The standard has a modifier for either meaning of `extremely`, and differences of sigmoids become points.
    knobs = method.semantics
    there = Semantics(profile="FML", extremely=knobs.extremely, sigmoid_difference=knobs.sigmoid_difference)
    yield from other_numerics(system, there, lambda output: output.defuzzifier or method.defuzzifier)
