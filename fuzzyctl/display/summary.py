"""Summary of a system as plain data for `fuzzyctl show`: numbers, settings in effect, proved bounds."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, ExprError, to_text
from fuzzyctl.formats.fz import activation_text, antecedent_text, block_settings, cell_text, defuzzifier_text, rule_text
from fuzzyctl.formats.fz_blocks import function_text
from fuzzyctl.formats.fz_strings import bounds_text, guarantee_text
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.loading.block_equations import in_order
from fuzzyctl.model.controller import Definition, EquationBlock, Instance, Result, Signal, State
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.method import KNOBS, Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.rule import Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Output, Term

#: How rule files call the settings whose fields are called otherwise.
KEYWORDS: Final = {"conjunction": "and", "disjunction": "or"}

#: Settings that have no effect where a defuzzifier sums over rules.
OVER_SETS: Final = ("implication", "aggregation")


def summary(system: FuzzySystem) -> dict[str, Any]:
    """Return a system as the data of `fuzzyctl show --format json`; infinities are the texts `inf` and `-inf`.

    A setting of an output is None where it has no effect, as implication has none on an average over rules.
    """
    return {
        "system": system.name,
        "title": system.title,
        "source": system.citation,
        "file": system.path,
        "method": _method(system.method),
        "knobs": {knob: system.method.semantics.text(knob) for knob in KNOBS},
        "params": [
            {"name": p.name, "value": system.values[p.name], "expression": to_text(p.expression), "unit": p.unit}
            for p in system.params
        ],
        "hedges": [
            {"name": h.name, "meaning": f"{h.name}({h.parameter}) = {to_text(h.expression)}"} for h in system.hedges
        ],
        "inputs": [_input(system, v) for v in system.inputs],
        "lets": [_variable(system, v) | {"formula": to_text(v.value)} for v in system.lets],
        "outputs": _outputs(system),
        "rule_count": len(system.rules),
        "rules": [_block(block) for block in system.blocks],
        "guarantees": [guarantee_text(g) for g in system.guarantees],
    }


def _method(method: Method) -> dict[str, str]:
    return {KEYWORDS.get(f.name, f.name): _setting(getattr(method, f.name)) for f in fields(method) if f.compare}


def _setting(value: object) -> str:
    match value:
        case Defuzzifier(resolution=None, over_rules=False):
            return f"{defuzzifier_text(value)}, exact"
        case Defuzzifier():
            return defuzzifier_text(value)
        case Activation():
            return activation_text(value)
        case Semantics(profile=profile):
            return profile
    return str(value)


def _variable(system: FuzzySystem, v: LinguisticVariable) -> dict[str, Any]:
    return {
        "name": v.name,
        "label": v.label,
        "unit": v.unit,
        "low": _plain(system.number(v.lower)),
        "high": _plain(system.number(v.upper)),
        "terms": [_term(system, t) for t in v.terms],
    }


def _term(system: FuzzySystem, term: Term) -> dict[str, Any]:
    membership = term.membership
    parameters: list[float | str] = []
    for argument in membership.arguments:
        try:
            parameters.append(_plain(system.number(argument)))
        except ExprError:
            # An expression over the inputs stays one.
            parameters.append(to_text(argument))
    return {
        "name": term.name,
        "kind": membership.kind,
        "parameters": parameters,
        "height": system.number(membership.height),
    }


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def _input(system: FuzzySystem, v: Input) -> dict[str, Any]:
    return _variable(system, v) | {"outside": "extrapolated" if v.extrapolate else "clamped"}


def _outputs(system: FuzzySystem) -> list[dict[str, Any]]:
    outputs = []
    proved = _proved(system)
    for v in system.outputs:
        method: dict[str, str | None] = {
            name: _setting(getattr(v, name) if getattr(v, name) is not None else getattr(system.method, name))
            for name in ("implication", "aggregation", "defuzzifier")
        }
        if "implication" in method:
            method["implication"] = " and ".join(system.implications_of(v))
        defuzzifier = v.defuzzifier or system.method.defuzzifier
        if defuzzifier.over_rules:
            idle = OVER_SETS[:1] if system.method.semantics.joins_rules else OVER_SETS
            method |= {name: None for name in idle if name in method}
        rest = {
            "method": method,
            "else": _otherwise(system, v),
            "held_at_first": _held_at_first(system, v),
            "clamped": v.clamped,
            "adaptive": to_text(v.adaptive) if v.adaptive else None,
            "formula": to_text(v.value) if v.value is not None else None,
        }
        outputs.append(_variable(system, v) | rest | proved[v.name])
    return outputs


def _otherwise(system: FuzzySystem, v: Output) -> float | str | None:
    if v.otherwise is None or isinstance(v.otherwise, str):
        return v.otherwise
    if isinstance(v.otherwise, Hold):
        return "hold"
    return _plain(system.number(v.otherwise))


def _held_at_first(system: FuzzySystem, v: Output) -> float | str | None:
    if not isinstance(v.otherwise, Hold):
        return None
    if v.otherwise.start == "nan":
        return "nan"
    if v.otherwise.start is not None:
        return _plain(system.number(v.otherwise.start))
    return _plain(0.5 * system.number(v.lower) + 0.5 * system.number(v.upper))


def _proved(system: FuzzySystem) -> dict[str, dict[str, Any]]:
    """Return bounds and coverage of each output, as far as this version can prove them."""
    from fuzzyctl.analysis.bounds import output_bounds
    from fuzzyctl.analysis.coverage.box_search import Hole
    from fuzzyctl.analysis.coverage.coverage import uncovered

    try:
        bounds, verdicts = output_bounds(system), uncovered(system)
    except DiagnosticError as error:
        unknown = {"verdict": "undecided", "reason": error.diagnostics[0].message}
        return {o.name: {"bounds": None, "coverage": unknown} for o in system.outputs}
    facts: dict[str, dict[str, Any]] = {}
    for o in system.outputs:
        bound, verdict = bounds[o.name], verdicts[o.name]
        coverage: dict[str, Any]
        if verdict is None:
            coverage = {"verdict": "proved"}
        elif isinstance(verdict, Hole):
            coverage = {"verdict": "hole", "region": str(verdict), "witness": verdict.witness}
        else:
            coverage = {"verdict": "undecided", "reason": verdict.reason}
        values = {"low": _plain(bound.lo), "high": _plain(bound.hi), "attained": bound.exact}
        facts[o.name] = {"bounds": values, "coverage": coverage}
    return facts


def _block(block: RuleTable | Rule | RuleBlock) -> dict[str, Any]:
    if isinstance(block, Rule):
        return {"rule": rule_text(block)}
    if isinstance(block, RuleBlock):
        settings = dict(block_settings(block))
        return {"block": block.name, "method": settings, "rules": [_block(part) for part in block.rules]}
    return {
        "table": list(block.outputs),
        "rows": block.rows,
        "columns": block.columns,
        "row_terms": list(block.row_terms),
        "column_terms": list(block.column_terms),
        "cells": [[cell_text(cell) for cell in row] for row in block.cells],
        "with": antecedent_text(block.condition, top=True) if block.condition is not None else None,
    }


def block_summary(block: EquationBlock) -> dict[str, Any]:
    """Return a controller, plant or loop as the data of `fuzzyctl show --format json`.

    `statements` holds lines by heading; equations are in the order in which they are computed.
    """

    def number(expr: Expr | None) -> float | None:
        return None if expr is None else block.number(expr)

    data: dict[str, Any] = {
        "kind": block.kind,
        "name": block.name,
        "title": block.title,
        "source": block.citation,
        "file": block.path,
        "params": [
            {"name": p.name, "value": block.values[p.name], "expression": to_text(p.expression), "unit": p.unit}
            for p in block.params
        ],
    }
    if block.is_sampled:
        data["period"] = number(block.period)
    if isinstance(block, Loop):
        data |= {"duration": number(block.duration), "step": number(block.step)}
    statements = {"Functions": [function_text(f).removeprefix("function ") for f in block.functions]}
    statements |= _loop(block) if isinstance(block, Loop) else _equations(block)
    return data | {"statements": {heading: lines for heading, lines in statements.items() if lines}}


def _equations(block: Any) -> dict[str, list[str]]:
    states = [_signal(s) for s in block.states]
    prime, heading, external = "next", "Next values", ""
    if isinstance(block, Plant):
        prime, heading, external = "d/dt", "Derivatives", block.external
    elif hidden := len(equations_of(block).states) - len(states):
        states.append(f"and {counted(hidden, 'number')} of operators, systems and blocks")
    return {
        "Inputs": [_signal(i) for i in block.inputs],
        "States": states,
        "Blocks": [_instance(i) for i in block.instances],
        "Equations in order": [f'in "{external}"'] if external else [_defined(d) for d in in_order(block)],
        heading: [] if external else [f"{prime} {_defined(d)}" for d in block.changes],
        "Outputs": [_signal(r) for r in block.outputs],
    }


def _signal(signal: Signal) -> str:
    """Return an input, state or output as a file writes it; texts may hold what no file can."""
    label, unit = (f' {word}"{text}"' if text else "" for word, text in (("", signal.label), ("unit ", signal.unit)))
    start = f" = {to_text(signal.start)}" if isinstance(signal, State) else ""
    return f"{signal.name}{label}{bounds_text(signal.bounds)}{unit}{start}"


def _loop(loop: Loop) -> dict[str, list[str]]:
    return {
        "Blocks": [_instance(i) for i in loop.instances],
        "Signals": [_defined(d) for d in loop.definitions],
        "Measures": [f"{_defined(m)}{f' [{m.unit}]' if m.unit else ''}" for m in loop.measures],
        "Requirements, checked on a run": [guarantee_text(g) for g in loop.requirements],
        "Family": [f"for {v.name}{bounds_text(v.bounds)}" for v in loop.varied]
        + [f"disturbance {_signal(d)} = {to_text(d.nominal)}" for d in loop.disturbances],
        "Claims about every member": [guarantee_text(g) for g in loop.guarantees],
    }


def _defined(d: Definition | Result) -> str:
    return f"{d.name} = {to_text(d.value)}"


def _instance(instance: Instance) -> str:
    return f"{instance.name} = {instance.controller}({', '.join(map(to_text, instance.arguments))})"
