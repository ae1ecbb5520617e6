"""Losses of numerics in a written file: settings that its tool computes in another way."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, MEMBERSHIP, is_endless
from fuzzyctl.model.method import KNOBS, MAXIMA, Defuzzifier, Semantics
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Membership, Output

#: Weights and heights below which a tool that leaves out activations of 1e-6 leaves out much of a term.
_SMALL: Final = 1e-3


def cannot(system: FuzzySystem, format: str, reasons: Sequence[str]) -> DiagnosticError:
    """Return the error for a system that a format cannot hold at all."""
    found = dict.fromkeys(reasons)
    message = f"a {format} file cannot express '{system.name}'"
    return DiagnosticError([Diagnostic("FZ608", message, system.span, facts=tuple(found), file=system.path)])


def defuzzifier_of(system: FuzzySystem, output: Output) -> Defuzzifier:
    """Return the defuzzifier of an output: its own or the system's."""
    return output.defuzzifier or system.method.defuzzifier


def middle_of(system: FuzzySystem, output: Output) -> float:
    """Return the middle of the range of an output."""
    return system.number(output.lower) / 2 + system.number(output.upper) / 2


def value_unfired(system: FuzzySystem, output: Output) -> float | None:
    """Return the value of an output where no rule fires, or before any has fired; None for NaN and for an error."""
    own = output.otherwise
    start = own.start if isinstance(own, Hold) else own
    if isinstance(start, Expr):
        return system.number(start)
    return middle_of(system, output) if start == "midpoint" or own == Hold() else None


def used_norms(system: FuzzySystem) -> set[str]:
    """Return the norms of a system, its rule blocks and its outputs."""
    own = system.method
    named = [own.conjunction, own.disjunction, own.implication, own.aggregation]
    named += [n for o in system.outputs for n in (o.implication, o.aggregation) if n is not None]
    named += [n for b in system.rule_blocks for n in (b.conjunction, b.disjunction, b.implication) if n is not None]
    return set(named)


def used_hedges(system: FuzzySystem) -> tuple[set[str], set[str]]:
    """Return the hedges of conditions and those of conclusions."""
    of_conditions = {h for r in system.rules for i in literals(r.antecedent) for h in i.hedges}
    return of_conditions, {h for r in system.rules for c in r.consequents for h in c.hedges}


def other_knobs(system: FuzzySystem, there: Semantics) -> Iterator[Loss]:
    """Yield the knobs that are others in the tool of a format, and change numbers of a system."""
    own = system.method.semantics
    for knob in KNOBS:
        if getattr(own, knob) != getattr(there, knob) and _matters(system, knob, there):
            why = f"{there.text(knob)} under '{there.profile}'"
            yield Loss(f"system '{system.name}'", f"{knob} {own.text(knob)}", why)


def _matters(system: FuzzySystem, knob: str, there: Semantics) -> bool:
    """Whether a system would compute other numbers with the value of a knob that it has there."""
    methods = [defuzzifier_of(system, o) for o in system.outputs]
    norms = used_norms(system)
    hedges, consequent_hedges = used_hedges(system)
    kinds = {t.membership.kind for v in (*system.inputs, *system.outputs) for t in v.terms}
    weighted = any(system.number(r.weight) != 1 for r in system.rules)
    outputs = {o.name for o in system.outputs}
    relevant = {
        "weight": weighted and any(not m.over_rules for m in methods) and norms != {"product"},
        # Where rules stand by themselves a file says so: it adds them up.
        "merge": system.method.semantics.merge != "rules"
        and _merges(system)
        and any(shares_terms(system, o) for o in system.outputs),
        "total": any(m.averages for m in methods) and (weighted or len(system.outputs) > 1),
        "least": bool(consequent_hedges) or _least_decides(system, there),
        "equal": any({**CONJUNCTIONS, **AGGREGATIONS}[n].tolerant for n in norms),
        "chained": any(i.variable in outputs for r in system.rules for i in literals(r.antecedent)),
        "consequent_hedges": bool(consequent_hedges),
        "extremely": "extremely" in hedges | consequent_hedges,
        "sigmoid_difference": "sigmoid_difference" in kinds,
        "places": any(_places_leave(system, o) for o in system.outputs),
        "none_active": any(m.kind in MAXIMA for m in methods),
        "fallback": _has_functions(system) or any("tsukamoto" in m.kind for m in methods),
    }
    return relevant[knob]


