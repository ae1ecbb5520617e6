"""Losses of writing: the parts of a system that a file does not express, or that its tool computes otherwise."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Expr, Number, names_in
from fuzzyctl.formats.common.ranges import holding_matters
from fuzzyctl.formats.fz import defuzzifier_text, otherwise_text
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, MEMBERSHIP, is_endless
from fuzzyctl.model.method import KNOBS, MAXIMA, Defuzzifier, Semantics
from fuzzyctl.model.rule import And, Consequent, Or, RuleTable, is_joined_by, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term

#: Weights and heights below which a tool that leaves out activations of 1e-6 leaves out much of a term.
_SMALL: Final = 1e-3

# --- parts of a system ---------------------------------------------------------------------------------------------


def defuzzifier_of(system: FuzzySystem, output: Output) -> Defuzzifier:
    """Return the defuzzifier of an output, which may be the system's."""
    return output.defuzzifier or system.method.defuzzifier


def value_unfired(system: FuzzySystem, output: Output) -> float | None:
    """Return the value of an output if no rule fires, or before any has fired; None for NaN and for an error."""
    otherwise = output.otherwise
    start = otherwise.start if isinstance(otherwise, Hold) else otherwise
    if isinstance(start, Expr):
        return system.number(start)
    return middle_of(system, output) if start == "midpoint" or otherwise == Hold() else None


def middle_of(system: FuzzySystem, output: Output) -> float:
    """Return the middle of the range of an output."""
    low, high = system.range_of(output)
    return low / 2 + high / 2


def used_norms(system: FuzzySystem) -> set[str]:
    """Return the norms of a system, its rule blocks and its outputs."""
    method = system.method
    norms = [method.conjunction, method.disjunction, method.implication, method.aggregation]
    norms += [n for o in system.outputs for n in (o.implication, o.aggregation) if n is not None]
    norms += [n for b in system.rule_blocks for n in (b.conjunction, b.disjunction, b.implication) if n is not None]
    return set(norms)


def used_hedges(system: FuzzySystem) -> tuple[set[str], set[str]]:
    """Return the hedges of conditions and those of conclusions."""
    of_conditions = {h for r in system.rules for i in literals(r.antecedent) for h in i.hedges}
    return of_conditions, {h for r in system.rules for c in r.consequents for h in c.hedges}


def _shares_terms(system: FuzzySystem, output: Output) -> bool:
    """Whether two rules name one term of an output."""
    terms = [c.term for r in system.rules for c in r.consequents if c.output == output.name]
    return len(set(terms)) < len(terms)


def aggregation_matters(system: FuzzySystem, output: Output, merge: str) -> bool:
    """Whether a norm changes an output under a tool's `merge`; some tools join the rules of one term before sums."""
    is_sum = defuzzifier_of(system, output).over_rules
    return not is_sum or merge == "places" or (merge == "terms" and _shares_terms(system, output))


# --- reasons why no file can be written ----------------------------------------------------------------------------


def cannot(system: FuzzySystem, format: str, reasons: Sequence[str]) -> DiagnosticError:
    """Return the error for a system that a format cannot hold at all."""
    facts = tuple(dict.fromkeys(reasons))
    message = f"a {format} file cannot express '{system.name}'"
    return DiagnosticError([Diagnostic("FZ608", message, system.span, facts=facts, file=system.path)])


def impossible(system: FuzzySystem) -> Iterator[str]:
    """Yield the parts that no format of another tool has."""
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


# --- numerics ------------------------------------------------------------------------------------------------------


def other_knobs(system: FuzzySystem, there: Semantics) -> Iterator[Loss]:
    """Yield the knobs that differ in the tool of a format and change numbers of a system."""
    here = system.method.semantics
    for knob in KNOBS:
        if getattr(here, knob) != getattr(there, knob) and _matters(system, knob, there):
            why = f"{there.text(knob)} under '{there.profile}'"
            yield Loss(f"system '{system.name}'", f"{knob} {here.text(knob)}", why)


