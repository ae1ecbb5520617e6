"""Systems as the plain data of a page, and the sets whose degrees its JavaScript computes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, Generic, TypeVar

from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.analysis.prove import Prover
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.analysis.work import clock
from fuzzyctl.codegen.javascript_parts import Shown
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.explain.implied_sets import antecedent_set
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.formats.fz import antecedent_text, cell_text, membership_text, rule_text, semantics_text
from fuzzyctl.formulas import is_number
from fuzzyctl.kernels.inference.defuzzify.defuzzify import consequent_hull
from fuzzyctl.kernels.plan.build import ImpliedPlan, OutputPlan, SetPlan, planned_set
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.rule import Consequent, Rule, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, LinguisticVariable

_T = TypeVar("_T")


class _Once(list[_T], Generic[_T]):
    """A list that holds each entry once."""

    def __init__(self) -> None:
        self._places: dict[_T, int] = {}

    def place(self, entry: _T) -> int:
        """Return where an entry stands."""
        place = self._places.setdefault(entry, len(self))
        if place == len(self):
            self.append(entry)
        return place


@dataclass
class SystemFacts:
    """The data of a system, computed once.

    Args:
        unit: The system.
        verdicts: Of its guarantees.
    """

    unit: Unit
    verdicts: Sequence[Verdict]
    implications: _Once[tuple[str, float]] = field(default_factory=_Once)
    values: _Once[Expr] = field(default_factory=_Once)

    def __post_init__(self) -> None:
        system = self.unit.system
        self.variables: list[LinguisticVariable] = [*system.inputs, *system.lets, *system.outputs]
        self.names = [v.name for v in self.variables]
        self.sets: list[_Once[SetPlan]] = [_Once() for _ in self.variables]

    @cached_property
    def _entries(self) -> list[dict[int, list[tuple[int, ImpliedPlan]]]]:
        """The effects of each rule on each output, by their places."""
        entries: list[dict[int, list[tuple[int, ImpliedPlan]]]] = []
        for output in self.unit.plan.outputs:
            entries.append({})
            for k, entry in enumerate(output.implied):
                entries[-1].setdefault(entry.rule, []).append((k, entry))
        return entries

    @property
    def shown(self) -> Shown:
        """Values that the JavaScript of the page computes besides those of the system; complete with the data."""
        return Shown(self.sets, self.implications, self.values)

    def data(self) -> dict[str, Any]:
        """Return the facts as plain data."""
        system = self.unit.system
        rules = [self._rule(k, rule) for k, rule in enumerate(system.rules)]
        return {
            "kind": "system",
            "name": system.name,
            "title": system.title,
            "source": system.citation,
            "facts": [
                ["semantics", semantics_text(system.method.semantics)],
                ["algorithm", f"{self.unit.algorithm.name}; {self.unit.algorithm.reason}"],
                *([n, f"{v:.9g}"] for n, v in system.values.items()),
            ],
            "inputs": [self._variable(v) for v in system.inputs],
            "outputs": [self._variable(v) | self._output(k) for k, v in enumerate(system.outputs)],
            "rules": rules,
            "tables": list(self._tables()),
            "degrees": len(self.unit.plan.degrees),
            "state": bool(self.unit.plan.initial_state),
            "bounds": [bound_row(self.unit.bounds[v.name], v.unit) for v in system.outputs],
            "verdicts": [verdict_row(v) for v in self.verdicts],
        }

    def _variable(self, v: LinguisticVariable) -> dict[str, Any]:
        system, k = self.unit.system, self.names.index(v.name)
        low, high = system.number(v.lower), system.number(v.upper)
        terms, corners = [], set()
        for term in v.terms:
            planned = planned_set(system, v, term)
            at = planned.parameters[0] if planned is not None and _is_spike(planned) else None
            place = None if planned is None or at is not None else self.sets[k].place(planned)
            corners |= set(planned.pieces if planned is not None and at is None else ())
            terms.append({"name": term.name, "text": membership_text(term.membership), "set": place, "at": at})
        data: dict[str, Any] = {"name": v.name, "label": v.label, "unit": v.unit, "lower": low, "upper": high}
        data |= {"variable": k, "terms": terms, "corners": sorted(c for c in corners if low < c < high)}
        return data | ({"extrapolate": v.extrapolate} if isinstance(v, Input) else {})

    def _output(self, k: int) -> dict[str, Any]:
        output = self.unit.plan.outputs[k]
        crisp = output.over_rules or output.inverts or output.takes_degrees
        return {"crisp": crisp, "formula": output.value is not None}

    def _rule(self, k: int, rule: Rule) -> dict[str, Any]:
        parts = []
        for part in dict.fromkeys(literals(rule.antecedent)):
            v = self.variables[self.names.index(part.variable)]
            curve = antecedent_set(self.unit.system, v, part)
            if curve is not None:
                place = self.sets[self.names.index(v.name)].place(curve)
                parts.append({"variable": v.name, "set": place, "name": " ".join((*part.hedges, part.term))})
        return {"text": rule_text(rule), "parts": parts, "consequents": list(self._consequents(k, rule))}

    def _consequents(self, rule: int, written: Rule) -> Iterator[dict[str, Any]]:
        """Yield the effects of a rule on outputs; `effect` is its place behind the activations."""
        before = 0
        for o, output in enumerate(self.unit.plan.outputs):
            named: list[Consequent] = [c for c in written.consequents if c.output == output.name]
            for (k, entry), consequent in zip(self._entries[o].get(rule, []), named, strict=True):
                text = consequent.term if isinstance(consequent.term, str) else membership_text(consequent.term)
                data = {"output": o, "name": " ".join((*consequent.hedges, text)), "effect": before + k}
                yield data | self._acting(o, output, entry.term, k)
            before += len(output.implied)

    def _acting(self, o: int, output: OutputPlan, term: int, k: int) -> dict[str, Any]:
        """Return a consequent as data: a number, a function of the inputs, a state, or a set with its implication."""
        plan = output.terms[term]
        if output.rate is not None:
            return {"state": self.unit.plan.states.index((o, k))}
        if plan.reads_inputs:
            assert plan.expression is not None
            return {"function": self.values.place(plan.expression)} if self._reads_inputs_only(plan.expression) else {}
        if output.over_rules and output.kind not in TSUKAMOTO:
            return {"value": consequent_hull(output, [term])[0]}
        place = self.sets[self.names.index(output.name)].place(plan)
        implied = self.implications.place((output.implication_of(plan), output.equal))
        return {"set": place, "implication": implied}

    def _reads_inputs_only(self, expression: Expr) -> bool:
        flat = self.unit.plan
        inputs = {i.name for i in flat.inputs}
        for let in flat.lets:
            if not let.calls and {n.name for n in names_in(let.value)} <= inputs:
                inputs.add(let.name)
        return {n.name for n in names_in(expression)} <= inputs

    def _tables(self) -> Iterator[dict[str, Any]]:
        """Yield the rule tables; each cell that is a rule has its place."""
        rule = 0
        for part in self.unit.system.tables_and_rules:
            if not isinstance(part, RuleTable):
                rule += 1
                continue
            cells = []
            for row in part.cells:
                cells.append([{"text": cell_text(c), "rule": rule + n} if c.terms else None for c, n in _counted(row)])
                rule += sum(bool(c.terms) for c in row)
            condition = f", with {antecedent_text(part.condition, top=True)}" if part.condition is not None else ""
            yield {
                "outputs": ", ".join(part.outputs) + condition,
                "rows": part.rows,
                "columns": part.columns,
                "row_terms": list(part.row_terms),
                "column_terms": list(part.column_terms),
                "cells": cells,
            }


def _counted(row: Sequence[Any]) -> Iterator[tuple[Any, int]]:
    """Yield the cells of a row, each with the number of rules before it in the row."""
    rules = 0
    for cell in row:
        yield cell, rules
        rules += bool(cell.terms)


def _is_spike(planned: SetPlan) -> bool:
    return is_number(planned.kind) and planned.expression is None


#: Seconds that all bounds of a controller may take; 'fuzzyctl prove --bounds' takes longer.
BOUND_SECONDS: Final = 0.5
#: Seconds that reading, all claims and all bounds of a page may take together; the least for claims and bounds.
PAGE_SECONDS: Final = 2.5
LEAST_SECONDS: Final = 1.0


def bound_row(bound: OutputBound, unit: str) -> list[str]:
    """Return a name and the bounds of its value."""
    low, high = (f"{end + 0.0:.9g}" for end in (bound.lo, bound.hi))
    tail = f" {unit}" if unit else ""
    if bound.lo == bound.hi:
        return [bound.name, f"always {low}{tail}"]
    if math.isinf(bound.lo) and math.isinf(bound.hi):
        return [bound.name, "no bound is known"]
    if math.isinf(bound.lo):
        return [bound.name, f"at most {high}{tail}"]
    return [bound.name, f"at least {low}{tail}" if math.isinf(bound.hi) else f"from {low} to {high}{tail}"]


def verdict_row(verdict: Verdict) -> list[Any]:
    """Return the verdict, the claim, a note, and of a refuted claim the values by name that show it."""
    match verdict:
        case Proved(note=found):
            text = found
        case Refuted(witness=witness, note=found):
            text = "; ".join(filter(None, (str(witness), found)))
        case Undecided(reason=reason):
            text = reason
    point = [verdict.witness.point] if isinstance(verdict, Refuted) else []
    return [type(verdict).__name__.lower(), verdict.claim, text, *point]


def decided(
    system: FuzzySystem, verdicts: Sequence[Verdict], seconds: float, until: float = math.inf
) -> tuple[Verdict, ...]:
    """Return verdicts on the claims of a system; those that are open take subdivision, with a time limit each.

    Args:
        system: The system.
        verdicts: What quick methods say.
        seconds: How long one claim may take.
        until: When no other claim is begun, on the clock of proofs [s].
    """
    prover = Prover(system, timeout=seconds)
    pairs = zip(system.guarantees, verdicts, strict=True)
    return tuple(prover.verdict(g) if isinstance(v, Undecided) and clock.now() <= until else v for g, v in pairs)


def proofs(
    block: Any,
    quick: Sequence[Verdict],
    seconds: float,
    *,
    bound_seconds: float = BOUND_SECONDS,
    block_seconds: float = math.inf,
    until: float = math.inf,
) -> tuple[list[Verdict], dict[str, list[list[Any]]]]:
    """Return the verdicts on a block, and their rows; of a controller also those of bounds over every step.

    Args:
        block: A system or controller.
        quick: What quick methods say of the claims of a system.
        seconds: How long one claim may take.
        bound_seconds: How long all bounds may take; 0 for no subdivision.
        block_seconds: How long all claims may take together.
        until: When no other claim is begun, on the clock of proofs [s].
    """
    if not block.is_sampled:
        verdicts = list(decided(block, quick, min(seconds, block_seconds / max(len(quick), 1)), until))
        return verdicts, {"verdicts": list(map(verdict_row, verdicts))}
    from fuzzyctl.analysis.induction.bounds import bounds_by  # numpy, which the start of the studio does without
    from fuzzyctl.analysis.induction.prover import ControllerProver

    prover = ControllerProver(block, seconds, until=until)
    prover.timeout = min(seconds, block_seconds / max(len(prover.own), 1))
    verdicts = [prover.verdict(c) for c in prover.own]
    units = {s.name: s.unit for s in (*block.results, *block.states)}
    bounds = [bound_row(b, units[name]) for name, b in bounds_by(prover, bound_seconds).items()]
    return verdicts, {"bounds": bounds, "verdicts": list(map(verdict_row, verdicts))}
