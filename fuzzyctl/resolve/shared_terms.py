"""Resolution of `terms of VARIABLE`: a variable takes the term lines of another one."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.expr import to_text
from fuzzyctl.lang import syntax as sx
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import terms_of

#: Most terms of a system that variables have in common with others, each counted for each further variable.
MAX_SHARED: Final = 20_000


def share_terms(context: Context, statements: Sequence[sx.Statement]) -> Iterator[sx.Statement]:
    """Yield the statements, those of variables that share terms with the lines that they take over.

    Args:
        context: What is declared; the variables change there, too.
        statements: All statements of a system.
    """
    first: set[int] = set()
    count = 0
    for s in statements:
        if not isinstance(s, sx.Variable):
            yield s
            continue
        clause = _clause(s)
        lines = _lines(context, s, clause) if clause is not None else s.terms
        if lines and id(lines) in first:
            before, count = count, count + len(terms_of(dataclasses.replace(s, terms=lines)))
            if before <= MAX_SHARED < count:
                context.report("FZ112", f"variables share more than {MAX_SHARED} terms", s.name.span)
            lines = lines if count <= MAX_SHARED else None
        first.add(id(lines))
        yield s if lines is s.terms else _changed(context, s, lines)


def _changed(
    context: Context, variable: sx.Variable, lines: tuple[sx.TermLine | sx.TermsLine, ...] | None
) -> sx.Variable:
    """Return a variable with other term lines, which it has in the context from now on; None for lines not known."""
    changed = dataclasses.replace(variable, terms=lines or (), incomplete=variable.incomplete or lines is None)
    for known in (context.inputs, context.lets, context.outputs):
        if known.get(variable.name.text) is variable:
            known[variable.name.text] = changed
    return changed


def _clause(statement: sx.Statement) -> sx.TermsClause | None:
    clauses = statement.clauses if isinstance(statement, sx.Variable) else ()
    return next((c for c in clauses if isinstance(c, sx.TermsClause)), None)


def _lines(
    context: Context, variable: sx.Variable, clause: sx.TermsClause
) -> tuple[sx.TermLine | sx.TermsLine, ...] | None:
    """Return the lines that a variable takes over; None where there is a mistake, or was one in those lines."""
    name = clause.variable.text
    known = {**context.inputs, **context.lets, **context.outputs}
    other = known.get(name)
    if other is None:
        context.unknown("input or output", clause.variable, known)
        return None
    source = _clause(other)
    if source is not None:
        of_itself = source.variable.text == variable.name.text or name == variable.name.text
        help_text = "" if of_itself else f"write: terms of {source.variable.text}"
        message = f"'{name}' has no terms of its own"
        context.report("FZ214", message, clause.variable.span, help=help_text or "write its terms below it")
        return None
    if variable.terms:
        message = f"the terms are those of '{name}', and terms are given below"
        context.report("FZ215", message, clause.span, help="remove one of them")
        return None
    if not _fits(variable, other):
        ranges = [f"'{v.name.text}' is in [{to_text(v.lower)}, {to_text(v.upper)}]" for v in (variable, other)]
        help_text = "give both one range and scale by a gain, or write the terms of each"
        message = f"the terms of '{name}' have numbers for another range"
        context.report("FZ214", message, clause.span, facts=(", ".join(ranges),), help=help_text)
        return None
    return None if other.incomplete else other.terms


def _fits(variable: sx.Variable, other: sx.Variable) -> bool:
    """Whether the terms of a variable mean for another one what they mean there: names alone follow any range."""
    if (variable.lower, variable.upper) == (other.lower, other.upper):
        return True
    lines = [line for line in other.terms if not isinstance(line, sx.TermsLine)]
    items = [i for line in other.terms if isinstance(line, sx.TermsLine) for i in line.items]
    return not lines and all(i.peak is None and i.value is None for i in items)
