"""Writes drawn systems as JSON, for peers that take no files but calls in Python."""

from __future__ import annotations

import json
from typing import Any

from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable


def text(system: FuzzySystem) -> str:
    """Return a system as JSON."""
    return json.dumps(
        {
            "inputs": [_variable(v) for v in system.inputs],
            "outputs": [_variable(v) for v in system.outputs],
            "conjunction": system.method.conjunction,
            "aggregation": system.method.aggregation,
            "defuzzifier": system.method.defuzzifier.kind,
            "resolution": system.method.defuzzifier.resolution,
            "rules": [
                {
                    "antecedent": _antecedent(rule.antecedent),
                    "consequents": [(c.output, c.term) for c in rule.consequents],
                    "weight": rule.weight.value,
                }
                for rule in system.rules
            ],
        }
    )


def _variable(variable: LinguisticVariable) -> dict[str, Any]:
    terms = [(t.name, t.membership.kind, [a.value for a in t.membership.arguments]) for t in variable.terms]
    return {"name": variable.name, "range": [variable.lower.value, variable.upper.value], "terms": terms}


def _antecedent(antecedent: Antecedent) -> list[Any]:
    match antecedent:
        case Is(variable=variable, term=term):
            return ["is", variable, term]
        case Not(operand=operand):
            return ["not", _antecedent(operand)]
        case And(operands=operands):
            return ["and", *map(_antecedent, operands)]
        case Or(operands=operands):
            return ["or", *map(_antecedent, operands)]
    raise TypeError(type(antecedent).__name__)
