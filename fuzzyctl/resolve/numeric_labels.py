"""Resolution of row and column labels that are numbers: they count the terms of the variable in the order declared."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fuzzyctl.diagnostics.suggestions import counted, listed
from fuzzyctl.lang import syntax as sx
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import is_unsure, terms_of


def is_number(label: sx.Word) -> bool:
    """Return whether a label is a number."""
    return not (label.text[0].isalpha() or label.text[0] == "_")


def with_names(context: Context, table: sx.Table, rows: sx.Variable, columns: sx.Variable) -> sx.Table | None:
    """Return a table with terms in place of labels that are numbers; None where these do not count the terms.

    Args:
        context: Where mistakes go.
        table: The table; one with lines that could not be read keeps its labels.
        rows: The variable of the rows.
        columns: The variable of the columns.
    """
    if table.incomplete or table.header is None:
        return table
    header = _names(context, columns, table.header.terms)
    labels = [r.label for r in table.rows if r.label is not None]
    is_labelled = table.second is not None and len(labels) == len(table.rows)
    names = _names(context, rows, labels) if is_labelled else ()
    if header is None or names is None:
        return None
    lines = (
        tuple(dataclasses.replace(r, label=n) for r, n in zip(table.rows, names, strict=True)) if names else table.rows
    )
    return dataclasses.replace(table, header=dataclasses.replace(table.header, terms=header), rows=lines)


def _names(context: Context, variable: sx.Variable, labels: Sequence[sx.Word]) -> tuple[sx.Word, ...] | None:
    """Return labels as terms if all of them are numbers, None where these do not count the terms."""
    if not labels or not all(map(is_number, labels)):
        return tuple(labels)
    terms = terms_of(variable)
    numbers = [float(label.text) for label in labels]
    low = min(numbers)
    if sorted(numbers) == [low + k for k in range(len(terms))] and low.is_integer():
        return tuple(sx.Word(terms[int(n - low)], w.span) for n, w in zip(numbers, labels, strict=True))
    if not is_unsure(variable):
        name, count = variable.name.text, len(terms)
        message = f"the numbers do not count the {counted(count, 'term')} of '{name}'"
        counts = " ".join(str(k - count // 2) for k in range(count))
        help_text = f"write each of {counts} once, or the names of the terms"
        place = labels[0].span.to(labels[-1].span) if labels[0].span.line == labels[-1].span.line else labels[0].span
        context.report("FZ203", message, place, facts=(f"terms: {listed(terms)}",), help=help_text)
    return None