def _matters(system: FuzzySystem, knob: str, there: Semantics) -> bool:
    """Whether the value of a knob there changes numbers of a system."""
    methods = [defuzzifier_of(system, o) for o in system.outputs]
    norms = used_norms(system)
    hedges, consequent_hedges = used_hedges(system)
    memberships = [t.membership for v in (*system.inputs, *system.outputs) for t in v.terms]
    weighted = any(system.number(r.weight) != 1 for r in system.rules)
    outputs = {o.name for o in system.outputs}
    relevant = {
        "weight": weighted and any(not m.over_rules for m in methods) and norms != {"product"},
        # A file says that rules count by themselves: it adds them up.
        "merge": system.method.semantics.merge != "rules"
        and any(_joins_terms(system, o) for o in system.outputs)
        and any(_shares_terms(system, o) for o in system.outputs),
        "total": any(m.averages for m in methods) and (weighted or len(system.outputs) > 1),
        "least": bool(consequent_hedges) or _least_decides(system, there),
        "equal": any({**CONJUNCTIONS, **AGGREGATIONS}[n].tolerant for n in norms),
        "chained": any(i.variable in outputs for r in system.rules for i in literals(r.antecedent)),
        "consequent_hedges": bool(consequent_hedges),
        "extremely": "extremely" in hedges | consequent_hedges,
        "sigmoid_difference": any(m.kind == "sigmoid_difference" for m in memberships),
        "places": any(_places_leave(system, o) for o in system.outputs),
        "none_active": any(m.kind in MAXIMA for m in methods),
        "fallback": any(map(_is_function, memberships)) or any("tsukamoto" in m.kind for m in methods),
    }
    return relevant[knob]


def _joins_terms(system: FuzzySystem, output: Output) -> bool:
    """Whether an output that sums over rules joins those of one term otherwise than by adding them."""
    return defuzzifier_of(system, output).over_rules and (output.aggregation or system.method.aggregation) != "sum"


def _is_function(membership: Membership) -> bool:
    """Whether a term is a function that may have no value somewhere."""
    return membership.kind == "function" and bool(names_in(membership.arguments[0]))


def _least_decides(system: FuzzySystem, there: Semantics) -> bool:
    """Whether the activations that one of two tools leaves out may be the only ones in more than a sliver of a range.

    Larger ones outweigh them. Straight sides, and smooth ones that end, have them only within about the root of the
    bound of their ends; tails of curved terms, functions and small weights have them anywhere.
    """
    if max(system.method.semantics.least or 0.0, there.least or 0.0) == 0.0:
        return False
    if any(system.number(r.weight) < _SMALL for r in system.rules):
        return True
    used = {(i.variable, i.term) for r in system.rules for i in literals(r.antecedent)}
    terms = [t.membership for v in system.inputs for t in v.terms if (v.name, t.name) in used]
    return any(system.number(m.height) < _SMALL or is_endless(m.kind) or _is_function(m) for m in terms)


def _places_leave(system: FuzzySystem, output: Output) -> bool:
    """Whether places that Tsukamoto's method finds may lie outside the range of an output."""
    kind = defuzzifier_of(system, output).kind
    if "tsukamoto" not in kind:
        return False
    low, high = system.range_of(output)
    if kind.startswith("inverse"):
        return not (low <= 0.0 and high >= 1.0)
    # No place has a degree beyond the height of a term, and rules of one term may add up to more than 1.
    if _shares_terms(system, output) or any(system.number(t.membership.height) != 1 for t in output.terms):
        return True
    return not all(low <= end <= high for t in output.terms for end in _ends(system, t.membership))


def _ends(system: FuzzySystem, membership: Membership) -> tuple[float, float]:
    """Return the places of the degrees 0 and 1 of a monotone term; infinite for other terms and endless tails."""
    if membership.kind in MEMBERSHIP and not is_endless(membership.kind):
        formula = MEMBERSHIP[membership.kind]
        p = tuple(system.number(a) for a in membership.arguments)
        if formula.monotone(p):
            bends = [x for x in formula.pieces(p) if math.isfinite(x)]
            return min(bends), max(bends)
    return -math.inf, math.inf


# --- the system that a text is read as -----------------------------------------------------------------------------


def losses_of(
    system: FuzzySystem, back: FuzzySystem | None, rules: Sequence[int] | None = None, *, nan_for_error: bool = False
) -> Iterator[Loss]:
    """Yield the differences between a system and its text, apart from its terms.

    Args:
        system: The system with the names of the text.
        back: The system that the text is read as; None if it cannot be read.
        rules: Positions of the system's rules in the order of the text; None for the order of the system.
        nan_for_error: Whether NaN if no rule fires is as good as an error.
    """
    where = f"system '{system.name}'"
    if back is None:
        yield Loss(where, "the system", "what is written cannot be read")
        return
    yield from _of_words(system, back, where)
    yield from other_knobs(system, back.method.semantics)
    yield from _of_rules(system, back, range(len(system.rules)) if rules is None else rules)
    for variable, there in zip(system.inputs, back.inputs, strict=False):
        yield from _of_input(system, variable, there)
    for output, read in zip(system.outputs, back.outputs, strict=False):
        yield from _of_output(system, output, back, read)
        yield from _of_otherwise(system, output, read, nan_for_error=nan_for_error)


