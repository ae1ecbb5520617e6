"""Losses of a system in FCL: elements without FCL words, and differences found by reading back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.expr import Expr
from fuzzyctl.formats.common.blocks import BlockPart
from fuzzyctl.formats.common.clamped_inputs import holding_matters
from fuzzyctl.formats.common.numerics import other_knobs
from fuzzyctl.formats.fcl.dialect import DialectName
from fuzzyctl.formats.fcl.written_names import WrittenNames
from fuzzyctl.formats.fcl.written_shapes import counts_as_number, says_otherwise, unknown_functions
from fuzzyctl.formats.fz import defuzzifier_text
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.method import OVER_RULES, Defuzzifier
from fuzzyctl.model.rule import And, Not, Or, RuleTable, is_joined_by, literals, parts_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output


def losses_of(
    system: FuzzySystem,
    read_back: FuzzySystem | None,
    dialect: DialectName,
    names: WrittenNames,
    parts: Sequence[BlockPart],
) -> Iterator[Loss]:
    """Yield what a text does not say.

    Args:
        system: The system.
        read_back: What reading the text gives, None where it cannot be read.
        dialect: The dialect of the text.
        names: What its names became.
        parts: Its rule blocks as they were written.
    """
    yield from _of_system(system)
    for variable in system.inputs:
        yield from _of_variable(system, variable, dialect)
    for output in system.outputs:
        yield from _of_variable(system, output, dialect)
        yield from _of_output(system, output)
    yield from _of_rules(system, dialect)
    if read_back is None:
        yield Loss(f"system '{system.name}'", "the system", "what is written cannot be read as FCL")
    else:
        yield from _of_numerics(system, read_back, names)
        yield from _of_methods(system, read_back, [r for part in parts for r, _ in part.rules])


def _of_system(system: FuzzySystem) -> Iterator[Loss]:
    where = f"system '{system.name}'"
    if system.title:
        yield Loss(where, "title", "it is a comment", exact=True)
    for param in system.params:
        yield Loss(where, f"param '{param.name}'", "numbers stand for what it is used in", exact=True)
    for hedge in system.hedges:
        yield Loss(where, f"hedge '{hedge.name}'", "FCL has no hedges of one's own; it is left out")
    if system.citation:
        yield Loss(where, "source", "FCL has no words for it", exact=True)
    if system.guarantees:
        yield Loss(where, "guarantees", "FCL has no words for them", exact=True)
    if any(isinstance(b, RuleTable) for b in system.tables_and_rules):
        yield Loss(where, "tables", "they are written as single rules", exact=True)
    for kind in dict.fromkeys(m.activation.kind for m in system.rule_methods if m.activation.kind != "general"):
        yield Loss(where, f"activation '{kind}'", "in FCL all rules act")


def _of_variable(system: FuzzySystem, variable: Input | Output, dialect: DialectName) -> Iterator[Loss]:
    where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
    for what, text in (("label", variable.label), ("unit", variable.unit)):
        if text:
            yield Loss(where, what, "FCL has no words for it", exact=True)
    if isinstance(variable, Input) and not variable.extrapolate:
        matters = holding_matters(system, variable)
        why = "they are not held at its ends" if matters else "terms stay there what they are at its ends"
        yield Loss(where, "values outside the range", why, exact=not matters)
    for term in variable.terms:
        if isinstance(variable, Output) and counts_as_number(system, variable, term.membership):
            read = any(i.variable == variable.name for r in system.rules for i in literals(r.antecedent))
            why = "in an average only the middle of its core counts, which is written"
            yield Loss(where, f"term '{term.name}'", why, exact=not read)
        elif says_otherwise(term.membership, system.values, dialect):
            yield Loss(where, f"term '{term.name}'", f"the {term.membership.kind} is written as points", exact=True)
        yield from _of_function(f"{where}, term '{term.name}'", term.membership)


def _of_function(where: str, membership: Membership) -> Iterator[Loss]:
    for name in unknown_functions(membership):
        yield Loss(where, f"function '{name}'", "no FCL tool has it")


def _of_output(system: FuzzySystem, output: Output) -> Iterator[Loss]:
    where = f"output '{output.name}'"
    if output.adaptive is not None:
        yield Loss(where, "adaptive consequents", "in FCL consequents stay as they are")
    if output.otherwise is None:
        yield Loss(where, "that some rule always fires", "FCL has no words for it", exact=True)
    elif output.otherwise == "error":
        yield Loss(where, "else error", "where no rule fires it is NaN")
    elif output.otherwise == "midpoint":
        yield Loss(where, "else midpoint", "the number is written", exact=True)
    if any(isinstance(c.term, Membership) for r in system.rules for c in r.consequents if c.output == output.name):
        yield Loss(where, "consequents without a name", "they are terms with names of their own", exact=True)
        for rule in system.rules:
            for c in rule.consequents:
                if c.output == output.name and isinstance(c.term, Membership):
                    yield from _of_function(where, c.term)


def _of_rules(system: FuzzySystem, dialect: DialectName) -> Iterator[Loss]:
    own = {h.name for h in system.hedges}
    no_tool = {"slightly"} if dialect == "fuzzylite" else set()
    for number, rule in enumerate(system.rules, 1):
        hedges = {h for i in literals(rule.antecedent) for h in i.hedges}
        hedges |= {h for c in rule.consequents for h in c.hedges}
        for hedge in sorted(hedges & (own | no_tool) | (hedges - set(HEDGES))):
            why = "it is left out" if hedge not in HEDGES else "only fuzzyctl reads it"
            yield Loss(f"rule {number}", f"hedge '{hedge}'", f"no FCL tool has it; {why}")
        if dialect == "fuzzylite" and any(isinstance(part, Not) for part in parts_of(rule.antecedent)):
            yield Loss(f"rule {number}", "not", "fuzzylite does not read NOT before a condition", exact=True)


def _needs_sets(system: FuzzySystem, output: Output) -> bool:
    return (output.defuzzifier or system.method.defuzzifier).kind not in OVER_RULES


def _of_numerics(system: FuzzySystem, read_back: FuzzySystem, names: WrittenNames) -> Iterator[Loss]:
    """Yield the settings that are others after reading the text back."""
    yield from other_knobs(system, read_back.method.semantics)
    for output in system.outputs:
        yield from _of_output_numerics(system, output, read_back, read_back.output(names.variables[output.name]))


def _of_methods(system: FuzzySystem, read_back: FuzzySystem, written: Sequence[int]) -> Iterator[Loss]:
    """Yield norms that are others after reading the text back; `written` are the rules in the order of the text."""
    for r, method in zip(written, read_back.rule_methods, strict=False):
        block = system.rule_methods[r].block
        where = f"rule block '{system.rule_blocks[block].name}'" if block >= 0 else f"system '{system.name}'"
        for field, kind in (("conjunction", And), ("disjunction", Or)):
            said, found = getattr(system.rule_methods[r], field), getattr(method, field)
            if said != found and is_joined_by(kind, system.rules[r].antecedent):
                yield Loss(where, f"{field} '{said}'", f"it is read as '{found}'")


def _of_output_numerics(system: FuzzySystem, output: Output, read_back: FuzzySystem, found: Output) -> Iterator[Loss]:
    where = f"output '{output.name}'"
    ours = output.defuzzifier or system.method.defuzzifier
    theirs = found.defuzzifier or read_back.method.defuzzifier
    if _plain(ours) != _plain(theirs):
        yield Loss(where, f"defuzzifier {_text(ours)}", f"it is read as {_text(theirs)}")
    if _needs_sets(system, output) and output.adaptive is None:
        for said, read in zip(system.implications_of(output), read_back.implications_of(found), strict=False):
            if said != read:
                yield Loss(where, f"implication '{said}'", f"it is read as '{read}'")
        said, read = (o.aggregation or s.method.aggregation for s, o in ((system, output), (read_back, found)))
        if said != read:
            yield Loss(where, f"aggregation '{said}'", f"it is read as '{read}'")
    elif not _needs_sets(system, output) and read_back.method.semantics.merge != "rules":
        # Rules that stand by themselves are added up.
        alone = system.method.semantics.merge == "rules"
        said = "sum" if alone else output.aggregation or system.method.aggregation
        read = found.aggregation or read_back.method.aggregation
        if said != read:
            yield Loss(where, f"aggregation '{said}'", f"it is read as '{read}'")
    if output.clamped and not found.clamped:
        yield Loss(where, "clamp", "FCL has no words for it")
    yield from _of_otherwise(system, output, found)


def _of_otherwise(system: FuzzySystem, output: Output, found: Output) -> Iterator[Loss]:
    said, read = output.otherwise, found.otherwise
    if isinstance(said, Hold):
        start = said.start if isinstance(said.start, Expr) else None
        if not isinstance(read, Hold):
            yield Loss(f"output '{output.name}'", "else hold", "FCL has no words for it")
        elif (start is None) != (not isinstance(read.start, Expr)) and said.start is not None:
            yield Loss(f"output '{output.name}'", "what it holds at first", "FCL has no words for it")
        elif said.start is None and not isinstance(read.start, Expr):
            yield Loss(f"output '{output.name}'", "the middle held at first", "FCL begins with NaN")
    elif said == "nan" and read != "nan":
        why = (
            "where no rule fires it keeps its previous value"
            if isinstance(read, Hold)
            else "it has another value there"
        )
        yield Loss(f"output '{output.name}'", "else nan", why)


def _plain(defuzzifier: Defuzzifier) -> Defuzzifier:
    """Return a defuzzifier without the name that Mamdani systems have for the average."""
    return defuzzifier.model_copy(update={"kind": "weighted_average"}) if defuzzifier.averages else defuzzifier


def _text(defuzzifier: Defuzzifier) -> str:
    return f"'{defuzzifier_text(defuzzifier)}'"
