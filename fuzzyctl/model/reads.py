"""Which outputs the rules of an output read."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.expr import names_in, span_of
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output
from fuzzyctl.source import Span


def reads_of(system: FuzzySystem) -> Iterator[tuple[str, dict[str, Span | None]]]:
    """Yield for each consequent its output and the outputs that its rule waits for, each with its place.

    A rule waits for outputs in its antecedent, unless they count there with the degree that the rules before have
    reached; and for outputs that its consequent is a function of.
    """
    outputs = {o.name: o for o in system.outputs}
    waits = system.method.semantics.chained == "value"
    functions = {(o.name, t.name): t.membership for o in system.outputs for t in o.terms if _is_function(t.membership)}
    for rule in system.rules:
        read = {i.variable: i.span for i in literals(rule.antecedent) if i.variable in outputs} if waits else {}
        for consequent in rule.consequents:
            term = consequent.term
            membership = functions.get((consequent.output, term)) if isinstance(term, str) else term
            inside = _in_function(outputs, membership) if membership is not None and _is_function(membership) else {}
            yield consequent.output, read | inside


def _is_function(membership: Membership) -> bool:
    return membership.kind == "function"


def _in_function(outputs: dict[str, Output], membership: Membership) -> dict[str, Span | None]:
    return {n.name: span_of(n) for n in names_in(membership.arguments[0]) if n.name in outputs}
