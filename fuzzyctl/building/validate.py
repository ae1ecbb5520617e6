"""Validation of a system built in Python: the checks of the rule file that it is printed as."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.loading.load import examine
from fuzzyctl.model.method import Method
from fuzzyctl.model.rule import RuleBlock, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output

#: Names as the language has them; which of them are words of the language is for the checks.
_NAME: Final = re.compile(r"[^\W\d]\w*")

#: What a system names: what it is called, and the name.
_Named = Iterator[tuple[str, str]]


def require_as_file(built: FuzzySystem) -> None:
    """Check a system as a rule file.

    Raises:
        DiagnosticError: With all mistakes, without places.
        ArgumentError: For elements made by hand that cannot be expressed in .fz.
        ValueOutOfBoundsError: For a title, label, unit or citation that a rule file cannot hold.
    """
    mistakes = list(_no_names(built))
    if mistakes:  # nothing can be printed
        raise DiagnosticError(mistakes)
    text = dumps(built)
    read, found = examine(SourceText(f"system {built.name}", text))
    errors = [_without_place(d) for d in found if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    if read is None or dumps(read) != text:  # such as a name in a rule made by hand that prints as something else
        raise ArgumentError(f"the system {built.name!r} contains elements that cannot be expressed in .fz")


def _without_place(d: Diagnostic) -> Diagnostic:
    """Return a diagnostic of generated text without its location, and without the lines that its facts name."""
    facts = tuple(re.sub(r" \(line \d+\)", "", fact) for fact in d.facts)
    return dataclasses.replace(d, span=None, notes=(), facts=facts)


def _no_names(built: FuzzySystem) -> Iterator[Diagnostic]:
    """Find names that cannot be written as names of a rule file."""
    named = [*_declared(built), *_method_names(built), *_in_rules(built), *_in_tables(built)]
    for what, name in dict.fromkeys(named):
        if not _NAME.fullmatch(name):
            help_text = "a name is a letter, and letters, digits and underscores behind it"
            yield Diagnostic("FZ102", f"{name!r} cannot be the name of {what}", help=help_text)


def _declared(built: FuzzySystem) -> _Named:
    yield "a system", built.name
    for p in built.params:
        yield "a param", p.name
    for h in built.hedges:
        yield "a hedge", h.name
        yield "the parameter of a hedge", h.parameter
    for v in built.variables:
        yield "a variable", v.name
        for t in v.terms:
            yield f"a term of '{v.name}'", t.name
            yield "a membership function", t.membership.kind
    yield from (("a rule block", b.name) for b in built.rule_blocks)


def _method_names(built: FuzzySystem) -> _Named:
    owners: tuple[Method | Output | RuleBlock, ...] = (built.method, *built.outputs, *built.rule_blocks)
    for owner in owners:
        for field in ("conjunction", "disjunction", "implication", "aggregation"):
            name = getattr(owner, field, None)
            if name is not None:
                yield f"{'an' if field[0] in 'ai' else 'a'} {field}", name
        for field in ("activation", "defuzzifier"):
            setting = getattr(owner, field, None)
            if setting is not None:
                yield f"{'an' if field[0] == 'a' else 'a'} {field}", setting.kind


def _in_rules(built: FuzzySystem) -> _Named:
    for r in built.rules:
        for i in literals(r.antecedent):
            yield from (("a part of a rule", w) for w in (i.variable, i.term, *i.hedges))
        for c in r.consequents:
            name = c.term.kind if isinstance(c.term, Membership) else c.term
            yield from (("a part of a rule", w) for w in (c.output, *c.hedges, name))


def _in_tables(built: FuzzySystem) -> _Named:
    for table in built.tables_and_rules:
        if isinstance(table, RuleTable):
            words = [*table.outputs, table.columns, *([table.rows] if table.rows else [])]
            yield from (("a part of a table", w) for w in (*words, *table.row_terms, *table.column_terms))
