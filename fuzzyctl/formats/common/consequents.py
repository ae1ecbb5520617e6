"""Consequents as formats have them: every one a term, and numbers where an average takes nothing else of a set."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyctl.expr import Number
from fuzzyctl.formats.common.numerics import defuzzifier_of
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.rule import Consequent, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output, Term


def with_named_consequents(
    system: FuzzySystem, prefix: str = "mf", *, fold: Callable[[str], str] = str
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system in which every consequent is a term, and the outputs that get terms by this.

    Args:
        system: The system; numbers and functions in its rules and cells have no names.
        prefix: What the names begin with, before a number; `mf` is followed by the number of the term.
        fold: What makes two names one, such as a change of case.
    """
    outputs = {o.name: list(o.terms) for o in system.outputs}
    names: dict[tuple[str, Membership], str] = {}

    def named(c: Consequent) -> Consequent:
        if not isinstance(c.term, Membership):
            return c
        key = c.output, c.term
        if key not in names:
            terms = outputs[c.output]
            taken = {fold(t.name) for t in terms}
            number = len(terms) + 1 if prefix == "mf" else 1
            while fold(f"{prefix}{number}") in taken:
                number += 1
            names[key] = f"{prefix}{number}"
            terms.append(Term(name=names[key], membership=c.term))
        return c.model_copy(update={"term": names[key]})

    rules = [r.model_copy(update={"consequents": tuple(map(named, r.consequents))}) for r in system.rules]
    if not names:
        return system, []
    made = tuple(o.model_copy(update={"terms": tuple(outputs[o.name])}) for o in system.outputs)
    changed = dict.fromkeys(output for output, _ in names)
    what, why = "consequents without a name", "they are terms with names of their own"
    losses = [Loss(f"output '{output}'", what, why, exact=True) for output in changed]
    return system.with_rules(rules).model_copy(update={"outputs": made}), losses


def with_numbers_averaged(system: FuzzySystem) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose averages are over numbers, the middles of the cores of sets, and which sets they were."""
    losses: list[Loss] = []
    outputs = tuple(_with_numbers(system, o, losses) for o in system.outputs)
    return system.model_copy(update={"outputs": outputs}), losses


def _with_numbers(system: FuzzySystem, output: Output, losses: list[Loss]) -> Output:
    defuzzifier = defuzzifier_of(system, output)
    if not (defuzzifier.averages or defuzzifier.kind == "weighted_sum"):
        return output
    by_degree = system.method.semantics.chained == "degree"
    reads = not by_degree and any(i.variable == output.name for r in system.rules for i in literals(r.antecedent))
    terms = []
    for term in output.terms:
        own = term.membership
        if own.kind in MEMBERSHIP and own.kind != "constant":
            low, high = MEMBERSHIP[own.kind].core(tuple(system.number(a) for a in own.arguments))
            number = Membership(kind="constant", arguments=(Number((low + high) / 2),), span=own.span)
            if MEMBERSHIP[own.kind].fuzzy:
                why = "in an average only the middle of its core counts, which is written"
                losses.append(Loss(f"output '{output.name}'", f"term '{term.name}'", why, exact=not reads))
            term = term.model_copy(update={"membership": number})
        terms.append(term)
    return output.model_copy(update={"terms": tuple(terms)})
