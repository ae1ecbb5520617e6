"""Writes drawn systems as JSON, for peers that take no files but calls in Python."""

from __future__ import annotations

import json
from typing import Any

from fuzzyctl import And, Antecedent, FuzzySystem, Is, LinguisticVariable, Not, Or
from fuzzyctl.expr import to_text


def text(system: FuzzySystem) -> str:
    """Return a system as JSON."""
    return json.dumps(
        {
            "inputs": [_variable(system, v) for v in system.inputs],
            "outputs": [_variable(system, v) for v in system.outputs],
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


def _variable(system: FuzzySystem, variable: LinguisticVariable) -> dict[str, Any]:
    terms = []
    for term in variable.terms:
        kind, arguments = term.membership.kind, term.membership.arguments
        terms.append((term.name, kind, [to_text(a) if kind == "function" else system.number(a) for a in arguments]))
    ends = [system.number(variable.lower), system.number(variable.upper)]
    return {"name": variable.name, "range": ends, "terms": terms}


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
