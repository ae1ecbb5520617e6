"""Resolves rules, rule tables and guarantees."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.errors import closest, counted, listed, look_alikes
from fuzzyctl.formulas import HEDGES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.csv_table import CSV_FORM
from fuzzyctl.lang.mistakes import RULE_WORDS, capital_keyword
from fuzzyctl.model.guarantee import Guarantee
from fuzzyctl.model.rule import And, Antecedent, Cell, Consequent, Is, Not, Or, Rule, RuleTable
from fuzzyctl.model.variable import Membership
from fuzzyctl.resolve.claims import check_claim, check_condition, check_tolerance, names_output
from fuzzyctl.resolve.context import Context

#: Most rules of one system, tables included.
MAX_RULES: Final = 20_000

#: Most outputs of one system; each may read others, and they are put in order before anything is computed.
MAX_OUTPUTS: Final = 200

#: What stands for an antecedent without a meaning in a system that has mistakes, of which only numbers are checked.
_UNKNOWN: Final = And(operands=())


def resolve_function(context: Context, term: sx.FunctionTerm) -> Membership | None:
    """Resolve a Takagi-Sugeno consequent: `constant(c)`, `linear(a, b, ..., c)`, `function(expression)`."""
    kind = term.kind.text
    due = {"constant": 1, "function": 1}.get(kind, len(context.inputs) + 1)
    if len(term.arguments) != due and not (kind == "linear" and context.lost_input):
        form = f"linear({', '.join([*(f'per {name}' for name in context.inputs), 'constant'])})"
        facts = (f"the form is: {form if kind == 'linear' else kind + '(expression)'}",)
        message = f"'{kind}' takes {counted(due, 'parameter')}, not {len(term.arguments)}"
        context.report("FZ303", message, term.span, facts=facts)
        return None
    names = [*context.params, *context.inputs] if kind == "function" else list(context.params)
    what = "param or input" if kind == "function" else "param"
    if not all([context.check_names(a, names, what) for a in term.arguments]):
        return None
    return Membership(kind=kind, arguments=term.arguments, span=term.span)


def terms_of(variable: sx.Variable) -> list[str]:
    """Return the names of the terms written below a variable."""
    names: list[str] = []
    for line in variable.terms:
        names.extend([i.name.text for i in line.items] if isinstance(line, sx.TermsLine) else [line.name.text])
    return names


def is_garbled(line: sx.TermLine | sx.TermsLine) -> bool:
    """Whether a `terms` line mixes its forms or holds one name alone: what its terms are nobody can tell."""
    if not isinstance(line, sx.TermsLine):
        return False
    kinds = {"@" if i.peak is not None else "=" if i.value is not None else "" for i in line.items}
    return len(kinds) > 1 or (len(line.items) == 1 and kinds != {"="})


def _is_unsure(variable: sx.Variable) -> bool:
    """Whether a variable may have other terms than those that could be read."""
    names = terms_of(variable)
    # Where a name is given twice the slip is most likely in the name, so that another one is missing now.
    is_repeated = len(set(names)) < len(names)
    return variable.incomplete or is_repeated or any(is_garbled(line) for line in variable.terms)


def resolve_rule(context: Context, statement: sx.Rule) -> Rule | None:
    """Resolve an `if ... then ...` line; of one that has no meaning its numbers are kept, for the checks of numbers."""
    antecedent = _antecedent(context, statement.antecedent)
    consequents = [_consequent(context, c) for c in statement.consequents]
    ok = statement.weight is None or context.check_names(statement.weight, context.params, "param")
    named = [c.output.text for c in statement.consequents]
    for c in statement.consequents:
        if named.count(c.output.text) > 1:
            context.report("FZ215", f"the rule sets '{c.output.text}' twice", c.output.span)
            break
    return Rule(
        antecedent=antecedent if antecedent is not None else _UNKNOWN,
        consequents=tuple(c for c in consequents if c is not None),
        weight=statement.weight if statement.weight is not None and ok else ex.ONE,
        span=statement.span,
    )


def _antecedent(context: Context, truth: sx.Truth) -> Antecedent | None:
    match truth:
        case sx.Literal(variable=variable, hedges=hedges, term=term, span=span):
            if _runs_on(context, hedges):
                return None
            hedged = all([_known_hedge(context, h) for h in hedges])
            among = context.outputs if variable.text in context.outputs else context.inputs
            if not _known_term(context, variable, term, among, "input or output") or not hedged:
                return None
            return Is(variable=variable.text, term=term.text, hedges=tuple(h.text for h in hedges), span=span)
        case sx.Negation(operand=operand, span=span):
            inner = _antecedent(context, operand)
            return None if inner is None else Not(operand=inner, span=span)
        case sx.Group(operand=operand):
            return _antecedent(context, operand)
        case sx.Chain(connective=connective, operands=operands, span=span):
            parts = [_antecedent(context, o) for o in operands]
            known = tuple(p for p in parts if p is not None)
            if len(known) < len(parts):
                return None
            return And(operands=known, span=span) if connective == "and" else Or(operands=known, span=span)
    raise TypeError(type(truth).__name__)


def _runs_on(context: Context, hedges: Sequence[sx.Word]) -> bool:
    """Report words of the language among what stands between `is` and the term: the antecedent has run on."""
    names = {*HEDGES, *context.hedges}
    for before, word in zip((None, *hedges), hedges, strict=False):
        small = word.text.lower()
        if word.text in names or small not in RULE_WORDS:
            continue
        if word.text != small:
            context.diagnostics.append(capital_keyword(word.text, word.span))
        elif small == "is":
            place = before or word
            context.report("FZ102", f"'and' or 'or' is missing before '{place.text}'", place.span)
        else:
            context.report("FZ102", f"a term is missing before '{word.text}'", word.span)
        return True
    return False


def _known_hedge(context: Context, hedge: sx.Word) -> bool:
    names = [*HEDGES, *context.hedges]
    if hedge.text not in names:
        context.unknown("hedge", hedge, names)
    return hedge.text in names


def _consequent(context: Context, text: sx.ConsequentText) -> Consequent | None:
    if text.output.text in context.inputs:
        message = f"'{text.output.text}' is an input; a consequent sets an output"
        context.report("FZ214", message, text.output.span, facts=(f"outputs: {', '.join(context.outputs)}",))
        return None
    term: str | Membership | None
    if isinstance(text.term, sx.Word):
        known = _known_term(context, text.output, text.term, context.outputs, "output")
        term = text.term.text if known else None
    else:
        declared = context.outputs.get(text.output.text)
        if declared is None and text.output.text not in context.where:
            context.unknown("output", text.output, context.outputs)
        term = resolve_function(context, text.term) if declared is not None else None
    if term is None:
        return None
    return Consequent(output=text.output.text, term=term, span=text.output.span.to(text.term.span))


def _known_term(context: Context, variable: sx.Word, term: sx.Word, among: dict[str, sx.Variable], kind: str) -> bool:
    declared = among.get(variable.text)
    if declared is None:
        # A variable whose own line was broken is no mistake of the rule's.
        if variable.text not in context.where:
            known = among if kind == "output" else [*context.inputs, *context.outputs]
            context.unknown(kind, variable, known)
        elif variable.text in context.params:
            context.report("FZ214", f"'{variable.text}' is a param, not an {kind}", variable.span)
        return False
    return known_term(
        context, declared, term, f"for the param write: constant({term.text})" if kind == "output" else ""
    )


def known_term(context: Context, variable: sx.Variable, term: sx.Word, param_help: str = "") -> bool:
    """Check that a variable has a term; silent where the variable's own lines could not all be read.

    `param_help` says how a param is written where the term stands.
    """
    # Asked for every cell; the list is long to make and never changes.
    names = context.terms.get(id(variable))
    if names is None:
        names = context.terms[id(variable)] = terms_of(variable)
    if term.text in names:
        return True
    if not names and variable.keyword.text == "output" and not _is_unsure(variable):
        _report_termless(context, variable, term)
    elif names and not _is_unsure(variable):
        near = closest(term.text, names)
        help_text = param_help if term.text in context.params else f"did you mean '{near}'?" if near else ""
        context.report(
            "FZ203",
            f"{variable.keyword.text} '{variable.name.text}' has no term '{term.text}'",
            term.span,
            facts=(
                *look_alikes(term.text),
                f"terms of '{variable.name.text}': {listed(names)} (line {variable.name.span.line})",
            ),
            help=help_text,
        )
    return False


def _report_termless(context: Context, output: sx.Variable, term: sx.Word) -> None:
    """Report an output without terms once, at the first rule that names one."""
    name = output.name.text
    if name not in context.termless:
        context.termless.add(name)
        note = (term.span, f"'{term.text}' is named here")
        help_text = "add lines such as: NB = triangle(-2, -1, 0)"
        context.report("FZ212", f"output '{name}' has no terms", output.name.span, note=note, help=help_text)


def resolve_table(context: Context, statement: sx.Table) -> RuleTable | None:
    """Resolve a `table` with its header and rows."""
    outputs = [_variable(context, w, context.outputs, "output") for w in statement.outputs]
    if not _distinct(context, statement.outputs):
        return None
    rows = _variable(context, statement.first, context.inputs, "input")
    columns = rows
    if statement.second is not None:
        columns = _variable(context, statement.second, context.inputs, "input")
        if rows is columns and rows is not None:
            context.report("FZ214", f"the table crosses '{statement.first.text}' with itself", statement.second.span)
            return None
    condition = _antecedent(context, statement.condition) if statement.condition is not None else None
    if columns is None or rows is None or any(o is None for o in outputs):
        return None
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
    """Resolve the cells of all rows; while header and labels are wrong nobody knows how many a row should have."""
    # Without a header its line may stand among the rows.
    if statement.header is None or not _same_counts(context, statement):
        return []
    columns = statement.header.terms if framed else None
    found = []
    for row in statement.rows:
        counted_right = columns is None or _has_count(context, row, columns)
        cells = tuple(_cell(context, outputs, c) for c in row.cells) if counted_right else ()
        found.append((row, cells))
    # Only a table without mistakes goes beyond the checks of numbers, so gaps need no filling.
    return [pair for pair in found if framed and pair[1]]


def _check_frame(context: Context, statement: sx.Table, rows: sx.Variable, columns: sx.Variable) -> bool:
    """Check what holds the cells: header and labels, each there and each a term."""
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
    ok = _check_labels(context, columns, statement.header.terms, statement, "column")
    if statement.second is None:
        return _check_one_way(context, statement) and ok
    return _check_rows(context, rows, statement) and ok


def _check_what_is_there(context: Context, statement: sx.Table, rows: sx.Variable, columns: sx.Variable) -> None:
    """Check the labels of a table of which a line could not be read; what is missing may have stood in that line."""
    for word in statement.header.terms if statement.header is not None else ():
        known_term(context, columns, word)
    for row in statement.rows if statement.second is not None else ():
        if row.label is not None:
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
        numbers = all(isinstance(t, ex.Expr) for t in cell.terms)
        help_text = f"for a quotient write: ({cell.span.text})" if numbers else "name one term"
    more = len(odd) - 1
    facts = (f"and so {'does' if more == 1 else 'do'} {counted(more, 'other cell')}",) if more else ()
    context.report("FZ207", message, cell.span, facts=facts, help=help_text)
    return False


def _table_form(statement: sx.Table, columns: sx.Variable, rows: sx.Variable) -> str:
    """Say what a table looks like, with the terms of its own inputs."""
    if statement.csv:
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
        context.report("FZ214", f"'{word.text}' is not an {kind}", word.span, facts=(f"{kind}s: {', '.join(among)}",))
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
    if missing and ok and not _is_unsure(variable):
        code = "FZ204" if what == "row" else "FZ205"
        place = statement.first.span if what == "row" or statement.header is None else statement.header.span
        names = ", ".join(f"'{m}'" for m in missing)
        context.report(
            code,
            f"the table has no {what} for {names} of '{variable.name.text}'",
            place,
            help=f"add the {what}; write '.' in a cell where there is to be no rule",
        )
        return False
    return ok


def _has_count(context: Context, row: sx.RowLine, header: Sequence[sx.Word]) -> bool:
    """Check that a row has a cell for each column."""
    if len(row.cells) == len(header):
        return True
    place = row.cells[len(header)].span if len(row.cells) > len(header) else row.span
    many = "too many" if len(row.cells) > len(header) else "too few"
    context.report(
        "FZ207",
        f"the row has {counted(len(row.cells), 'cell')}, {many} for {counted(len(header), 'column')}",
        place,
        facts=(f"columns: {', '.join(w.text for w in header)}",),
        help="write '.' in a cell where there is to be no rule" if len(row.cells) < len(header) else "",
    )
    return False


def _cell(context: Context, outputs: Sequence[sx.Variable], cell: sx.CellText) -> Cell:
    """Resolve a cell; one without a meaning becomes an empty one."""
    if not cell.terms:
        return Cell(terms=(), span=cell.span)
    terms = [_cell_term(context, o, t) for o, t in zip(outputs, cell.terms, strict=True)]
    ok = all(t is not None for t in terms)
    if cell.weight is not None:
        ok = context.check_names(cell.weight, context.params, "param") and ok
    if not ok:
        return Cell(terms=(), span=cell.span)
    return Cell(terms=tuple(t for t in terms if t is not None), weight=cell.weight or ex.ONE, span=cell.span)


def _cell_term(context: Context, output: sx.Variable, term: sx.ConsequentTerm) -> str | Membership | None:
    match term:
        case sx.Word():
            return term.text if known_term(context, output, term, f"for the param write: ({term.text})") else None
        case sx.FunctionTerm():
            return resolve_function(context, term)
    if not context.check_names(term, context.params, "param"):
        return None
    return Membership(kind="constant", arguments=(term,), span=ex.span_of(term))


def resolve_require(context: Context, statement: sx.Require) -> Guarantee | None:
    """Resolve a `require`: its form and its names are checked here, its truth is for the proof."""
    ok = check_claim(context, statement.claim, truth=True)
    if statement.when is not None:
        ok = check_condition(context, statement.when) and ok
    if statement.within is not None:
        ok = check_tolerance(context, statement.claim, statement.within) and ok
    if not ok:
        return None
    if not names_output(context, statement.claim):
        help_text = "it says nothing about the rules; name an output, or remove it"
        context.report("FZ214", "the guarantee names no output", statement.span, help=help_text, warning=True)
    return Guarantee(claim=statement.claim, within=statement.within, when=statement.when, span=statement.span)
