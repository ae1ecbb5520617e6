"""Losses of a conversion: what differs between a system and what its text is read as."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.expr import Expr
from fuzzyctl.formats.common.clamped_inputs import holding_matters
from fuzzyctl.formats.common.numerics import defuzzifier_of, middle_of, other_knobs, shares_terms
from fuzzyctl.formats.fz import defuzzifier_text, otherwise_text
from fuzzyctl.formats.losses import Loss
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.rule import And, Or, RuleTable, is_joined_by
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Output


def losses_of(
    system: FuzzySystem, back: FuzzySystem | None, rules: Sequence[int] | None = None, *, nan_for_error: bool = False
) -> Iterator[Loss]:
    """Yield what a text does not say, or says in another way, apart from its terms.

    Args:
        system: The system as it is written, its names those of the text.
        back: What the text is read as; None where it cannot be read.
        rules: Positions of the system's rules in the order of the text; None where that is their own.
        nan_for_error: Whether NaN where no rule fires is as good as an error.
    """
    where = f"system '{system.name}'"
    if back is None:
        yield Loss(where, "the system", "what is written cannot be read")
        return
    yield from _of_words(system, back, where)
    yield from other_knobs(system, back.method.semantics)
    yield from _of_rules(system, back, range(len(system.rules)) if rules is None else rules)
    for variable, own in zip(system.inputs, back.inputs, strict=False):
        yield from _of_input(system, variable, own)
    for output, read in zip(system.outputs, back.outputs, strict=False):
        yield from _of_output(system, output, back, read)
        yield from _of_otherwise(system, output, read, nan_for_error=nan_for_error)


def _of_words(system: FuzzySystem, back: FuzzySystem, where: str) -> Iterator[Loss]:
    """Yield what a kernel does not read and the text does not say."""
    found = {
        "the title": (system.title, back.title),
        "the source": (system.citation, back.citation),
        "units of params": (any(p.unit for p in system.params), any(p.unit for p in back.params)),
        "guarantees": (system.guarantees, back.guarantees),
    }
    for what, (said, kept) in found.items():
        if said and not kept:
            yield Loss(where, what, "the format has none", exact=True)
    for variables, read in ((system.inputs, back.inputs), (system.outputs, back.outputs)):
        for own, there in zip(variables, read, strict=False):
            for field in ("label", "unit"):
                if getattr(own, field) and not getattr(there, field):
                    kind = "output" if isinstance(own, Output) else "input"
                    yield Loss(f"{kind} '{own.name}'", f"the {field}", "the format has none", exact=True)
    if system.params:
        yield Loss(where, f"params {', '.join(p.name for p in system.params)}", "written as their values", exact=True)
    if any(isinstance(b, RuleTable) for b in system.tables_and_rules):
        yield Loss(where, "tables", "they are written as single rules", exact=True)
    for block in system.rule_blocks if not back.rule_blocks else ():
        yield Loss(f"rule block '{block.name}'", "the block", "the format has none; its rules stand alone", exact=True)


def _of_rules(system: FuzzySystem, back: FuzzySystem, rules: Sequence[int]) -> Iterator[Loss]:
    outputs = {there.name: output for output, there in zip(system.outputs, back.outputs, strict=False)}
    for r, (k, there) in zip(rules, enumerate(back.rule_methods), strict=False):
        own, rule = system.rule_methods[r], system.rules[r]
        where = f"rule block '{system.rule_blocks[own.block].name}'" if own.block >= 0 else f"system '{system.name}'"
        pairs = [("activation", own.activation.kind, there.activation.kind)]
        if is_joined_by(And, rule.antecedent):
            pairs.append(("and", own.conjunction, there.conjunction))
        if is_joined_by(Or, rule.antecedent):
            pairs.append(("or", own.disjunction, there.disjunction))
        for name in {c.output for c in back.rules[k].consequents} & outputs.keys():
            if not defuzzifier_of(system, outputs[name]).over_rules:
                kept = back.implication_of(k, back.output(name))
                pairs.append(("implication", system.implication_of(r, outputs[name]), kept))
        for what, said, read in pairs:
            if said != read:
                yield Loss(where, f"{what} {said}", f"it is read as '{read}'")


def _of_input(system: FuzzySystem, variable: Input, read: Input) -> Iterator[Loss]:
    where = f"input '{variable.name}'"
    if variable.extrapolate == read.extrapolate:
        return
    exact = not holding_matters(system, variable)
    if variable.extrapolate:
        yield Loss(where, "values outside the range", "they are held at its ends", exact=exact)
    else:
        why = "beyond it its terms stay what they are at its ends" if exact else "values outside it are not held"
        yield Loss(where, "clamped to its range", why, exact=exact)


def _of_output(system: FuzzySystem, output: Output, back: FuzzySystem, read: Output) -> Iterator[Loss]:
    where = f"output '{output.name}'"
    if output.adaptive is not None:
        yield Loss(where, "adaptive consequents", "they stay as they are")
    if output.clamped and not read.clamped:
        yield Loss(where, "clamped to its range", "nothing clamps it")
    ours, theirs = defuzzifier_of(system, output), defuzzifier_of(back, read)
    same = (ours.averages and theirs.averages) or (ours.over_rules and ours.kind == theirs.kind)
    if ours != theirs and not same:
        yield Loss(where, f"defuzzifier {_text(ours)}", f"becomes {_text(theirs)}")
    said, kept = (o.aggregation or s.method.aggregation for s, o in ((system, output), (back, read)))
    if ours.over_rules and system.method.semantics.merge == "rules":
        said = "sum"  # rules that stand by themselves are added up
    merge = back.method.semantics.merge
    matters = not ours.over_rules or merge == "places" or (merge == "terms" and shares_terms(system, output))
    if matters and said != kept:
        yield Loss(where, f"aggregation {said}", f"it is read as '{kept}'")


def _of_otherwise(system: FuzzySystem, output: Output, found: Output, *, nan_for_error: bool) -> Iterator[Loss]:
    """Yield what an output is where no rule fires, as far as it is something else."""
    where = f"output '{output.name}'"
    middle = middle_of(system, output)
    said, read = (_value(system, o.otherwise, middle) for o in (output, found))
    if output.otherwise is None:
        if found.otherwise is not None:
            yield Loss(where, "that some rule always fires", "the format has no words for it", exact=True)
    elif said != read:
        text = output.otherwise if isinstance(output.otherwise, str) else "hold" if said[0] == "hold" else "a value"
        exact = text == "error" and nan_for_error
        kept = "nothing" if found.otherwise is None else otherwise_text(found.otherwise)
        if said[0] == read[0] == "hold":
            yield Loss(where, "what it holds at first", f"it begins with {kept}")
        else:
            yield Loss(where, f"else {text}", f"it is '{kept}' there where no rule fires", exact=exact)
    elif output.otherwise == "midpoint" != found.otherwise:
        yield Loss(where, "else midpoint", "the number is written", exact=True)


def _value(system: FuzzySystem, otherwise: object, middle: float) -> tuple[str, object]:
    """Return what an output is where no rule fires in a form that can be compared."""
    if isinstance(otherwise, Hold):
        return "hold", _value(system, "midpoint" if otherwise.start is None else otherwise.start, middle)
    if isinstance(otherwise, Expr):
        return "value", system.number(otherwise)
    return ("value", middle) if otherwise == "midpoint" else (str(otherwise), None)


def _text(defuzzifier: Defuzzifier) -> str:
    exact = defuzzifier.resolution is None and not defuzzifier.over_rules
    return f"{defuzzifier_text(defuzzifier)} without samples" if exact else defuzzifier_text(defuzzifier)
