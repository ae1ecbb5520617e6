"""Terms of variables: those of a terms line, and those that several variables share."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.expr import to_text
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.variable import Membership, Term
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import terms_of

#: Most terms of a system that variables have in common with others, each counted for each further variable.
MAX_SHARED: Final = 20_000


def share_terms(context: Context, statements: Sequence[sx.Statement]) -> Iterator[sx.Statement]:
    """Yield the statements, those of variables that share terms with the lines that they take over.

    Args:
        context: The declarations; its variables change, too.
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
    for variables in (context.inputs, context.lets, context.outputs):
        if variables.get(variable.name.text) is variable:
            variables[variable.name.text] = changed
    return changed


def _clause(statement: sx.Statement) -> sx.TermsClause | None:
    clauses = statement.clauses if isinstance(statement, sx.Variable) else ()
    return next((c for c in clauses if isinstance(c, sx.TermsClause)), None)


def _lines(
    context: Context, variable: sx.Variable, clause: sx.TermsClause
) -> tuple[sx.TermLine | sx.TermsLine, ...] | None:
    """Return the lines that a variable takes over; None where there is a mistake, or was one in those lines."""
    name = clause.variable.text
    variables = {**context.inputs, **context.lets, **context.outputs}
    other = variables.get(name)
    if other is None:
        context.unknown("input or output", clause.variable, variables)
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
    """Whether the terms of a variable have the same meaning for another one: bare names follow any range."""
    if (variable.lower, variable.upper) == (other.lower, other.upper):
        return True
    lines = [line for line in other.terms if not isinstance(line, sx.TermsLine)]
    items = [i for line in other.terms if isinstance(line, sx.TermsLine) for i in line.items]
    return not lines and all(i.peak is None and i.value is None for i in items)


_INFINITY = ex.Name("inf")
_RUN_IN: Final = re.compile(r"(.*?\D)(\d+)")


def partition(context: Context, statement: sx.Variable, line: sx.TermsLine) -> list[Term | None]:
    """Expand a `terms` line: triangles by their peaks, uniform triangles over the range, or singletons by value."""
    items = line.items
    kinds = {_form(i) for i in items}
    if len(kinds) > 1:
        odd = next(i for i in items if _form(i) != _form(items[0]))
        context.report(
            "FZ214",
            "one 'terms' line mixes peaks (@), values (=) and bare names",
            odd.name.span,
            help=_joined(items) or "give every term a peak, or every term a value, or none of them anything",
        )
        return [None] * len(items)
    if any(
        e is not None and not context.check_names(e, context.params, "param") for i in items for e in (i.peak, i.value)
    ):
        return [None] * len(items)
    if kinds == {"="}:
        return [_made("singleton", (i.value,), i.name) for i in items]
    if len(items) == 1:
        context.report("FZ214", "a partition needs two terms or more", items[0].name.span, help="write triangle(...)")
        return [None]
    peaks = [i.peak for i in items] if kinds == {"@"} else _uniform(statement, len(items))
    return [
        _made(
            "triangle",
            (peaks[k - 1] if k else ex.Negate(_INFINITY), p, peaks[k + 1] if k + 1 < len(peaks) else _INFINITY),
            i.name,
        )
        for k, (i, p) in enumerate(zip(items, peaks, strict=True))
    ]


def _form(item: sx.PartitionItem) -> str:
    return "@" if item.peak is not None else "=" if item.value is not None else ""


def _joined(items: Sequence[sx.PartitionItem]) -> str:
    """Say how a name is written that ran into its number, such as Z0 for Z@0 or Z=0."""
    sign = next(form for form in map(_form, items) if form)
    run = next((match for i in items if not _form(i) and (match := _RUN_IN.fullmatch(i.name.text))), None)
    return f"write {run[1]}{sign}{run[2]}" if run is not None else ""


def _uniform(statement: sx.Variable, count: int) -> list[ex.Expr]:
    """Peaks from end to end of the range: lower + k (upper - lower) / (count - 1), the ends themselves exact."""
    lower, upper = statement.lower, statement.upper
    if not any(isinstance(n, ex.Name | ex.Call) for e in (lower, upper) for n in ex.walk(e)):
        with contextlib.suppress(ex.ExprError):  # a range without a value has another diagnostic
            # Numbers, so that the system reads well when it is printed; the same as those of the expressions below.
            low, high = ex.evaluate(lower, {}), ex.evaluate(upper, {})
            inner = [(low * (count - 1 - k) + high * k) / (count - 1) for k in range(1, count - 1)]
            return [lower, *map(ex.Number, inner), upper]
    peaks: list[ex.Expr] = [lower]
    for k in range(1, count - 1):
        # A weighted mean of the ends is symmetric if the range is: the middle of [-a, a] is exactly 0.
        peaks.append((lower * float(count - 1 - k) + upper * float(k)) / float(count - 1))
    peaks.append(upper)
    return peaks


def _made(kind: str, arguments: tuple[ex.Expr | None, ...], word: sx.Word) -> Term:
    parameters = tuple(a for a in arguments if a is not None)
    return Term(name=word.text, membership=Membership(kind=kind, arguments=parameters, span=word.span), span=word.span)