def _of_words(system: FuzzySystem, back: FuzzySystem, where: str) -> Iterator[Loss]:
    """Yield the words that the text does not have; no kernel reads them."""
    texts = [
        (where, "the title", system.title, back.title),
        (where, "the source", system.citation, back.citation),
        (where, "units of params", any(p.unit for p in system.params), any(p.unit for p in back.params)),
        (where, "guarantees", system.guarantees, back.guarantees),
    ]
    for kind in ("input", "output"):
        for here, there in zip(getattr(system, f"{kind}s"), getattr(back, f"{kind}s"), strict=False):
            owner = f"{kind} '{here.name}'"
            texts += [(owner, f"the {f}", getattr(here, f), getattr(there, f)) for f in ("label", "unit")]
    for owner, what, text, text_there in texts:
        if text and not text_there:
            yield Loss(owner, what, "the format has none", exact=True)
    if system.params:
        yield Loss(where, f"params {', '.join(p.name for p in system.params)}", "written as their values", exact=True)
    if any(isinstance(b, RuleTable) for b in system.tables_and_rules):
        yield Loss(where, "tables", "they are written as single rules", exact=True)
    for block in system.rule_blocks if not back.rule_blocks else ():
        yield Loss(f"rule block '{block.name}'", "the block", "the format has none; its rules stand alone", exact=True)


def _of_rules(system: FuzzySystem, back: FuzzySystem, rules: Sequence[int]) -> Iterator[Loss]:
    outputs = {there.name: output for output, there in zip(system.outputs, back.outputs, strict=False)}
    for r, (k, there) in zip(rules, enumerate(back.rule_methods), strict=False):
        here, rule = system.rule_methods[r], system.rules[r]
        where = f"rule block '{system.rule_blocks[here.block].name}'" if here.block >= 0 else f"system '{system.name}'"
        pairs = [("activation", here.activation.kind, there.activation.kind)]
        if is_joined_by(And, rule.antecedent):
            pairs.append(("and", here.conjunction, there.conjunction))
        if is_joined_by(Or, rule.antecedent):
            pairs.append(("or", here.disjunction, there.disjunction))
        for name in {c.output for c in back.rules[k].consequents} & outputs.keys():
            if not defuzzifier_of(system, outputs[name]).over_rules:
                implication = system.implication_of(r, outputs[name])
                pairs.append(("implication", implication, back.implication_of(k, back.output(name))))
        for what, method, method_there in pairs:
            if method != method_there:
                yield Loss(where, f"{what} {method}", f"it is read as '{method_there}'")


def _of_input(system: FuzzySystem, variable: Input, there: Input) -> Iterator[Loss]:
    where = f"input '{variable.name}'"
    if variable.extrapolate == there.extrapolate:
        return
    exact = not holding_matters(system, variable)
    if variable.extrapolate:
        yield Loss(where, "values outside the range", "they are held at its ends", exact=exact)
    else:
        why = "beyond it its terms stay what they are at its ends" if exact else "values outside it are not held"
        yield Loss(where, "clamped to its range", why, exact=exact)


def _of_output(system: FuzzySystem, output: Output, back: FuzzySystem, there: Output) -> Iterator[Loss]:
    where = f"output '{output.name}'"
    if output.adaptive is not None:
        yield Loss(where, "adaptive consequents", "they stay as they are")
    if output.clamped and not there.clamped:
        yield Loss(where, "clamped to its range", "nothing clamps it")
    ours, theirs = defuzzifier_of(system, output), defuzzifier_of(back, there)
    same = (ours.averages and theirs.averages) or (ours.over_rules and ours.kind == theirs.kind)
    if ours != theirs and not same:
        yield Loss(where, f"defuzzifier {_text(ours)}", f"becomes {_text(theirs)}")
    norm, norm_there = (o.aggregation or s.method.aggregation for s, o in ((system, output), (back, there)))
    if ours.over_rules and system.method.semantics.merge == "rules":
        norm = "sum"  # each rule counts by itself
    if aggregation_matters(system, output, back.method.semantics.merge) and norm != norm_there:
        yield Loss(where, f"aggregation {norm}", f"it is read as '{norm_there}'")