def _least_decides(system: FuzzySystem, there: Semantics) -> bool:
    """Whether activations that one of two tools leaves out may be all there are at more than a sliver of a range.

    Beside larger ones they do not matter. Straight sides, and smooth ones that end, leave them only within about the
    root of the bound of where they end; tails of curved terms, functions and small weights leave them anywhere.
    """
    if max(system.method.semantics.least or 0.0, there.least or 0.0) == 0.0:
        return False
    if any(system.number(r.weight) < _SMALL for r in system.rules):
        return True
    used = {(i.variable, i.term) for r in system.rules for i in literals(r.antecedent)}
    terms = [t.membership for v in system.inputs for t in v.terms if (v.name, t.name) in used]
    small = any(system.number(m.height) < _SMALL for m in terms)
    return small or any(is_endless(m.kind) or (m.kind == "function" and names_in(m.arguments[0])) for m in terms)


def _places_leave(system: FuzzySystem, output: Output) -> bool:
    """Whether places that Tsukamoto's method finds may lie outside the range of an output."""
    kind = defuzzifier_of(system, output).kind
    if "tsukamoto" not in kind:
        return False
    low, high = system.number(output.lower), system.number(output.upper)
    if kind.startswith("inverse"):
        return not (low <= 0.0 and high >= 1.0)
    # Beyond its height a term has a degree nowhere, and rules of one term may add up to more than 1.
    if shares_terms(system, output) or any(system.number(t.membership.height) != 1 for t in output.terms):
        return True
    return not all(low <= end <= high for t in output.terms for end in _ends(system, t.membership))


def _ends(system: FuzzySystem, membership: Membership) -> tuple[float, float]:
    """Return where a monotone term has the degrees 0 and 1; infinite for what is none and for endless tails."""
    if membership.kind not in MEMBERSHIP or is_endless(membership.kind):
        return -math.inf, math.inf
    formula = MEMBERSHIP[membership.kind]
    p = tuple(system.number(a) for a in membership.arguments)
    if not formula.monotone(p):
        return -math.inf, math.inf
    bends = [x for x in formula.pieces(p) if math.isfinite(x)]
    return min(bends), max(bends)


def _merges(system: FuzzySystem) -> bool:
    """Whether an output that sums over rules joins those of one term otherwise than by adding them."""
    usual = system.method.aggregation
    return any(defuzzifier_of(system, o).over_rules and (o.aggregation or usual) != "sum" for o in system.outputs)


def _has_functions(system: FuzzySystem) -> bool:
    """Whether a term is a function that may have no value somewhere."""
    terms = [t.membership for v in (*system.inputs, *system.outputs) for t in v.terms]
    return any(m.kind == "function" and names_in(m.arguments[0]) for m in terms)


def shares_terms(system: FuzzySystem, output: Output) -> bool:
    """Whether two rules name one term of an output."""
    named = [c.term for r in system.rules for c in r.consequents if c.output == output.name]
    return len(set(named)) < len(named)


def impossible(system: FuzzySystem) -> Iterator[str]:
    """Yield what no format of another tool has."""
    for output in system.outputs:
        if output.adaptive is not None:
            yield f"output '{output.name}' is adaptive"


def missing_words(system: FuzzySystem, kinds: Container[str], norms: Container[str]) -> Iterator[str]:
    """Yield the membership functions and norms of a system that a format has no words for."""
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            kind = term.membership.kind
            if kind in MEMBERSHIP and kind not in kinds:
                yield f"term '{term.name}' of '{variable.name}' is of the kind '{kind}'"
    for norm in sorted(used_norms(system)):
        if norm not in norms:
            yield f"there is no norm '{norm}'"


def formula_sets(system: FuzzySystem) -> Iterator[str]:
    """Yield terms of outputs that are sets written as formulas, which only FLL has."""
    for output in system.outputs:
        for term in output.terms:
            if term.membership.kind == "formula":
                yield f"term '{term.name}' of '{output.name}' is a set that is a formula"
