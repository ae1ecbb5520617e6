"""Which outputs the rules of an output read."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.expr import names_in, span_of
from fuzzyctl.model.rule import Consequent, literals
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
    for rule in system.rules:
        read = {i.variable: i.span for i in literals(rule.antecedent) if i.variable in outputs} if waits else {}
        for consequent in rule.consequents:
            yield consequent.output, read | _in_function(outputs, consequent)


def _in_function(outputs: dict[str, Output], consequent: Consequent) -> dict[str, Span | None]:
    membership = consequent.term
    if isinstance(membership, str):
        declared = outputs.get(consequent.output)
        term = declared.term(membership) if declared is not None else None
        if term is None:
            return {}
        membership = term.membership
    assert isinstance(membership, Membership)
    if membership.kind != "function":
        return {}
    return {n.name: span_of(n) for n in names_in(membership.arguments[0]) if n.name in outputs}