def _of_otherwise(system: FuzzySystem, output: Output, there: Output, *, nan_for_error: bool) -> Iterator[Loss]:
    """Yield a difference of the value if no rule fires."""
    where = f"output '{output.name}'"
    value, value_there = (_value(system, o.otherwise, middle_of(system, output)) for o in (output, there))
    if output.otherwise is None:
        if there.otherwise is not None:
            yield Loss(where, "that some rule always fires", "the format has no words for it", exact=True)
    elif value != value_there:
        text_there = "nothing" if there.otherwise is None else otherwise_text(there.otherwise)
        if value[0] == value_there[0] == "hold":
            yield Loss(where, "what it holds at first", f"it begins with {text_there}")
        else:
            text = (
                output.otherwise if isinstance(output.otherwise, str) else "hold" if value[0] == "hold" else "a value"
            )
            exact = text == "error" and nan_for_error
            yield Loss(where, f"else {text}", f"it is '{text_there}' there where no rule fires", exact=exact)
    elif output.otherwise == "midpoint" != there.otherwise:
        yield Loss(where, "else midpoint", "the number is written", exact=True)


def _value(system: FuzzySystem, otherwise: object, middle: float) -> tuple[str, object]:
    """Return the value of an output if no rule fires in a form that can be compared."""
    if isinstance(otherwise, Hold):
        return "hold", _value(system, "midpoint" if otherwise.start is None else otherwise.start, middle)
    if isinstance(otherwise, Expr):
        return "value", system.number(otherwise)
    return ("value", middle) if otherwise == "midpoint" else (str(otherwise), None)


def _text(defuzzifier: Defuzzifier) -> str:
    exact = defuzzifier.resolution is None and not defuzzifier.over_rules
    return f"{defuzzifier_text(defuzzifier)} without samples" if exact else defuzzifier_text(defuzzifier)


# --- consequents as formats have them ------------------------------------------------------------------------------


def with_named_consequents(
    system: FuzzySystem, prefix: str = "mf", *, fold: Callable[[str], str] = str
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system in which every consequent is a term, and the outputs that get terms by this.

    Args:
        system: The system; numbers and functions in its rules and cells have no names.
        prefix: The beginning of the names, before a number; behind `mf` it is the number of the term.
        fold: Makes equal names of two that the format does not tell apart, such as a change of case.
    """
    terms = {o.name: list(o.terms) for o in system.outputs}
    names: dict[tuple[str, Membership], str] = {}

    def named(c: Consequent) -> Consequent:
        if not isinstance(c.term, Membership):
            return c
        key = c.output, c.term
        if key not in names:
            known = {fold(t.name) for t in terms[c.output]}
            number = len(terms[c.output]) + 1 if prefix == "mf" else 1
            while fold(f"{prefix}{number}") in known:
                number += 1
            names[key] = f"{prefix}{number}"
            terms[c.output].append(Term(name=names[key], membership=c.term))
        return c.model_copy(update={"term": names[key]})

    rules = [r.model_copy(update={"consequents": tuple(map(named, r.consequents))}) for r in system.rules]
    if not names:
        return system, []
    outputs = tuple(o.model_copy(update={"terms": tuple(terms[o.name])}) for o in system.outputs)
    what, why = "consequents without a name", "they are terms with names of their own"
    losses = [Loss(f"output '{name}'", what, why, exact=True) for name in dict.fromkeys(o for o, _ in names)]
    return system.with_rules(rules).model_copy(update={"outputs": outputs}), losses


def with_numbers_averaged(system: FuzzySystem) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose averages are over numbers, the middles of the cores of sets, and the sets it replaced."""
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
        membership = term.membership
        formula = MEMBERSHIP.get(membership.kind)
        if formula is not None and membership.kind != "constant":
            low, high = formula.core(tuple(system.number(a) for a in membership.arguments))
            number = Membership(kind="constant", arguments=(Number((low + high) / 2),), span=membership.span)
            if formula.fuzzy:
                why = "in an average only the middle of its core counts, which is written"
                losses.append(Loss(f"output '{output.name}'", f"term '{term.name}'", why, exact=not reads))
            term = term.model_copy(update={"membership": number})
        terms.append(term)
    return output.model_copy(update={"terms": tuple(terms)})
