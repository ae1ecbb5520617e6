"""Resolution of rule tables."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, listed
from fuzzyctl.formulas import HEDGES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.repaired_text import rewritten
from fuzzyctl.model.rule import Cell, RuleTable
from fuzzyctl.model.variable import Membership
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import is_unsure, known_hedge, known_term, resolve_antecedent, resolve_value, terms_of

_WHOLE: Final = re.compile(r"[^\s,#]+")
_NO_RULE: Final = "write '.' in a cell where there is to be no rule"


def resolve_table(context: Context, statement: sx.Table) -> RuleTable | None:
    """Resolve a `table` with its header and rows."""
    outputs = [_variable(context, w, context.outputs, "output") for w in statement.outputs]
    if not _distinct(context, statement.outputs):
        return None
    variables = {**context.inputs, **context.lets, **context.outputs}
    rows = _variable(context, statement.first, variables, "input or output")
    columns = rows
    if statement.second is not None:
        columns = _variable(context, statement.second, variables, "input or output")
        if rows is columns and rows is not None:
            context.report("FZ214", f"the table crosses '{statement.first.text}' with itself", statement.second.span)
            return None
    for word in (statement.first, statement.second):
        if word is not None and word.text in {w.text for w in statement.outputs}:
            context.report(
                "FZ214", f"the table sets '{word.text}' and reads it", word.span, help="cross other variables"
            )
            return None
    condition = resolve_antecedent(context, statement.condition) if statement.condition is not None else None
    if columns is None or rows is None or any(o is None for o in outputs):
        return None
    named = _with_names(context, statement, rows, columns)
    if named is None:
        return None
    statement = named
    ok = _check_frame(context, statement, rows, columns)
    cells = _cells(context, [o for o in outputs if o is not None], statement, ok)
    one_way = statement.second is None
    return RuleTable(
        outputs=tuple(w.text for w in statement.outputs),
        rows=None if one_way else statement.first.text,
        columns=columns.name.text,
        row_terms=() if one_way else tuple(row.label.text for row, _ in cells if row.label is not None),
        column_terms=tuple(w.text for w in statement.header.terms) if statement.header is not None else (),
        cells=tuple(c for _, c in cells),
        condition=condition,
        span=statement.span,
    )


def _cells(
    context: Context, outputs: Sequence[sx.Variable], statement: sx.Table, framed: bool
) -> list[tuple[sx.RowLine, tuple[Cell, ...]]]:
    """Resolve the cells of all rows; while header and labels are wrong, the expected number per row is unknown."""
    # Without a header its line may be among the rows.
    if statement.header is None or not _same_counts(context, statement):
        return []
    columns = statement.header.terms if framed else None
    if statement.scale is not None:
        if not _can_scale(context, statement, statement.scale):
            return []
        statement = _scaled(statement, statement.scale)
    results = []
    for row in statement.rows:
        counted_right = not _begins_with_input(context, outputs, row)
        counted_right = counted_right and (columns is None or _has_count(context, row, columns))
        cells = tuple(_cell(context, outputs, c) for c in row.cells) if counted_right else ()
        results.append((row, cells))
    # Only a table without mistakes goes beyond the checks of numbers, so gaps need no filling.
    return [pair for pair in results if framed and pair[1]]


def _can_scale(context: Context, statement: sx.Table, scale: ex.Expr) -> bool:
    """Check that the factor of a table has a value and all of its cells are numbers; one message for the rest."""
    cells = [t for row in statement.rows for c in row.cells for t in c.terms]
    others = [t for t in cells if not isinstance(t, ex.Expr)]
    if others:
        message = f"'scale' multiplies numbers, but '{others[0].span.text}' is not a number"
        more = len(others) - 1
        facts = (f"nor {'is' if more == 1 else 'are'} {counted(more, 'other cell')}",) if more else ()
        context.report("FZ214", message, others[0].span, facts=facts, help="write numbers, or leave 'scale' out")
    return context.check_names(scale, context.params, "param") and not others


def _scaled(statement: sx.Table, scale: ex.Expr) -> sx.Table:
    """Return a table of numbers with each multiplied by a factor."""

    def cell(c: sx.CellText) -> sx.CellText:
        numbers = (ex.Binary("*", scale, t, ex.span_of(t)) for t in c.terms if isinstance(t, ex.Expr))
        return dataclasses.replace(c, terms=tuple(numbers))

    rows = tuple(dataclasses.replace(row, cells=tuple(map(cell, row.cells))) for row in statement.rows)
    return dataclasses.replace(statement, rows=rows)


def _check_frame(context: Context, statement: sx.Table, rows: sx.Variable, columns: sx.Variable) -> bool:
    """Check header and labels of the cells, each present and each a term."""
    if statement.incomplete:
        _check_what_is_there(context, statement, rows, columns)
        return False
    if statement.header is None or not statement.rows:
        what = "header line with the terms of the columns" if statement.header is None else "rows"
        form = _table_form(statement, columns, rows)
        # A header that begins with a bar is a row to the parser.
        barred = len(statement.rows) > 1 and statement.rows[0].label is None and not statement.csv
        facts, help_text = ((form,), "leave the bar of the first line out") if barred else ((), form)
        context.report("FZ212", f"the table has no {what}", statement.span, facts=facts, help=help_text)
        return False
    if statement.second is not None and _is_transposed(context, statement, rows, columns):
        return False
    if not statement.csv and _has_corner(context, columns, statement.header):
        return False
    ok = _check_labels(context, columns, statement.header.terms, statement, "column")
    if statement.second is None:
        return _check_one_way(context, statement) and ok
    return _check_rows(context, rows, statement) and ok


def _check_what_is_there(context: Context, statement: sx.Table, rows: sx.Variable, columns: sx.Variable) -> None:
    """Check the labels of a table with an unreadable line; a missing label may belong to that line."""
    for word in statement.header.terms if statement.header is not None else ():
        if not _is_number(word):
            known_term(context, columns, word)
    for row in statement.rows if statement.second is not None else ():
        if row.label is not None and not _is_number(row.label):
            known_term(context, rows, row.label)


def _is_transposed(context: Context, statement: sx.Table, rows: sx.Variable, columns: sx.Variable) -> bool:
    """Report a table whose rows stand for the input of the columns, and the other way round."""
    assert statement.header is not None
    assert statement.second is not None
    across = {w.text for w in statement.header.terms}
    down = {r.label.text for r in statement.rows if r.label is not None}
    if across == set(terms_of(columns)) or across != set(terms_of(rows)) or down != set(terms_of(columns)):
        return False
    first, second = statement.first, statement.second
    message = f"rows and columns are swapped: '{first.text}' heads the columns, '{second.text}' the rows"
    outputs = ", ".join(w.text for w in statement.outputs)
    help_text = f"write: table {outputs} = {second.text} x {first.text}"
    context.report("FZ214", message, first.span.to(second.span), help=help_text)
    return True


def _same_counts(context: Context, statement: sx.Table) -> bool:
    """Check that every cell names one term for each output; one message for all that do not."""
    due = len(statement.outputs)
    odd = [c for row in statement.rows for c in row.cells if c.terms and len(c.terms) != due]
    if not odd:
        return True
    cell = odd[0]
    message = f"the cell names {counted(len(cell.terms), 'term')} for {counted(due, 'output')}"
    help_text = "join the terms of a cell with '/', one an output"
    if due == 1:
        help_text = _as_expression(context, cell.span) or "name one term"
    more = len(odd) - 1
    facts = (f"and so {'does' if more == 1 else 'do'} {counted(more, 'other cell')}",) if more else ()
    context.report("FZ207", message, cell.span, facts=facts, help=help_text)
    return False


def _as_expression(context: Context, cell: Span) -> str:
    """Say how a cell is written that is an expression of numbers, params and variables; nothing for other cells."""
    words = set(re.findall(sx.NAME, cell.text))
    if not words <= {*context.params, *context.inputs, *context.outputs} or "(" in cell.text:
        return ""
    formula = f"({cell.text})" if words <= context.params.keys() else f"function({cell.text})"
    return f"write: {rewritten(cell, formula)}"


def _whole(cell: sx.CellText) -> Span:
    """Return a cell with its weight and with the text that follows without a blank, as the parts of a sum do."""
    result = _WHOLE.match(cell.span.source.text, cell.span.start)
    return cell.span if result is None else Span(cell.span.source, *result.span())


def _begins_with_input(context: Context, outputs: Sequence[sx.Variable], row: sx.RowLine) -> bool:
    """Report a cell that begins with an input: an expression without its parentheses."""
    for cell in row.cells:
        word = cell.terms[0] if len(outputs) == 1 and cell.terms else None
        if not isinstance(word, sx.Word) or word.text not in context.inputs:
            continue
        if word.text in terms_of(outputs[0]) or is_unsure(outputs[0]):
            continue
        message = f"'{word.text}' is an input, not a term of '{outputs[0].name.text}'"
        whole = _whole(cell)
        help_text = _as_expression(context, whole) or "a formula of inputs is written function(...)"
        context.report("FZ203", message, whole, help=help_text)
        return True
    return False


def _has_corner(context: Context, columns: sx.Variable, header: sx.HeaderLine) -> bool:
    """Report a header that begins with a name which is not a term of the columns, before as many terms as there are."""
    first, *others = header.terms
    terms = terms_of(columns)
    if first.text in terms or [w.text for w in others if w.text in terms] != [w.text for w in others] or not others:
        return False
    if len(others) < len(terms) or is_unsure(columns):
        return False
    context.report(
        "FZ102", "a table of a rule file has no corner", first.span, help=f"write: {rewritten(first.span, '')}"
    )
    return True


def _table_form(statement: sx.Table, columns: sx.Variable, rows: sx.Variable) -> str:
    """Return the form of a table, with the terms of its inputs."""
    if statement.csv:
        from fuzzyctl.lang.csv_table import CSV_FORM

        return f"the form of the file is: {CSV_FORM}"
    terms = terms_of(columns)
    header = " ".join(terms[:7]) + (" ..." if len(terms) > 7 else "")
    cells = " ".join(["CELL"] * min(len(terms), 7)) + (" ..." if len(terms) > 7 else "")
    if statement.second is None:
        return f"the form is: a line '{header}', below it a line '| {cells}'"
    label = next(iter(terms_of(rows)), "TERM")
    each = f"for each term of '{statement.first.text}'"
    return f"the form is: a line '{header}', below it a line '{label} | {cells}' {each}"


def _distinct(context: Context, outputs: Sequence[sx.Word]) -> bool:
    """Check that a table names each output once."""
    seen: dict[str, sx.Word] = {}
    for word in outputs:
        if word.text in seen:
            note = (seen[word.text].span, "first named here")
            message = f"the table sets '{word.text}' twice"
            context.report("FZ215", message, word.span, note=note, help="name each output once")
            return False
        seen[word.text] = word
    return True


def _variable(context: Context, word: sx.Word, among: dict[str, sx.Variable], kind: str) -> sx.Variable | None:
    declared = among.get(word.text)
    if declared is None and word.text not in context.where:
        context.unknown(kind, word, among)
    elif declared is None and (
        word.text in context.inputs or word.text in context.outputs or word.text in context.params
    ):
        facts = (f"{kind.replace(' or ', 's and ')}s: {', '.join(among)}",)
        context.report("FZ214", f"'{word.text}' is not an {kind}", word.span, facts=facts)
    return declared


def _check_one_way(context: Context, statement: sx.Table) -> bool:
    row = statement.rows[0]
    if row.label is not None:
        bar = "an empty field" if statement.csv else "'|'"
        help_text = f"begin the row with {bar}: the columns are the terms of '{statement.first.text}'"
        context.report("FZ214", "the row of a one-way table has no label", row.label.span, help=help_text)
        return False
    if len(statement.rows) > 1:
        help_text = f"the columns are the terms of '{statement.first.text}', and one row holds their cells"
        context.report("FZ207", "a one-way table has one row", statement.rows[1].span, help=help_text)
        return False
    return True


def _check_rows(context: Context, variable: sx.Variable, statement: sx.Table) -> bool:
    unlabelled = [r for r in statement.rows if r.label is None]
    for row in unlabelled:
        where = "in its first field" if statement.csv else "before '|'"
        message = f"the row lacks its term of '{variable.name.text}' {where}"
        context.report("FZ207", message, row.span, facts=(f"terms: {', '.join(terms_of(variable))}",))
    labels = [r.label for r in statement.rows if r.label is not None]
    return not unlabelled and _check_labels(context, variable, labels, statement, "row")


def _check_labels(
    context: Context, variable: sx.Variable, labels: Sequence[sx.Word], statement: sx.Table, what: str
) -> bool:
    """Check that the labels of rows or columns are the terms of the variable, each once."""
    ok = True
    seen: dict[str, sx.Word] = {}
    for label in labels:
        if label.text in seen:
            context.report(
                "FZ206",
                f"{what} '{label.text}' is given twice",
                label.span,
                note=(seen[label.text].span, "first given here"),
                help=f"every term of '{variable.name.text}' has one {what}",
            )
            ok = False
        seen[label.text] = label
        ok = known_term(context, variable, label) and ok
    missing = [t for t in terms_of(variable) if t not in seen]
    if missing and ok and not is_unsure(variable):
        code = "FZ204" if what == "row" else "FZ205"
        place = statement.first.span if what == "row" or statement.header is None else statement.header.span
        names = ", ".join(f"'{m}'" for m in missing)
        context.report(
            code,
            f"the table has no {what} for {names} of '{variable.name.text}'",
            place,
            help=f"add the {what}; {_NO_RULE}",
        )
        return False
    return ok


def _has_count(context: Context, row: sx.RowLine, header: Sequence[sx.Word]) -> bool:
    """Check that a row has a cell for each column."""
    if len(row.cells) == len(header):
        return True
    place = row.cells[len(header)].span if len(row.cells) > len(header) else row.span
    many = "too many" if len(row.cells) > len(header) else "too few"
    sums = (_whole(c) for c, after in pairwise(row.cells) if c.span.end == after.span.start)
    help_text = next((_as_expression(context, whole) for whole in sums), "") if many == "too many" else _NO_RULE
    words = [c.terms[0].text for c in row.cells if c.terms and isinstance(c.terms[0], sx.Word)]
    hedge = next((w for w in words if w in HEDGES or w in context.hedges), None)
    if many == "too many" and hedge is not None:
        help_text = f"a hedged term is written in brackets: [{hedge} TERM]"
    context.report(
        "FZ207",
        f"the row has {counted(len(row.cells), 'cell')}, {many} for {counted(len(header), 'column')}",
        place,
        facts=(f"columns: {', '.join(w.text for w in header)}",),
        help=help_text,
    )
    return False


def _cell(context: Context, outputs: Sequence[sx.Variable], cell: sx.CellText) -> Cell:
    """Resolve a cell; one without a meaning becomes an empty one."""
    if not cell.terms:
        return Cell(terms=(), span=cell.span)
    if len(outputs) == 1 and type(cell.terms[0]) is sx.Word and cell.weight is None:  # nearly all are
        word = cell.terms[0]
        return Cell(terms=(word.text,) if _is_named(context, outputs[0], word) else (), span=cell.span)
    terms = [_cell_term(context, o, t) for o, t in zip(outputs, cell.terms, strict=True)]
    hedges = [t.hedges if isinstance(t, sx.HedgedTerm) else () for t in cell.terms]
    ok = all(t is not None for t in terms) and all([known_hedge(context, h) for words in hedges for h in words])
    if cell.weight is not None:
        ok = context.check_names(cell.weight, context.params, "param") and ok
    if not ok:
        return Cell(terms=(), span=cell.span)
    return Cell(
        terms=tuple(t for t in terms if t is not None),
        weight=cell.weight or ex.ONE,
        hedges=tuple(tuple(h.text for h in words) for words in hedges) if any(hedges) else (),
        span=cell.span,
    )


def _is_named(context: Context, output: sx.Variable, term: sx.Word) -> bool:
    return known_term(context, output, term, f"for the param write: ({term.text})")


def _cell_term(
    context: Context, output: sx.Variable, term: sx.ConsequentTerm | sx.HedgedTerm
) -> str | Membership | None:
    if isinstance(term, sx.HedgedTerm):
        term = term.term
    if isinstance(term, sx.Word):
        return term.text if _is_named(context, output, term) else None
    return resolve_value(context, output, term)


def _is_number(label: sx.Word) -> bool:
    """Return whether a label is a number."""
    return not (label.text[0].isalpha() or label.text[0] == "_")


def _with_names(context: Context, table: sx.Table, rows: sx.Variable, columns: sx.Variable) -> sx.Table | None:
    """Return a table with terms in place of labels that are numbers; None where these do not count the terms.

    Args:
        context: Where mistakes go.
        table: The table; one with lines that could not be read keeps its labels.
        rows: The variable of the rows.
        columns: The variable of the columns.
    """
    if table.incomplete or table.header is None:
        return table
    header = _labels_of(context, columns, table.header.terms)
    labels = [r.label for r in table.rows if r.label is not None]
    is_labelled = table.second is not None and len(labels) == len(table.rows)
    names = _labels_of(context, rows, labels) if is_labelled else ()
    if header is None or names is None:
        return None
    lines = (
        tuple(dataclasses.replace(r, label=n) for r, n in zip(table.rows, names, strict=True)) if names else table.rows
    )
    return dataclasses.replace(table, header=dataclasses.replace(table.header, terms=header), rows=lines)


def _labels_of(context: Context, variable: sx.Variable, labels: Sequence[sx.Word]) -> tuple[sx.Word, ...] | None:
    """Return labels as terms if all of them are numbers, None where these do not count the terms."""
    if not labels or not all(map(_is_number, labels)):
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
