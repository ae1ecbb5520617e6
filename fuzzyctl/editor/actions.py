"""Code actions that write what a rule file lacks, or write the same in another form."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.hints import peak
from fuzzyctl.editor.layout import laid_out
from fuzzyctl.expr import number_text
from fuzzyctl.formats.fz import membership_text
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable


@dataclass(frozen=True)
class Action:
    """A change that is offered.

    Args:
        title: What it does.
        replacements: The change.
        rewrites: Whether the file means the same afterwards.
    """

    title: str
    replacements: tuple[Replacement, ...]
    rewrites: bool = False


def actions(document: Document, offset: int) -> list[Action]:
    """Return what can be written at an offset besides repairs of mistakes."""
    statement = _statement_at(document, offset)
    found: Iterator[Action] = iter(())
    if isinstance(statement, sx.Table) and not statement.csv:
        found = _table(document, statement, offset)
    elif isinstance(statement, sx.Variable):
        found = _variable(document, statement)
    return list(found)


def _statement_at(document: Document, offset: int) -> sx.Statement | None:
    """Return the statement whose lines, those below it included, hold an offset."""
    line = document.source.line_of(offset)
    for s in document.tree.statements:
        if s.span.source.name == document.source.name and s.span.line <= line <= _last_line(s):
            return s
    return None


def _last_line(s: sx.Statement) -> int:
    below: tuple[sx.Statement, ...] = ()
    if isinstance(s, sx.Variable):
        below = s.terms
    elif isinstance(s, sx.Table) and not s.csv:
        below = (*((s.header,) if s.header is not None else ()), *s.rows)
    return max(line.span.end_line for line in (s, *below))


# -- tables


def _table(document: Document, table: sx.Table, offset: int) -> Iterator[Action]:
    terms = document.symbols.scope_at(offset)[0].terms
    rows = list(terms.get(table.first.text, ())) if table.second is not None else []
    columns = list(terms.get(table.second.text if table.second is not None else table.first.text, ()))
    header = table.header
    given = {r.label.text for r in table.rows if r.label is not None}
    more_rows = [name for name in rows if name not in given]
    more_columns = [] if header is None else [c for c in columns if c not in {w.text for w in header.terms}]
    if more_rows and (header is not None or not table.rows):
        width = len(header.terms) if header is not None else len(columns)
        new = [f"  {name} |" + "  ." * width for name in more_rows]
        if header is None:
            new.insert(0, "    " + "  ".join(columns))
        at = _end_of_line(document.source, _last_line(table))
        change = Replacement(Span(document.source, at, at), "".join(f"\n{line}" for line in new))
        yield _with_layout(document, f"add {counted(len(more_rows), 'missing row')}", [change], table)
    if more_columns and header is not None:
        lines = [(header.span, "  ".join(more_columns)), *((r.span, "  ." * len(more_columns)) for r in table.rows)]
        changes = [Replacement(Span(document.source, s.end, s.end), f"  {text.strip()}") for s, text in lines]
        yield _with_layout(document, f"add {counted(len(more_columns), 'missing column')}", changes, table)


def _end_of_line(source: SourceText, line: int) -> int:
    return source.line_start(line) + len(source.line_text(line))


def _with_layout(document: Document, title: str, changes: list[Replacement], table: sx.Table) -> Action:
    """Return an action that also aligns the lines of the table."""
    source = document.source
    after = SourceText(source.name, fixed(source, [Fix(tuple(changes), "sure")]))
    first, last = table.span.line, _last_line(table)
    added = after.line_count - source.line_count
    laid = fixed(after, [Fix(tuple(laid_out(after, first, last + added)), "sure")])
    lines = laid.split("\n")[first - 1 : last + added]
    place = Span(source, source.line_start(first), _end_of_line(source, last))
    return Action(title, (Replacement(place, "\n".join(lines)),))


# -- variables


def _variable(document: Document, s: sx.Variable) -> Iterator[Action]:
    source = document.source
    if s.keyword.text == "output" and s.value is None and not any(isinstance(c, sx.FallbackClause) for c in s.clauses):
        at = Span(source, s.span.end, s.span.end)
        yield Action("add 'else midpoint', the output where no rule fires", (Replacement(at, " else midpoint"),))
    if len(s.terms) == 1 and isinstance(s.terms[0], sx.TermsLine):
        yield from _rewritten(document, s, "write the terms as functions, one a line", _as_lines)
    elif s.terms and all(isinstance(line, sx.TermLine) for line in s.terms):
        yield from _rewritten(document, s, "write the terms as one line of peaks", _as_partition)


def _as_lines(_: FuzzySystem, variable: LinguisticVariable) -> list[str]:
    return [f"  {t.name} = {membership_text(t.membership)}" for t in variable.terms]


def _as_partition(system: FuzzySystem, variable: LinguisticVariable) -> list[str]:
    kinds = {t.membership.kind for t in variable.terms}
    peaks = [peak(system, t.membership) for t in variable.terms]
    sign = "=" if kinds <= {"singleton", "constant"} else "@"
    if any(p is None for p in peaks):
        return []
    low, high = system.number(variable.lower), system.number(variable.upper)
    step = (high - low) / max(len(peaks) - 1, 1)
    if sign == "@" and all(p is not None and abs(p - low - k * step) < 1e-12 * step for k, p in enumerate(peaks)):
        return ["  terms " + " ".join(t.name for t in variable.terms)]
    pairs = zip(variable.terms, peaks, strict=True)
    return ["  terms " + " ".join(f"{t.name}{sign}{number_text(p)}" for t, p in pairs if p is not None)]


def _rewritten(
    document: Document, s: sx.Variable, title: str, form: Callable[[FuzzySystem, LinguisticVariable], list[str]]
) -> Iterator[Action]:
    """Yield the action that writes the terms in another form, where the system then computes the same."""
    for system in document.examined.systems:
        for variable in system.variables:
            if variable.span is None or variable.span.start != s.name.span.start:
                continue
            lines = form(system, variable)
            first, last = s.terms[0].span, s.terms[-1].span
            start = document.text.rfind("\n", 0, first.start) + 1
            change = Replacement(Span(document.source, start, last.end), "\n".join(lines))
            if lines and "#" not in change.span.text and _is_same(document, system, change):
                yield Action(title, (change,), rewrites=True)
            return


def _is_same(document: Document, system: FuzzySystem, change: Replacement) -> bool:
    text = fixed(document.source, [Fix((change,), "sure")])
    after = Document(SourceText(document.source.name, text), document.folder, document.buffers)
    try:
        return any(s.name == system.name and plan(s) == plan(system) for s in after.examined.systems)
    except DiagnosticError:
        return False
